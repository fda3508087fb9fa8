//! Goal: no effect makes a run costly: a fit takes hundreds of them.
//! Setup: the release at 15 psi, 32 nodes, 20 s, damped, with each effect of the catalogue at its
//! default, at the tolerance of fits and at the default one.
//! Expected: at most four times the steps of the plain run.

use efam_core::forward::{DEFAULT_TOLERANCE, FAST_TOLERANCE, Run};
use efam_core::integrate::Method;
use models::effects::CATALOGUE;
use models::model::Model;
use tests::{paper_spec, simulate};

fn steps(effect: Option<&str>, tolerance: f64) -> usize {
    let mut spec = paper_spec(15.0, 32, &[("rayleigh_mass.alpha", 1.0), ("rayleigh_stiffness.beta", 0.01)]);
    spec.effects.extend(effect.map(|name| (name.to_owned(), vec![])));
    let model = Model::new(&spec).expect("defaults are admissible");
    let run = Run { method: Method::Rodas4, tolerance, ..Run::release(20.0, 10.0) };
    let effort = simulate(&model, &run).effort;
    effort.steps + effort.rejected
}

#[test]
fn of_a_run_with_any_effect_is_at_most_four_plain_ones() {
    for tolerance in [FAST_TOLERANCE, DEFAULT_TOLERANCE] {
        let plain = steps(None, tolerance);
        for effect in CATALOGUE {
            let name = effect.about().name;
            let found = steps(Some(name), tolerance);
            assert!(found <= 4 * plain, "{name}: {found} steps against {plain} without");
        }
    }
}

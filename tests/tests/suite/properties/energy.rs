//! Goal: no combination of effects creates energy.
//! Setup: up to four effects of the catalogue, with strengths between off and the plausible limit, or their scale;
//! the muscle at any pressure of its table, let go at any angle, 2 s, 12 nodes.
//! Expected: kinetic, stored and dissipated energy and what was supplied add up to 1e-3 of what moves, and what is
//! dissipated never comes back. Laws that soften the rod can make it unstable: such a run may stop, with its time and
//! node, and the same holds up to there.

use std::ops::ControlFlow;

use efam_core::forward::{ForwardError, Run, forward};
use efam_core::integrate::IntegrateError;
use models::effects::{About, CATALOGUE, Kind, Parameter};
use models::model::Model;
use models::snapshot::Energy;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;
use tests::paper_spec;

use super::cases;

/// A value between off and the farthest plausible one.
fn value(parameter: &Parameter, share: f64) -> f64 {
    let Some(off) = parameter.null_value else { return parameter.default };
    let (low, high) = parameter.plausible.unwrap_or((-parameter.scale, parameter.scale));
    let (low, high) = (low.max(parameter.range.0), high.min(parameter.range.1));
    let far = if high - off >= off - low { high } else { low };
    off + share * (far - off)
}

/// Effects that move the rod; what only the cameras see has no energy.
fn movers() -> Vec<&'static About> {
    let all = CATALOGUE.iter().map(|effect| effect.about());
    all.filter(|about| {
        !matches!(about.kind, Kind::Description | Kind::Measurement)
            && about.parameters.iter().any(|parameter| parameter.null_value.is_some())
    })
    .collect()
}

fn model(psi: f64, angle: f64, drawn: &[(Index, f64)]) -> Model {
    let all = movers();
    let mut spec = paper_spec(psi, 12, &[("rayleigh_stiffness.beta", 2e-3)]);
    spec.release_angle = angle;
    for (index, share) in drawn {
        let about = index.get(&all);
        if spec.effects.iter().all(|(name, _)| name != about.name) {
            let values = about.parameters.iter().map(|p| (p.name.to_owned(), value(p, *share)));
            spec.effects.push((about.name.to_owned(), values.collect()));
        }
    }
    Model::new(&spec).expect("within their ranges")
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn is_never_created(
        psi in 1..=20u8,
        angle in -1.0..0.5f64,
        drawn in vec((any::<Index>(), 0.02..1.0f64), 1..=4),
    ) {
        let model = model(5.0 * f64::from(psi), angle, &drawn);
        let run = Run { energy: true, tolerance: 1e-7, ..Run::release(2.0, 100.0) };
        let path = match forward(&model, &run, &mut |_| ControlFlow::Continue(())) {
            Ok(path) => path,
            Err(ForwardError::Integrate { error, trajectory }) => {
                use IntegrateError::{StepTooSmall, TooSlow};
                prop_assert!(matches!(error, StepTooSmall { .. } | TooSlow { .. }), "{error}");
                *trajectory
            }
            Err(error) => return Err(TestCaseError::fail(error.to_string())),
        };
        let total = |e: &Energy| e.kinetic + e.elastic + e.potential + e.dissipated + e.supplied;
        let (first, moved) = (path.energy[0], path.energy.iter().map(|e| e.kinetic).fold(0.0, f64::max));
        for (before, e) in path.energy.iter().zip(&path.energy[1..]) {
            let (off, back) = (total(e) - total(&first), before.dissipated - e.dissipated);
            prop_assert!(off.abs() < 1e-3 * moved, "{} J of {moved} J appear", off);
            prop_assert!(back < 1e-6 * moved, "{} J of {moved} J come back", back);
        }
    }
}

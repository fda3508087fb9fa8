//! Scenarios drawn at random: the paper's muscle at any pressure, from any angle, with payloads, losses and effects.

use efam_core::forward::Run;
use models::model::Model;

use crate::paper_spec;
use crate::twin::random::Random;

/// Effects that a drawn scenario may have one of, each with a parameter and the range of its size.
const EFFECTS: [(&str, &str, [f64; 2]); 12] = [
    ("air_drag", "drag_coefficient", [0.5, 3.0]),
    ("tip_drag", "drag_area", [1e-4, 4e-3]),
    ("linear_drag", "drag_per_length", [1e-3, 1e-2]),
    ("viscoelastic", "branch_stiffness", [0.02, 0.5]),
    ("creep", "creep_stiffness", [0.05, 0.3]),
    ("cubic_stiffness", "coefficient", [1e-4, 5e-3]),
    ("quadratic_stiffness", "coefficient", [-5e-3, 5e-3]),
    ("clamp_compliance", "compliance", [0.02, 0.5]),
    ("braid_friction", "friction_moment", [1e-4, 2e-3]),
    ("hysteresis", "loss_coefficient", [0.005, 0.05]),
    ("strain_rate_cubed", "coefficient", [1e-8, 1e-7]),
    ("pressure_volume", "stiffening", [1e-4, 2e-3]),
];

/// The scenario of a seed, and what it is.
pub fn drawn(seed: u64) -> (Model, Run, String) {
    let mut random = Random::new(seed);
    let log = |random: &mut Random, low: f64, high: f64| low * (high / low).powf(random.share());
    let psi = random.between(5.0, 100.0);
    let angle = random.between(-60.0, 45.0_f64).to_radians();
    let payload = if random.chance(0.5) { random.between(0.0, 0.2) } else { 0.0 };
    let alpha = log(&mut random, 0.1, 3.0);
    let beta = if random.chance(0.8) { log(&mut random, 1e-3, 3e-2) } else { 0.0 };
    let mut text = format!(
        "{psi:.1} psi, {:.0} deg, {:.0} g, alpha {alpha:.2}, beta {:.1} ms",
        angle.to_degrees(),
        1e3 * payload,
        1e3 * beta
    );
    let mut parameters =
        vec![("rayleigh_mass.alpha".to_owned(), alpha), ("rayleigh_stiffness.beta".to_owned(), beta)];
    parameters.push(("payload.mass".to_owned(), payload));
    parameters.push(("payload.center_of_mass".to_owned(), 0.02));
    if random.chance(0.6) {
        let at = (random.share() * EFFECTS.len() as f64) as usize;
        let (effect, parameter, [low, high]) = EFFECTS[at];
        let size = random.between(low, high);
        text += &format!(", {effect} {size:.2e}");
        parameters.push((format!("{effect}.{parameter}"), size));
    }
    let borrowed: Vec<(&str, f64)> = parameters.iter().map(|(path, value)| (path.as_str(), *value)).collect();
    let mut spec = paper_spec(psi, 16, &borrowed);
    (spec.base_angle, spec.release_angle) = (angle, angle);
    let duration = random.between(3.0, 10.0);
    let model = Model::new(&spec).expect("within their ranges");
    (model, Run { energy: true, ..Run::release(duration, 100.0) }, text)
}

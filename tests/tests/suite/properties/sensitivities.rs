//! Goal: forward sensitivities of the tip's path against central differences of the forward run.
//! Setup: the 15 psi row, 12 nodes, with every effect of the catalogue on, three swings at a tolerance of
//! 1e-10; every parameter of the model.
//! Expected: within 1e-5 of the largest derivative along the path.

use models::effects::CATALOGUE;
use models::model::Model;
use sim::forward::{Initial, Run};
use sim::integrate::Method;
use tests::{paper_spec, simulate};

fn everything() -> Model {
    let mut spec = paper_spec(15.0, 12, &[]);
    spec.release_angle = 0.1;
    spec.release_rate = 0.2;
    for effect in CATALOGUE {
        let about = effect.about();
        let values = about.parameters.iter().filter(|_| about.name != "end_fitting").map(|p| {
            let value = if Some(p.default) == p.off || p.default == 0.0 { 0.1 * p.scale } else { p.default };
            (p.name.to_owned(), value)
        });
        spec.effects.push((about.name.to_owned(), values.collect()));
    }
    let mut model = Model::new(&spec).expect("valid");
    model.set("effects.rayleigh_stiffness.beta", 0.005).expect("baseline");
    model.set("effects.end_fitting.rotary_inertia", 1e-5).expect("baseline");
    // Friction that turns round within steps leaves slopes good to 1e-4 only: here it is smooth.
    for effect in ["braid_friction", "clamp_friction", "dahl", "hysteresis"] {
        model.set(&format!("effects.{effect}.creep_rate"), 20.0).expect("in the catalogue");
    }
    // Enough of it to see it in a difference of runs.
    model.set("effects.strain_rate_cubed.coefficient", 1e-6).expect("in the catalogue");
    model
}

fn check(model: &Model, run: &Run, skip: &[usize]) {
    let all: Vec<usize> = (0..model.theta.len()).filter(|k| !skip.contains(k)).collect();
    let found = simulate(model, &Run { sensitivities: all.clone(), ..run.clone() });
    for (place, &k) in all.iter().enumerate() {
        let p = &model.parameters[k];
        let step = 3e-5 * model.theta[k].abs().max(0.1 * p.scale);
        let side = |sign: f64| {
            let mut moved = model.clone();
            moved.theta[k] += sign * step;
            simulate(&moved, run).tip
        };
        let (plus, minus) = (side(1.0), side(-1.0));
        let difference = |s: usize, c: usize| (plus[s][c] - minus[s][c]) / (2.0 * step);
        let (mut worst, mut scale): (f64, f64) = (0.0, 0.0);
        for s in 0..plus.len() {
            for c in 0..2 {
                scale = scale.max(difference(s, c).abs());
                let error = (found.tip_by_parameters[s][place][c] - difference(s, c)).abs();
                assert!(error.is_finite(), "{}", p.path);
                worst = worst.max(error);
            }
        }
        assert!(worst <= 1e-5 * scale, "{}: off by {:.1e} of {scale:.3e}", p.path, worst / scale);
    }
}

#[test]
fn by_every_parameter_of_every_effect() {
    let run = Run { method: Method::Rodas4, tolerance: 1e-10, ..Run::release(5.0, 4.0) };
    check(&everything(), &run, &[]);
}

/// Held at rest under a payload of its own: the start moves with the parameters, too, but not with
/// those that the hold has of its own, nor with the straight release's.
#[test]
fn from_a_held_equilibrium() {
    let model = everything();
    let own = vec![model.index("effects.payload.mass").expect("baseline")];
    let run = |model: &Model| {
        let mut hold = model.clone();
        hold.theta[own[0]] = 0.12;
        Run {
            initial: Initial::Equilibrium { hold: Box::new(hold), own: own.clone() },
            method: Method::Rodas4,
            tolerance: 1e-10,
            ..Run::release(1.0, 4.0)
        }
    };
    for path in
        ["rod.bending_stiffness", "rod.length", "effects.payload.mass", "effects.clamp_compliance.compliance"]
    {
        let k = model.index(path).expect("there");
        let found = simulate(&model, &Run { sensitivities: vec![k], ..run(&model) });
        let step = 3e-5 * model.theta[k];
        let side = |sign: f64| {
            let mut moved = model.clone();
            moved.theta[k] += sign * step;
            simulate(&moved, &run(&moved)).tip
        };
        let (plus, minus) = (side(1.0), side(-1.0));
        for s in 0..plus.len() {
            for c in 0..2 {
                let expected = (plus[s][c] - minus[s][c]) / (2.0 * step);
                let scale = plus
                    .iter()
                    .zip(&minus)
                    .map(|(p, m)| ((p[c] - m[c]) / (2.0 * step)).abs())
                    .fold(0.0, f64::max);
                let found = found.tip_by_parameters[s][0][c];
                assert!((found - expected).abs() <= 1e-5 * scale, "{path}: {found} against {expected}");
            }
        }
    }
}

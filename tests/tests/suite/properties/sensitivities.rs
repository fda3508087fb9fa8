//! Goal: forward sensitivities of the path of the tip, and of what is seen of it and of a point of the
//! rod, against central differences of the forward run.
//! Setup: the 15 psi row, 8 nodes, with every effect of the catalogue on, at a tolerance of
//! 1e-11; a parameter of each effect, or every parameter of the model.
//! Expected: within 1e-5 of the largest derivative along the path.

use efam_core::forward::{Initial, Run};
use efam_core::integrate::Method;
use efam_core::trajectory::Trajectory;
use efam_experiments::release::Point;
use models::effects::CATALOGUE;
use models::history::History;
use models::model::Model;
use tests::{paper_spec, simulate};

fn everything() -> Model {
    let mut spec = paper_spec(15.0, 8, &[]);
    spec.release_angle = 0.1;
    spec.release_rate = 0.2;
    for effect in CATALOGUE {
        let about = effect.about();
        let values = about.parameters.iter().filter(|_| about.name != "end_fitting").map(|p| {
            let value =
                if Some(p.default) == p.null_value || p.default == 0.0 { 0.1 * p.scale } else { p.default };
            (p.name.to_owned(), value)
        });
        spec.effects.push((about.name.to_owned(), values.collect()));
    }
    let mut model = Model::new(&spec).expect("valid");
    model.set("effects.rayleigh_stiffness.beta", 0.005).expect("baseline");
    model.set("effects.end_fitting.rotary_inertia", 1e-5).expect("baseline");
    // Friction that turns round within steps leaves slopes good to 1e-4 only: here it is smooth.
    for effect in ["braid_friction", "friction_over_pressure", "clamp_friction", "dahl", "hysteresis"] {
        model.set(&format!("effects.{effect}.creep_rate"), 20.0).expect("in the catalogue");
    }
    // Enough of it to see it in a difference of runs.
    model.set("effects.strain_rate_cubed.coefficient", 1e-6).expect("in the catalogue");
    model
}

/// The tip, and what is seen of the points.
fn paths(path: &Trajectory, sample: usize) -> Vec<[f64; 2]> {
    [&[path.tip[sample]], &path.points[sample][..]].concat()
}

/// Derivatives by one of the parameters of what is seen of the points.
fn of_points(path: &Trajectory, sample: usize, parameter: usize) -> Vec<[f64; 2]> {
    path.points_by_parameters[sample].iter().map(|of_point| of_point[parameter]).collect()
}

fn check(model: &Model, run: &Run, all: Vec<usize>) {
    let mut wrong = Vec::new();
    let found = simulate(model, &Run { sensitivities: all.clone(), ..run.clone() });
    for (place, &k) in all.iter().enumerate() {
        let p = &model.parameters[k];
        let largest =
            found.tip_by_parameters.iter().map(|by| by[place][0].hypot(by[place][1])).fold(0.0, f64::max);
        // Runs at this tolerance differ by 1e-10 m in what their steps leave: the parameter is moved
        // until the tip moves 200 000 times that, as far as its own size lets it.
        let step = (2e-5 / largest).min(3e-3 * model.theta[k].abs().max(0.1 * p.scale));
        let side = |sign: f64| {
            let mut moved = model.clone();
            moved.theta[k] += sign * step;
            simulate(&moved, run)
        };
        let (plus, minus) = (side(1.0), side(-1.0));
        let samples = run.samples.len();
        assert_eq!([plus.points.len(), minus.points.len(), found.points.len()], [samples; 3], "{}", p.path);
        // A point that moves less shares the errors of the whole rod.
        let (mut worst, mut scale): (f64, f64) = (0.0, 0.0);
        for s in 0..samples {
            let by_theta = [&[found.tip_by_parameters[s][place]], &of_points(&found, s, place)[..]].concat();
            let sides = paths(&plus, s).into_iter().zip(paths(&minus, s));
            for ((plus, minus), by_theta) in sides.zip(by_theta) {
                for c in 0..2 {
                    let difference = (plus[c] - minus[c]) / (2.0 * step);
                    let error = (by_theta[c] - difference).abs();
                    assert!(error.is_finite(), "{}", p.path);
                    scale = scale.max(difference.abs());
                    worst = worst.max(error);
                }
            }
        }
        if worst > 1e-5 * scale {
            wrong.push(format!("{}: off by {:.1e} of {scale:.3e}", p.path, worst / scale));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn by_parameters(seconds: f64, wanted: impl Fn(&Model, usize) -> bool) {
    let points = vec![Point::Tip, Point::Along(0.55)];
    let run =
        Run { method: Method::Rodas4, tolerance: 1e-11, points, ..Run::release(seconds, 8.0 / seconds) };
    let model = everything();
    let all = (0..model.theta.len()).filter(|k| wanted(&model, *k)).collect();
    check(&model, &run, all);
}

/// The derivatives of each law by each of its parameters have tests of their own; here they pass through the system.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn by_one_parameter_of_every_effect() {
    let of = |model: &Model, k: usize| model.parameters[k].path.rsplit_once('.').map(|(of, _)| of.to_owned());
    by_parameters(0.5, |model, k| k == 0 || of(model, k) != of(model, k - 1));
}

#[test]
#[ignore = "minutes; its kind has a shorter test beside it"]
fn by_every_parameter_of_every_effect() {
    by_parameters(2.0, |_, _| true);
}

/// With a history the memory at the start follows the rest in which the rod hung, the posture of release
/// and the laws.
#[test]
#[ignore = "long; .ci/thorough runs it"]
fn with_a_history() {
    let model = everything();
    let run = Run {
        history: Some(History { hung: 3.0, raised: 1.0, held: 0.5 }),
        method: Method::Rodas4,
        tolerance: 1e-10,
        ..Run::release(1.0, 4.0)
    };
    for path in [
        "rod.bending_stiffness",
        "release.angle",
        "effects.gravity.acceleration",
        "effects.creep.creep_time",
        "effects.relaxation.longest_time",
        "effects.payload.mass",
    ] {
        let k = model.index(path).expect("there");
        let found = simulate(&model, &Run { sensitivities: vec![k], ..run.clone() });
        let step = if path.ends_with("time") { 3e-3 } else { 1e-4 } * model.theta[k];
        let side = |sign: f64| {
            let mut moved = model.clone();
            moved.theta[k] += sign * step;
            simulate(&moved, &run).tip
        };
        let (plus, minus) = (side(1.0), side(-1.0));
        let difference = |s: usize, c: usize| (plus[s][c] - minus[s][c]) / (2.0 * step);
        let all = || (0..plus.len()).flat_map(|s| [(s, 0), (s, 1)]);
        let scale = all().map(|(s, c)| difference(s, c).abs()).fold(0.0, f64::max);
        for (s, c) in all() {
            let (found, expected) = (found.tip_by_parameters[s][0][c], difference(s, c));
            // Runs at this tolerance differ by some 1e-10 m in what their steps leave.
            let tolerance = 1e-5 * scale + 1e-10 / step;
            assert!((found - expected).abs() <= tolerance, "{path}: {found} against {expected}");
        }
    }
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
    for path in [
        "rod.bending_stiffness",
        "rod.length",
        "effects.payload.mass",
        "effects.clamp_compliance.compliance",
        "effects.initial_velocity.angular_velocity",
    ] {
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

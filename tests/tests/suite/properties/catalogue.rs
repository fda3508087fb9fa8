//! What every registered effect keeps, whoever wrote it.

use models::effects::{CATALOGUE, LANES, Parameter, Real, Sight};
use models::lanes::{seeded, slopes};
use models::model::{Model, ModelSpec};
use models::sensor::Sensor;
use models::system::{System, TimePass};
use tests::paper_spec;

/// Time at which laws are looked at, s: not the release, at which a drift has not begun.
const NOW: f64 = 0.3;

/// Effects that pull towards places or directions of the laboratory, and so know its frame.
const FIXED_IN_THE_LABORATORY: [&str; 5] = ["gravity", "tip_load", "tip_hold", "hose", "hand_release"];

/// A model in which one effect acts: each parameter at its default or, where that is off, at half its
/// scale; those `off` at off.
fn with(name: &str, off: impl Fn(&Parameter) -> bool) -> Model {
    let effect = models::effects::by_name(name).expect("registered");
    let values = effect.about().parameters.iter().map(|p| {
        let on = if Some(p.default) == p.off || p.default == 0.0 { 0.5 * p.scale } else { p.default };
        (p.name.to_owned(), p.off.filter(|_| off(p)).unwrap_or(on))
    });
    let mut spec = paper_spec(40.0, 8, &[]);
    spec.effects.push((name.to_owned(), values.collect()));
    Model::new(&spec).expect("defaults are admissible")
}

fn on(name: &str) -> Model {
    with(name, |_| false)
}

fn moving(model: &Model) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let (mut q, mut v) = System::new(model).assembly.straight(-0.5, 1.0);
    for k in 0..q.len() {
        q[k] += 0.004 * ((k * k) as f64).sin();
        v[k] += 0.2 * (3.0 * k as f64).cos();
    }
    let z = vec![0.1; model.memory()];
    (q, v, z)
}

fn force(model: &Model) -> Vec<f64> {
    let (q, v, z) = moving(model);
    let mut force = vec![0.0; q.len()];
    let mut rate = vec![0.0; z.len()];
    System::new(model).force(NOW, &q, &v, &z, &mut force, &mut rate);
    force
}

/// A point of the end body, and one of the rod.
fn sights<T: Real>() -> [Sight<T>; 2] {
    let of = |[x, z]: [f64; 2], angle: f64, share, is_tip| {
        let tangent = [angle.cos(), angle.sin()].map(T::from);
        Sight { position: [x, z].map(T::from), tangent, share, is_tip }
    };
    [of([0.11, -0.13], -0.9, 1.0, true), of([0.09, -0.04], -0.6, 0.5, false)]
}

/// A time of a recording, s.
const RECORDED: f64 = 0.7;

/// Wherever an effect can show: forces at a state in motion, masses, the state in which the straight
/// rod is let go, and what is seen of it and when.
fn trace(model: &Model) -> Vec<f64> {
    let system = System::new(model);
    let straight = system.assembly.straight_at_release();
    let (q, v) = system.assembly.let_go(model, straight);
    let sensor = Sensor::new(model, model.theta.clone());
    let seen = sights().map(|sight| sensor.see(sight));
    [&force(model)[..], &system.mass, &q, &v, seen.as_flattened(), &[sensor.instant(RECORDED)]].concat()
}

/// Derivatives of the [`trace`] by one parameter.
fn trace_by(model: &Model, parameter: usize) -> Vec<f64> {
    let (q, v, z) = moving(model);
    let mut system = System::new(model);
    let watched = [Some(parameter)];
    system.watch(&watched);
    let (mut by_theta, mut rates) = (vec![[0.0; LANES]; q.len()], vec![[0.0; LANES]; z.len()]);
    system.by_parameters(0, NOW, &q, &v, &z, &mut by_theta, &mut rates);
    let (by_q, by_v) = system.let_go_by_parameters(0, system.straight_by_parameters(0));
    let sensor = Sensor::new(model, seeded(&model.theta, &watched));
    let seen = sights().map(|sight| sensor.see(sight)).into_iter().flatten();
    let seen = seen.chain([sensor.instant(RECORDED.into())]).map(|x| slopes(&x));
    by_theta.into_iter().chain(by_q).chain(by_v).chain(seen).map(|row| row[0]).collect()
}

#[test]
fn off_is_exactly_off_and_on_is_on() {
    for effect in CATALOGUE {
        let about = effect.about();
        let switches = || about.parameters.iter().filter(|p| p.off.is_some());
        let without = |model: &Model| {
            let mut without = model.clone();
            without.effects.retain(|active| active.effect.about().name != about.name);
            trace(&without)
        };
        // Each that can do so alone, and all parts together.
        let alone = switches().filter(|p| !p.is_part).map(|p| vec![p.name]);
        let parts: Vec<_> = switches().filter(|p| p.is_part).map(|p| p.name).collect();
        for off in alone.chain((!parts.is_empty()).then_some(parts)) {
            let model = with(about.name, |p| off.contains(&p.name));
            assert_eq!(trace(&model), without(&model), "{} with {off:?} at off", about.name);
        }
        let model = on(about.name);
        if switches().next().is_some() {
            assert_ne!(trace(&model), without(&model), "{} on", about.name);
        }
        for part in switches().filter(|p| p.is_part) {
            let alone = with(about.name, |p| p.is_part && p.name != part.name);
            assert_ne!(trace(&alone), without(&alone), "{} with {} alone", about.name, part.name);
        }
    }
}

#[test]
fn at_off_the_sensitivity_is_not_zero() {
    for effect in CATALOGUE {
        let about = effect.about();
        for p in about.parameters.iter().filter(|p| p.off.is_some()) {
            // All others on; of parts, all off.
            let model = with(about.name, |other| other.name == p.name || (p.is_part && other.is_part));
            let k = model.index(&format!("effects.{}.{}", about.name, p.name)).expect("there");
            assert!(trace_by(&model, k).iter().any(|slope| *slope != 0.0), "{}.{}", about.name, p.name);
        }
    }
}

#[test]
fn none_feeds_energy() {
    for effect in CATALOGUE {
        let model = on(effect.about().name);
        let (q, v, z) = moving(&model);
        let mut pass = TimePass::new(&model);
        let (lost, supplied) = System::new(&model).powers(&mut pass, NOW, &q, &v, &z);
        let scale: f64 = force(&model).iter().zip(&v).map(|(f, v)| (f * v).abs()).sum();
        assert!(lost >= -1e-12 * scale, "{} feeds {lost} W", effect.about().name);
        assert!(effect.about().timed || supplied == 0.0, "{} depends on time unsaid", effect.about().name);
    }
}

#[test]
fn pages_and_parameters_are_complete() {
    for effect in CATALOGUE {
        let about = effect.about();
        let page = effect.page();
        for heading in ["Law:", "Assumes:", "Off:", "Silent:", "Source:"] {
            assert!(page.contains(heading), "{}: the page lacks {heading}", about.name);
        }
        for p in about.parameters {
            assert!(
                models::quantity::Unit::parse(p.unit).is_ok() || p.unit.is_empty(),
                "{}: {}",
                about.name,
                p.unit
            );
            assert!(p.range.0 <= p.default && p.default <= p.range.1, "{}.{}", about.name, p.name);
        }
        for other in about.confounded_with {
            assert!(other.chars().all(|c| c.is_ascii_lowercase() || c == '_'), "{other}");
        }
    }
}

/// Turning everything turns the forces, and what is let go: with the clamp, the gravity off. What is
/// observed has no part in it: a camera does not turn with the rod.
#[test]
fn laws_are_frame_indifferent() {
    for effect in CATALOGUE.iter().filter(|e| !FIXED_IN_THE_LABORATORY.contains(&e.about().name)) {
        let model = on(effect.about().name);
        let mut still = model.clone();
        still.set("effects.gravity.acceleration", 0.0).expect("baseline");
        let turn = 0.9_f64;
        let mut turned = still.clone();
        for path in ["rod.base_angle", "release.angle"] {
            turned.set(path, turn).expect("a rod parameter");
        }
        let (q, v, z) = moving(&still);
        let rotate = |x: &[f64], angle: f64| -> Vec<f64> {
            let mut y: Vec<f64> = Vec::new();
            for pair in x[..x.len() - 1].chunks(2) {
                y.push(turn.cos() * pair[0] - turn.sin() * pair[1]);
                y.push(turn.sin() * pair[0] + turn.cos() * pair[1]);
            }
            y.push(x[x.len() - 1] + angle);
            y
        };
        let at = |model: &Model, q: &[f64], v: &[f64]| {
            let mut force = vec![0.0; q.len()];
            let mut rate = vec![0.0; z.len()];
            System::new(model).force(NOW, q, v, &z, &mut force, &mut rate);
            force
        };
        let expected = rotate(&at(&still, &q, &v), 0.0);
        let found = at(&turned, &rotate(&q, turn), &rotate(&v, 0.0));
        let scale = expected.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-11 * scale, "{}", effect.about().name);
        }
        let let_go = |model: &Model| {
            let assembly = &System::new(model).assembly;
            assembly.let_go(model, assembly.straight_at_release())
        };
        let ((q, v), (turned_q, turned_v)) = (let_go(&still), let_go(&turned));
        let expected = [rotate(&q, turn), rotate(&v, 0.0)].concat();
        for (found, expected) in turned_q.iter().chain(&turned_v).zip(&expected) {
            assert!((found - expected).abs() < 1e-14, "{} at release", effect.about().name);
        }
    }
}

/// Spec of the shared muscle with nothing added, so that the helper above is seen to add.
#[test]
fn the_baseline_is_in_every_model() {
    let model = Model::new(&ModelSpec { ..paper_spec(40.0, 8, &[]) }).expect("valid");
    for name in models::model::BASELINE {
        assert!(model.effect(name).is_some(), "{name}");
    }
}

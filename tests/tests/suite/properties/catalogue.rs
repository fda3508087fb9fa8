//! What every registered effect keeps, whoever wrote it.

use models::effects::CATALOGUE;
use models::model::{Model, ModelSpec};
use models::system::{System, TimePass};
use tests::paper_spec;

/// Time at which laws are looked at, s: not the release, at which a drift has not begun.
const NOW: f64 = 0.3;

/// Effects that pull towards places or directions of the laboratory, and so know its frame.
const FIXED_IN_THE_LABORATORY: [&str; 4] = ["gravity", "tip_load", "hose", "hand_release"];

/// A model in which one effect acts, at its default or, where that is off, at half its scale.
fn with(name: &str, off: bool) -> Option<Model> {
    let effect = models::effects::by_name(name).expect("registered");
    let mut values: Vec<(String, f64)> = Vec::new();
    for p in effect.about().parameters {
        let on = if Some(p.default) == p.off || p.default == 0.0 { 0.5 * p.scale } else { p.default };
        values.push((p.name.to_owned(), if off { p.off.unwrap_or(on) } else { on }));
    }
    if off && effect.about().parameters.iter().all(|p| p.off.is_none()) {
        return None;
    }
    let mut spec = paper_spec(40.0, 8, &[]);
    spec.effects.push((name.to_owned(), values));
    Some(Model::new(&spec).expect("defaults are admissible"))
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

/// What the forces do: a body adds none, but slows what they do.
fn acceleration(model: &Model) -> Vec<f64> {
    force(model).iter().zip(&System::new(model).mass).map(|(f, m)| f / m).collect()
}

#[test]
fn off_is_exactly_off_and_on_is_on() {
    for effect in CATALOGUE {
        let about = effect.about();
        let Some(off) = with(about.name, true) else { continue };
        let mut without = off.clone();
        without.effects.retain(|active| active.effect.about().name != about.name);
        assert_eq!(acceleration(&off), acceleration(&without), "{} at off", about.name);
        let on = with(about.name, false).expect("on");
        assert_ne!(acceleration(&on), acceleration(&without), "{} on", about.name);
    }
}

#[test]
fn at_off_the_sensitivity_is_not_zero() {
    for effect in CATALOGUE {
        for p in effect.about().parameters.iter().filter(|p| p.off.is_some()) {
            let Some(model) = with(effect.about().name, true) else { continue };
            let (q, v, z) = moving(&model);
            let mut system = System::new(&model);
            let k = model.index(&format!("effects.{}.{}", effect.about().name, p.name)).expect("there");
            system.watch(&[Some(k)]);
            let mut by_theta = vec![[0.0; models::effects::LANES]; q.len()];
            let mut rates = vec![[0.0; models::effects::LANES]; z.len()];
            // With every other parameter on, this one at off.
            system.by_parameters(0, NOW, &q, &v, &z, &mut by_theta, &mut rates);
            let others_off = effect.about().parameters.iter().filter(|p| p.off.is_some()).count() > 1;
            assert!(
                others_off || by_theta.iter().any(|row| row[0] != 0.0),
                "{}.{}",
                effect.about().name,
                p.name
            );
        }
    }
}

#[test]
fn none_feeds_energy() {
    for effect in CATALOGUE {
        let Some(model) = with(effect.about().name, false) else { continue };
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

/// Turning everything turns the forces: with the clamp, the gravity off.
#[test]
fn laws_are_frame_indifferent() {
    for effect in CATALOGUE.iter().filter(|e| !FIXED_IN_THE_LABORATORY.contains(&e.about().name)) {
        let Some(model) = with(effect.about().name, false) else { continue };
        let mut still = model.clone();
        still.set("effects.gravity.acceleration", 0.0).expect("baseline");
        let turn = 0.9_f64;
        let mut turned = still.clone();
        turned.set("rod.base_angle", turn).expect("a rod parameter");
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

//! Goal: no law of the catalogue hides a length, a time or a mass.
//! Setup: each effect, its parameters at their defaults or half their scale, in a release of the muscle of 40 psi
//! with 8 nodes; the same with all lengths, all times or all masses doubled, by the units of the parameters.
//! Expected: the tip, and where it is seen, go the same way, larger or slower, to rounding.

use efam_core::forward::Run;
use efam_core::integrate::Steps;
use models::effects::{CATALOGUE, Parameter, Rod, by_name};
use models::model::{Model, ModelSpec};
use tests::{paper_spec, simulate};

/// Friction turns round over a curvature of 0.01 1/m, of which a camera sees nothing.
const HAS_A_LENGTH: [&str; 4] = ["braid_friction", "friction_over_pressure", "clamp_friction", "hysteresis"];
/// The description's sign is smooth over 0.5 1/(m s).
const HAS_A_RATE: [&str; 1] = ["latent_moment"];

/// Air is a substance: it has a gas constant, a temperature and an ambient pressure.
const HAS_A_GAS: [&str; 1] = ["enclosed_air"];

/// By what lengths, times and masses are multiplied.
#[derive(Clone, Copy, Debug)]
struct Larger {
    length: f64,
    time: f64,
    mass: f64,
}

impl Larger {
    /// Of a unit such as `rad/(N m)`.
    fn factor(self, unit: &str) -> f64 {
        let (above, below) = unit.split_once('/').unwrap_or((unit, ""));
        let product = |words: &str| {
            words
                .trim_matches(['(', ')'])
                .split_whitespace()
                .map(|word| self.of_symbol(word))
                .product::<f64>()
        };
        product(above) / product(below)
    }

    /// Of a symbol with its power, such as `m^2`.
    fn of_symbol(self, word: &str) -> f64 {
        let Larger { length, time, mass } = self;
        let (symbol, power) = word.split_once('^').unwrap_or((word, "1"));
        let factor = match symbol {
            "m" => length,
            "s" => time,
            "kg" => mass,
            "N" => mass * length / (time * time),
            "Pa" => mass / (length * time * time),
            "Hz" => time.recip(),
            "1" | "rad" => 1.0,
            other => panic!("the unit {other} is not known here"),
        };
        factor.powi(power.parse().expect("a whole power"))
    }
}

/// A release with one effect, all of it larger.
fn spec(name: &str, larger: Larger) -> ModelSpec {
    let mut spec = paper_spec(40.0, 8, &[]);
    let is_on = |spec: &ModelSpec, name: &str| spec.effects.iter().any(|(own, _)| own == name);
    for effect in CATALOGUE.iter().map(|effect| effect.about()) {
        let standing = ["gravity", "rayleigh_mass", "rayleigh_stiffness"].contains(&effect.name);
        if (standing || effect.name == name) && !is_on(&spec, effect.name) {
            let value = |p: &Parameter| if p.default == 0.0 { 0.5 * p.scale } else { p.default };
            let values = effect.parameters.iter().map(|p| (p.name.to_owned(), value(p)));
            spec.effects.push((effect.name.to_owned(), values.collect()));
        }
    }
    let of = |unit: &str| larger.factor(unit);
    for (name, values) in &mut spec.effects {
        let effect = by_name(name).expect("registered");
        for (key, value) in values {
            let parameter = effect.about().parameters.iter().find(|p| p.name == *key).expect("it has it");
            *value *= of(parameter.unit);
        }
    }
    let Rod { length, mass, bending_stiffness, axial_stiffness, diameter, pressure } = spec.rod;
    spec.rod = Rod {
        length: length * of("m"),
        mass: mass * of("kg"),
        bending_stiffness: bending_stiffness * of("N m^2"),
        axial_stiffness: axial_stiffness * of("N"),
        diameter: diameter * of("m"),
        pressure: pressure * of("Pa"),
    };
    spec.tip_distance *= of("m");
    spec
}

/// Where the tip is and is seen, in lengths of the rod: steps are given, because a tolerance is a length.
fn path(name: &str, larger: Larger) -> Vec<[f64; 2]> {
    let spec = spec(name, larger);
    let run = Run {
        duration: 0.5 * larger.time,
        samples: (0..=50).map(|k| 0.01 * f64::from(k) * larger.time).collect(),
        steps: Steps::Fixed(1e-3 * larger.time),
        ..Run::release(0.5, 100.0)
    };
    let model = Model::new(&spec).unwrap_or_else(|error| panic!("{name}, {larger:?}: {error}"));
    let path = simulate(&model, &run);
    let per = larger.length.recip();
    path.tip.iter().chain(&path.seen_tip).map(|tip| tip.map(|x| per * x)).collect()
}

/// Largest distance of two paths, m.
fn apart(name: &str, larger: Larger) -> f64 {
    let one = Larger { length: 1.0, time: 1.0, mass: 1.0 };
    let pairs = path(name, one).into_iter().zip(path(name, larger));
    pairs.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).fold(0.0, f64::max)
}

#[test]
fn every_effect_scales_with_lengths_times_and_masses() {
    let one = Larger { length: 1.0, time: 1.0, mass: 1.0 };
    for name in CATALOGUE.iter().map(|effect| effect.about().name) {
        let twice = [Larger { length: 2.0, ..one }, Larger { time: 2.0, ..one }, Larger { mass: 2.0, ..one }];
        for (k, larger) in twice.into_iter().enumerate() {
            let hides = (k == 0 && HAS_A_LENGTH.contains(&name))
                || (k < 2 && HAS_A_RATE.contains(&name))
                || HAS_A_GAS.contains(&name);
            let apart = apart(name, larger);
            assert!(hides || apart < 1e-9, "{name}, {larger:?}: {apart:e} m");
            assert!(!hides || apart > 1e-9, "{name} hides nothing any more: {apart:e} m");
        }
    }
}

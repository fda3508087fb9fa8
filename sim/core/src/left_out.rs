//! What a model leaves out although its size is known: shear and rotary inertia of a thick section, and the size of a
//! payload that is a point. Each comes with how much it lowers a frequency, to first order.

use models::digits::significant;
use models::model::Model;
use models::quantity::format_si;
use models::statics::{Equilibrium, Mode, equilibrium, modes, section_share};

/// Share of a frequency that is worth a warning.
const LEAST: f64 = 0.01;
/// Densities of steel and of water, kg/m³: what is at hand as a weight lies between.
const DENSITIES: [f64; 2] = [7850.0, 1000.0];

/// Warnings of what lowers one of the `count` slowest modes by more than a per cent. The section of a muscle is no solid,
/// and its EI was fitted to the same model: of it only the payload is known.
pub fn warnings(model: &Model, is_muscle: bool, count: usize) -> Vec<String> {
    // Friction that sticks is no part of a swing.
    let slipping = model.slipping();
    let model = slipping.as_ref().unwrap_or(model);
    let Ok(rest) = equilibrium(model, None) else { return Vec::new() };
    let Ok(modes) = modes(model, &rest, count) else { return Vec::new() };
    let of_section = if is_muscle { None } else { of_section(model, &rest, &modes) };
    of_section.into_iter().chain(of_payload(model, &modes)).collect()
}

fn of_section(model: &Model, rest: &Equilibrium, modes: &[Mode]) -> Option<String> {
    let lowered = |(k, mode): (usize, &Mode)| {
        let share = lowered_by(section_share(model, rest, mode)?);
        let hertz = mode.angular_frequency / std::f64::consts::TAU;
        (share > LEAST).then(|| {
            let [percent, frequency] = [100.0 * share, hertz * (1.0 - share)];
            format!("mode {} by {} % to {} Hz", k + 1, significant(percent, 2), significant(frequency, 3))
        })
    };
    let all: Vec<String> = modes.iter().enumerate().filter_map(lowered).collect();
    (!all.is_empty()).then(|| {
        format!(
            "the rod is thick for its length: shear and rotary inertia of its section, which the model leaves out, \
             lower {}; an EI that is fitted to a frequency includes that",
            all.join(", ")
        )
    })
}

fn of_payload(model: &Model, modes: &[Mode]) -> Option<String> {
    let compact = Compact::of(model)?;
    let mode = modes.first()?;
    let [low, high] = compact.interval().map(|inertia| 100.0 * lowered_by(compact.share(mode, inertia)));
    (high > 100.0 * LEAST).then(|| {
        format!(
            "{}, which lowers mode 1 by {} to {} %; {MEASURE}",
            compact.words("the model has a point"),
            significant(low, 2),
            significant(high, 2)
        )
    })
}

/// What to do about a payload without a size.
pub const MEASURE: &str = "measure its size and how far its centre lies from the rod's end, and give rotary_inertia and \
                           center_of_mass of the payload";

/// Share by which a frequency falls where its square is divided by `1 + x`.
fn lowered_by(x: f64) -> f64 {
    1.0 - (1.0 + x).sqrt().recip()
}

/// A payload whose size nobody has given, as a compact body of its mass.
///
/// Its rotary inertia about the rod's end is at least that of a sphere of steel whose centre is there, `2/5 m r²`. It is
/// at most that of a sphere of water that touches the end from outside, `2/5 m r² + m r²`. Where the centre is given, both have
/// the sphere's own inertia only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compact {
    mass: f64,
    interval: [f64; 2],
}

impl Compact {
    /// The payload of a model; none where there is none, or its rotary inertia is given.
    pub fn of(model: &Model) -> Option<Self> {
        let value = |key: &str| model.value(&format!("effects.payload.{key}")).ok();
        let mass = value("mass").filter(|mass| *mass > 0.0)?;
        if value("rotary_inertia")? > 0.0 {
            return None;
        }
        let is_centered = value("center_of_mass")? != 0.0 || value("offset")? != 0.0;
        let farthest = if is_centered { 0.0 } else { 1.0 };
        let square = DENSITIES.map(|density| (0.75 * mass / (std::f64::consts::PI * density)).cbrt().powi(2));
        Some(Self { mass, interval: [0.4 * mass * square[0], (0.4 + farthest) * mass * square[1]] })
    }

    /// Interval of its rotary inertia that holds 95 %, kg m².
    pub fn interval(&self) -> [f64; 2] {
        self.interval
    }

    /// Median of the rotary inertia, kg m²; its logarithm is normal.
    pub fn median(&self) -> f64 {
        (self.interval[0] * self.interval[1]).sqrt()
    }

    /// Standard deviation of that logarithm: the ends of the interval are 1.96 deviations from the median.
    pub fn deviation(&self) -> f64 {
        (self.interval[1] / self.interval[0]).ln() / (2.0 * 1.96)
    }

    /// Kinetic energy of a rotary inertia in a mode, over that of the mode.
    fn share(&self, mode: &Mode, inertia: f64) -> f64 {
        mode.shape.last().map_or(0.0, |turn| inertia * turn * turn)
    }

    /// What is not known, in words; `taken` says what a model has in its place.
    pub fn words(&self, taken: &str) -> String {
        let [low, high] = self.interval.map(|inertia| format_si(inertia, "kg m^2"));
        format!(
            "the payload of {} has no size, and {taken}: a compact body of its mass, of steel or water, has a rotary inertia of {low} to {high} about the rod's end",
            format_si(self.mass, "kg")
        )
    }
}

#[cfg(test)]
mod tests {
    use models::effects::Rod;
    use models::model::ModelSpec;

    use super::*;

    fn model(rod: Rod<f64>, payload: &[(&str, f64)]) -> Model {
        Model::new(&ModelSpec::of(rod).with(&[("gravity.acceleration", 0.0)]).with(payload)).expect("a model")
    }

    /// A soft stub: Timoshenko has 23.7 Hz, Euler and Bernoulli 27.2 Hz. A rod of forty diameters is thin.
    #[test]
    fn a_thick_rod_is_said_with_the_size_of_the_error() {
        let stub = Rod { diameter: 0.02, ..Rod::plain(0.04, 13.4e-3, 2.03e-3) };
        let [warning] = &warnings(&model(stub, &[]), false, 1)[..] else { panic!("one warning") };
        assert!(warning.contains("mode 1 by 13 % to 23.7 Hz"), "{warning}");
        assert!(warnings(&model(stub, &[]), true, 1).is_empty());
        assert!(warnings(&model(Rod { length: 0.8, ..stub }, &[]), false, 1).is_empty());
        assert!(warnings(&model(Rod { diameter: f64::NAN, ..stub }, &[]), false, 1).is_empty());
    }

    /// A silicone beam with 52 and 104 g at its end. Expected, by Ritz with six powers of x: between a steel sphere at the end
    /// and one of water that touches it, 52 g lower the frequency by 0.40 to 5.34 %, 104 g by 0.77 to 9.77 %. The warning has the
    /// first order of it, which is low by the share itself: a twentieth and a tenth.
    #[test]
    fn a_payload_without_a_size_is_said_with_the_size_of_the_error() {
        let beam = Rod::plain(0.1, 0.0963, 0.01781);
        let of = |payload: &[(&str, f64)]| warnings(&model(beam, payload), false, 1);
        for (mass, least, most) in [(0.052, 0.40, 5.34), (0.104, 0.77, 9.77)] {
            let [warning] = &of(&[("payload.mass", mass)])[..] else { panic!("one warning") };
            assert!(warning.contains("give rotary_inertia"), "{warning}");
            let (_, range) = warning.split_once("lowers mode 1 by ").expect("a range");
            let (low, high) =
                range.split_once(" %").and_then(|(range, _)| range.split_once(" to ")).expect("two");
            for (text, due) in [(low, least), (high, most)] {
                let found: f64 = text.parse().expect("a number");
                // Half a digit of what is printed, and the second order.
                assert!((due - found).abs() < 0.01 + 0.01 * due * due, "{text} for {due}: {warning}");
            }
        }
        assert!(of(&[("payload.mass", 0.052), ("payload.rotary_inertia", 1e-5)]).is_empty());
        assert!(of(&[("payload.mass", 1e-3)]).is_empty() && of(&[]).is_empty());
    }

    /// A sphere of 52 g: of steel its radius is 11.65 mm, of water 23.16 mm; where its centre is given, it may not lie beside.
    #[test]
    fn the_interval_is_that_of_spheres() {
        let of = |payload: &[(&str, f64)]| {
            Compact::of(&model(Rod::plain(0.1, 0.0963, 0.01781), payload)).expect("a payload").interval()
        };
        let near = |found: [f64; 2], due: [f64; 2]| (0..2).all(|k| (found[k] / due[k] - 1.0).abs() < 1e-3);
        assert!(near(of(&[("payload.mass", 0.052)]), [2.823e-6, 3.903e-5]));
        let beyond = of(&[("payload.mass", 0.052), ("payload.center_of_mass", 0.015)]);
        assert!(near(beyond, [2.823e-6, 1.115e-5]), "{beyond:?}");
    }
}

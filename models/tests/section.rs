//! What shear and rotary inertia of the section take off a frequency, against Timoshenko's beam solved by shooting.

use std::f64::consts::TAU;

use models::effects::Rod;
use models::model::{Model, ModelSpec};
use models::statics::{equilibrium, modes, section_share};

/// E/(k G) of a material that keeps its volume.
const SHEAR: f64 = 10.0 / 3.0;

/// A solid round cantilever with a point mass at its end, kg.
#[derive(Clone, Copy)]
struct Beam {
    length: f64,
    mass: f64,
    stiffness: f64,
    diameter: f64,
    payload: f64,
}

impl Beam {
    /// Imbalance at the free end of Timoshenko's beam that vibrates at a frequency, rad/s: zero at a mode.
    fn imbalance(&self, omega: f64) -> f64 {
        const STEPS: usize = 400;
        let square = self.diameter * self.diameter / 16.0;
        let (line_mass, omega2) = (self.mass / self.length, omega * omega);
        let by_shear = square * SHEAR / self.stiffness;
        // Deflection, turn of the section, moment, shear force.
        let slope = |[w, turn, moment, force]: [f64; 4]| {
            [
                turn + by_shear * force,
                moment / self.stiffness,
                -force - line_mass * square * omega2 * turn,
                -line_mass * omega2 * w,
            ]
        };
        let step = self.length / STEPS as f64;
        let end = |start: [f64; 4]| {
            (0..STEPS).fold(start, |y, _| {
                let at = |by: [f64; 4], share: f64| [0, 1, 2, 3].map(|k| y[k] + share * step * by[k]);
                let a = slope(y);
                let b = slope(at(a, 0.5));
                let c = slope(at(b, 0.5));
                let d = slope(at(c, 1.0));
                [0, 1, 2, 3].map(|k| y[k] + step / 6.0 * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]))
            })
        };
        let free = |[w, _, moment, force]: [f64; 4]| [moment, force - self.payload * omega2 * w];
        let [a, b] = [[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]].map(|start| free(end(start)));
        a[0] * b[1] - a[1] * b[0]
    }

    /// Its slowest modes, Hz.
    fn timoshenko(&self, count: usize) -> Vec<f64> {
        let scale = (self.stiffness / (self.mass * self.length.powi(3))).sqrt();
        let mut found = Vec::new();
        let mut low = 0.05 * scale;
        while found.len() < count {
            let high = low + 0.05 * scale;
            if self.imbalance(low) * self.imbalance(high) < 0.0 {
                let (mut a, mut b) = (low, high);
                for _ in 0..60 {
                    let middle = 0.5 * (a + b);
                    if self.imbalance(a) * self.imbalance(middle) < 0.0 { b = middle } else { a = middle }
                }
                found.push(a / TAU);
            }
            low = high;
        }
        found
    }

    /// Slowest modes of the model, Hz, and those with the first order of shear and rotary inertia.
    fn corrected(&self) -> Vec<[f64; 2]> {
        let rod = Rod { diameter: self.diameter, ..Rod::plain(self.length, self.mass, self.stiffness) };
        let spec = ModelSpec::of(rod).with(&[("gravity.acceleration", 0.0), ("payload.mass", self.payload)]);
        let model = Model::new(&spec).unwrap();
        let rest = equilibrium(&model, None).unwrap();
        let modes = modes(&model, &rest, 2).unwrap();
        modes
            .iter()
            .map(|mode| {
                let own = mode.angular_frequency / TAU;
                [own, own / (1.0 + section_share(&model, &rest, mode).unwrap()).sqrt()]
            })
            .collect()
    }
}

/// A soft stub of 40 mm, 20 mm thick.
const STUB: Beam = Beam { length: 0.04, mass: 13.4e-3, stiffness: 2.03e-3, diameter: 0.02, payload: 0.0 };

/// The stub: 27.2 Hz by Euler and Bernoulli, 23.8 Hz by Timoshenko with the shear coefficient 0.9 (23.6 Hz with 5/6). The first
/// order in x is right to x², a tenth here; as a quotient it leaves less.
#[test]
fn a_stub_is_slower_by_an_eighth() {
    let due = STUB.timoshenko(1)[0];
    assert!((due - 23.8).abs() < 0.1, "{due} Hz");
    let [own, corrected] = STUB.corrected()[0];
    assert!((own - 27.23).abs() < 0.05, "{own} Hz");
    assert!((corrected / due - 1.0).abs() < 0.01, "{corrected} Hz, {due} Hz");
}

/// Rods of five to forty diameters, bare and with four times their mass at the end: the share that the section takes is
/// that of Timoshenko's beam, to second order in it.
#[test]
fn the_first_order_is_that_of_timoshenko() {
    for slenderness in [5.0, 10.0, 20.0, 40.0] {
        for payload in [0.0, 4.0 * STUB.mass] {
            let beam = Beam { length: slenderness * STUB.diameter, payload, ..STUB };
            let thin = Beam { diameter: 1e-6, ..beam };
            for (k, [own, corrected]) in beam.corrected().into_iter().enumerate() {
                let (due, euler) = (beam.timoshenko(2)[k], thin.timoshenko(2)[k]);
                let (share, expected) = (1.0 - corrected / own, 1.0 - due / euler);
                let error = (share - expected).abs();
                let tolerance = expected * expected + 0.03 * expected;
                assert!(error < tolerance, "{slenderness}, {payload} kg, mode {k}: {share}, due {expected}");
            }
        }
    }
}

/// The closed form of a bare cantilever, `x = 4.648 (1 + E/(k G)) (r/L)²`, and no section where none is known.
#[test]
fn a_cantilever_has_its_closed_form() {
    let rod = Rod::plain(0.4, 0.05, 0.02);
    let share = |rod: Rod<f64>| {
        let model = Model::new(&ModelSpec::of(rod).with(&[("gravity.acceleration", 0.0)])).unwrap();
        let rest = equilibrium(&model, None).unwrap();
        section_share(&model, &rest, &modes(&model, &rest, 1).unwrap()[0])
    };
    let due = |square: f64| 4.648 * (1.0 + SHEAR) * square / 0.16;
    let round = share(Rod { diameter: 0.02, ..rod }).unwrap();
    assert!((round / due(0.02 * 0.02 / 16.0) - 1.0).abs() < 0.01, "{round}");
    // E of 30 x 30 mm: EA = E a², EI = E a⁴/12.
    let square = share(Rod { axial_stiffness: 12.0 * 0.02 / 9e-4, ..rod }).unwrap();
    assert!((square / due(9e-4 / 12.0) - 1.0).abs() < 0.01, "{square}");
    assert_eq!(share(rod), None);
}

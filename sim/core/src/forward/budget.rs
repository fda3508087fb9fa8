//! The budget of energy: what is dissipated and supplied along a run.

use models::model::Model;
use models::snapshot::Energy;
use models::system::{System, TimePass};

use crate::integrate::{Integrator, State};

/// Energy dissipated and supplied, by Gauss's three points in every step.
pub(super) struct Budget {
    pass: TimePass,
    /// Dissipated and supplied up to the start of the last step, J.
    before: [f64; 2],
    /// Within the last step: powers at the three points, W.
    powers: [[f64; 2]; 3],
    last_step: f64,
}

/// Gauss's three points of the unit interval.
const GAUSS: [f64; 3] = [0.112_701_665_379_258_3, 0.5, 0.887_298_334_620_741_7];

impl Budget {
    pub fn new(model: &Model) -> Self {
        Self { pass: TimePass::new(model), before: [0.0; 2], powers: [[0.0; 2]; 3], last_step: 0.0 }
    }

    pub fn follow(&mut self, system: &mut System, integrator: &mut dyn Integrator, at: &mut State) {
        let (begin, end) = (integrator.step_start(), integrator.state().time);
        self.before = self.until(self.last_step, 1.0);
        self.last_step = end - begin;
        for (node, powers) in GAUSS.iter().zip(&mut self.powers) {
            let time = begin + node * (end - begin);
            integrator.interpolate(time, at);
            let (dissipated, supplied) = system.powers(&mut self.pass, time, &at.q, &at.v, &at.z);
            *powers = [dissipated, supplied];
        }
    }

    /// Dissipated and supplied up to a share `s` of the last step, of `h` seconds: the parabola
    /// through the three powers, integrated.
    fn until(&self, h: f64, s: f64) -> [f64; 2] {
        let mut sum = self.before;
        for (k, powers) in self.powers.iter().enumerate() {
            let [a, b] = [GAUSS[(k + 1) % 3], GAUSS[(k + 2) % 3]];
            let scale = (GAUSS[k] - a) * (GAUSS[k] - b);
            let weight = (s * s * s / 3.0 - (a + b) * s * s / 2.0 + a * b * s) / scale;
            for (sum, power) in sum.iter_mut().zip(powers) {
                *sum += h * weight * power;
            }
        }
        sum
    }

    pub fn at(&self, system: &mut System, at: &State, begin: f64, end: f64) -> Energy {
        let h = end - begin;
        let s = if h > 0.0 { (at.time - begin) / h } else { 0.0 };
        let [dissipated, supplied] = self.until(h, s);
        let (kinetic, elastic, potential) = system.energy(at.time, &at.q, &at.v, &at.z);
        Energy { kinetic, elastic, potential, dissipated, supplied: -supplied }
    }
}

//! The budget of energy: what is dissipated and supplied along a run.

use models::effects::Kind;
use models::fault::alone;
use models::model::Model;
use models::snapshot::Energy;
use models::system::{System, TimePass};

use crate::integrate::{Reached, State};
use crate::trajectory::Fed;

/// Energy dissipated and supplied, by Gauss's three points in every step.
pub(super) struct Budget {
    pass: TimePass,
    /// Dissipated and supplied up to the start of the last step, J.
    before: [f64; 2],
    /// Within the last step: powers at the three points, W.
    powers: [[f64; 2]; 3],
    last_step: f64,
    /// Laws as text, which nobody may have tested.
    laws: Vec<OfLaw>,
}

/// What one law takes from the rod, by the middle of each step: where a law never feeds energy, no error of that feeds
/// any.
struct OfLaw {
    fed: Fed,
    system: System,
    pass: TimePass,
    /// Taken so far, J.
    taken: f64,
    /// Whether it may give back what it has taken.
    stores: bool,
}

impl OfLaw {
    /// Those of the laws as text in a model that should feed no energy.
    fn all(model: &Model) -> Vec<Self> {
        let written =
            model.effects.iter().enumerate().filter(|(_, active)| {
                active.effect.text().is_some() && active.effect.about().kind != Kind::Load
            });
        written
            .map(|(k, active)| {
                let alone = alone(model, k);
                let about = active.effect.about();
                Self {
                    fed: Fed { law: about.name, energy: 0.0, since: None },
                    pass: TimePass::new(&alone),
                    system: System::new(&alone),
                    taken: 0.0,
                    stores: about.memory > 0 || about.kind == Kind::Elastic,
                }
            })
            .collect()
    }

    fn follow(&mut self, h: f64, at: &State) {
        let power = self.system.powers(&mut self.pass, at.time, &at.q, &at.v, &at.z).0;
        self.taken += h * power;
        let fed = if self.stores {
            (-self.taken).max(self.fed.energy)
        } else {
            self.fed.energy + (-h * power).max(0.0)
        };
        if fed > self.fed.energy {
            self.fed.energy = fed;
            self.fed.since.get_or_insert(at.time);
        }
    }
}

/// Gauss's three points of the unit interval.
const GAUSS: [f64; 3] = [0.112_701_665_379_258_3, 0.5, 0.887_298_334_620_741_7];

impl Budget {
    pub fn new(model: &Model) -> Self {
        Self {
            pass: TimePass::new(model),
            before: [0.0; 2],
            powers: [[0.0; 2]; 3],
            last_step: 0.0,
            laws: OfLaw::all(model),
        }
    }

    pub fn follow(&mut self, system: &mut System, integrator: &mut dyn Reached, at: &mut State) {
        let (begin, end) = (integrator.step_start(), integrator.state().time);
        self.before = self.until(self.last_step, 1.0);
        self.last_step = end - begin;
        for (node, powers) in GAUSS.iter().zip(&mut self.powers) {
            let time = begin + node * (end - begin);
            integrator.interpolate(time, at);
            let (dissipated, supplied) = system.powers(&mut self.pass, time, &at.q, &at.v, &at.z);
            *powers = [dissipated, supplied];
        }
        if !self.laws.is_empty() {
            integrator.interpolate(begin + 0.5 * (end - begin), at);
            self.laws.iter_mut().for_each(|law| law.follow(end - begin, at));
        }
    }

    /// What laws as text have fed.
    pub fn fed(&self) -> Vec<Fed> {
        self.laws.iter().filter(|law| law.fed.energy > 0.0).map(|law| law.fed).collect()
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

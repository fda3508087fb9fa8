//! The axial stiffness of a rod for which none is given.

use crate::digits::significant;
use crate::effects::{EffectFor, Mass, Tip};
use crate::quantity::format_si;
use crate::rod::Rod;

use super::{AXIAL_STIFFNESS, Model, RELEASE_ANGLE, RELEASE_RATE};

/// Where the axial stiffness of a model comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxialSource {
    /// It was given.
    Given,
    /// The diameter, as of a solid round section: `EA = 16 EI / d²`, eq. 8 of Garbulinski and Wereley (2022) without a
    /// bore.
    RoundSection,
    /// Nothing is known of it: the rod stretches too little to be seen.
    Unstretched,
}

/// Stretch of such a rod under the load at its release. The end of a hanging metre then lies 0.1 mm too low, and its
/// frequency is 5e-5 too small.
const UNSTRETCHED: f64 = 1e-4;
/// The least axial stiffness of such a rod over EI/L²: that of a round section and a length of fifty diameters, 16 · 50².
const SLENDER: f64 = 4e4;
/// Stretch under the load at the release from which on a diameter is not taken as that of a solid round section. It would
/// lower the frequency of a hanging rod by half a per cent. A strip whose width is given as its diameter is such a rod.
const DOUBTFUL: f64 = 0.01;

impl Model {
    /// Chooses an axial stiffness, N, where none is given, and says where it comes from.
    pub(super) fn choose_axial_stiffness(&mut self) {
        if !self.theta[AXIAL_STIFFNESS].is_nan() {
            return;
        }
        let round = self.round_axial_stiffness();
        let load = self.load_at_release();
        (self.theta[AXIAL_STIFFNESS], self.axial_source) = match round {
            Some(round) if load <= DOUBTFUL * round => (round, AxialSource::RoundSection),
            _ => {
                let Rod { length, bending_stiffness, .. } = self.rod();
                let slender = SLENDER * bending_stiffness / (length * length);
                (slender.max(load / UNSTRETCHED), AxialSource::Unstretched)
            }
        };
    }

    /// Square of the section's radius of gyration, `I/A`, m²; none where the section is not known. That of a given axial
    /// stiffness is `EI/EA`, at most that of a thin tube of the diameter, `d²/8`; that of a solid round section `d²/16`.
    pub fn gyration_square(&self) -> Option<f64> {
        let Rod { bending_stiffness, axial_stiffness, diameter, .. } = self.rod();
        let tube = if diameter > 0.0 { diameter * diameter / 8.0 } else { f64::INFINITY };
        match self.axial_source {
            AxialSource::Given => Some(tube.min(bending_stiffness / axial_stiffness)),
            AxialSource::RoundSection => Some(0.5 * tube),
            AxialSource::Unstretched => None,
        }
    }

    /// The axial stiffness of a solid round section of the rod's diameter, N; none without a diameter or EI.
    fn round_axial_stiffness(&self) -> Option<f64> {
        let Rod { diameter, bending_stiffness, .. } = self.rod();
        (diameter > 0.0 && bending_stiffness > 0.0).then(|| 16.0 * bending_stiffness / (diameter * diameter))
    }

    /// What pulls at the clamp at most while the straight rod is let go, N: weights, loads on the end body, and the pull
    /// of the initial rotation.
    fn load_at_release(&self) -> f64 {
        let rod = self.rod();
        let angle = self.theta[RELEASE_ANGLE];
        let tip = Tip {
            position: [rod.length * angle.cos(), rod.length * angle.sin()],
            velocity: [0.0; 2],
            angle,
            angular_velocity: 0.0,
            center: [0.0; 2],
            time: 0.0,
            rod: &rod,
        };
        let (mut along, mut at_end, mut reach) = (rod.mass, 0.0, 0.0);
        let (mut acceleration, mut force) = ([0.0; 2], [0.0; 2]);
        for active in &self.effects {
            let (effect, theta) = (active.effect, &self.theta[active.theta.clone()]);
            along += rod.length * EffectFor::<f64>::inertia(effect, &rod, theta).inert;
            let body = EffectFor::<f64>::body(effect, theta);
            at_end += body.mass;
            reach += body.mass * (rod.length + body.center_of_mass);
            let pull = EffectFor::<f64>::mass(effect, &Mass { time: 0.0, rod: &rod }, theta).acceleration;
            let load = EffectFor::<f64>::tip(effect, &tip, theta).force;
            for k in 0..2 {
                acceleration[k] += pull[k];
                force[k] += load[k];
            }
        }
        let rate = self.theta[RELEASE_RATE];
        let norm = |[x, z]: [f64; 2]| x.hypot(z);
        norm(acceleration) * (along + at_end)
            + norm(force)
            + rate * rate * (0.5 * along * rod.length + reach.abs())
    }

    /// What to know of an axial stiffness that was not given: that the diameter is not that of a solid round section.
    pub fn axial_warning(&self) -> Option<String> {
        let round = self.round_axial_stiffness().filter(|_| self.axial_source == AxialSource::Unstretched)?;
        let stretch = 100.0 * self.load_at_release() / round;
        Some(format!(
            "rod.diameter = {}: a solid round section of that size and EI would stretch by {} % under its load, so the \
             rod is taken not to stretch; give rod.axial_stiffness if it does",
            format_si(self.rod().diameter, "m"),
            significant(stretch, 2)
        ))
    }
}

//! What the rod went through before its release, for effects that remember.
//!
//! The rod is new and straight, and its memories are relaxed there. It hangs for a while in its rest
//! posture, is raised, and is held in the posture of release. While it is raised, the curvature of each
//! bend goes along a straight line from one posture to the other.
//!
//! Assumed: the posture does not wait for the memory. While it hangs it is the one in which all memories
//! are relaxed, with the loads that act at the release.
//!
//! Each memory obeys `ż = g(κ, κ̇, z)` with `κ` linear in time. A step is the exponential one of Rosenbrock
//! and Euler, `z + h φ₁(h g_z) g + h² φ₂(h g_z) g_t`, which is exact where `g` is linear in `z` and in time,
//! as of Maxwell branches and of friction with the exponent one. Elsewhere it is of second order, and steps
//! are halved until halving changes the memory by no more than `TOLERANCE`.
//! Source: Hochbruck and Ostermann (2010), Exponential integrators, Acta Numerica 19, sec. 2.4.

use crate::model::BASE_ANGLE;
use crate::system::System;

/// How long the rod hung, was raised and was held before its release, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct History {
    /// At rest under its weight, not negative.
    pub hung: f64,
    /// On the way from there to the posture of release, positive.
    pub raised: f64,
    /// In the posture of release, not negative.
    pub held: f64,
}

/// Change of the memory by halving a step, over one and the memory, that is admitted.
const TOLERANCE: f64 = 1e-9;
/// Share of a leg below which a step is not halved: rounding, not curvature.
const SMALLEST_STEP: f64 = 1e-6;

/// Integrated curvatures of the bends at both ends of a leg, and how long it takes, s.
struct Leg<'a> {
    from: &'a [f64],
    to: &'a [f64],
    duration: f64,
}

impl System {
    /// The memory at the release of a rod that hung with the coordinates `hanging` and is let go with
    /// `held`, shape `[2N+1]` each.
    pub fn remember(&mut self, history: &History, hanging: &[f64], held: &[f64]) -> Vec<f64> {
        let mut z = vec![0.0; self.model.memory()];
        let straight = self.assembly.straight(self.model.theta[BASE_ANGLE], 0.0).0;
        self.relax_memory(0.0, &straight, &mut z);
        let before = std::mem::replace(&mut self.assembly.stands_still, true);
        let [hanging, held] = [hanging, held].map(|q| {
            self.assembly.place(&self.model, 0.0, q, &vec![0.0; q.len()]);
            self.assembly.fields.kappa.clone()
        });
        for leg in [
            Leg { from: &hanging, to: &hanging, duration: history.hung },
            Leg { from: &hanging, to: &held, duration: history.raised },
            Leg { from: &held, to: &held, duration: history.held },
        ] {
            self.follow(&leg, &mut z);
        }
        self.assembly.stands_still = before;
        z
    }

    fn follow(&mut self, leg: &Leg, z: &mut Vec<f64>) {
        let (mut share, mut step) = (0.0, 1.0);
        while share < 1.0 && leg.duration > 0.0 {
            step = f64::min(step, 1.0 - share);
            let whole = self.step(leg, share, step, z);
            let half = self.step(leg, share, 0.5 * step, z);
            let twice = self.step(leg, share + 0.5 * step, 0.5 * step, &half);
            let changes = |(a, b): (&f64, &f64)| (a - b).abs() > TOLERANCE * (1.0 + b.abs());
            if step > SMALLEST_STEP && whole.iter().zip(&twice).any(changes) {
                step *= 0.5;
                continue;
            }
            *z = twice;
            share += step;
            step *= 2.0;
        }
    }

    /// The memory after a step of a leg, in shares of it.
    fn step(&mut self, leg: &Leg, share: f64, step: f64, z: &[f64]) -> Vec<f64> {
        let bends = self.model.edges + 1;
        let fields = &mut self.assembly.fields;
        for i in 0..bends {
            let change = leg.to[i] - leg.from[i];
            fields.kappa[i] = leg.from[i] + share * change;
            fields.kappa_rate[i] = change / leg.duration;
        }
        let h = step * leg.duration;
        let mut rate = vec![0.0; z.len()];
        self.linearise_bends(z, &mut rate);
        let kappa_rate = &self.assembly.fields.kappa_rate;
        let after = |(k, [g_kappa, _, g_z]): (usize, [f64; 3])| {
            let (x, by_time) = (h * g_z, g_kappa * kappa_rate[k % bends]);
            z[k] + h * (phi_1(x) * rate[k] + h * phi_2(x) * by_time)
        };
        self.tangent.memory_rates().enumerate().map(after).collect()
    }
}

/// `(eˣ − 1)/x`.
fn phi_1(x: f64) -> f64 {
    if x.abs() < 1e-8 { 1.0 + 0.5 * x } else { x.exp_m1() / x }
}

/// `(φ₁(x) − 1)/x`.
fn phi_2(x: f64) -> f64 {
    if x.abs() < 1e-3 { 0.5 + x / 6.0 + x * x / 24.0 } else { (phi_1(x) - 1.0) / x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::rod_with;
    use crate::model::Model;
    use crate::statics::equilibrium;

    fn hanging(model: &Model) -> Vec<f64> {
        equilibrium(model, None).unwrap().q
    }

    /// Curvature of the bends at coordinates, 1/m.
    fn curvature(model: &Model, q: &[f64]) -> Vec<f64> {
        let mut system = System::new(model);
        system.assembly.posture(q, &vec![0.0; q.len()]);
        let (c, f) = (&system.assembly.context, &system.assembly.fields);
        f.kappa.iter().zip(&c.per_voronoi).map(|(k, per)| k * per).collect()
    }

    /// A Maxwell branch: `z` goes to κ of the hanging posture as `exp(−t/τ)`, follows a curvature that
    /// falls in proportion to the time, and comes to rest at the straight posture, each in closed form.
    #[test]
    fn a_branch_remembers_as_its_solution_says() {
        let tau = 4.0;
        let model = rod_with(&[("viscoelastic", &[("branch_stiffness", 0.1), ("relaxation_time", tau)])]);
        let hanging = hanging(&model);
        let mut system = System::new(&model);
        let held = system.assembly.straight(0.1, 0.0).0;
        let history = History { hung: 9.0, raised: 3.0, held: 5.0 };
        let found = system.remember(&history, &hanging, &held);
        for (found, kappa) in found.iter().zip(curvature(&model, &hanging)) {
            let hung = kappa * (1.0 - (-9.0_f64 / tau).exp());
            // κ = κ₀ (1 − t/T): z = κ₀ (1 − (t − τ)/T) + (z₀ − κ₀ (1 + τ/T)) exp(−t/τ).
            let lag = 1.0 + tau / 3.0;
            let raised = kappa * (tau / 3.0) + (hung - kappa * lag) * (-3.0_f64 / tau).exp();
            let due = raised * (-5.0_f64 / tau).exp();
            assert!((found - due).abs() < 1e-12 * (1.0 + kappa.abs()), "{found}, due {due}");
        }
    }

    /// After long hanging and holding all is forgotten but the posture of release.
    #[test]
    fn after_long_holding_the_memory_is_relaxed() {
        let effects: [(&str, &[(&str, f64)]); 3] =
            [("relaxation", &[]), ("structural_damping", &[]), ("dahl", &[])];
        let model = rod_with(&effects);
        let (hanging, mut system) = (hanging(&model), System::new(&model));
        let held = system.assembly.straight(0.4, 0.0).0;
        let found = system.remember(&History { hung: 1e4, raised: 2.0, held: 1e4 }, &hanging, &held);
        let mut due = vec![0.0; model.memory()];
        system.relax_memory(0.0, &held, &mut due);
        for (found, due) in found.iter().zip(due) {
            assert!((found - due).abs() < 1e-9, "{found}, due {due}");
        }
    }

    /// What slides while it is raised has its whole moment at the end of it.
    #[test]
    fn friction_is_strained_by_the_raising() {
        let model = rod_with(&[("braid_friction", &[("creep_rate", 1e-6)])]);
        let (hanging, mut system) = (hanging(&model), System::new(&model));
        let held = system.assembly.straight(0.1, 0.0).0;
        let found = system.remember(&History { hung: 1.0, raised: 2.0, held: 0.0 }, &hanging, &held);
        for (found, kappa) in found.iter().zip(curvature(&model, &hanging)) {
            // Over a path of κ: z = −sgn κ (1 − exp(−|κ|/κ_b)), from z = 0, the rod having hung bent.
            let due = -kappa.signum() * (1.0 - (-kappa.abs() / 0.01).exp());
            assert!((found - due).abs() < 1e-4, "{found}, due {due}");
        }
    }
}

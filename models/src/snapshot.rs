//! What can be seen of the rod at one instant; observers draw and store it.

/// The rod at one instant, in W: x along the undeformed horizontal rod, z up, origin at the clamp.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Time since release, s.
    pub time: f64,
    /// Node positions, m, shape `[N+1]`.
    pub nodes: Vec<[f64; 2]>,
    /// Node velocities, m/s, shape `[N+1]`.
    pub velocities: Vec<[f64; 2]>,
    /// Angle of the rigid end body, rad, from x towards z.
    pub body_angle: f64,
    /// Angular velocity of the rigid end body, rad/s.
    pub body_angular_velocity: f64,
    /// Centre of mass of the rigid end body, m.
    pub body_center: [f64; 2],
    /// The observed tip point, m.
    pub tip: [f64; 2],
    /// Its velocity, m/s.
    pub tip_velocity: [f64; 2],
    /// Bending moment at the root, the interior nodes and the end fitting, N m, shape `[N+1]`;
    /// the moment with which the rod resists, positive where it is bent towards +z.
    pub bending_moment: Vec<f64>,
    /// Force of each active effect on each node, N.
    pub effect_forces: Vec<EffectForce>,
    /// Where the energy is.
    pub energy: Energy,
}

/// Force of one effect on the nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EffectForce {
    /// Name of the effect.
    pub effect: &'static str,
    /// Force on each node, N, shape `[N+1]`; the last node includes the loads of the end body.
    pub force: Vec<[f64; 2]>,
}

/// Where the energy is, J. Without a pressure that changes, the sum of all is constant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Energy of motion.
    pub kinetic: f64,
    /// Stored in stretch, bending and other elastic effects.
    pub elastic: f64,
    /// Potential energy of weight, and of other dead loads; zero at the height of the clamp.
    pub potential: f64,
    /// Dissipated since release.
    pub dissipated: f64,
    /// Minus the work that a changing pressure has done since release.
    pub supplied: f64,
}

impl Energy {
    /// All energy that a run accounts for, J: constant, but for the error of integration.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.potential + self.dissipated + self.supplied
    }
}

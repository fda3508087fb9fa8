//! An [`Effect`] that a model can hold without knowing its law, and the scalars over which it is
//! evaluated.

use std::ops::Range;

use num_dual::{Dual64, DualSVec64};

use super::about::About;
use super::law::{Body, Flow, Line, LineMass, Mass, MassLoad, Release, Sight, Tip, TipLoad};
use crate::context::Context;
use crate::kinematics::Fields;
use crate::pack::{Laid, Pack};
use crate::real::Real;
use crate::rod::Rod;

/// How many parameters one pass of sensitivities carries: with its value a dual number then fills
/// one cache line.
pub const LANES: usize = 6;
/// Scalar with [`LANES`] derivatives.
pub type Lanes = DualSVec64<LANES>;

/// The most parameters that one effect may have.
pub const MOST_PARAMETERS: usize = 8;

/// What an effect adds, over one scalar.
pub trait EffectFor<T: Real>: Sync {
    /// Adds moments at all bends, and writes the rates of the effect's memories, shape `[memories, N+1]`.
    fn add_moments(&self, c: &Context<T>, theta: &[T], f: &mut Fields<T>, z: &[T], z_rate: &mut [T]);
    /// Adds tensions of all edges.
    fn add_tensions(&self, c: &Context<T>, theta: &[T], f: &mut Fields<T>);
    /// Adds outer forces on all edges.
    fn add_flows(&self, c: &Context<T>, theta: &[T], f: &mut Fields<T>);
    /// The law of the surroundings of one edge.
    fn flow(&self, at: &Flow<T>, theta: &[T]) -> [T; 2];
    /// Load that goes with mass.
    fn mass(&self, at: &Mass<T>, theta: &[T]) -> MassLoad<T>;
    /// Load on the end body.
    fn tip(&self, at: &Tip<T>, theta: &[T]) -> TipLoad<T>;
    /// Body at the end of the active length.
    fn body(&self, theta: &[T]) -> Body<T>;
    /// How much further out all bodies at the end lie, m.
    fn shift(&self, theta: &[T]) -> T;
    /// Mass that moves with a metre of the rod.
    fn inertia(&self, at_release: &Rod<T>, theta: &[T]) -> LineMass<T>;
    /// Compliance of the clamp, rad/(N m).
    fn clamp(&self, theta: &[T]) -> T;
    /// Where an observed point is seen, m.
    fn sensor(&self, at: &Sight<T>, theta: &[T]) -> [T; 2];
    /// Time since release at a time of the recording, s.
    fn clock(&self, recorded: T, theta: &[T]) -> T;
    /// Pressure in the rod, Pa, and its rate, Pa/s.
    fn line(&self, at: &Line<T>, theta: &[T]) -> [T; 2];
    /// Time after which it begins to follow its command, s.
    fn dead_time(&self, theta: &[T]) -> T;
    /// What is added to the start.
    fn release(&self, theta: &[T]) -> Release<T>;
    /// Stored energy in bends, edges and tip load, J.
    fn energy(&self, c: &Context<T>, theta: &[T], f: &Fields<T>, z: &[T], tip: &Tip<T>) -> T;
}

/// A scalar over which registered effects are compiled.
pub trait Scalar: Real {
    /// The laws of an effect over this scalar.
    fn laws(effect: &'static dyn Effect) -> &'static dyn EffectFor<Self>;
}

impl Scalar for f64 {
    fn laws(effect: &'static dyn Effect) -> &'static dyn EffectFor<Self> {
        effect
    }
}

impl Scalar for Dual64 {
    fn laws(effect: &'static dyn Effect) -> &'static dyn EffectFor<Self> {
        effect
    }
}

impl Scalar for Lanes {
    fn laws(effect: &'static dyn Effect) -> &'static dyn EffectFor<Self> {
        effect
    }
}

/// Tangents of a law at a bend: by curvature, its rate and one memory.
#[derive(Clone, Copy, Debug, Default)]
pub struct BendTangent<T = f64> {
    /// Of the moment.
    pub moment: [T; 3],
    /// Of the rate of that memory.
    pub memory_rate: [T; 3],
}

/// A registered effect.
pub trait Effect: EffectFor<f64> + EffectFor<Dual64> + EffectFor<Lanes> {
    /// What the catalogue knows.
    fn about(&self) -> &'static About;
    /// Its page: law, symbols, assumptions, source.
    fn page(&self) -> String;
    /// The table `[laws.NAME]` that it was read from; none of an effect of the catalogue.
    fn text(&self) -> Option<&str>;
    /// Whether it needs the diameter elsewhere than in the flow, where it shows by itself.
    fn needs_diameter(&self) -> bool;
    /// Adds moments and memory rates of a pack of rods, as [`EffectFor::add_moments`] does for one.
    fn add_moments_of(
        &self,
        rods: &Laid,
        theta: Range<usize>,
        f: &mut Fields<Pack>,
        z: &[Pack],
        z_rate: &mut [Pack],
    );
    /// Adds tensions of a pack of rods.
    fn add_tensions_of(&self, rods: &Laid, theta: Range<usize>, f: &mut Fields<Pack>);
    /// Adds outer forces of a pack of rods.
    fn add_flows_of(&self, rods: &Laid, theta: Range<usize>, f: &mut Fields<Pack>);
    /// Adds the effect's moment and its tangents by curvature and rate, all of integrated
    /// curvature; for an effect with memories, writes their tangents and rates, shape `[memories, N+1]`.
    #[expect(clippy::too_many_arguments, reason = "what goes in, and four lists that come out")]
    fn linearise_moments(
        &self,
        c: &Context<f64>,
        theta: &[f64],
        f: &mut Fields<f64>,
        z: &[f64],
        by_kappa: &mut [f64],
        by_rate: &mut [f64],
        memory: &mut [BendTangent],
        z_rate: &mut [f64],
    );
    /// Adds the tangents of the moments by the mean square curvature.
    fn linearise_by_mean(
        &self,
        c: &Context<f64>,
        theta: &[f64],
        f: &Fields<f64>,
        z: &[f64],
        by_mean: &mut [f64],
    );
    /// Adds tensions and their tangents by stretch and its rate.
    fn linearise_tensions(
        &self,
        c: &Context<f64>,
        theta: &[f64],
        f: &mut Fields<f64>,
        by_stretch: &mut [f64],
        by_rate: &mut [f64],
    );
    /// Adds outer forces and their tangents: row of force (tangential, normal) by column of
    /// velocity (tangential, normal), N s/m.
    fn linearise_flows(
        &self,
        c: &Context<f64>,
        theta: &[f64],
        f: &mut Fields<f64>,
        by_velocity: &mut [[[f64; 2]; 2]],
    );
    /// Tangent of force (x, z) and moment by position, angle, velocity, angular velocity.
    fn linearise_tip(&self, at: &Tip<f64>, theta: &[f64]) -> [[f64; 6]; 3];
}

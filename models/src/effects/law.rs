//! What an effect's author writes: a law over a generic scalar, and what it is given to see.

use super::about::{About, Parameter};
use crate::number::Number;
use crate::plane::{cross, left};
use crate::real::Real;
use crate::rod::Rod;

/// A bend, as a law sees it.
#[derive(Clone, Copy, Debug)]
pub struct Bend<'a, T> {
    /// Curvature: integrated curvature over the Voronoi length, 1/m; positive towards +z.
    pub kappa: T,
    /// Its rate, 1/(m s), that of a changing rest length included.
    pub kappa_rate: T,
    /// Mean square of the curvature over the rod, 1/m²: for effects that name [`Whole`](super::Place::Whole),
    /// zero for others. Rates of memory must not depend on it.
    pub mean_square_curvature: T,
    /// Which of the effect's memories at this bend is meant, from 0; 0 for an effect with one or none.
    pub branch: usize,
    /// That memory.
    pub memory: T,
    /// Place along the rod, from 0 at the clamp to 1 at the end fitting.
    pub position: f64,
    /// Time since release, s.
    pub time: T,
    /// The rod as it is now.
    pub rod: &'a Rod<T>,
}

/// What a law says of a bend.
#[derive(Clone, Copy, Debug)]
pub struct Moment<T> {
    /// Resisting moment, N m: of the sign of the curvature that it resists; the branch's part of it.
    pub moment: T,
    /// Rate of the branch's memory, own unit per s.
    pub memory_rate: T,
}

impl<T: Real> Moment<T> {
    /// A moment without memory.
    pub fn of(moment: T) -> Self {
        let memory_rate = T::from(0.0);
        Self { moment, memory_rate }
    }
}

/// An edge along itself, as a law sees it.
#[derive(Clone, Copy, Debug)]
pub struct Edge<'a, T> {
    /// Current over rest length, minus one.
    pub stretch: T,
    /// Its rate, 1/s, that of a changing rest length included.
    pub stretch_rate: T,
    /// Place of the midpoint along the rod, from 0 at the clamp to 1 at the end fitting.
    pub position: f64,
    /// Time since release, s.
    pub time: T,
    /// The rod as it is now.
    pub rod: &'a Rod<T>,
}

/// The surroundings of an edge, as a law sees them.
#[derive(Clone, Copy, Debug)]
pub struct Flow<'a, T> {
    /// Velocity of the midpoint along the edge, m/s, positive towards the tip.
    pub tangential_velocity: T,
    /// Velocity of the midpoint across the edge, m/s, positive to the left when looking to the tip.
    pub normal_velocity: T,
    /// Place of the midpoint along the rod, from 0 at the clamp to 1 at the end fitting.
    pub position: f64,
    /// Time since release, s.
    pub time: T,
    /// The rod as it is now.
    pub rod: &'a Rod<T>,
}

/// All that has mass, as a law sees it.
#[derive(Clone, Copy, Debug)]
pub struct Mass<'a, T> {
    /// Time since release, s.
    pub time: T,
    /// The rod as it is now.
    pub rod: &'a Rod<T>,
}

/// A load that goes with mass: `force = mass (acceleration − rate · velocity)`, and likewise
/// `moment = −rotary inertia · rate · angular velocity`.
#[derive(Clone, Copy, Debug)]
pub struct MassLoad<T> {
    /// Uniform acceleration in W, m/s².
    pub acceleration: [T; 2],
    /// Rate at which velocities decay, 1/s.
    pub rate: T,
}

/// The end of the active length, as a law sees it.
#[derive(Clone, Copy, Debug)]
pub struct Tip<'a, T> {
    /// Position of the last node in W, m.
    pub position: [T; 2],
    /// Its velocity, m/s.
    pub velocity: [T; 2],
    /// Angle of the end body, rad, from x towards z.
    pub angle: T,
    /// Its rate, rad/s.
    pub angular_velocity: T,
    /// Centre of mass of all that is fixed to the last node, from there along and across the body's
    /// axis, m: end fitting, payload and their like, without the rod's last half cell.
    pub center: [T; 2],
    /// Time since release, s.
    pub time: T,
    /// The rod as it is now.
    pub rod: &'a Rod<T>,
}

impl<T: Real> Tip<'_, T> {
    /// From the last node to [`center`](Self::center), in W, m, with its rate, m/s.
    pub fn arm(&self) -> ([T; 2], [T; 2]) {
        let arm = in_world(self.center, [self.angle.cos(), self.angle.sin()]);
        (arm, left(arm).map(|x| x * self.angular_velocity))
    }
}

/// A vector along and across an axis, in W.
#[inline(always)]
fn in_world<T: Number>([along, across]: [T; 2], axis: [T; 2]) -> [T; 2] {
    let normal = left(axis);
    [0, 1].map(|k| axis[k] * along + normal[k] * across)
}

/// What acts on the end body at the last node.
#[derive(Clone, Copy, Debug)]
pub struct TipLoad<T> {
    /// Force in W, N.
    pub force: [T; 2],
    /// Moment, N m, positive from x towards z.
    pub moment: T,
}

impl<T: Real> TipLoad<T> {
    /// A force in W, N, at a point `arm` away from the last node, m.
    pub fn of_force_at(arm: [T; 2], force: [T; 2]) -> Self {
        Self { force, moment: cross(arm, force) }
    }
}

/// A rigid body fixed to the end of the active length.
#[derive(Clone, Copy, Debug)]
pub struct Body<T> {
    /// Mass, kg.
    pub mass: T,
    /// The part of it that weighs, kg.
    pub heavy: T,
    /// Centre of mass beyond the end of the active length, along the end fitting's axis, m.
    pub center_of_mass: T,
    /// Centre of mass beside that axis, m, positive to the left when looking outwards.
    pub offset: T,
    /// Rotary inertia about its own centre of mass, kg m².
    pub rotary_inertia: T,
}

impl<T: Real> Body<T> {
    /// A body on the axis from the values of [`BODY_PARAMETERS`].
    pub fn of(theta: &[T]) -> Self {
        let [mass, center_of_mass, rotary_inertia] = named(theta);
        Self { mass, heavy: mass, center_of_mass, offset: T::from(0.0), rotary_inertia }
    }
}

impl<T: Number> Body<T> {
    /// From the end of the active length to the centre of mass, in W, m, for a direction of the axis.
    #[inline(always)]
    pub fn arm(&self, axis: [T; 2]) -> [T; 2] {
        in_world([self.center_of_mass, self.offset], axis)
    }
}

/// Mass that moves with a metre of the rod.
#[derive(Clone, Copy, Debug)]
pub struct LineMass<T> {
    /// What has to be moved, kg/m.
    pub inert: T,
    /// What weighs, kg/m: what the fluid around it does not bear.
    pub heavy: T,
}

/// A pressure line while its command moves at a steady rate, as a law sees it; pressures from that at the release.
#[derive(Clone, Copy, Debug)]
pub struct Line<T> {
    /// Pressure in the rod when this begins, Pa.
    pub pressure: T,
    /// Commanded pressure then, Pa.
    pub command: T,
    /// Its rate, Pa/s.
    pub command_rate: T,
    /// Time since then, s.
    pub time: T,
}

/// What an effect adds to the posture and the velocities with which the rod is let go.
#[derive(Clone, Copy, Debug)]
pub struct Release<T> {
    /// Turn of the whole rod about the clamp, rad, from x towards z.
    pub angle: T,
    /// Angular velocity of the whole rod about the clamp, rad/s, from x towards z.
    pub angular_velocity: T,
}

/// A point of the rod that is observed.
#[derive(Clone, Copy, Debug)]
pub struct Sight<T> {
    /// Where it is in W, m, or where the effects before this one have it seen.
    pub position: [T; 2],
    /// Direction of the rod there, towards the tip, of length one; at the observed tip that of the
    /// end body.
    pub tangent: [T; 2],
    /// Place along the rod, from 0 at the clamp to 1 at the end fitting.
    pub share: f64,
    /// Whether it is the observed tip, which is a point of the end body.
    pub is_tip: bool,
}

/// Parameters of an effect that is a [`Body`].
pub const BODY_PARAMETERS: &[Parameter] = &[
    Parameter {
        name: "mass",
        meaning: "mass of the body",
        unit: "kg",
        default: 0.0,
        range: (0.0, 100.0),
        scale: 0.05,
        ..Parameter::PLAIN
    },
    Parameter {
        name: "center_of_mass",
        meaning: "its centre of mass beyond the end of the active length",
        unit: "m",
        default: 0.0,
        range: (-1.0, 10.0),
        scale: 0.01,
        ..Parameter::PLAIN
    },
    Parameter {
        name: "rotary_inertia",
        meaning: "its rotary inertia about its centre of mass",
        unit: "kg m^2",
        default: 0.0,
        range: (0.0, 100.0),
        scale: 1e-5,
        ..Parameter::PLAIN
    },
];

/// The first parameters of a law, to be given names: `let [friction_moment, creep_rate] = named(theta);`.
#[inline(always)]
pub fn named<T: Copy, const N: usize>(theta: &[T]) -> [T; N] {
    std::array::from_fn(|k| theta[k])
}

/// A physical effect as its author writes it: [`ABOUT`](Law::ABOUT) and the laws of the places
/// where it acts. Derivatives are taken by dual numbers; `theta` are the parameters, in the order
/// of `ABOUT.parameters`, SI, to which [`named`] gives names. A law of the catalogue has nothing in it; one that is
/// [read from text](crate::written) has its formulas.
///
/// Where a law has an energy, its force must be the gradient of it, or what is left over must not
/// feed energy: the energy budget takes the difference as dissipation.
pub trait Law: Sync + 'static {
    /// What the catalogue knows. No loop over the rod is compiled for places that it does not name.
    const ABOUT: About;

    /// The same of this law, which may act at fewer places.
    fn about(&self) -> &'static About {
        const { &Self::ABOUT }
    }
    /// Its page, if that is not the head of its file.
    fn page(&self) -> Option<&str> {
        None
    }
    /// The text that it was read from, if it was.
    fn text(&self) -> Option<&str> {
        None
    }
    /// Whether it needs the diameter elsewhere than in the flow, where it shows by itself.
    fn needs_diameter(&self) -> bool {
        false
    }

    /// Moment at a bend; of each [branch](Bend::branch), if the effect has several memories.
    fn bend<T: Real>(&self, _at: &Bend<T>, _theta: &[T]) -> Moment<T> {
        Moment::of(T::from(0.0))
    }
    /// Energy stored at a bend, J per metre of rod, of each branch; its derivative by `kappa` is a moment.
    fn bend_energy<T: Real>(&self, _at: &Bend<T>, _theta: &[T]) -> T {
        T::from(0.0)
    }
    /// Tension in an edge, N, positive where it pulls the ends together.
    fn edge<T: Real>(&self, _at: &Edge<T>, _theta: &[T]) -> T {
        T::from(0.0)
    }
    /// Energy stored in an edge, J per metre of rest length.
    fn edge_energy<T: Real>(&self, _at: &Edge<T>, _theta: &[T]) -> T {
        T::from(0.0)
    }
    /// Force on an edge from outside, tangential and normal, N per metre of rest length.
    fn flow<T: Real>(&self, _at: &Flow<T>, _theta: &[T]) -> [T; 2] {
        [T::from(0.0); 2]
    }
    /// Load that goes with mass.
    fn mass<T: Real>(&self, _at: &Mass<T>, _theta: &[T]) -> MassLoad<T> {
        let zero = T::from(0.0);
        MassLoad { acceleration: [zero; 2], rate: zero }
    }
    /// Load on the end body.
    fn tip<T: Real>(&self, _at: &Tip<T>, _theta: &[T]) -> TipLoad<T> {
        let zero = T::from(0.0);
        TipLoad { force: [zero; 2], moment: zero }
    }
    /// Potential energy of the load on the end body, J.
    fn tip_energy<T: Real>(&self, _at: &Tip<T>, _theta: &[T]) -> T {
        T::from(0.0)
    }
    /// Body at the end of the active length.
    fn body<T: Real>(&self, _theta: &[T]) -> Body<T> {
        let zero = T::from(0.0);
        Body { mass: zero, heavy: zero, center_of_mass: zero, offset: zero, rotary_inertia: zero }
    }
    /// How much further along the end fitting's axis all bodies at the end lie than they say, m.
    fn shift<T: Real>(&self, _theta: &[T]) -> T {
        T::from(0.0)
    }
    /// Mass that moves with a metre of the rod beside its own; of the rod at release, as masses are.
    fn inertia<T: Real>(&self, _at_release: &Rod<T>, _theta: &[T]) -> LineMass<T> {
        let zero = T::from(0.0);
        LineMass { inert: zero, heavy: zero }
    }
    /// Rotational compliance of the clamp, rad/(N m).
    fn clamp<T: Real>(&self, _theta: &[T]) -> T {
        T::from(0.0)
    }
    /// Where an observed point is seen, m.
    fn sensor<T: Real>(&self, at: &Sight<T>, _theta: &[T]) -> [T; 2] {
        at.position
    }
    /// Time since release, s, at which what is seen at the time `recorded` of the recording took
    /// place; it rises with it.
    fn clock<T: Real>(&self, recorded: T, _theta: &[T]) -> T {
        recorded
    }
    /// Pressure in the rod, Pa, and its rate, Pa/s, behind a command that [moves steadily](Line).
    fn line<T: Real>(&self, at: &Line<T>, _theta: &[T]) -> [T; 2] {
        [at.command + at.command_rate * at.time, at.command_rate]
    }
    /// Time after which the line begins to follow its command, s.
    fn dead_time<T: Real>(&self, _theta: &[T]) -> T {
        T::from(0.0)
    }
    /// What is added to the start.
    fn release<T: Real>(&self, _theta: &[T]) -> Release<T> {
        let zero = T::from(0.0);
        Release { angle: zero, angular_velocity: zero }
    }
}

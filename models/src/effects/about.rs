//! What the catalogue knows of an effect and of its parameters.

use crate::rod::Rod;

/// Acceleration of free fall where nothing else is said, m/s².
pub(super) const STANDARD_GRAVITY: f64 = 9.81;

/// What an effect does to the energy of the rod.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Stores energy and gives all of it back.
    Elastic,
    /// Never feeds energy to the rod.
    Dissipative,
    /// Adds mass or rotary inertia.
    Inertial,
    /// Acts from outside.
    Load,
    /// Changes what is observed, not what happens.
    Measurement,
    /// Describes a force whose cause nobody knows; no diagnosis names it.
    Description,
}

impl Kind {
    /// Whether it is the law of a material or of a fluid, which holds to a limited accuracy. A mass, a load or the place of a
    /// marker has no such error.
    pub fn is_law(self) -> bool {
        matches!(self, Self::Elastic | Self::Dissipative)
    }
}

/// A part of the rod that an effect can act on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Every bend, root and end fitting included: curvature, its rate, own memory; gives a moment.
    Bend,
    /// Every edge, along itself: stretch and its rate; gives a tension.
    Edge,
    /// Every edge, from outside: velocity of its midpoint; gives a force per unit length.
    Flow,
    /// The rod as a whole: its bends see the mean square curvature. Beside [`Place::Bend`].
    Whole,
    /// Everything that has mass: gives an acceleration and a rate of decay of velocity.
    Mass,
    /// The end of the active length: position, angle and their rates; gives a force and a moment.
    Tip,
    /// The rigid body at the end of the active length: gives mass, centre of mass, rotary inertia, and
    /// a shift of all that is fixed there.
    Body,
    /// What moves with the rod: gives masses per length, that which has to be moved and that which weighs.
    Inertia,
    /// The clamp: gives a rotational compliance in series with the root bend.
    Clamp,
    /// What brings a commanded pressure to the rod: gives the pressure behind a command that moves steadily, its rate, and a
    /// dead time.
    Line,
    /// The instant of release: gives a turn about the clamp and an angular velocity about it, on top
    /// of those of the start, whatever that is.
    Release,
    /// What is observed, and nothing of the rod itself: gives the position at which a point is seen,
    /// and the time at which.
    Sensor,
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Scenario key, `snake_case`, without unit.
    pub name: &'static str,
    /// What it is, as a phrase.
    pub meaning: &'static str,
    /// SI unit, such as `kg m^2`; empty if dimensionless. Scenario values must have its dimension.
    pub unit: &'static str,
    /// Value when the effect is switched on and the parameter is not given.
    pub default: f64,
    /// Smallest and largest admissible value, both included.
    pub range: (f64, f64),
    /// A typical size: step of finite differences, scale of fits.
    pub scale: f64,
    /// Value at which the effect is exactly zero, if this parameter alone can switch it off, or its
    /// share of the effect, if it [is a part](Self::is_part).
    /// A diagnosis tries an effect by the first of its parameters that has one.
    pub null_value: Option<f64>,
    /// Whether the effect is a sum in which this parameter scales one term: then the effect is off
    /// where all such parameters are, and not where one of them is.
    pub is_part: bool,
    /// Whether it is the size of a friction: where that is small against what it holds, the rod slips, and small
    /// vibrations, in which friction sticks as a spring, are not those of a swing.
    pub is_friction: bool,
    /// Smallest and largest value that a diagnosis finds plausible for a rod in a laboratory, in units of
    /// [`Self::per`]; none for all that is admissible. A fit that ends there is repeated with a wider range.
    pub plausible: Option<(f64, f64)>,
    /// What of the rod plausible and tried values are over.
    pub per: Per,
    /// Values at which a diagnosis tries the effect, in units of [`Self::per`], where its trace depends on this parameter
    /// other than in proportion, such as a time constant. Empty: it stays at its default.
    pub tries: &'static [f64],
    /// The effect beside which they are tried; in a model without it the parameter stays at its default.
    pub tries_beside: Option<&'static str>,
}

impl Parameter {
    /// What most parameters leave unsaid: `..Parameter::PLAIN`.
    pub const PLAIN: Parameter = Parameter {
        name: "",
        meaning: "",
        unit: "",
        default: 0.0,
        range: (0.0, 0.0),
        scale: 1.0,
        null_value: None,
        is_part: false,
        is_friction: false,
        plausible: None,
        per: Per::Unit,
        tries: &[],
        tries_beside: None,
    };
}

/// The property of the rod that scales a plausible value, so that one range suits a muscle of 30 g and a cable of 400 g.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Per {
    /// Nothing: the SI unit itself.
    Unit,
    /// Distributed mass of the rod, kg.
    Mass,
    /// Moment of its weight at the clamp when it is level, N m: friction that holds more than this lets nothing swing.
    WeightMoment,
    /// Its length, m.
    Length,
    /// Square of its length, m².
    LengthSquared,
    /// Curvature of a turn by one radian over its length, 1/m.
    Curvature,
    /// Angular velocity at which it hangs if it falls from the level about the clamp without bending, rad/s.
    Fall,
}

impl Per {
    /// Its size for a rod.
    pub fn of(self, rod: &Rod<f64>) -> f64 {
        match self {
            Per::Unit => 1.0,
            Per::Mass => rod.mass,
            Per::WeightMoment => 0.5 * rod.mass * STANDARD_GRAVITY * rod.length,
            Per::Length => rod.length,
            Per::LengthSquared => rod.length * rod.length,
            Per::Curvature => rod.length.recip(),
            Per::Fall => (3.0 * STANDARD_GRAVITY / rod.length).sqrt(),
        }
    }
}

/// What has a value of its own of an effect's parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// The muscle: one value for all releases.
    Muscle,
    /// Each pressure.
    Pressure,
    /// Each release.
    Release,
}

/// What an experiment can add to distinguish effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// Markers along the body.
    BodyMarkers,
    /// Releases at several pressures.
    Pressures,
    /// Releases from several angles.
    Angles,
    /// Releases with a weighed payload.
    Payload,
    /// A long recording, the rest after the swing included.
    LongRecord,
    /// The same release with the valve open and shut.
    Valve,
    /// A plate of known area at the tip.
    TipPlate,
    /// Several releases that are meant to be equal.
    Repeats,
    /// A faster camera on the hand.
    Video,
    /// A balance or a ruler: weights, lengths, the centre of mass.
    Metrology,
    /// The hose taken off, or held elsewhere.
    Hose,
    /// A recording in three dimensions.
    ThirdAxis,
}

/// What the catalogue knows of an effect.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// Stable name: scenario key, file name.
    pub name: &'static str,
    /// One sentence.
    pub meaning: &'static str,
    /// What it does to the energy.
    pub kind: Kind,
    /// Where it acts.
    pub places: &'static [Place],
    /// How many memories of the effect's own each bend carries. The moment is the sum over them, and the
    /// law is evaluated for one at a time, see [`Bend::branch`](super::Bend::branch); so no memory can depend on another.
    pub memory: usize,
    /// Whether its law names the time.
    pub timed: bool,
    /// Its parameters, in the order in which laws receive them.
    pub parameters: &'static [Parameter],
    /// What it looks like in a recording.
    pub signature: &'static str,
    /// Names of effects with which recordings confound it.
    pub confounded_with: &'static [&'static str],
    /// What distinguishes it from those.
    pub separated_by: &'static [Separator],
    /// What has its own values of the parameters.
    pub reach: Reach,
}

impl About {
    /// Whether the effect is exactly zero at these values of its parameters, in their order.
    pub fn is_off(&self, values: &[f64]) -> bool {
        let both = || self.parameters.iter().zip(values);
        let stands_off = |(p, value): (&Parameter, &f64)| p.null_value == Some(*value);
        let mut parts = both().filter(|(p, _)| p.is_part).peekable();
        both().any(|(p, value)| !p.is_part && stands_off((p, value)))
            || (parts.peek().is_some() && parts.all(stands_off))
    }
}

//! Effects as text: a law's formulas, parameters and units, read into an effect like those of the catalogue.
//!
//! A [`Definition`] is plain data; who reads files makes it. [`Definition::effect`] checks it and compiles its
//! formulas, once for each text: an effect lives as long as the program, as those of the catalogue do.

mod about;
mod law;
pub mod names;
mod page;
mod rust;
mod text;

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use thiserror::Error;

use crate::effects::{Effect, Kind, MOST_PARAMETERS, Per, Place, Reach, Registered, Separator};
use crate::formula::FormulaProblem;
use law::WrittenLaw;
pub use law::integral;

/// A law as its author writes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Definition {
    /// Name of the effect.
    pub name: String,
    /// One sentence.
    pub meaning: String,
    /// What it does to the energy; none to take it from the formulas.
    pub kind: Option<Kind>,
    /// Where it acts, of [`names::PLACES`].
    pub places: Vec<Place>,
    /// Its parameters, in their order.
    pub parameters: Vec<OwnParameter>,
    /// SI unit of its memory; empty for a plain number.
    pub memory_unit: String,
    /// Its formulas, each with the number of what it gives in [`names::OUTPUTS`].
    pub formulas: Vec<(usize, String)>,
    /// What it looks like in a recording.
    pub signature: String,
    /// Effects with which recordings confound it.
    pub confounded_with: Vec<String>,
    /// What distinguishes it from those.
    pub separated_by: Vec<Separator>,
    /// What has its own values of the parameters.
    pub reach: Reach,
    /// What it takes for granted, motions without a trace, and where it is from: for its page.
    pub notes: [Option<String>; 3],
}

/// Keys of [`Definition::notes`].
pub const NOTES: [&str; 3] = ["assumes", "silent", "source"];

/// A parameter of a law; as [`Parameter`](crate::effects::Parameter), of which it becomes one.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnParameter {
    /// Key.
    pub name: String,
    /// What it is.
    pub meaning: String,
    /// SI unit; empty if dimensionless.
    pub unit: String,
    /// Value where a scenario is silent.
    pub default: f64,
    /// Smallest and largest admissible value.
    pub range: (f64, f64),
    /// A typical size; none for that of the default.
    pub scale: Option<f64>,
    /// Value at which the law is off; none to take it from the formulas.
    pub null_value: Option<f64>,
    /// Whether it scales one term of several.
    pub is_part: bool,
    /// Whether it is the size of a friction.
    pub is_friction: bool,
    /// Its plausible range in a diagnosis, in units of `per`.
    pub plausible: Option<(f64, f64)>,
    /// What of the rod that is over.
    pub per: Per,
    /// Values at which a diagnosis tries the law.
    pub tries: Vec<f64>,
}

/// Names of the scales of plausible values.
pub const PER: [(&str, Per); 7] = [
    ("unit", Per::Unit),
    ("mass", Per::Mass),
    ("weight_moment", Per::WeightMoment),
    ("length", Per::Length),
    ("length_squared", Per::LengthSquared),
    ("curvature", Per::Curvature),
    ("fall", Per::Fall),
];

/// Names of what a law does to the energy; text makes no measurement, no mass and no description.
pub const KINDS: [(&str, Kind); 3] =
    [("elastic", Kind::Elastic), ("dissipative", Kind::Dissipative), ("load", Kind::Load)];

/// Names of what has its own values.
pub const REACHES: [(&str, Reach); 3] =
    [("muscle", Reach::Muscle), ("pressure", Reach::Pressure), ("release", Reach::Release)];

/// Names of what distinguishes effects.
pub const SEPARATORS: [(&str, Separator); 12] = [
    ("body_markers", Separator::BodyMarkers),
    ("pressures", Separator::Pressures),
    ("angles", Separator::Angles),
    ("payload", Separator::Payload),
    ("long_record", Separator::LongRecord),
    ("valve", Separator::Valve),
    ("tip_plate", Separator::TipPlate),
    ("repeats", Separator::Repeats),
    ("video", Separator::Video),
    ("metrology", Separator::Metrology),
    ("hose", Separator::Hose),
    ("third_axis", Separator::ThirdAxis),
];

/// What is wrong with a law, and where.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{problem}")]
pub struct LawError {
    /// Key in the law's table, such as `force` or `parameters.c.unit`; empty for the law itself.
    pub key: String,
    /// The bytes of its text that are at fault; none for all.
    pub span: Option<Range<usize>>,
    /// What is wrong.
    pub problem: LawProblem,
}

/// What is wrong with a law.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LawProblem {
    /// A formula.
    #[error(transparent)]
    Formula(#[from] FormulaProblem),
    /// The name of a law or of a parameter.
    #[error(
        "`{name}` cannot be a name; it begins with a small letter and goes on with small letters, digits and _"
    )]
    Name {
        /// The name.
        name: String,
    },
    /// A parameter with the name of something that the law sees.
    #[error("`{name}` is something that a law sees: {meaning}; give the parameter another name")]
    Shadows {
        /// The name.
        name: String,
        /// What it is.
        meaning: &'static str,
    },
    /// More parameters than a law may have.
    #[error("{found} parameters; a law has at most {MOST_PARAMETERS}")]
    TooMany {
        /// How many there are.
        found: usize,
    },
    /// A parameter that no formula names.
    #[error("no formula names it; use it or strike it")]
    Unused,
    /// A place without formula.
    #[error("a law at the place {place} gives {keys}; write one of them")]
    NoFormula {
        /// The place.
        place: &'static str,
        /// Keys that would do.
        keys: String,
    },
    /// A formula of another place.
    #[error("belongs to the place {place}; add that to `place`, or strike it")]
    OtherPlace {
        /// Its place.
        place: &'static str,
    },
    /// A unit that cannot be read, or is not the SI unit.
    #[error("{message}")]
    Unit {
        /// What is wrong.
        message: String,
    },
    /// A default or an off value outside the range, a range without room.
    #[error("{value}: must lie in the range {low}..={high}")]
    Range {
        /// Value found.
        value: f64,
        /// The range.
        low: f64,
        /// The range.
        high: f64,
    },
    /// A range that is none.
    #[error("the range must go from a smaller to a larger finite number")]
    NoRange,
    /// A memory without rate, or the other way round.
    #[error("{message}")]
    Memory {
        /// What is wrong.
        message: &'static str,
    },
}

/// The effects that were read, by their texts. It grows by one with each text that is new: an effect is never freed,
/// as models hold it without owning it.
static READ: Mutex<BTreeMap<String, &'static dyn Effect>> = Mutex::new(BTreeMap::new());

impl Definition {
    /// The effect.
    /// # Errors
    /// [`LawError`] for what cannot be, with its key and its place in the key's text.
    pub fn effect(&self) -> Result<&'static dyn Effect, LawError> {
        let text = self.text();
        let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = read.get(&text) {
            return Ok(*known);
        }
        let effect: &'static dyn Effect = Box::leak(Box::new(Registered::new(WrittenLaw::new(self)?, "")));
        read.insert(text, effect);
        Ok(effect)
    }
}

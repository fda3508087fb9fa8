//! Formulas as text: parsed once, checked for their units, and evaluated over any scalar of the laws.
//!
//! ```text
//! sum     = product { ("+" | "-") product }        abs sign sqrt exp log sin cos tan asin acos atan
//! product = unary { ("*" | "/") unary }            sinh cosh tanh  of one argument,  min max  of two
//! unary   = "-" unary | atom [ "^" unary ]         pi; `**` for `^`
//! atom    = number | name | name "(" sum { "," sum } ")" | "(" sum ")"
//! ```
//!
//! It is our own because no crate evaluates one parse over several scalars, knows units, and locates errors, see
//! decision 46.

mod parse;
mod program;
mod unit;

use std::ops::Range;

use thiserror::Error;

use crate::effects::Real;
use crate::nearest::offer;
pub use parse::parse;
pub use program::{Program, Source};
pub use unit::{Measure, measure};

/// Characters that a formula may have.
pub const LONGEST: usize = 1000;
/// Parentheses, signs and powers within one another.
const DEEPEST: usize = 32;

/// A part of a formula and its position.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// What it is.
    pub node: Node,
    /// Its bytes in the text.
    pub span: Range<usize>,
}

/// What a part of a formula is.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// A plain number.
    Number(f64),
    /// A parameter, or a quantity that the law sees.
    Name(String),
    /// The part with the other sign.
    Negative(Box<Term>),
    /// Two parts and what is between them.
    Binary(Operator, Box<[Term; 2]>),
    /// A function of its arguments.
    Call(Function, Vec<Term>),
}

/// An operator between two parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`
    Multiply,
    /// `/`
    Divide,
    /// `^`
    Power,
}

/// The functions that there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "they have their usual names")]
pub enum Function {
    Abs,
    /// −1, 0 or 1.
    Sign,
    Sqrt,
    Exp,
    Log,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Min,
    Max,
}

/// The functions by their names.
pub const FUNCTIONS: [(&str, Function); 16] = [
    ("abs", Function::Abs),
    ("sign", Function::Sign),
    ("sqrt", Function::Sqrt),
    ("exp", Function::Exp),
    ("log", Function::Log),
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("asin", Function::Asin),
    ("acos", Function::Acos),
    ("atan", Function::Atan),
    ("sinh", Function::Sinh),
    ("cosh", Function::Cosh),
    ("tanh", Function::Tanh),
    ("min", Function::Min),
    ("max", Function::Max),
];

impl Function {
    /// How many arguments it has.
    pub fn arguments(self) -> usize {
        if matches!(self, Function::Min | Function::Max) { 2 } else { 1 }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        FUNCTIONS.iter().find(|(_, function)| *function == self).map_or("", |(name, _)| name)
    }
}

/// What is wrong with a formula, and where.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{problem}")]
pub struct FormulaError {
    /// The bytes at fault.
    pub span: Range<usize>,
    /// What is wrong.
    pub problem: FormulaProblem,
}

/// What is wrong with a formula.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum FormulaProblem {
    /// It is too long or too deep.
    #[error(
        "a formula has at most {LONGEST} characters and {DEEPEST} levels of parentheses; cut it into parts"
    )]
    TooLarge,
    /// Something else is due here.
    #[error("{found} stands where {due} is due")]
    Unexpected {
        /// What the text has there.
        found: String,
        /// What is due.
        due: &'static str,
    },
    /// A character that no formula has.
    #[error("`{character}` is no part of a formula; {instead}")]
    Character {
        /// The character.
        character: char,
        /// What would do.
        instead: &'static str,
    },
    /// A name that means nothing here.
    #[error(
        "no `{name}` here{}; there are {}",
        offer(.nearest.as_deref()),
        .known.join(", ")
    )]
    Name {
        /// The name.
        name: String,
        /// What was most likely meant.
        nearest: Option<String>,
        /// Names that there are.
        known: Vec<String>,
    },
    /// A function with other arguments than it has.
    #[error("{function} takes {due} arguments, not {found}")]
    Arguments {
        /// Its name.
        function: &'static str,
        /// How many it takes.
        due: usize,
        /// How many it was given.
        found: usize,
    },
    /// Two parts of different units where they have to have one.
    #[error("{found} and {other} cannot be {verb}; both need the same unit")]
    Mixed {
        /// Unit of the one.
        found: String,
        /// Unit of the other.
        other: String,
        /// What was tried.
        verb: &'static str,
    },
    /// A unit where another one is due.
    #[error("this is in {found}, but {due} is due")]
    Unit {
        /// Its unit.
        found: String,
        /// The unit that is due.
        due: String,
    },
    /// A power of a quantity with a unit whose exponent is no number.
    #[error(
        "this is in {found}; a quantity with a unit takes a plain number as its exponent, such as 2 or 0.5"
    )]
    Exponent {
        /// Unit of the base.
        found: String,
    },
}

/// The exponent of a power, if it is written as a number.
pub fn exponent(term: &Term) -> Option<f64> {
    match &term.node {
        Node::Number(number) => Some(*number),
        Node::Negative(inner) => exponent(inner).map(|number| -number),
        Node::Binary(operator @ (Operator::Divide | Operator::Multiply), sides) => {
            let [left, right] = [exponent(&sides[0])?, exponent(&sides[1])?];
            Some(if *operator == Operator::Divide { left / right } else { left * right })
        }
        _ => None,
    }
}

/// The largest whole exponent that is a chain of products.
const LARGEST_WHOLE: f64 = 64.0;

/// A whole exponent, which a base of either sign takes.
pub fn whole(exponent: f64) -> Option<i32> {
    (exponent.fract() == 0.0 && exponent.abs() <= LARGEST_WHOLE).then_some(exponent as i32)
}

/// `base` to a power that is no whole number, with its first derivatives by both; of a base below zero not a number.
/// At a base of zero it is 0, with no derivative, but 1 for an exponent of zero.
pub fn power<T: Real>(base: T, exponent: T) -> T {
    if exponent.re() == 0.0 {
        // A plain number carries no derivative, and is spared the logarithm.
        if const { size_of::<T>() == size_of::<f64>() } {
            return T::from(1.0);
        }
        // The derivative by the exponent, which friction multiplies by the base, has a limit at 0.
        return exponent * base.re().max(f64::MIN_POSITIVE).ln() + 1.0;
    }
    match base.re() {
        base if base < 0.0 => T::from(f64::NAN),
        0.0 if exponent.re() > 0.0 => T::from(0.0),
        _ => base.powd(exponent),
    }
}

/// −1, 0 or 1, without derivative.
pub fn sign<T: Real>(x: T) -> T {
    T::from(if x.re() > 0.0 {
        1.0
    } else if x.re() < 0.0 {
        -1.0
    } else {
        0.0
    })
}

/// The smaller of two.
pub fn min<T: Real>(a: T, b: T) -> T {
    if b.re() < a.re() { b } else { a }
}

/// The larger of two.
pub fn max<T: Real>(a: T, b: T) -> T {
    if b.re() > a.re() { b } else { a }
}

/// The square root; at zero without derivative, which is infinite there.
pub fn root<T: Real>(x: T) -> T {
    if x.re() == 0.0 { T::from(0.0) } else { x.sqrt() }
}

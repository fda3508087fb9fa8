//! What a formula measures, from the units of its names.

use std::fmt;

use super::{FormulaError, FormulaProblem, Function, Node, Operator, Term, exponent};
use crate::quantity::Dimension;

/// Exponents of kilogram, metre and second. The radian is a plain number here: laws multiply by angles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measure([f64; 3]);

impl Measure {
    /// A plain number.
    pub const NONE: Measure = Measure([0.0; 3]);

    fn map(self, other: Measure, f: impl Fn(f64, f64) -> f64) -> Measure {
        Measure([0, 1, 2].map(|k| f(self.0[k], other.0[k])))
    }

    /// That of a product.
    pub fn times(self, other: Measure) -> Measure {
        self.map(other, |a, b| a + b)
    }

    /// That of a quotient.
    pub fn over(self, other: Measure) -> Measure {
        self.map(other, |a, b| a - b)
    }

    /// Of a power.
    fn to(self, exponent: f64) -> Measure {
        Measure(self.0.map(|own| own * exponent))
    }

    /// Whether it is the same, but for rounding of exponents such as 1/3.
    pub fn is(self, other: Measure) -> bool {
        self.0.iter().zip(other.0).all(|(a, b)| (a - b).abs() < 1e-9)
    }
}

impl From<Dimension> for Measure {
    fn from(of: Dimension) -> Self {
        Measure([of.kilogram, of.metre, of.second].map(f64::from))
    }
}

impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = || ["kg", "m", "s"].into_iter().zip(self.0).filter(|(_, exponent)| exponent.abs() > 1e-9);
        let part = |(unit, exponent): (&str, f64)| match exponent {
            1.0 => unit.to_owned(),
            _ => format!("{unit}^{}", (exponent * 1e4).round() / 1e4),
        };
        let [over, under] = [1.0, -1.0].map(|sign: f64| {
            let own = all().filter(|(_, exponent)| exponent * sign > 0.0);
            own.map(|(unit, exponent)| part((unit, exponent * sign))).collect::<Vec<_>>()
        });
        match (over.join(" "), under.join(" ")) {
            (over, under) if over.is_empty() && under.is_empty() => f.write_str("a plain number"),
            (over, under) if under.is_empty() => f.write_str(&over),
            (over, under) => {
                let over = if over.is_empty() { "1" } else { &over };
                // Of several units under the stroke each belongs there.
                let is_one = !under.contains(' ');
                if is_one { write!(f, "{over}/{under}") } else { write!(f, "{over}/({under})") }
            }
        }
    }
}

/// What a formula measures; none for a zero, which suits any quantity. `of` knows the names.
/// # Errors
/// [`FormulaError`] at the part whose units do not go together, or at a name that `of` refuses.
pub fn measure(
    term: &Term,
    of: &dyn Fn(&str) -> Result<Measure, FormulaProblem>,
) -> Result<Option<Measure>, FormulaError> {
    let at = |term: &Term, problem| FormulaError { span: term.span.clone(), problem };
    let plain = |term: &Term| match measure(term, of)? {
        Some(found) if !found.is(Measure::NONE) => {
            let problem = FormulaProblem::Unit { found: found.to_string(), due: Measure::NONE.to_string() };
            Err(at(term, problem))
        }
        _ => Ok(Some(Measure::NONE)),
    };
    let alike =
        |left: &Term, right: &Term, verb: &'static str| match (measure(left, of)?, measure(right, of)?) {
            (Some(a), Some(b)) if !a.is(b) => {
                let problem = FormulaProblem::Mixed { found: a.to_string(), other: b.to_string(), verb };
                Err(at(term, problem))
            }
            (a, b) => Ok(a.or(b)),
        };
    match &term.node {
        Node::Number(number) => Ok((*number != 0.0).then_some(Measure::NONE)),
        Node::Name(name) => of(name).map(Some).map_err(|problem| at(term, problem)),
        Node::Negative(inner) => measure(inner, of),
        Node::Binary(operator, sides) => {
            let [left, right] = &**sides;
            match operator {
                Operator::Add => alike(left, right, "added"),
                Operator::Subtract => alike(left, right, "subtracted"),
                Operator::Multiply => {
                    let (left, right) = (measure(left, of)?, measure(right, of)?);
                    Ok(left.zip(right).map(|(left, right)| left.times(right)))
                }
                Operator::Divide => {
                    let (over, under) = (measure(left, of)?, measure(right, of)?);
                    Ok(over.map(|over| over.over(under.unwrap_or_default())))
                }
                Operator::Power => {
                    plain(right)?;
                    match (measure(left, of)?, exponent(right)) {
                        (Some(base), Some(exponent)) => Ok(Some(base.to(exponent))),
                        (Some(base), None) if !base.is(Measure::NONE) => {
                            Err(at(left, FormulaProblem::Exponent { found: base.to_string() }))
                        }
                        (base, _) => Ok(base),
                    }
                }
            }
        }
        Node::Call(function, arguments) => match function {
            Function::Abs => measure(&arguments[0], of),
            Function::Sqrt => Ok(measure(&arguments[0], of)?.map(|own| own.to(0.5))),
            Function::Min | Function::Max => alike(&arguments[0], &arguments[1], "compared"),
            Function::Sign => measure(&arguments[0], of).map(|_| Some(Measure::NONE)),
            _ => plain(&arguments[0]),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;
    use crate::quantity::Unit;

    fn of(text: &str) -> Result<String, FormulaError> {
        let names = [("c", "kg/m^3"), ("v", "m/s"), ("d", "m"), ("kappa", "1/m"), ("phi", "rad")];
        let known = |name: &str| {
            let unit = names.iter().find(|(known, _)| *known == name).expect("a name").1;
            Ok(Unit::parse(unit).expect("a unit").dimension.into())
        };
        Ok(measure(&parse(text)?, &known)?.map_or("anything".to_owned(), |found| found.to_string()))
    }

    #[test]
    fn units_follow_the_formula() {
        for (text, unit) in [
            ("-c * v * abs(v) * d", "kg/s^2"),
            ("sqrt(v^2 + 0) / d", "1/s"),
            ("max(0, kappa)", "1/m"),
            ("0 * c", "anything"),
            ("c * 0", "anything"),
            ("(d^3)^(1/3)", "m"),
            ("2^(v/v)", "a plain number"),
            ("sin(phi) + 1", "a plain number"),
            ("1/(c*d)", "m^2/kg"),
            ("1/(v*c)", "m^2 s/kg"),
            ("v/d/d", "1/(m s)"),
        ] {
            assert_eq!(of(text).unwrap(), unit, "{text}");
        }
    }

    #[test]
    fn what_does_not_go_together_is_refused_where_it_stands() {
        for (text, at, message) in [
            ("c * (v + d)", 4..11, "m/s and m cannot be added; both need the same unit"),
            ("1 + exp(kappa)", 8..13, "this is in 1/m, but a plain number is due"),
            ("v^kappa", 2..7, "this is in 1/m, but a plain number is due"),
            ("d^sin(phi)", 0..1, "this is in m; a quantity with a unit takes a plain number"),
            ("min(d, v)", 0..9, "m and m/s cannot be compared"),
        ] {
            let error = of(text).unwrap_err();
            assert_eq!(error.span, at, "{text}: {error}");
            assert!(error.to_string().starts_with(message), "{text}: {error}");
        }
    }
}

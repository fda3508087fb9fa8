//! Quantities with units: `15 psi`, `80 g`, `0.2 rad/(N m)` into SI values, and back into short text.
//!
//! The dimension is checked against the unit that is due, so that no mass passes for a pressure and
//! no bare number for either. It is our own because `uom` reads only quantities that it has a name
//! for (not `N m^2` or `rad/(N m)`), and `rink` comes under the MPL with GPL data.

mod grammar;
mod kind;
mod misspelt;
mod names;
mod unit;

use std::fmt::{self, Display};

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use thiserror::Error;

use kind::QuantityKind;
pub use unit::{Dimension, Unit};

/// A number with its unit, as it was written.
///
/// Serialises as it was written: a string, or a plain number if it has no unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// The number as written, for messages.
    number: String,
    /// The unit as written; empty for a bare number.
    unit: String,
    value: f64,
    dimension: Dimension,
}

/// Why a text is not the quantity that is due.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum QuantityError {
    /// The text does not begin with a number.
    #[error("\"{text}\": begins with no number; write number and unit, such as \"15 psi\"")]
    NoNumber {
        /// What was written.
        text: String,
    },
    /// The number is infinite, too large, or NaN.
    #[error("{text}: the number must be finite")]
    NotFinite {
        /// What was written.
        text: String,
    },
    /// No unit has this name.
    #[error("unknown unit `{unit}`{}", offer(.meant))]
    UnknownUnit {
        /// The name.
        unit: String,
        /// What was most likely meant.
        meant: Option<String>,
    },
    /// The unit breaks the grammar.
    #[error("unit `{unit}`: {problem}")]
    MalformedUnit {
        /// The whole unit.
        unit: String,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A bare number where a unit is due.
    #[error("{number}: needs {}{}", unit_of(.due), such_as(.number, .due))]
    NeedsUnit {
        /// The number as written.
        number: String,
        /// A unit of what is due.
        due: String,
    },
    /// A quantity of another kind than is due.
    #[error("\"{number} {unit}\" is {}, but {} is due{}", kind_of(.unit), kind_of(.due), such_as(.number, .due))]
    WrongDimension {
        /// The number as written.
        number: String,
        /// The unit as written.
        unit: String,
        /// A unit of what is due; empty if a plain number is.
        due: String,
    },
}

impl Quantity {
    /// Reads a number, and the unit behind it if there is one: `15 psi`, `1.2e-3 N·m²`, `-5 %`, `3`.
    ///
    /// # Errors
    /// A [`QuantityError`] if it does not begin with a finite number or the unit cannot be read.
    pub fn parse(text: &str) -> Result<Quantity, QuantityError> {
        let text = text.trim();
        let (number, unit) = split_number(text).ok_or_else(|| {
            let text = text.to_string();
            if is_not_finite(&text) {
                QuantityError::NotFinite { text }
            } else {
                QuantityError::NoNumber { text }
            }
        })?;
        let (unit, number) = (unit.trim(), number.to_string());
        let Unit { scale, dimension } = Unit::parse(unit)?;
        let parsed: Result<f64, _> = number.replace('−', "-").parse();
        match parsed.map(|parsed| parsed * scale) {
            Ok(value) if value.is_finite() => {
                Ok(Quantity { number, unit: unit.to_string(), value, dimension })
            }
            _ => Err(QuantityError::NotFinite { text: text.to_string() }),
        }
    }

    /// A number without unit.
    ///
    /// # Errors
    /// [`QuantityError::NotFinite`] if it is infinite or NaN.
    pub fn bare(value: f64) -> Result<Quantity, QuantityError> {
        Quantity::parse(&value.to_string())
    }

    /// Value in the unit that is due, such as `kg m^2`; an empty `unit` expects a plain number. Zero needs no unit.
    ///
    /// # Errors
    /// [`QuantityError::NeedsUnit`] or [`QuantityError::WrongDimension`], with the right form.
    /// # Panics
    /// If `due` is not a unit; one that a user wrote goes through [`Unit::parse`] first.
    pub fn to(&self, due: &str) -> Result<f64, QuantityError> {
        let asked = Unit::parse(due).unwrap_or_else(|error| panic!("declared unit: {error}"));
        let is_zero = self.unit.is_empty() && self.value == 0.0;
        if is_zero || self.dimension.fits(asked.dimension) {
            return Ok(self.value / asked.scale);
        }
        let (number, due) = (self.number.clone(), due.to_string());
        Err(if self.unit.is_empty() {
            QuantityError::NeedsUnit { number, due }
        } else {
            QuantityError::WrongDimension { number, unit: self.unit.clone(), due }
        })
    }

    /// Value in SI units, radians for angles.
    pub fn si(&self) -> f64 {
        self.value
    }

    /// What it measures.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }
}

impl Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.number, behind_number(&self.unit))
    }
}

impl<'de> Deserialize<'de> for Quantity {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Quantity, D::Error> {
        deserializer.deserialize_any(Visitor)
    }
}

impl Serialize for Quantity {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.unit.is_empty() { serializer.serialize_f64(self.value) } else { serializer.collect_str(self) }
    }
}

/// `value` of SI unit `unit` as short text of four significant digits, with a prefix where the unit
/// is a single one: `103.4 kPa`, `54.92 g`, `0.00709 N m^2`.
///
/// [`Quantity::parse`] reads it back.
pub fn format_si(value: f64, unit: &str) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    let scaled = match unit {
        "kg" => scale(rounded * 1e3, "g", &["µ", "m", "", "k"]),
        "m" => scale(rounded, "m", &["n", "µ", "m", ""]),
        "s" => scale(rounded, "s", &["n", "µ", "m", ""]),
        "N" | "Pa" | "J" | "W" | "Hz" => scale(rounded, unit, &["n", "µ", "m", "", "k", "M", "G"]),
        _ => None,
    };
    let (number, unit) = scaled.unwrap_or((rounded, unit.to_string()));
    format!("{}{}", four_digits(number), behind_number(&unit))
}

/// Cuts `15psi` or `-1.2e-3 m` behind the number.
fn split_number(text: &str) -> Option<(&str, &str)> {
    let bytes = text.as_bytes();
    let digits = |from: usize| from + bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let sign = ["+", "-", "−"].iter().find(|sign| text.starts_with(**sign));
    let start = sign.map_or(0, |sign| sign.len());
    let mut end = digits(start);
    let mut count = end - start;
    if bytes.get(end) == Some(&b'.') {
        let fraction = digits(end + 1);
        count += fraction - end - 1;
        end = fraction;
    }
    if count == 0 {
        return None;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let signed = matches!(bytes.get(end + 1), Some(b'+' | b'-'));
        let first = end + 1 + usize::from(signed);
        if bytes.get(first).is_some_and(u8::is_ascii_digit) {
            end = digits(first);
        }
    }
    Some(text.split_at(end))
}

fn is_not_finite(text: &str) -> bool {
    let number = text.split_whitespace().next().unwrap_or_default();
    number.parse::<f64>().is_ok_and(|value| !value.is_finite())
}

/// The text after a number: the unit with a space before it, or nothing.
fn behind_number(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}

/// `value`, in `unit`, in the largest prefixed unit of which it is at least one.
fn scale(value: f64, unit: &str, prefixes: &[&str]) -> Option<(f64, String)> {
    let size = |unit: &str| Unit::parse(unit).map_or(1.0, |unit| unit.scale);
    let si = value * size(unit);
    let units = prefixes.iter().rev().map(|prefix| format!("{prefix}{unit}"));
    let suits = units.into_iter().find(|unit| si.abs() >= size(unit))?;
    Some((si / size(&suits), suits))
}

fn four_digits(value: f64) -> String {
    let scientific = format!("{value:.3e}");
    let Some((mantissa, exponent)) = scientific.split_once('e') else {
        return scientific; // NaN or inf
    };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trim = |number: &str| {
        if number.contains('.') {
            number.trim_end_matches('0').trim_end_matches('.').to_string()
        } else {
            number.to_string()
        }
    };
    if (-4..6).contains(&exponent) {
        let rounded: f64 = scientific.parse().unwrap_or(value);
        let decimals = usize::try_from(3 - exponent).unwrap_or(0);
        trim(&format!("{rounded:.decimals$}"))
    } else {
        format!("{}e{exponent}", trim(mantissa))
    }
}

/// Where [`QuantityError::UnknownUnit`] goes on.
fn offer(meant: &Option<String>) -> String {
    match meant {
        Some(meant) => format!("; did you mean `{meant}`?"),
        None => format!("; known are {}", names::names()),
    }
}

/// "a pressure", or the unit itself where its kind has no name.
fn kind_of(unit: &str) -> String {
    if unit.is_empty() {
        return "a plain number".to_string();
    }
    match QuantityKind::of(unit).map(|kind| kind.name) {
        Some(name) if name.starts_with(['a', 'e', 'i', 'o', 'u']) => format!("an {name}"),
        Some(name) => format!("a {name}"),
        None => format!("a value in `{unit}`"),
    }
}

/// "a unit of pressure", or "the unit `kg m^5`" where its kind has no name.
fn unit_of(due: &str) -> String {
    QuantityKind::of(due).map_or(format!("the unit `{due}`"), |kind| format!("a unit of {}", kind.name))
}

/// `, such as "15 psi" or "15 kPa"`, with the number that was written.
fn such_as(number: &str, due: &str) -> String {
    if due.is_empty() {
        return format!(", such as {number}");
    }
    let units = QuantityKind::of(due).map_or(vec![due], |kind| kind.units.to_vec());
    let forms: Vec<String> = units.iter().map(|unit| format!("\"{number} {unit}\"")).collect();
    format!(", such as {}", forms.join(" or "))
}

struct Visitor;

impl de::Visitor<'_> for Visitor {
    type Value = Quantity;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number with its unit, such as \"15 psi\"")
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Quantity, E> {
        Quantity::parse(text).map_err(E::custom)
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<Quantity, E> {
        Quantity::bare(value).map_err(E::custom)
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<Quantity, E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<Quantity, E> {
        self.visit_f64(value as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn si(text: &str, due: &str) -> f64 {
        let quantity = Quantity::parse(text).unwrap_or_else(|error| panic!("{error}"));
        quantity.to(due).unwrap_or_else(|error| panic!("{error}"))
    }

    fn error(text: &str, due: &str) -> String {
        let value = Quantity::parse(text).and_then(|quantity| quantity.to(due));
        value.unwrap_err().to_string()
    }

    #[test]
    fn reads_number_and_unit() {
        assert_eq!(si("6.69 in", "m"), 6.69 * 0.0254);
        assert_eq!(si("  +103kPa ", "Pa"), 103e3);
        assert_eq!(si("80 g", "kg"), 80.0 * 1e-3);
        assert_eq!(si("1.2e-3 N m^2", "N m^2"), 1.2e-3);
        assert_eq!(si(".5 1/s", "1/s"), 0.5);
        assert_eq!(si("3/s", "1/s"), 3.0);
        assert_eq!(si("-5 %", ""), -0.05);
        assert_eq!(si("−5", ""), -5.0);
        assert_eq!(si("9.81 m/s^2", "m/s^2"), 9.81);
        assert!((si("180 deg", "rad") - std::f64::consts::PI).abs() < 1e-15);
        assert!((si("15 psi", "kPa") - 103.421359).abs() < 1e-6);
        // The e of a unit is no exponent.
        assert!(error("5em", "m").starts_with("unknown unit `em`"));
        assert_eq!(
            error("5 em", "m"),
            "unknown unit `em`; known are g, m, s, rad, N, Pa, J, W, Hz with or without an SI prefix, and in, ft, lb, oz, lbf, psi, bar, mbar, atm, mmHg, min, h, deg, °, rpm, %"
        );
    }

    #[test]
    fn a_bare_number_is_right_only_where_no_unit_is_due() {
        assert_eq!(si("15", ""), 15.0);
        assert_eq!((si("0", "Pa"), si("-0.0", "1/s")), (0.0, 0.0));
        assert!(error("0 kg", "Pa").contains("is a mass"));
        assert_eq!(error("15", "Pa"), "15: needs a unit of pressure, such as \"15 psi\" or \"15 kPa\"");
        assert_eq!(error("0.30", "rad"), "0.30: needs a unit of angle, such as \"0.30 deg\" or \"0.30 rad\"");
        assert_eq!(error("2", "kg m^5"), "2: needs the unit `kg m^5`, such as \"2 kg m^5\"");
    }

    #[test]
    fn a_quantity_of_another_kind_is_refused_with_the_right_form() {
        assert_eq!(
            error("15 kg", "Pa"),
            "\"15 kg\" is a mass, but a pressure is due, such as \"15 psi\" or \"15 kPa\""
        );
        assert_eq!(
            error("30 deg", "m"),
            "\"30 deg\" is an angle, but a length is due, such as \"30 mm\" or \"30 in\""
        );
        assert_eq!(error("30 deg", ""), "\"30 deg\" is an angle, but a plain number is due, such as 30");
        assert_eq!(
            error("2 Hz", "rad/s"),
            "\"2 Hz\" is a frequency or rate, but an angular velocity is due, such as \"2 rad/s\" or \"2 rpm\""
        );
        assert_eq!(
            error("2 kg^2", "s"),
            "\"2 kg^2\" is a value in `kg^2`, but a time is due, such as \"2 s\" or \"2 ms\""
        );
    }

    /// Every unit that a message offers must be one that the key would have taken.
    #[test]
    fn offered_forms_are_accepted() {
        for due in [
            "m",
            "kg",
            "Pa",
            "rad",
            "1/s",
            "rad/s",
            "kg m^2",
            "N/m",
            "N m",
            "N m/rad",
            "rad/(N m)",
            "N m^2",
            "1/m",
            "N s/m",
            "N m s/rad",
            "kg/m",
        ] {
            let message = error("7 m^7", due);
            let offered: Vec<&str> = message.split('"').skip(3).step_by(2).collect();
            assert!(!offered.is_empty(), "{message}");
            for text in offered {
                si(text, due);
            }
        }
    }

    #[test]
    fn refuses_what_is_no_finite_number() {
        assert!(error("psi", "Pa").starts_with("\"psi\": begins with no number"));
        assert!(error("", "Pa").contains("begins with no number"));
        assert!(error(". m", "m").contains("begins with no number"));
        for text in ["NaN", "inf m", "-inf", "1e999 m", "1e308 GPa"] {
            assert_eq!(error(text, "m"), format!("{text}: the number must be finite"));
        }
        assert_eq!(error("1 parsecs/s", "m/s"), error("1 parsecs", "m"));
    }

    #[test]
    fn comes_from_a_string_or_a_number_and_goes_back() {
        #[derive(Deserialize, Serialize)]
        struct Keys {
            pressure: Quantity,
            factor: Quantity,
            count: Quantity,
        }
        let text = "pressure = \"15 psi\"\nfactor = 0.5\ncount = 3\n";
        let keys: Keys = toml::from_str(text).unwrap();
        assert_eq!(keys.pressure, Quantity::parse("15 psi").unwrap());
        assert_eq!(keys.factor.to("").unwrap(), 0.5);
        assert!(matches!(keys.count.to("kg"), Err(QuantityError::NeedsUnit { .. })));
        assert_eq!(toml::to_string(&keys).unwrap(), text.replace('3', "3.0"));

        let refused = |text: &str| toml::from_str::<Keys>(text).err().unwrap().to_string();
        assert!(refused("pressure = nan").contains("must be finite"));
        assert!(refused("pressure = \"15 pis\"").contains("did you mean `psi`?"));
        assert!(refused("pressure = true").contains("a number with its unit"));
    }

    #[test]
    fn prints_four_digits_with_a_prefix_that_suits() {
        for (value, unit, text) in [
            (103421.359, "Pa", "103.4 kPa"),
            (0.169926, "m", "169.9 mm"),
            (0.05492, "kg", "54.92 g"),
            (0.999_96, "m", "1 m"),
            (1.5, "kg", "1.5 kg"),
            (0.01, "s", "10 ms"),
            (-3.25e-5, "N", "-32.5 µN"),
            (0.00709, "N m^2", "0.00709 N m^2"),
            (123456.0, "N/m", "123500 N/m"),
            (2e-7, "1/s", "2e-7 1/s"),
            (0.25, "", "0.25"),
            (1200.0, "", "1200"),
            (0.0, "m", "0 m"),
            (2e12, "", "2e12"),
            (f64::NAN, "m", "NaN m"),
        ] {
            assert_eq!(format_si(value, unit), text);
        }
    }

    #[test]
    fn what_is_printed_can_be_read_back() {
        for unit in ["Pa", "m", "kg", "s", "N m^2", "rad/(N m)", "1/s", ""] {
            for exponent in -12..12 {
                let value = -1.2345 * 10f64.powi(exponent);
                let back = si(&format_si(value, unit), unit);
                // Half a unit of the fourth digit.
                assert!((back / value - 1.0).abs() < 5e-4, "{value} {unit}: {back}");
            }
        }
    }
}

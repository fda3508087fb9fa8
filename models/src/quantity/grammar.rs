//! The grammar that combines units.

use super::QuantityError;
use super::misspelt::meant;
use super::names::named;
use super::unit::Unit;

impl Unit {
    /// Reads a unit such as `kg m^2`, `lbf s/in^2`, `rad/(N·m)`, `1/s` or `%`; empty is [`Unit::ONE`].
    ///
    /// A space, `*` or `·` multiplies; `/` divides by the one factor that follows it; `^2` and `²`
    /// raise. What could be read in two ways, as `W/m s`, is refused.
    ///
    /// # Errors
    /// [`QuantityError::UnknownUnit`] or [`QuantityError::MalformedUnit`].
    pub fn parse(text: &str) -> Result<Unit, QuantityError> {
        let malformed = |problem| QuantityError::MalformedUnit { unit: text.to_string(), problem };
        if text.chars().count() > LONGEST {
            return Err(malformed("a unit this long cannot be meant"));
        }
        let mut reader = Reader { text, rest: text };
        let unit = reader.product()?;
        if !reader.rest.is_empty() {
            return Err(malformed("a closing parenthesis has no opening one"));
        }
        if !(unit.scale.is_finite() && unit.scale > 0.0) {
            return Err(malformed("its size is beyond the range of numbers"));
        }
        Ok(unit)
    }
}

/// More characters than any sensible unit has; it bounds the nesting of parentheses.
const LONGEST: usize = 64;

/// Reads a unit from left to right; `rest` is what is still to be read.
struct Reader<'a> {
    text: &'a str,
    rest: &'a str,
}

impl<'a> Reader<'a> {
    /// Factors up to the end or a closing parenthesis.
    fn product(&mut self) -> Result<Unit, QuantityError> {
        let mut product = Unit::ONE;
        let mut divided = false;
        let mut first = true;
        loop {
            self.skip_spaces();
            let divides = self.takes(&['/']);
            let multiplies = !divides && !first && self.takes(&['*', '·', '⋅']);
            self.skip_spaces();
            if self.rest.is_empty() || self.rest.starts_with(')') {
                return if divides || multiplies {
                    Err(self.malformed("it ends where a factor is due"))
                } else {
                    Ok(product)
                };
            }
            if divided && !divides {
                return Err(self.malformed(
                    "a product after `/` can be read in two ways; put the denominator in parentheses, as in rad/(N m)",
                ));
            }
            let (factor, power) = self.factor()?;
            product = product.times(factor, if divides { -power } else { power });
            divided = divides;
            first = false;
        }
    }

    /// One name, `1` or parenthesis with its power.
    fn factor(&mut self) -> Result<(Unit, i32), QuantityError> {
        if self.takes(&['(']) {
            let inside = self.product()?;
            if !self.takes(&[')']) {
                return Err(self.malformed("an opening parenthesis has no closing one"));
            }
            return Ok((inside, self.power()?));
        }
        let end = (self.rest)
            .find(|c: char| c.is_whitespace() || "*·⋅/^()".contains(c) || superscript(c).is_some());
        let (name, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest;
        let unit = match name {
            "" => return Err(self.malformed("an operator stands where a unit is due")),
            "1" => Unit::ONE,
            _ => named(name)
                .ok_or_else(|| QuantityError::UnknownUnit { unit: name.to_string(), meant: meant(name) })?,
        };
        Ok((unit, self.power()?))
    }

    /// `^2`, `^-1`, `²`, `⁻¹` or nothing, which is one.
    fn power(&mut self) -> Result<i32, QuantityError> {
        let raised: String = if self.takes(&['^']) {
            self.take_while(|c| (c == '-' || c.is_ascii_digit()).then_some(c))
        } else {
            let raised = self.take_while(superscript);
            if raised.is_empty() {
                return Ok(1);
            }
            raised
        };
        match raised.parse() {
            Ok(power @ -9..=9) => Ok(power),
            _ => Err(self.malformed("a power must be a whole number from -9 to 9")),
        }
    }

    fn skip_spaces(&mut self) {
        self.rest = self.rest.trim_start();
    }

    fn takes(&mut self, any: &[char]) -> bool {
        let rest = self.rest.strip_prefix(any);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn take_while(&mut self, digit: impl Fn(char) -> Option<char>) -> String {
        let end = self.rest.find(|c| digit(c).is_none());
        let (taken, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest;
        taken.chars().filter_map(digit).collect()
    }

    fn malformed(&self, problem: &'static str) -> QuantityError {
        QuantityError::MalformedUnit { unit: self.text.to_string(), problem }
    }
}

/// The digit or sign that a superscript character shows.
fn superscript(c: char) -> Option<char> {
    let shown = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹".chars().zip("-0123456789".chars());
    shown.into_iter().find(|pair| pair.0 == c).map(|pair| pair.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(text: &str) -> Unit {
        Unit::parse(text).unwrap_or_else(|error| panic!("{error}"))
    }

    fn error(text: &str) -> String {
        Unit::parse(text).unwrap_err().to_string()
    }

    /// Reference: NIST Special Publication 811 (2008), appendix B.8, to the digits given there.
    #[test]
    fn sizes_agree_with_nist() {
        for (text, si) in [
            ("psi", 6.894757e3),
            ("lbf", 4.448222),
            ("oz", 2.834952e-2),
            ("lb", 4.5359237e-1),
            ("mmHg", 1.333224e2),
            ("atm", 1.01325e5),
            ("ft", 3.048e-1),
            ("rpm", 1.047198e-1),
            ("deg", 1.745329e-2),
            ("lbf/in", 1.751268e2),
        ] {
            let relative = unit(text).scale / si - 1.0;
            // Seven digits are printed.
            assert!(relative.abs() < 5e-7, "{text}: {}", unit(text).scale);
        }
    }

    #[test]
    fn a_name_has_the_same_meaning_in_every_spelling() {
        for (one, other) in [
            ("kg m^2", "kg*m²"),
            ("kg m^2", " kg · m·m "),
            ("N", "kg m/s^2"),
            ("N", "kg m s⁻²"),
            ("Pa", "N/m/m"),
            ("rad/(N m)", "rad N^-1 m^-1"),
            ("1/s", "/s"),
            ("1/s", "Hz"),
            ("us", "µs"),
            ("us", "μs"),
            ("(N m)^2/s", "J J Hz"),
            ("lbf s/in^2", "psi s"),
        ] {
            let (one, other) = (unit(one), unit(other));
            assert_eq!(one.dimension, other.dimension, "{one:?} {other:?}");
            assert!((one.scale / other.scale - 1.0).abs() < 1e-14, "{one:?} {other:?}");
        }
        assert_eq!(unit(""), Unit::ONE);
        assert_eq!(unit("min").scale, 60.0);
        assert_eq!(unit("mN").scale, 1e-3);
        assert_eq!(unit("MN").scale, 1e6);
    }

    #[test]
    fn the_radian_drops_beside_mass_or_length_only() {
        let fits = |given: &str, due: &str| unit(given).dimension.fits(unit(due).dimension);
        assert!(fits("1/(N m)", "rad/(N m)"));
        assert!(fits("N m/deg", "N m"));
        assert!(fits("deg/m", "1/m"));
        assert!(!fits("Hz", "rad/s"));
        assert!(!fits("rad/s", "1/s"));
        assert!(!fits("deg", ""));
        assert!(!fits("%", "rad"));
        assert!(!fits("deg", "m"));
    }

    #[test]
    fn an_unknown_name_is_answered_with_the_likely_one() {
        for (wrong, right) in [
            ("PSI", "psi"),
            ("pis", "psi"),
            ("KPa", "kPa"),
            ("hz", "Hz"),
            ("inches", "in"),
            ("sec", "s"),
            ("m/s2", "s^2"),
            ("Nm", "N m"),
            ("Nm2", "N m^2"),
            ("Nm^2", "N m"),
            ("bars", "bar"),
        ] {
            let message = error(wrong);
            assert!(message.ends_with(&format!("; did you mean `{right}`?")), "{message}");
        }
        assert!(error("parsec").contains("known are g, m, s, rad, N, Pa"), "{}", error("parsec"));
    }

    #[test]
    fn refuses_what_is_no_unit() {
        for (text, problem) in [
            ("rad/N m", "read in two ways"),
            ("rad/", "ends where a factor is due"),
            ("N *", "ends where a factor is due"),
            ("* N", "operator stands where a unit is due"),
            ("N//m", "operator stands where a unit is due"),
            ("rad/(N m", "no closing one"),
            ("N m)", "no opening one"),
            ("m^", "a power must be"),
            ("m^10", "a power must be"),
            ("m^1.5", "unknown unit `.5`"),
            ("((((((Gs^9)^9)^9)^9)^9)^9)", "beyond the range"),
            (&"(".repeat(100), "this long"),
        ] {
            assert!(error(text).contains(problem), "{text}: {}", error(text));
        }
    }
}

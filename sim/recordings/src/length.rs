//! Units of length in which recordings give positions.

use std::fmt;
use std::str::FromStr;

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// m
    Metre,
    /// cm
    Centimetre,
    /// mm
    Millimetre,
    /// um
    Micrometre,
    /// in
    Inch,
    /// ft
    Foot,
    /// One of a picture's pixels, whose length no file states.
    Pixel,
    /// So many metres, such as `0.42 mm` to a pixel.
    Of(f64),
}

/// Each with its symbol, its length in metres, and what else files call it.
const LENGTHS: [(Length, &str, f64, &[&str]); 6] = [
    (Length::Metre, "m", 1.0, &["meter", "meters", "metre", "metres"]),
    (Length::Centimetre, "cm", 1e-2, &["centimeter", "centimeters", "centimetre", "centimetres"]),
    (Length::Millimetre, "mm", 1e-3, &["millimeter", "millimeters", "millimetre", "millimetres"]),
    (
        Length::Micrometre,
        "um",
        1e-6,
        &["µm", "μm", "micrometer", "micrometers", "micrometre", "micrometres", "micron", "microns"],
    ),
    (Length::Inch, "in", 0.0254, &["inch", "inches"]),
    (Length::Foot, "ft", 0.3048, &["foot", "feet"]),
];

/// What files call a pixel.
const PIXELS: [&str; 4] = ["px", "pix", "pixel", "pixels"];
/// Letters that a unit which a file cut off must have left.
const LEAST_LETTERS: usize = 3;

/// What is said of a length in millimetres that was taken for metres.
pub const TOO_FAR: &str = "1000 times too far: is the unit mm?";
/// How far a length may be off a thousand times another one, as a factor, for its unit to be doubted.
const DOUBT: f64 = 2.5;

impl Length {
    /// Its length, m; of a pixel no number.
    pub fn metres(self) -> f64 {
        match self {
            Length::Pixel => f64::NAN,
            Length::Of(metres) => metres,
            named => named.row().2,
        }
    }

    /// What a length that is seen says of its unit, where another one would make it about the length that is due:
    /// "1000 times too far: is the unit mm?".
    pub fn doubt(seen: f64, due: f64) -> Option<&'static str> {
        let times = seen / due;
        let near = |factor: f64| (factor / DOUBT..factor * DOUBT).contains(&times);
        match times {
            _ if near(1e3) => Some(TOO_FAR),
            _ if near(1e-3) => Some("1000 times too near: is the unit m?"),
            _ => None,
        }
    }

    /// A length in this unit, in metres, with one rounding.
    pub(super) fn to_metres(self, value: f64) -> f64 {
        let metres = self.metres();
        let per_metre = (1.0 / metres).round();
        // 0.001 is no exact number, 1000 is.
        let divides = (per_metre * metres - 1.0).abs() < f64::EPSILON;
        if divides { value / per_metre } else { value * metres }
    }

    /// Its symbol, such as `mm`.
    pub fn symbol(self) -> String {
        match self {
            Length::Pixel => "px".to_owned(),
            Length::Of(metres) => format!("{} mm", 1e3 * metres),
            named => named.row().1.to_owned(),
        }
    }

    /// All units by their symbols.
    pub fn by_symbol() -> [(&'static str, Length); 6] {
        LENGTHS.map(|row| (row.1, row.0))
    }

    /// All symbols, for messages.
    fn symbols() -> String {
        LENGTHS.map(|row| row.1).join(", ")
    }

    /// The unit of a symbol or name, in any case.
    pub(super) fn named(word: &str) -> Option<Self> {
        let word = word.trim().to_lowercase();
        if PIXELS.contains(&word.as_str()) {
            return Some(Length::Pixel);
        }
        let row = LENGTHS.iter().find(|row| row.1 == word || row.3.contains(&word.as_str()));
        row.map(|row| row.0)
    }

    /// The unit whose name begins with a word that a file cut off, such as `mete`.
    pub(super) fn cut_off(word: &str) -> Option<Self> {
        let word = word.trim().to_lowercase();
        let begins = |name: &&str| name.starts_with(&word);
        let row = LENGTHS.iter().find(|row| row.3.iter().any(begins));
        row.filter(|_| word.chars().count() >= LEAST_LETTERS).map(|row| row.0)
    }

    fn row(self) -> &'static (Length, &'static str, f64, &'static [&'static str]) {
        LENGTHS.iter().find(|row| row.0 == self).expect("every unit has a row")
    }
}

/// A unit that is none of length.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{place}: `{value}` is no unit of length; it must be one of {}, or a length such as `0.42 mm` to a pixel",
    Length::symbols()
)]
pub struct UnknownUnit {
    /// Its place.
    pub place: String,
    /// The text found there.
    pub value: String,
}

impl FromStr for Length {
    type Err = UnknownUnit;

    fn from_str(word: &str) -> Result<Self, UnknownUnit> {
        let unknown = || UnknownUnit { place: "unit".to_owned(), value: word.to_owned() };
        let is_length = |length: &Length| *length != Length::Pixel;
        if let Some(length) = Length::named(word).filter(is_length) {
            return Ok(length);
        }
        let word = word.trim();
        let end = word.rfind(|c: char| c.is_ascii_digit() || c == '.').map_or(0, |at| at + 1);
        let (number, unit) = word.split_at(end);
        let unit = Length::named(unit).filter(is_length).ok_or_else(unknown)?;
        let metres = number.parse().map(|number| unit.to_metres(number)).map_err(|_| unknown())?;
        if metres > 0.0 && metres.is_finite() { Ok(Length::Of(metres)) } else { Err(unknown()) }
    }
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.symbol())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_all_systems_are_known() {
        for (word, metres) in [
            ("mm", 1e-3),
            ("Meters", 1.0),
            (" MM ", 1e-3),
            ("Inches", 0.0254),
            ("µm", 1e-6),
            ("micron", 1e-6),
        ] {
            assert_eq!(Length::named(word).map(Length::metres), Some(metres), "{word}");
        }
        assert_eq!(Length::named("deg"), None);
        let doubts = [219.8, 0.25, 20.0, 2.0e-4].map(|seen| Length::doubt(seen, 0.2));
        assert_eq!(doubts, [Some(TOO_FAR), None, None, Some("1000 times too near: is the unit m?")]);
        assert_eq!(Length::Millimetre.to_metres(4.35), 4.35 / 1e3);
        assert_eq!(Length::Foot.to_metres(2.0), 2.0 * 0.3048);
        assert_eq!(
            "furlong".parse::<Length>().unwrap_err().to_string(),
            "unit: `furlong` is no unit of length; it must be one of m, cm, mm, um, in, ft, or a length such as `0.42 mm` to a \
             pixel"
        );
        assert_eq!("0.5 mm".parse(), Ok(Length::Of(5e-4)));
        for none in ["px", "0 mm", "-1 mm", "2", "2 px", "1e999 m"] {
            assert!(none.parse::<Length>().is_err(), "{none}");
        }
        assert_eq!(
            ["mete", "MILLI", "m", "me"].map(Length::cut_off),
            [Some(Length::Metre), Some(Length::Millimetre), None, None]
        );
    }
}

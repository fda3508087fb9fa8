//! A number with its 95 % interval, as people read it.

use models::digits::{significant, unsigned_zero};

/// Digits of a value that has no interval.
const DIGITS: i32 = 4;
/// Digits after which a difference is rounding: a double has sixteen.
const MOST_DIGITS: i32 = 13;
/// Sizes beyond which a decimal number would be mostly zeros.
const WITHOUT_EXPONENT: std::ops::Range<f64> = 1e-6..1e9;

/// A value and the ends of its interval, so many times finer, with as many decimals each as two digits of the
/// interval's width need, and four digits of the value at least.
///
/// An interval is often much narrower than the value: `-225.31` with `-225.35 to -225.27`.
pub fn with_ends(value: f64, ends: Option<[f64; 2]>, factor: f64) -> (String, Option<[String; 2]>) {
    let value = factor * value;
    let Some([low, high]) = ends.map(|ends| ends.map(|end| factor * end)) else {
        return (significant(value, DIGITS), None);
    };
    let size = low.abs().max(high.abs()).max(value.abs());
    let order = |of: f64| of.log10().floor() as i32;
    if !(size > 0.0 && size.is_finite() && high > low) {
        return (significant(value, DIGITS), Some([low, high].map(|end| significant(end, DIGITS))));
    }
    let digits = (order(size) - order(high - low) + 2).clamp(DIGITS, MOST_DIGITS);
    if !WITHOUT_EXPONENT.contains(&size) {
        return (significant(value, digits), Some([low, high].map(|end| significant(end, digits))));
    }
    let decimals = (digits - 1 - order(size)).max(0) as usize;
    let [value, low, high] = [value, low, high].map(|number| unsigned_zero(format!("{number:.decimals$}")));
    (value, Some([low, high]))
}

/// The same as one text: `-225.31 (-225.35 to -225.27)`; the unit follows the value.
pub fn with_interval(value: f64, ends: Option<[f64; 2]>, factor: f64, unit: &str) -> String {
    let (value, ends) = with_ends(value, ends, factor);
    let value = format!("{value} {unit}");
    let value = value.trim_end();
    ends.map_or(value.to_owned(), |[low, high]| format!("{value} ({low} to {high})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ends differ however narrow the interval is, and the value lies between them as printed.
    #[test]
    fn the_ends_of_an_interval_differ() {
        let text = |value: f64, low: f64, high: f64| {
            with_interval(1e-3 * value, Some([1e-3 * low, 1e-3 * high]), 1e3, "mm")
        };
        assert_eq!(text(-225.312, -225.348, -225.273), "-225.312 mm (-225.348 to -225.273)");
        assert_eq!(text(-232.63, -240.1, -226.2), "-232.6 mm (-240.1 to -226.2)");
        assert_eq!(text(0.045_32, 0.045_29, 0.045_37), "0.045320 mm (0.045290 to 0.045370)");
        assert_eq!(text(0.0, -1.0, 12.0), "0.00 mm (-1.00 to 12.00)");
        assert_eq!(text(0.5, 0.5, 0.5), "0.5000 mm (0.5000 to 0.5000)");
        assert_eq!(with_interval(0.08, None, 1e3, "g"), "80.00 g");
        // As it was found: the moment at the root of a rod that hangs straight had twenty zeros.
        assert_eq!(text(-1.915e-20, -1.915e-20, 0.0), "-1.915e-20 mm (-1.915e-20 to 0)");
        for width in [1e-2, 1e-4, 1e-6, 1e-9] {
            let (_, ends) = with_ends(1.164, Some([1.164 - width, 1.164 + width]), 1.0);
            let [low, high] = ends.unwrap();
            assert_ne!(low, high);
            assert!(low.parse::<f64>().unwrap() < 1.164 && high.parse::<f64>().unwrap() > 1.164);
        }
    }
}

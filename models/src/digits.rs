//! Numbers as people read them: with as many digits as count.

/// A number with that many digits that count; with an exponent where there would be many zeros.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(FEW_ZEROS.0..FEW_ZEROS.1).contains(&value.abs()) {
        return with_exponent(value, digits);
    }
    let order = value.abs().log10().floor() as i32;
    let unit = 10f64.powi(order + 1 - digits);
    let decimals = (digits - 1 - order).max(0) as usize;
    unsigned_zero(format!("{:.decimals$}", (value / unit).round() * unit))
}

/// Sizes of numbers that are written without an exponent.
const FEW_ZEROS: (f64, f64) = (1e-6, 1e9);

fn with_exponent(value: f64, digits: i32) -> String {
    format!("{value:.*e}", digits.max(1) as usize - 1)
}

/// A number with so many decimals. Where that leaves nothing of it, or has digits that nobody counts, it has two that count.
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = unsigned_zero(format!("{value:.decimals$}"));
    let is_lost = value != 0.0 && text.chars().all(|c| matches!(c, '0' | '.'));
    if is_lost || value.abs() >= FEW_ZEROS.1 { rounded(value, 2) } else { text }
}

/// A number and its standard error, whose two digits give the decimals of both.
pub fn with_error(value: f64, error: f64) -> String {
    if !(error.is_finite() && error > 0.0) {
        return format!("{} (error unknown)", significant(value, 3));
    }
    let decimals = 1 - error.log10().floor() as i32;
    // Beside an error that is far from the number's own size, neither has decimals in common with the other.
    if !(0..=9).contains(&decimals) || value.abs() >= FEW_ZEROS.1 {
        return format!("{} ± {}", rounded(value, 3), rounded(error, 2));
    }
    format!("{} ± {error:.*}", unsigned_zero(format!("{value:.*}", decimals as usize)), decimals as usize)
}

/// The same of a number that may be missing: a dash then.
pub fn significant_or_dash(value: Option<f64>, digits: i32) -> String {
    value.map_or("-".to_owned(), |value| significant(value, digits))
}

/// A number with three digits that count, with an exponent where it is very small or large.
pub fn short(value: f64) -> String {
    rounded(value, 3)
}

/// The same with as many digits.
pub fn rounded(value: f64, digits: i32) -> String {
    match value.abs() {
        size if size > 0.0 && !(1e-3..1e5).contains(&size) => with_exponent(value, digits),
        _ => significant(value, digits),
    }
}

/// The same text without the sign of a zero.
pub fn unsigned_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_what_counts() {
        for (value, digits, expected) in [
            (0.059_87, 3, "0.0599"),
            (1234.5, 2, "1200"),
            (1.2849, 3, "1.28"),
            (-0.0004, 1, "-0.0004"),
            (99.96, 3, "100"),
            (0.0, 3, "0"),
            (4.32e-18, 3, "4.32e-18"),
            (-1e-300, 3, "-1.00e-300"),
            (6_395_522_509_699_271.0, 2, "6.4e15"),
        ] {
            assert_eq!(significant(value, digits).trim_end_matches(".0"), expected);
        }
        assert_eq!(unsigned_zero("-0.00".to_owned()), "0.00");
        assert_eq!(unsigned_zero("-0.01".to_owned()), "-0.01");
    }

    #[test]
    fn no_number_is_rounded_to_nothing_or_written_with_zeros() {
        for (value, decimals, expected) in [
            (20.0, 2, "20.00"),
            (0.0, 2, "0.00"),
            (0.004, 2, "0.0040"),
            (3e-5, 2, "3.0e-5"),
            (-1e-300, 1, "-1.0e-300"),
            (6_395_522_509_699_271.0, 2, "6.4e15"),
        ] {
            assert_eq!(fixed(value, decimals), expected);
        }
        for (value, error, expected) in [
            (0.026_53, 0.0189, "0.027 ± 0.019"),
            (0.026_53, 0.000_012_3, "0.026530 ± 0.000012"),
            (1234.5, 56.0, "1234 ± 56"),
            (0.5, 6e15, "0.500 ± 6.0e15"),
            (0.5, f64::INFINITY, "0.500 (error unknown)"),
        ] {
            assert_eq!(with_error(value, error), expected);
        }
    }
}

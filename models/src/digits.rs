//! Numbers as people read them: with as many digits as count.

/// A number with that many digits that count, without exponent.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let order = value.abs().log10().floor() as i32;
    let unit = 10f64.powi(order + 1 - digits);
    let decimals = (digits - 1 - order).max(0) as usize;
    unsigned_zero(format!("{:.decimals$}", (value / unit).round() * unit))
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
        size if size > 0.0 && !(1e-3..1e5).contains(&size) => format!("{value:.*e}", digits as usize - 1),
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
        ] {
            assert_eq!(significant(value, digits).trim_end_matches(".0"), expected);
        }
        assert_eq!(unsigned_zero("-0.00".to_owned()), "0.00");
        assert_eq!(unsigned_zero("-0.01".to_owned()), "-0.01");
    }
}

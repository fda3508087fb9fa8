//! The root of a function of one variable.

/// Point where `f` changes sign between `low` and `high`, by halving down to neighbouring numbers.
///
/// Sixty evaluations or so, and no way to fail: closed forms pay for that gladly.
/// # Panics
/// If `f` has the same sign at both ends.
pub(crate) fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let rises = f(high) >= 0.0;
    assert!((f(low) >= 0.0) != rises, "no change of sign between {low} and {high}");
    loop {
        let middle = low + 0.5 * (high - low);
        if middle <= low || middle >= high {
            return middle;
        }
        if (f(middle) >= 0.0) == rises { high = middle } else { low = middle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rising_and_falling_functions_give_their_root() {
        assert!((bisect(0.0, 2.0, |x| x * x - 2.0) - 2f64.sqrt()).abs() < 1e-15);
        assert!((bisect(1.0, 2.0, f64::cos) - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    }
}

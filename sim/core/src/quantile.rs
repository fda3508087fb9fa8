//! Values below which a share of others lies.

/// The value below which a share of all lies, one of those given; none of nothing.
pub fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let at = ((values.len() - 1) as f64 * share).round() as usize;
    let (_, value, _) = values.select_nth_unstable_by(at, f64::total_cmp);
    Some(*value)
}

/// Median time between samples, s; none of fewer than two.
pub fn usual_step(time: &[f64]) -> Option<f64> {
    quantile(time.windows(2).map(|pair| pair[1] - pair[0]).collect(), 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_is_a_value_of_those_given() {
        assert_eq!(quantile(vec![3.0, 1.0, 2.0], 0.5), Some(2.0));
        assert_eq!(quantile(vec![], 0.5), None);
        // A jump of the clock does not count.
        assert_eq!(usual_step(&[0.0, 0.5, 1.0, 9.0]), Some(0.5));
    }
}

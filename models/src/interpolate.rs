//! Interpolation of tables: a piecewise cubic that overshoots nowhere.

use thiserror::Error;

/// Piecewise cubic through the points of a table, with a continuous slope.
///
/// Between two points it stays between their values, so monotone data stay monotone and positive
/// data stay positive. The slope at an interior point is the weighted harmonic mean of the slopes
/// of the two chords, or zero where these differ in sign; at the ends it is a one-sided
/// three-point slope, limited in the same spirit. The second derivative jumps at the points.
///
/// Source: Fritsch and Carlson (1980), Fritsch and Butland (1984); weights and end slopes are
/// those of MATLAB's `pchip` and SciPy's `PchipInterpolator`.
#[derive(Clone, Debug, PartialEq)]
pub struct Pchip {
    x: Vec<f64>,
    /// Value, slope, quadratic and cubic coefficient right of each point. The last point's cubic
    /// is its straight continuation.
    cubic: Vec<[f64; 4]>,
}

/// A table that cannot be interpolated.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PchipError {
    /// Fewer than two points.
    #[error("{points} points: interpolation needs at least 2")]
    TooFewPoints {
        /// How many there are.
        points: usize,
    },
    /// `x` and `y` differ in length.
    #[error("{x} abscissae but {y} values: there must be as many of both")]
    LengthsDiffer {
        /// Length of `x`.
        x: usize,
        /// Length of `y`.
        y: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("point {index} is ({x}, {y}): both must be finite")]
    NotFinite {
        /// Which point, from zero.
        index: usize,
        /// Its abscissa.
        x: f64,
        /// Its value.
        y: f64,
    },
    /// The abscissae do not increase.
    #[error("abscissa {index} is {x} after {previous}: each must be larger than the one before")]
    NotIncreasing {
        /// Which point, from zero.
        index: usize,
        /// Its abscissa.
        x: f64,
        /// The abscissa before it.
        previous: f64,
    },
}

impl Pchip {
    /// The interpolant through `(x[i], y[i])`, `x` increasing; through two points a straight line.
    ///
    /// # Errors
    /// A [`PchipError`] if there are too few points, or one is not finite, or `x` does not increase.
    pub fn new(x: Vec<f64>, y: Vec<f64>) -> Result<Pchip, PchipError> {
        check(&x, &y)?;
        let slopes = slopes(&x, &y);
        let mut cubic: Vec<[f64; 4]> = (0..x.len() - 1)
            .map(|i| {
                let h = x[i + 1] - x[i];
                let chord = (y[i + 1] - y[i]) / h;
                let quadratic = (3.0 * chord - 2.0 * slopes[i] - slopes[i + 1]) / h;
                let third = (slopes[i] - 2.0 * chord + slopes[i + 1]) / (h * h);
                [y[i], slopes[i], quadratic, third]
            })
            .collect();
        let last = x.len() - 1;
        cubic.push([y[last], slopes[last], 0.0, 0.0]);
        Ok(Pchip { x, cubic })
    }

    /// First and last abscissa.
    pub fn range(&self) -> (f64, f64) {
        (self.x[0], self.x[self.x.len() - 1])
    }

    /// Value at `x`.
    ///
    /// # Panics
    /// Outside [`range`](Pchip::range).
    pub fn value(&self, x: f64) -> f64 {
        self.value_and_slope(x).0
    }

    /// First derivative at `x`.
    ///
    /// # Panics
    /// Outside [`range`](Pchip::range).
    pub fn slope(&self, x: f64) -> f64 {
        self.value_and_slope(x).1
    }

    /// Value and first derivative at `x`.
    ///
    /// # Panics
    /// Outside [`range`](Pchip::range).
    pub fn value_and_slope(&self, x: f64) -> (f64, f64) {
        let (first, last) = self.range();
        assert!(first <= x && x <= last, "{x} lies outside {first}..={last}");
        self.extrapolate(x)
    }

    /// Value and first derivative at any `x`: inside the range the interpolant, outside it the
    /// straight line that leaves the end of the range with the slope that it has there.
    pub fn extrapolate(&self, x: f64) -> (f64, f64) {
        let [value, slope, _second] = self.derivatives(x);
        (value, slope)
    }

    /// Value, first and second derivative at any `x`, as [`extrapolate`](Self::extrapolate). At a point
    /// the second derivative is that to its right.
    pub fn derivatives(&self, x: f64) -> [f64; 3] {
        let i = self.x.partition_point(|&knot| knot <= x).saturating_sub(1);
        let s = x - self.x[i];
        let [value, slope, quadratic, third] = self.cubic[i];
        if s < 0.0 {
            return [value + s * slope, slope, 0.0];
        }
        [
            value + s * (slope + s * (quadratic + s * third)),
            slope + s * (2.0 * quadratic + 3.0 * s * third),
            2.0 * quadratic + 6.0 * s * third,
        ]
    }
}

fn check(x: &[f64], y: &[f64]) -> Result<(), PchipError> {
    if x.len() != y.len() {
        return Err(PchipError::LengthsDiffer { x: x.len(), y: y.len() });
    }
    if x.len() < 2 {
        return Err(PchipError::TooFewPoints { points: x.len() });
    }
    for (index, (&x, &y)) in x.iter().zip(y).enumerate() {
        if !(x.is_finite() && y.is_finite()) {
            return Err(PchipError::NotFinite { index, x, y });
        }
    }
    for (index, pair) in x.windows(2).enumerate() {
        if pair[1] <= pair[0] {
            return Err(PchipError::NotIncreasing { index: index + 1, x: pair[1], previous: pair[0] });
        }
    }
    Ok(())
}

/// Slope of the interpolant at each point.
fn slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let h: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let chord: Vec<f64> = (y.windows(2).zip(&h)).map(|(pair, h)| (pair[1] - pair[0]) / h).collect();
    let n = h.len();
    if n == 1 {
        return vec![chord[0]; 2];
    }
    let mut slopes = vec![end_slope(h[0], h[1], chord[0], chord[1])];
    slopes.extend((1..n).map(|i| interior_slope(h[i - 1], h[i], chord[i - 1], chord[i])));
    slopes.push(end_slope(h[n - 1], h[n - 2], chord[n - 1], chord[n - 2]));
    slopes
}

/// Weighted harmonic mean of the chords' slopes on both sides; zero at an extremum.
fn interior_slope(h_left: f64, h_right: f64, left: f64, right: f64) -> f64 {
    if left * right <= 0.0 {
        return 0.0;
    }
    let weight_left = 2.0 * h_right + h_left;
    let weight_right = h_right + 2.0 * h_left;
    (weight_left + weight_right) / (weight_left / left + weight_right / right)
}

/// Three-point slope at an end, from the chords next to it and next but one: never of the sign
/// opposite to the nearer chord, and at most three times it where the data turn.
fn end_slope(h_near: f64, h_far: f64, near: f64, far: f64) -> f64 {
    let slope = ((2.0 * h_near + h_far) * near - h_near * far) / (h_near + h_far);
    if slope * near <= 0.0 {
        0.0
    } else if near * far <= 0.0 && slope.abs() > 3.0 * near.abs() {
        3.0 * near
    } else {
        slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The radiochemical data RPN 15A of Fritsch and Carlson (1980): monotone, very uneven.
    fn rpn_15a() -> Pchip {
        let x = vec![7.99, 8.09, 8.19, 8.7, 9.2, 10.0, 12.0, 15.0, 20.0];
        let y = vec![0.0, 2.76429e-5, 4.37498e-2, 0.169183, 0.469428, 0.943740, 0.998636, 0.999919, 0.999994];
        Pchip::new(x, y).unwrap()
    }

    /// A table that turns twice, and steeply at both ends.
    fn zigzag() -> Pchip {
        Pchip::new(vec![0.0, 1.0, 2.0, 3.0], vec![0.0, 1.0, 0.0, 5.0]).unwrap()
    }

    fn samples(curve: &Pchip, count: usize) -> impl Iterator<Item = f64> {
        let (first, last) = curve.range();
        (0..=count).map(move |i| first + (last - first) * i as f64 / count as f64)
    }

    /// Reference: `scipy.interpolate.PchipInterpolator`, SciPy 1.17.1.
    #[test]
    fn agrees_with_scipy() {
        let (uneven, turning) = (rpn_15a(), zigzag());
        // Turns so sharply that the slope at its first end is limited.
        let sharp = Pchip::new(vec![0.0, 1.0, 2.0, 3.0], vec![0.0, 1.0, -4.0, 5.0]).unwrap();
        let reference = [
            (&uneven, 8.0, 2.767433863187248e-7, 5.534518408242687e-5),
            (&uneven, 8.15, 0.023528278365786123, 0.5891170393088024),
            (&uneven, 8.5, 0.1166325769392755, 0.20580225251505585),
            (&uneven, 9.9, 0.9252702456904094, 0.3008154294883696),
            (&uneven, 14.0, 0.99977249170715, 0.0002700904279658138),
            (&uneven, 19.0, 0.9999912279493809, 5.601088583484486e-6),
            (&turning, 0.25, 0.4375, 1.5),
            (&turning, 1.5, 0.5, -1.5),
            (&turning, 2.5, 1.5, 5.5),
            (&turning, 3.0, 5.0, 8.0),
            (&sharp, 0.0, 0.0, 3.0),
            (&sharp, 0.25, 0.578125, 1.6875),
        ];
        for (curve, x, value, slope) in reference {
            let found = curve.value_and_slope(x);
            // Round-off: the chord of the first interval cancels two digits of x.
            assert!((found.0 - value).abs() < 1e-14, "value at {x}: {found:?}");
            assert!((found.1 - slope).abs() < 1e-12, "slope at {x}: {found:?}");
        }
    }

    #[test]
    fn reproduces_every_point_bit_for_bit() {
        let x = [0.0, 0.1, 0.7, 1.3];
        let y = [1.0, 0.3, 0.2, 0.7];
        let curve = Pchip::new(x.to_vec(), y.to_vec()).unwrap();
        for (x, y) in x.into_iter().zip(y) {
            assert_eq!(curve.value(x), y);
        }
    }

    #[test]
    fn monotone_data_stay_monotone() {
        let curve = rpn_15a();
        let values: Vec<f64> = samples(&curve, 5000).map(|x| curve.value(x)).collect();
        // Round-off on the plateau near one.
        assert!(values.windows(2).all(|pair| pair[1] >= pair[0] - 1e-15));
    }

    #[test]
    fn never_leaves_the_values_on_both_sides() {
        let curve = zigzag();
        let bounds = [(0.0, 1.0), (0.0, 1.0), (0.0, 5.0)];
        for x in samples(&curve, 3000) {
            let (low, high) = bounds[(x as usize).min(2)];
            assert!((low..=high).contains(&curve.value(x)), "at {x}");
        }
    }

    #[test]
    fn slope_is_the_derivative_of_the_value() {
        for curve in [rpn_15a(), zigzag()] {
            let (first, last) = curve.range();
            let step = 1e-6;
            for x in samples(&curve, 997).filter(|x| first + step < *x && *x < last - step) {
                let difference = (curve.value(x + step) - curve.value(x - step)) / (2.0 * step);
                // A difference over a point sees the jump of the second derivative, below 1e3.
                let tolerance = 1e3 * step;
                assert!((difference - curve.slope(x)).abs() < tolerance, "at {x}");
            }
        }
    }

    #[test]
    fn straight_data_give_a_straight_line_also_outside() {
        let x = vec![-1.0, 0.5, 2.0, 7.0];
        let curve = Pchip::new(x.clone(), x.iter().map(|x| 3.0 - 2.0 * x).collect()).unwrap();
        for x in [-4.0, -1.0, 0.1, 1.9, 6.5, 7.0, 30.0] {
            let (value, slope) = curve.extrapolate(x);
            assert!((value - (3.0 - 2.0 * x)).abs() < 1e-13);
            assert!((slope + 2.0).abs() < 1e-13);
        }
    }

    #[test]
    fn extrapolates_from_each_end_with_the_slope_there() {
        let curve = zigzag();
        assert_eq!(curve.extrapolate(-0.5), (-1.0, 2.0));
        assert_eq!(curve.extrapolate(3.5), (9.0, 8.0));
        assert_eq!(curve.extrapolate(1.5), curve.value_and_slope(1.5));
    }

    #[test]
    #[should_panic(expected = "outside 0..=3")]
    fn does_not_extrapolate_unasked() {
        zigzag().value(3.0001);
    }

    #[test]
    fn refuses_tables_that_it_cannot_interpolate() {
        let error = |x: &[f64], y: &[f64]| Pchip::new(x.to_vec(), y.to_vec()).unwrap_err();
        assert_eq!(error(&[1.0], &[1.0]), PchipError::TooFewPoints { points: 1 });
        assert_eq!(error(&[1.0, 2.0], &[1.0]), PchipError::LengthsDiffer { x: 2, y: 1 });
        assert!(matches!(error(&[1.0, f64::NAN], &[1.0, 2.0]), PchipError::NotFinite { index: 1, .. }));
        assert_eq!(
            error(&[1.0, 2.0, 2.0], &[1.0, 2.0, 3.0]).to_string(),
            "abscissa 2 is 2 after 2: each must be larger than the one before"
        );
    }
}

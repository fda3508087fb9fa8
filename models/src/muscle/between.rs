//! Between calibrated pressures: what is interpolated, and how far that may be off.
//!
//! The logarithm of calibrated over published stiffness is taken for a Wiener process over pressure (Brownian
//! motion, a Gaussian process), known where it was calibrated. Its mean is the straight line between neighbours, so
//! the published shape of EI over pressure is kept. Its variance is `q (p − a)(b − p)/(b − a)` between the
//! calibrated pressures a and b, and `q |p − a|` beyond the last one. A loss has no published shape: its value takes
//! the place of the logarithm.
//!
//! The intensity `q`, 1/Pa, is the larger of two estimates:
//! * **table**: each row of the published table is predicted from all others; `q` is the mean square of what the
//!   prediction misses, over the variance of a process with `q = 1` there;
//! * **calibration**: the mean square of the change from one calibrated pressure to the next over their distance,
//!   less what the standard errors explain.
//!
//! On the paper's 20 rows, each left out in turn, the 95 % intervals hold 18. A process of Matérn type with length and
//! noise by maximum likelihood holds 18 (order 3/2) and 16 (order 5/2), with two parameters more. With the beam's
//! column of the table for the muscle and the rod's for the table, they hold all. With the axial column, which is 0.6 to 3
//! times the rod's, they hold 84 to 95 %: two calibrated pressures say little of such a muscle.
//!
//! Source: Rasmussen and Williams (2006), Gaussian Processes for Machine Learning, section B.2.1, for the process.

use serde::{Deserialize, Serialize};

use super::{CalibratedParameter, Extrapolation, Here, Known, Muscle, MuscleError};
use crate::interpolate::Pchip;

/// How one parameter is interpolated between calibrated pressures, and how far that may be off.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interpolation {
    /// Path of the parameter in a model, such as `rod.bending_stiffness`.
    pub path: String,
    /// Estimate of bending stiffness whose ratio to the calibrated one is interpolated, by the logarithm; without it
    /// the value itself is interpolated.
    pub shape: Option<String>,
    /// Intensity `q`: variance for each Pa, of the logarithm, or of the value in its SI unit squared.
    pub variance_per_pa: f64,
}

/// The parameter that a muscle's table has a shape for.
const BENDING_STIFFNESS: &str = "rod.bending_stiffness";

impl Muscle {
    /// How parameters that were calibrated at several pressures, or at one, are interpolated; `shape` is the estimate
    /// of bending stiffness whose shape is kept.
    ///
    /// A parameter that all pressures share is not interpolated, nor one without an estimate of `q`: a table of two
    /// rows and one calibrated pressure have none.
    /// # Errors
    /// [`MuscleError`] for a shape, or a pressure, that the table has not.
    pub fn interpolation(&self, known: &Known, shape: &str) -> Result<Vec<Interpolation>, MuscleError> {
        let table = self.roughness(shape)?;
        let mut all = Vec::new();
        for path in known.paths() {
            let parameters = known.over_pressure(path);
            if parameters.is_empty() {
                continue;
            }
            let is_stiffness = path == BENDING_STIFFNESS;
            // What is interpolated at each pressure, and its derivative by the parameter.
            let mut points = Vec::new();
            for (pressure, parameter) in &parameters {
                points.push(if is_stiffness {
                    let published = self.at(*pressure, shape, Extrapolation::Allowed)?.bending_stiffness;
                    ((parameter.value / published).ln(), parameter.value.recip())
                } else {
                    (parameter.value, 1.0)
                });
            }
            let change = |k: usize| {
                let [(a, first), (b, second)] = [parameters[k], parameters[k + 1]];
                let [left, right] = [(k, first), (k + 1, second)]
                    .map(|(k, parameter)| points[k].1 * parameter.standard_error.unwrap_or(0.0));
                let correlation = known.correlation(first, second);
                let explained = left * left + right * right - 2.0 * correlation * left * right;
                ((points[k + 1].0 - points[k].0).powi(2) - explained).max(0.0) / (b - a)
            };
            let changes: Vec<f64> = (0..parameters.len() - 1).map(change).collect();
            // Relative to itself a loss is taken to be at least as uneven as the stiffness is.
            let size = parameters.iter().map(|(_, parameter)| parameter.value).sum::<f64>()
                / parameters.len() as f64;
            let unit = if is_stiffness { 1.0 } else { size * size };
            let estimates = [table.map(|table| unit * table), mean(&changes)];
            let Some(variance_per_pa) = estimates.into_iter().flatten().reduce(f64::max) else { continue };
            all.push(Interpolation {
                path: path.to_owned(),
                shape: is_stiffness.then(|| shape.to_owned()),
                variance_per_pa,
            });
        }
        Ok(all)
    }

    /// The intensity `q` that the table shows: how far each inner row lies off the curve through all others, 1/Pa; none
    /// with fewer than four rows, whose curve without one of them is a straight line.
    /// # Errors
    /// [`MuscleError::UnknownStiffness`].
    pub fn roughness(&self, shape: &str) -> Result<Option<f64>, MuscleError> {
        let curve = self.bending_stiffness(shape)?;
        let pressures = self.pressures();
        if pressures.len() < 4 {
            return Ok(None);
        }
        let without = |left_out: usize| {
            let others = || pressures.iter().enumerate().filter(|(k, _)| *k != left_out).map(|(_, p)| *p);
            let pressure = pressures[left_out];
            let predicted = Pchip::new(others().collect(), others().map(|p| curve.value(p)).collect());
            let predicted = predicted.expect("rows of a table that is checked").value(pressure);
            let neighbours = [pressures[left_out - 1], pressures[left_out + 1]];
            (curve.value(pressure) / predicted).ln().powi(2) / distance(&neighbours, pressure)
        };
        Ok(mean(&(1..pressures.len() - 1).map(without).collect::<Vec<_>>()))
    }
}

/// Weights with which values at ascending places make the value at another: the straight line between neighbours,
/// the last value beyond.
pub(super) fn weights(places: &[f64], at: f64) -> Vec<f64> {
    let mut weights = vec![0.0; places.len()];
    let after = places.partition_point(|place| *place <= at);
    match (after.checked_sub(1), places.get(after)) {
        (Some(before), Some(next)) => {
            let share = (at - places[before]) / (next - places[before]);
            weights[before] = 1.0 - share;
            weights[after] = share;
        }
        (Some(last), None) => weights[last] = 1.0,
        (None, Some(_)) => weights[0] = 1.0,
        (None, None) => {}
    }
    weights
}

/// Variance at a place of a process with `q = 1` that is known at ascending places, Pa.
pub(super) fn distance(places: &[f64], at: f64) -> f64 {
    let after = places.partition_point(|place| *place <= at);
    match (after.checked_sub(1), places.get(after)) {
        (Some(before), Some(next)) => (at - places[before]) * (next - at) / (next - places[before]),
        (Some(last), None) => at - places[last],
        (None, Some(first)) => first - at,
        (None, None) => 0.0,
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

impl Known {
    /// The numbers of a path that belong to a pressure each, ascending.
    pub(super) fn over_pressure(&self, path: &str) -> Vec<(f64, &CalibratedParameter)> {
        let own = self.parameter.iter().filter(|parameter| parameter.path == path);
        let mut own: Vec<_> = own.filter_map(|parameter| Some((parameter.pressure_pa?, parameter))).collect();
        own.sort_by(|a, b| a.0.total_cmp(&b.0));
        own
    }

    /// Whether a pressure, Pa, was not calibrated and a parameter is interpolated there without a statement of how far
    /// that may be off: files by hand, and those of earlier versions, have none.
    pub fn is_silent_at(&self, pressure: f64) -> bool {
        self.paths().into_iter().any(|path| {
            let places: Vec<f64> = self.over_pressure(path).iter().map(|(place, _)| *place).collect();
            // Pressures in two units differ by rounding.
            let is_apart = places.iter().all(|place| (place - pressure).abs() > 1e-3 * place.abs());
            !places.is_empty() && is_apart && self.interpolation.iter().all(|own| own.path != path)
        })
    }

    /// How the slope over pressure of the logarithm of the bending stiffness, 1/Pa, moves with each number: by that of the
    /// weights between neighbours, at a calibrated pressure by the mean of both sides, and beyond the last as at it. The published shape is taken to be
    /// known, and a process without slopes of its own adds nothing.
    pub(super) fn slope_weights(&self, pressure: f64, here: &dyn Fn(&str) -> Here) -> Vec<f64> {
        let places: Vec<f64> =
            self.over_pressure(BENDING_STIFFNESS).iter().map(|(place, _)| *place).collect();
        let by_ratio = self.interpolation_of(BENDING_STIFFNESS).is_some_and(|own| own.shape.is_some());
        let (Some(first), Some(last)) = (places.first(), places.last()) else {
            return vec![0.0; self.parameter.len()];
        };
        let [low, high] =
            [-0.5, 0.5].map(|beside| (pressure.clamp(*first, *last) + beside).clamp(*first, *last));
        let [below, above] = [low, high].map(|place| weights(&places, place));
        let slope = |own: &CalibratedParameter| {
            let place = places.iter().position(|place| own.pressure_pa == Some(*place));
            let value = if by_ratio { own.value } else { here(BENDING_STIFFNESS).value };
            let of = |place: usize| (above[place] - below[place]) / (high - low) / value;
            place.filter(|_| own.path == BENDING_STIFFNESS && high > low).map_or(0.0, of)
        };
        self.parameter.iter().map(slope).collect()
    }

    fn correlation(&self, a: &CalibratedParameter, b: &CalibratedParameter) -> f64 {
        let place = self.parameter.iter().position(|parameter| std::ptr::eq(parameter, b));
        place.and_then(|place| a.correlations.get(place)).copied().unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PSI: f64 = 6_894.757_293_168_361;

    /// `q` of a random walk is found from its values; the table's is that of a table that zigzags.
    #[test]
    fn the_intensity_is_that_of_the_rows_or_of_the_calibrated_values() {
        let muscle = Muscle::built_in("garbulinski-2022").unwrap();
        let parameter = |psi: f64, factor: f64, error: f64, k: usize| {
            let published =
                muscle.at(psi * PSI, "pder_32", Extrapolation::Refused).unwrap().bending_stiffness;
            let mut correlations = vec![0.0; 3];
            correlations[k] = 1.0;
            CalibratedParameter {
                path: BENDING_STIFFNESS.to_owned(),
                pressure_pa: Some(psi * PSI),
                value: factor * published,
                standard_error: Some(error * factor * published),
                correlations,
            }
        };
        let of = |factors: [f64; 3], error: f64| {
            let parameter = vec![
                parameter(20.0, factors[0], error, 0),
                parameter(40.0, factors[1], error, 1),
                parameter(60.0, factors[2], error, 2),
            ];
            let known = Known { parameter, ..Known::default() };
            let all = muscle.interpolation(&known, "pder_32").unwrap();
            assert_eq!((all.len(), all[0].shape.as_deref()), (1, Some("pder_32")));
            all[0].variance_per_pa
        };
        let table = muscle.roughness("pder_32").unwrap().unwrap();
        // Rows of 5 psi, each some 3 % off its neighbours' curve.
        assert!((table * 2.5 * PSI).sqrt() > 0.02 && (table * 2.5 * PSI).sqrt() < 0.04, "{table}");
        assert_eq!(of([1.1, 1.1, 1.1], 0.0), table, "what is alike everywhere leaves the table's");
        let calibrated = of([1.0, 2.0, 1.0], 0.0);
        assert!((calibrated / (2f64.ln().powi(2) / (20.0 * PSI)) - 1.0).abs() < 1e-9, "{calibrated}");
        // What the standard errors explain is none of it.
        let explained = of([1.0, 2.0, 1.0], 0.1);
        assert!(
            (explained - (2f64.ln().powi(2) - 0.02) / (20.0 * PSI)).abs() < 1e-9 * calibrated,
            "{explained}"
        );
    }

    /// Half way between two pressures 100 kPa apart, whose values are known to a per cent each, the mean slope between them is
    /// known to √2 % over 100 kPa; at both ends and beyond as well. It goes with a number that goes with one of the two.
    /// Beside a single pressure there is none.
    #[test]
    fn the_slope_over_pressure_has_an_error() {
        let parameter = |path: &str, pressure_pa, value: f64, correlations: [f64; 3]| CalibratedParameter {
            path: path.to_owned(),
            pressure_pa,
            value,
            standard_error: Some(0.01 * value),
            correlations: correlations.to_vec(),
        };
        let shape = Some("pder_32".to_owned());
        let own = Interpolation { path: BENDING_STIFFNESS.to_owned(), shape, variance_per_pa: 4e-8 };
        let parameter = vec![
            parameter(BENDING_STIFFNESS, Some(1e5), 0.01, [1.0, 0.0, 0.5]),
            parameter(BENDING_STIFFNESS, Some(2e5), 0.02, [0.0, 1.0, 0.0]),
            parameter("alpha", None, 0.5, [0.5, 0.0, 1.0]),
        ];
        let known = Known { interpolation: vec![own], parameter, ..Known::default() };
        let slope =
            |known: &Known, pressure| known.at(pressure, &|_| Here { value: 0.015, scale: 0.5 }).slope;
        for pressure in [1e5, 1.5e5, 2e5, 9e5] {
            let own = slope(&known, pressure);
            assert!((own[2].sqrt() / (0.01 * 2f64.sqrt() / 1e5) - 1.0).abs() < 1e-9, "{pressure}: {own:?}");
            assert!((own[1] / (-0.01 / 1e5 * 0.5 * 0.005) - 1.0).abs() < 1e-9, "{pressure}: {own:?}");
        }
        assert_eq!(slope(&known.of(|own| own.value != 0.02), 1.5e5), [0.0; 3]);
    }

    #[test]
    fn a_process_is_known_where_it_was_seen_and_least_known_half_way() {
        let places = [10.0, 30.0, 70.0];
        assert_eq!(places.map(|at| distance(&places, at)), [0.0; 3]);
        assert_eq!((distance(&places, 20.0), distance(&places, 50.0)), (5.0, 10.0));
        assert_eq!((distance(&places, 4.0), distance(&places, 90.0)), (6.0, 20.0));
        assert_eq!(weights(&places, 50.0), [0.0, 0.5, 0.5]);
        assert_eq!(
            (weights(&places, 4.0), weights(&places, 90.0)),
            (vec![1.0, 0.0, 0.0], vec![0.0, 0.0, 1.0])
        );
        assert_eq!((weights(&[], 4.0), distance(&[], 4.0)), (vec![], 0.0));
    }
}

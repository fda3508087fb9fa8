//! How well a calibration knows a muscle, and how well that is then known at any pressure.

use serde::{Deserialize, Serialize};

use super::MuscleError;
use super::between::{self, Interpolation};

/// What a calibration says of the numbers that it put into a muscle file: the section `[calibration]`, SI.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Known {
    /// Releases that were fitted.
    pub releases: usize,
    /// Lowest and highest pressure of these, Pa.
    pub pressure_pa: [f64; 2],
    /// Lightest and heaviest payload of these, kg.
    pub payload_kg: [f64; 2],
    /// Largest excursion of the tip from its rest that was seen, m.
    pub excursion_m: f64,
    /// Nodes of the mesh that the numbers belong to; none where its error was removed.
    pub nodes: Option<usize>,
    /// How far the model was from the recordings that it was calibrated on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub misfit: Option<Misfit>,
    /// Offset of the tip's marker from the tip of the model; none where it was taken as given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub marker: Option<Marker>,
    /// How parameters are interpolated between calibrated pressures, and how far that may be off.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub interpolation: Vec<Interpolation>,
    /// The numbers.
    pub parameter: Vec<CalibratedParameter>,
}

/// How far a calibrated model was from its recordings, root mean square over the releases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Misfit {
    /// Distance of the tip over all samples, over the excursion.
    pub distance: f64,
    /// Distance of the tip at the end of the recordings, likewise.
    pub rest: f64,
    /// Relative difference of the frequencies.
    pub frequency: f64,
    /// Relative difference of the damping ratios.
    pub damping_ratio: f64,
    /// Lowest and highest frequency of the recordings and of small swings of the fitted rods, Hz; none where no recording has one.
    pub frequency_hz: Option<[f64; 2]>,
}

/// Offset of the tip's marker from the tip of the model: the marker is off the rod's end, or the clamp is not where it
/// is stated. Axes of the model: along the level, and up.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Marker {
    /// Its name.
    pub name: String,
    /// Mean over the releases, m.
    pub offset_m: [f64; 2],
    /// Standard error of the offset of one more release, m.
    pub standard_error_m: [f64; 2],
}

impl Marker {
    /// From the offset of each release with its standard error, along each axis; none without releases.
    ///
    /// The errors do not average out, since all come from the same parameters of the rod. What the releases differ by
    /// counts for the mean and for one more release.
    pub fn of(name: &str, releases: &[[(f64, f64); 2]]) -> Option<Self> {
        let count = releases.len() as f64;
        let mean = |axis: usize, of: fn((f64, f64)) -> f64| {
            releases.iter().map(|release| of(release[axis])).sum::<f64>() / count
        };
        let offset_m = [0, 1].map(|axis| mean(axis, |(offset, _)| offset));
        let standard_error = |axis: usize| {
            let square = |release: &[(f64, f64); 2]| (release[axis].0 - offset_m[axis]).powi(2);
            let spread = releases.iter().map(square).sum::<f64>() / (count - 1.0).max(1.0);
            (mean(axis, |(_, error)| error * error) + spread * (1.0 + 1.0 / count)).sqrt()
        };
        let standard_error_m = [0, 1].map(standard_error);
        (!releases.is_empty()).then(|| Self { name: name.to_owned(), offset_m, standard_error_m })
    }
}

/// One number that was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibratedParameter {
    /// Path of the parameter in a model, such as `rod.bending_stiffness`.
    pub path: String,
    /// Pressure that it belongs to, Pa; none for one that all share.
    pub pressure_pa: Option<f64>,
    /// Its value.
    pub value: f64,
    /// Its standard error; none where the data do not determine it.
    pub standard_error: Option<f64>,
    /// Correlations with all numbers, itself included, in their order.
    pub correlations: Vec<f64>,
}

/// What is known of a model's parameters at one pressure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KnownAt {
    /// Paths of the parameters.
    pub paths: Vec<String>,
    /// Their covariance, shape `[paths][paths]`: errors of the calibration and of interpolation together.
    pub covariance: Vec<Vec<f64>>,
    /// Standard deviation of each that interpolation over pressure adds, in the parameter's SI unit; zero at a
    /// calibrated pressure.
    pub interpolated: Vec<f64>,
    /// Covariances with each of them of the slope over pressure of the logarithm of the bending stiffness, 1/Pa, then its
    /// variance: of the mean slope between the calibrated pressures beside this one. Zero beside fewer than two.
    pub slope: Vec<f64>,
    /// Those that the data did not determine: without a standard error, or with a 95 % interval that includes zero.
    pub undetermined: Vec<CalibratedParameter>,
}

/// The requested parameter of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Here {
    /// Its value at the pressure requested.
    pub value: f64,
    /// Its typical size: the standard deviation that is taken where the data determine none.
    pub scale: f64,
}

/// Standard errors from a value to the end of its 95 % interval.
const NORMAL_95: f64 = 1.959_963_984_540_054;

impl Known {
    /// Paths of the parameters, each once.
    pub fn paths(&self) -> Vec<&str> {
        let mut paths: Vec<&str> = Vec::new();
        for parameter in &self.parameter {
            if !paths.contains(&parameter.path.as_str()) {
                paths.push(&parameter.path);
            }
        }
        paths
    }

    /// What is known at a pressure, Pa; `here` gives each parameter of the model there.
    ///
    /// Errors of calibrated pressures are carried over as the values are (see [`Interpolation`]), and what
    /// interpolation itself may be off by is added. This is the one place where the parts are put together.
    pub fn at(&self, pressure: f64, here: &dyn Fn(&str) -> Here) -> KnownAt {
        let paths = self.paths();
        let weights: Vec<Vec<f64>> =
            paths.iter().map(|path| self.weights(path, pressure, here(path))).collect();
        let slope = self.slope_weights(pressure, here);
        // Most do not move this one: with many numbers all pairs of all would take minutes.
        let moves = |weights: &[f64], k: usize| weights[k] != 0.0;
        let deviation = |parameter: &CalibratedParameter| {
            parameter.standard_error.unwrap_or_else(|| parameter.value.abs().max(here(&parameter.path).scale))
        };
        let covariance = |a: &[f64], b: &[f64]| {
            let mut sum = 0.0;
            for (k, first) in self.parameter.iter().enumerate().filter(|(k, _)| moves(a, *k)) {
                for (l, second) in self.parameter.iter().enumerate().filter(|(l, _)| moves(b, *l)) {
                    sum += a[k] * b[l] * first.correlations[l] * deviation(first) * deviation(second);
                }
            }
            sum
        };
        let mut of_all: Vec<Vec<f64>> =
            weights.iter().map(|a| weights.iter().map(|b| covariance(a, b)).collect()).collect();
        let of_slope = weights.iter().chain([&slope]).map(|own| covariance(own, &slope)).collect();
        let interpolated: Vec<f64> =
            paths.iter().map(|path| self.interpolated(path, pressure, here(path))).collect();
        for (k, deviation) in interpolated.iter().enumerate() {
            of_all[k][k] += deviation * deviation;
        }
        let is_used = |k: &usize| weights.iter().any(|weights| moves(weights, *k));
        let is_undetermined = |parameter: &&CalibratedParameter| {
            parameter.standard_error.is_none_or(|error| parameter.value.abs() <= NORMAL_95 * error)
        };
        let used = (0..self.parameter.len()).filter(is_used).map(|k| &self.parameter[k]);
        KnownAt {
            undetermined: used.filter(is_undetermined).cloned().collect(),
            paths: paths.into_iter().map(str::to_owned).collect(),
            covariance: of_all,
            interpolated,
            slope: of_slope,
        }
    }

    pub(super) fn interpolation_of(&self, path: &str) -> Option<&Interpolation> {
        self.interpolation.iter().find(|own| own.path == path)
    }

    /// How a parameter at a pressure moves with each number.
    fn weights(&self, path: &str, pressure: f64, here: Here) -> Vec<f64> {
        let mut own: Vec<usize> =
            (0..self.parameter.len()).filter(|k| self.parameter[*k].path == path).collect();
        let place = |k: &usize| self.parameter[*k].pressure_pa.unwrap_or(0.0);
        own.sort_by(|a, b| place(a).total_cmp(&place(b)));
        let places: Vec<f64> = own.iter().map(place).collect();
        let by_ratio = self.interpolation_of(path).is_some_and(|own| own.shape.is_some());
        let mut weights = vec![0.0; self.parameter.len()];
        for (k, weight) in own.iter().zip(between::weights(&places, pressure)) {
            // The value is shape · exp(Σ w ln(own / shape)).
            weights[*k] = if by_ratio { weight * here.value / self.parameter[*k].value } else { weight };
        }
        weights
    }

    /// Standard deviation of a parameter from interpolation alone.
    fn interpolated(&self, path: &str, pressure: f64, here: Here) -> f64 {
        let Some(own) = self.interpolation_of(path) else { return 0.0 };
        let places: Vec<f64> = self.over_pressure(path).iter().map(|(place, _)| *place).collect();
        let deviation = (own.variance_per_pa * between::distance(&places, pressure)).sqrt();
        if own.shape.is_some() { here.value.abs() * deviation } else { deviation }
    }

    /// Least and largest of some values; zeros of none.
    pub fn span(values: impl Iterator<Item = f64>) -> [f64; 2] {
        let ends = values.fold(None, |ends: Option<[f64; 2]>, value| {
            Some(ends.map_or([value; 2], |[low, high]| [low.min(value), high.max(value)]))
        });
        ends.unwrap_or_default()
    }

    /// What is known of some of the numbers alone, which then hold wherever they are used.
    pub fn of(&self, is_kept: impl Fn(&CalibratedParameter) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.parameter.len()).filter(|k| is_kept(&self.parameter[*k])).collect();
        let parameter = |k: &usize| {
            let own = &self.parameter[*k];
            let correlations = kept.iter().map(|l| own.correlations[*l]).collect();
            CalibratedParameter { correlations, pressure_pa: None, ..own.clone() }
        };
        Self { parameter: kept.iter().map(parameter).collect(), ..self.clone() }
    }

    /// The section `[calibration]` of a muscle's or a scenario's file.
    pub fn section(&self) -> String {
        let own = toml::Value::try_from(self).expect("it has nothing that TOML has not");
        format!(
            "# What `efam predict` takes its intervals from; SI.\n{}",
            toml::Table::from_iter([("calibration".to_owned(), own)])
        )
    }

    /// What the section of a text says; nothing where it has none.
    /// # Errors
    /// [`MuscleError`] for a section that makes no sense.
    pub fn read(text: &str) -> Result<Option<Self>, MuscleError> {
        #[derive(Deserialize)]
        struct File {
            calibration: Option<Known>,
        }
        let known = toml::from_str::<File>(text)?.calibration;
        known.as_ref().map_or(Ok(()), Known::check)?;
        Ok(known)
    }

    /// # Errors
    /// [`MuscleError::Calibration`], with what is wrong.
    pub(super) fn check(&self) -> Result<(), MuscleError> {
        let wrong = |what: String| Err(MuscleError::Calibration { what });
        let count = self.parameter.len();
        for (k, parameter) in self.parameter.iter().enumerate() {
            let name = format!("calibration.parameter {} ({})", k + 1, parameter.path);
            if parameter.standard_error.is_some_and(|error| !(error >= 0.0 && error.is_finite())) {
                return wrong(format!("{name}: standard_error must be finite and not negative"));
            }
            if !parameter.value.is_finite() {
                return wrong(format!("{name}: value must be finite"));
            }
            if parameter.correlations.len() != count {
                return wrong(format!(
                    "{name}: correlations has {} numbers, and there are {count} parameters",
                    parameter.correlations.len()
                ));
            }
            let is_one = |c: &f64| c.abs() <= 1.0 + 1e-9;
            if !parameter.correlations.iter().all(is_one) || (parameter.correlations[k] - 1.0).abs() > 1e-9 {
                return wrong(format!("{name}: correlations must lie in -1 to 1, and be 1 with itself"));
            }
        }
        if let Some(marker) = &self.marker {
            let is_error = |error: &f64| *error >= 0.0 && error.is_finite();
            let has_place = marker.offset_m.iter().all(|offset| offset.is_finite());
            if !has_place || !marker.standard_error_m.iter().all(is_error) {
                return wrong(
                    "calibration.marker: offset_m must be finite, and standard_error_m finite and not negative".to_owned(),
                );
            }
        }
        for own in &self.interpolation {
            let name = format!("calibration.interpolation of {}", own.path);
            if !(own.variance_per_pa >= 0.0 && own.variance_per_pa.is_finite()) {
                return wrong(format!("{name}: variance_per_pa must be finite and not negative"));
            }
            if own.shape.is_some()
                && self.over_pressure(&own.path).iter().any(|(_, parameter)| parameter.value <= 0.0)
            {
                return wrong(format!("{name}: a ratio to a shape needs positive values"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(
        path: &str,
        pressure_pa: Option<f64>,
        value: f64,
        error: f64,
        correlations: Vec<f64>,
    ) -> CalibratedParameter {
        CalibratedParameter {
            path: path.to_owned(),
            pressure_pa,
            value,
            standard_error: Some(error),
            correlations,
        }
    }

    fn known() -> Known {
        let parameter = vec![
            parameter("rod.bending_stiffness", Some(1e5), 0.01, 1e-4, vec![1.0, 0.0, 0.5]),
            parameter("rod.bending_stiffness", Some(2e5), 0.02, 2e-4, vec![0.0, 1.0, 0.0]),
            parameter("alpha", None, 0.5, 0.1, vec![0.5, 0.0, 1.0]),
        ];
        Known { parameter, ..Known::default() }
    }

    fn here(_: &str) -> Here {
        Here { value: 0.015, scale: 0.5 }
    }

    /// At a calibrated pressure its own errors hold; half way between two both count by half, and beyond the last
    /// one its own.
    #[test]
    fn errors_are_carried_over_as_values_are() {
        let at = |pressure: f64| known().at(pressure, &here);
        let own = at(1e5);
        assert_eq!(own.paths, ["rod.bending_stiffness", "alpha"]);
        assert!((own.covariance[0][0].sqrt() / 1e-4 - 1.0).abs() < 1e-6);
        assert!((own.covariance[0][1] - 0.5 * 1e-4 * 0.1).abs() < 1e-9);
        assert!((own.covariance[1][1] - 0.01).abs() < 1e-12);
        let between = at(1.5e5).covariance[0][0].sqrt();
        assert!((between / (0.5 * 1e-4f64.hypot(2e-4)) - 1.0).abs() < 1e-9, "{between}");
        assert!((at(9e5).covariance[0][0].sqrt() / 2e-4 - 1.0).abs() < 1e-6);
        assert!(known().is_silent_at(1.5e5) && !known().is_silent_at(1e5));
    }

    /// Two releases a millimetre apart: the variance of each is half a square millimetre, that of a third one beside their
    /// mean half as much again. The errors of the offsets themselves are added as they are.
    #[test]
    fn a_marker_has_the_spread_of_one_more_release() {
        let of = |x: f64| [(x, 2e-4), (1e-3, 3e-4)];
        let marker = Marker::of("Tip", &[of(0.0), of(1e-3)]).unwrap();
        assert_eq!(marker.offset_m, [5e-4, 1e-3]);
        let [x, z] = marker.standard_error_m;
        assert!((x / (0.75e-6f64 + 4e-8).sqrt() - 1.0).abs() < 1e-12 && (z / 3e-4 - 1.0).abs() < 1e-12);
        assert_eq!(Marker::of("Tip", &[of(1e-3)]).unwrap().standard_error_m, [2e-4, 3e-4]);
        assert!(Marker::of("Tip", &[]).is_none());
        let wrong = Marker { standard_error_m: [-1.0, 0.0], ..marker };
        assert!(Known { marker: Some(wrong), ..known() }.check().is_err());
    }

    /// With a ratio to a shape each number moves the value by its own share of it; what interpolation may be off by
    /// is added to that, and is nothing where it was calibrated.
    #[test]
    fn what_interpolation_may_be_off_by_is_part_of_the_covariance() {
        let shape = Some("pder_32".to_owned());
        let path = "rod.bending_stiffness".to_owned();
        let own = Interpolation { path, shape, variance_per_pa: 4e-8 };
        let known = Known { interpolation: vec![own], ..known() };
        assert!(known.check().is_ok() && !known.is_silent_at(1.5e5));
        let at = known.at(1.5e5, &here);
        // 25 kPa is the bridge's (p − a)(b − p)/(b − a).
        let interpolated = 0.015 * (4e-8f64 * 2.5e4).sqrt();
        assert!((at.interpolated[0] / interpolated - 1.0).abs() < 1e-12 && at.interpolated[1] == 0.0);
        // Half of a per cent each: both calibrated values are known to a per cent.
        let carried = 0.015 * 0.5 * 0.01f64.hypot(0.01);
        assert!((at.covariance[0][0].sqrt() / carried.hypot(interpolated) - 1.0).abs() < 1e-9);
        let on = known.at(2e5, &|_| Here { value: 0.02, scale: 0.5 });
        assert!((on.covariance[0][0].sqrt() / 2e-4 - 1.0).abs() < 1e-9 && on.interpolated[0] == 0.0);
    }

    #[test]
    fn what_is_known_of_some_keeps_their_correlations() {
        let some = known().of(|parameter| parameter.value != 0.02);
        let paths: Vec<&str> = some.parameter.iter().map(|parameter| parameter.path.as_str()).collect();
        assert_eq!(paths, ["rod.bending_stiffness", "alpha"]);
        assert_eq!(some.parameter[1].correlations, [0.5, 1.0]);
        assert_eq!(some.parameter[0].pressure_pa, None);
        assert!(some.check().is_ok());
    }

    /// Without a standard error a number is taken to be known to its own size, or to its typical size where it is
    /// smaller; it is named, and so is one that cannot be distinguished from zero.
    #[test]
    fn what_is_not_determined_is_named() {
        let named = |value: f64, standard_error: Option<f64>| {
            let mut known = known();
            (known.parameter[2].value, known.parameter[2].standard_error) = (value, standard_error);
            let at = known.at(1e5, &here);
            (
                at.undetermined.iter().map(|parameter| parameter.path.clone()).collect::<Vec<_>>(),
                at.covariance[1][1],
            )
        };
        assert_eq!(named(0.7, None), (vec!["alpha".to_owned()], 0.7 * 0.7));
        assert_eq!(named(0.0, None), (vec!["alpha".to_owned()], 0.5 * 0.5));
        assert_eq!(named(0.5, Some(0.3)).0, ["alpha"]);
        assert!(named(0.5, Some(0.2)).0.is_empty());
    }

    #[test]
    fn numbers_that_make_no_sense_are_refused_by_name() {
        let says = |change: &dyn Fn(&mut Known), expected: &str| {
            let mut known = known();
            change(&mut known);
            let text = known.check().unwrap_err().to_string();
            assert!(text.contains(expected), "{text}");
        };
        assert!(known().check().is_ok());
        says(
            &|k| k.parameter[1].standard_error = Some(-1.0),
            "parameter 2 (rod.bending_stiffness): standard_error",
        );
        says(&|k| k.parameter[0].correlations.truncate(2), "has 2 numbers, and there are 3");
        says(&|k| k.parameter[0].correlations[1] = 1.5, "must lie in -1 to 1");
        says(&|k| k.parameter[2].value = f64::NAN, "parameter 3 (alpha): value");
        let own = Interpolation { path: "alpha".to_owned(), shape: None, variance_per_pa: -1.0 };
        says(&|k| k.interpolation = vec![own.clone()], "interpolation of alpha: variance_per_pa");
    }
}

//! How well a calibration knows a muscle, and how well that is then known at any pressure.

use serde::{Deserialize, Serialize};

use super::MuscleError;
use crate::interpolate::Pchip;

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
    /// The numbers.
    pub parameter: Vec<Knob>,
}

/// One number that was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Knob {
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
    /// Their covariance, shape `[paths][paths]`.
    pub covariance: Vec<Vec<f64>>,
    /// Those that the data did not determine: their standard error is taken to be their value.
    pub undetermined: Vec<String>,
}

impl Known {
    /// What is known at a pressure, Pa: between those that were calibrated as the interpolation of a muscle's
    /// table carries it over, beyond them as at the nearest.
    pub fn at(&self, pressure: f64) -> KnownAt {
        let mut known = KnownAt::default();
        let mut weights: Vec<Vec<f64>> = Vec::new();
        for knob in &self.parameter {
            if !known.paths.contains(&knob.path) {
                known.paths.push(knob.path.clone());
                weights.push(self.weights(&knob.path, pressure));
            }
        }
        let deviation = |knob: &Knob| knob.standard_error.unwrap_or(knob.value.abs());
        let covariance = |a: &[f64], b: &[f64]| {
            let mut sum = 0.0;
            // Most do not move this one: with many numbers all pairs of all would take minutes.
            let moves = |weights: &[f64], k: usize| weights[k] != 0.0;
            for (k, first) in self.parameter.iter().enumerate().filter(|(k, _)| moves(a, *k)) {
                for (l, second) in self.parameter.iter().enumerate().filter(|(l, _)| moves(b, *l)) {
                    sum += a[k] * b[l] * first.correlations[l] * deviation(first) * deviation(second);
                }
            }
            sum
        };
        known.covariance =
            weights.iter().map(|a| weights.iter().map(|b| covariance(a, b)).collect()).collect();
        let is_used = |k: usize| weights.iter().any(|weights| weights[k] != 0.0);
        for (k, knob) in self.parameter.iter().enumerate() {
            let is_new = !known.undetermined.contains(&knob.path);
            if knob.standard_error.is_none() && is_used(k) && is_new {
                known.undetermined.push(knob.path.clone());
            }
        }
        known
    }

    /// How a parameter at a pressure moves with each number.
    fn weights(&self, path: &str, pressure: f64) -> Vec<f64> {
        let mut own: Vec<usize> =
            (0..self.parameter.len()).filter(|k| self.parameter[*k].path == path).collect();
        let place = |k: &usize| self.parameter[*k].pressure_pa.unwrap_or(0.0);
        own.sort_by(|a, b| place(a).total_cmp(&place(b)));
        let mut weights = vec![0.0; self.parameter.len()];
        let curve = |moved: Option<usize>, by: f64| {
            let value = |k: &usize| self.parameter[*k].value + if moved == Some(*k) { by } else { 0.0 };
            Pchip::new(own.iter().map(place).collect(), own.iter().map(value).collect())
        };
        let Ok(plain) = curve(None, 0.0) else {
            // One alone holds everywhere.
            own.iter().take(1).for_each(|k| weights[*k] = 1.0);
            return weights;
        };
        let (low, high) = plain.range();
        let at = pressure.clamp(low, high);
        let largest = own.iter().map(|k| self.parameter[*k].value.abs()).fold(f64::MIN_POSITIVE, f64::max);
        let step = 1e-6 * largest;
        for k in &own {
            let moved = curve(Some(*k), step).map_or(0.0, |curve| curve.value(at));
            weights[*k] = (moved - plain.value(at)) / step;
        }
        weights
    }

    /// Least and largest of some values; zeros of none.
    pub fn span(values: impl Iterator<Item = f64>) -> [f64; 2] {
        let ends = values.fold(None, |ends: Option<[f64; 2]>, value| {
            Some(ends.map_or([value; 2], |[low, high]| [low.min(value), high.max(value)]))
        });
        ends.unwrap_or_default()
    }

    /// What is known of some of the numbers alone, which then hold wherever they are used.
    pub fn of(&self, is_kept: impl Fn(&Knob) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.parameter.len()).filter(|k| is_kept(&self.parameter[*k])).collect();
        let knob = |k: &usize| {
            let own = &self.parameter[*k];
            let correlations = kept.iter().map(|l| own.correlations[*l]).collect();
            Knob { correlations, pressure_pa: None, ..own.clone() }
        };
        Self { parameter: kept.iter().map(knob).collect(), ..self.clone() }
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
        for (k, knob) in self.parameter.iter().enumerate() {
            let name = format!("calibration.parameter {} ({})", k + 1, knob.path);
            if knob.standard_error.is_some_and(|error| !(error >= 0.0 && error.is_finite())) {
                return wrong(format!("{name}: standard_error must be finite and not negative"));
            }
            if !knob.value.is_finite() {
                return wrong(format!("{name}: value must be finite"));
            }
            if knob.correlations.len() != count {
                return wrong(format!(
                    "{name}: correlations has {} numbers, and there are {count} parameters",
                    knob.correlations.len()
                ));
            }
            let is_one = |c: &f64| c.abs() <= 1.0 + 1e-9;
            if !knob.correlations.iter().all(is_one) || (knob.correlations[k] - 1.0).abs() > 1e-9 {
                return wrong(format!("{name}: correlations must lie in -1 to 1, and be 1 with itself"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knob(path: &str, pressure_pa: Option<f64>, value: f64, error: f64, correlations: Vec<f64>) -> Knob {
        Knob { path: path.to_owned(), pressure_pa, value, standard_error: Some(error), correlations }
    }

    fn known() -> Known {
        let parameter = vec![
            knob("rod.bending_stiffness", Some(1e5), 0.01, 1e-4, vec![1.0, 0.0, 0.5]),
            knob("rod.bending_stiffness", Some(2e5), 0.02, 2e-4, vec![0.0, 1.0, 0.0]),
            knob("alpha", None, 0.5, 0.1, vec![0.5, 0.0, 1.0]),
        ];
        Known { parameter, ..Known::default() }
    }

    /// At a pressure that was calibrated its own errors stand; between two of equal slope both count by half,
    /// and beyond the last one its own.
    #[test]
    fn errors_are_carried_over_as_values_are() {
        let at = |pressure: f64| known().at(pressure);
        let own = at(1e5);
        assert_eq!(own.paths, ["rod.bending_stiffness", "alpha"]);
        assert!((own.covariance[0][0].sqrt() / 1e-4 - 1.0).abs() < 1e-6);
        assert!((own.covariance[0][1] - 0.5 * 1e-4 * 0.1).abs() < 1e-9);
        assert!((own.covariance[1][1] - 0.01).abs() < 1e-12);
        let between = at(1.5e5).covariance[0][0].sqrt();
        assert!((between / (0.5 * 1e-4f64.hypot(2e-4)) - 1.0).abs() < 1e-3, "{between}");
        assert!((at(9e5).covariance[0][0].sqrt() / 2e-4 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn what_is_known_of_some_keeps_their_correlations() {
        let some = known().of(|knob| knob.value != 0.02);
        let paths: Vec<&str> = some.parameter.iter().map(|knob| knob.path.as_str()).collect();
        assert_eq!(paths, ["rod.bending_stiffness", "alpha"]);
        assert_eq!(some.parameter[1].correlations, [0.5, 1.0]);
        assert_eq!(some.parameter[0].pressure_pa, None);
        assert!(some.check().is_ok());
    }

    #[test]
    fn what_is_not_determined_is_known_to_its_value_and_named() {
        let mut known = known();
        known.parameter[2].standard_error = None;
        let at = known.at(1e5);
        assert_eq!(at.undetermined, ["alpha"]);
        assert!((at.covariance[1][1] - 0.25).abs() < 1e-12);
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
    }
}

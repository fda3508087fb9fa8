//! The height of the tip about its rest, evenly sampled: what all signal analysis starts from.

use super::AnalysisError;

/// `z(t)` minus its static rest, m; the first sample is the release, at time 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Excursion {
    step: f64,
    rest: f64,
    values: Vec<f64>,
}

impl Excursion {
    /// From heights of the tip, m, every `step` seconds, about a `rest` known from statics, m.
    ///
    /// # Errors
    /// [`AnalysisError::Step`], [`AnalysisError::NotFinite`]; [`AnalysisError::TooShort`] below
    /// three samples, which is the least that has a peak.
    pub fn about(rest: f64, z: &[f64], step: f64) -> Result<Self, AnalysisError> {
        const LEAST: usize = 3;
        if !(step > 0.0 && step.is_finite()) {
            return Err(AnalysisError::Step { step });
        }
        if z.len() < LEAST {
            return Err(AnalysisError::TooShort { samples: z.len(), least: LEAST });
        }
        let values: Vec<f64> = z.iter().map(|z| z - rest).collect();
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            return Err(AnalysisError::NotFinite { index, value: z[index] });
        }
        Ok(Self { step, rest, values })
    }

    /// About the mean of the last `seconds`, as the paper removes its static bias.
    ///
    /// # Errors
    /// As [`Self::about`]; [`AnalysisError::TooShort`] if the recording is shorter than that.
    pub fn about_end(seconds: f64, z: &[f64], step: f64) -> Result<Self, AnalysisError> {
        let least = (seconds / step).ceil().max(1.0) as usize;
        if z.len() < least {
            return Err(AnalysisError::TooShort { samples: z.len(), least });
        }
        let end = &z[z.len() - least..];
        Self::about(end.iter().sum::<f64>() / least as f64, z, step)
    }

    /// Time between samples, s.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Height of the static rest in W, m.
    pub fn rest(&self) -> f64 {
        self.rest
    }

    /// Height above rest, m, one a sample.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Time from the first sample to the last, s.
    pub fn duration(&self) -> f64 {
        (self.values.len() - 1) as f64 * self.step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rest_is_taken_off() {
        let excursion = Excursion::about(-0.2, &[0.0, -0.3, -0.1, -0.2], 0.01).unwrap();
        let expected = [0.2, -0.1, 0.1, 0.0];
        assert!(excursion.values().iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15));
        assert!((excursion.duration() - 0.03).abs() < 1e-15);
        let excursion = Excursion::about_end(0.02, &[0.0, -0.3, -0.1, -0.3], 0.01).unwrap();
        assert!((excursion.rest() + 0.2).abs() < 1e-15);
    }

    #[test]
    fn a_gap_a_step_of_zero_and_a_stump_are_refused() {
        let z = [0.0, f64::NAN, 0.0];
        let error = Excursion::about(0.0, &z, 0.01).unwrap_err();
        assert_eq!(error.to_string(), "sample 1 is NaN: fill or cut gaps before the analysis");
        let error = Excursion::about(0.0, &[0.0; 3], 0.0).unwrap_err();
        assert_eq!(error.to_string(), "sampling step 0 s: must be positive");
        let error = Excursion::about_end(1.0, &[0.0; 3], 0.01).unwrap_err();
        assert_eq!(error, AnalysisError::TooShort { samples: 3, least: 100 });
    }
}

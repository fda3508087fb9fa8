//! The fit of a pressure line: time constant, dead time and rate limit, from a command and the pressure that was read.
//!
//! The law is that of the effect `pressure_line`. A reading may have a constant offset, as a gauge has. The rate limit is
//! kept where it lowers chi squared by more than ln n of n samples (BIC); otherwise the command was never fast enough.
//! Errors count residuals that follow one another as fewer independent ones, by their correlation at one sample.
//! Source: Bayley and Hammersley (1946), Supplement to the J. Royal Statistical Society 8, 184-197.

use efam_core::levenberg_marquardt::{Evaluated, FIRST_DAMPING, Search, Solution, minimise};
use models::effects::pressure_line::PressureLine;
use models::effects::{Law, Line, Real};
use nalgebra::{DMatrix, DVector};
use num_dual::Dual64;
use schemars::JsonSchema;
use serde::Serialize;
use thiserror::Error;

/// A command and what was read, at the same times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PressureRecord {
    /// s, ascending.
    pub time: Vec<f64>,
    /// Commanded pressure, Pa; it moves on straight lines between the times.
    pub command: Vec<f64>,
    /// Pressure that was read, Pa; not a number where it is missing.
    pub reading: Vec<f64>,
}

/// What was found of a pressure line.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct PressureLineFit {
    /// Time constant, s.
    pub time_constant_s: Estimate,
    /// Dead time, s.
    pub dead_time_s: Estimate,
    /// Rate limit, Pa/s; none where the pressure never shows it.
    pub rate_limit_pa_per_s: Option<Estimate>,
    /// What the reading has more than the pressure, Pa.
    pub offset_pa: Estimate,
    /// Fastest change of the fitted pressure, Pa/s.
    pub fastest_pa_per_s: f64,
    /// Root mean square of what is left, Pa.
    pub rms_pa: f64,
    /// Correlation of what is left from one sample to the next.
    pub autocorrelation: f64,
    /// Samples.
    pub samples: usize,
    /// Caveats of the numbers.
    pub warnings: Vec<String>,
}

/// A value with its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// A record that says nothing of a line.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PressureRecordError {
    /// Columns that do not belong together.
    #[error("{times} times, {commands} commands and {readings} readings: each time has one of both")]
    Lengths {
        /// Times.
        times: usize,
        /// Commands.
        commands: usize,
        /// Readings.
        readings: usize,
    },
    /// Too few samples.
    #[error("{samples} samples with a reading; a pressure line needs {LEAST} at least")]
    TooFew {
        /// How many.
        samples: usize,
    },
    /// Times that do not ascend, or a command that is no number.
    #[error("sample {}: times must ascend, and times and commands must be finite", sample + 1)]
    Sample {
        /// Its place.
        sample: usize,
    },
    /// A command that stays.
    #[error("the command never changes, so the line shows nothing; record a step")]
    Constant,
}

/// Unknowns: time constant, dead time, rate limit, offset.
const UNKNOWNS: usize = 4;
/// Samples that are needed, a few for each unknown.
const LEAST: usize = 5 * UNKNOWNS;
/// Factor between time constants, and between dead times, from which searches begin: each reaches the next.
const APART: f64 = 3.0;
/// Searches that are begun, from the best starts.
const SEARCHES: usize = 3;
/// Predicted decrease of the cost, as a share of it, at which a search ends: far below a standard error of any record.
const SETTLED: f64 = 1e-9;
/// Correlation of neighbouring residuals from which on another law than a lag would be seen: half of their variance.
const CORRELATED: f64 = 0.7;
/// A rate that no pressure reaches, over the fastest that was read.
const UNREACHED: f64 = 1e4;

impl PressureRecord {
    fn check(&self) -> Result<(), PressureRecordError> {
        let (times, commands, readings) = (self.time.len(), self.command.len(), self.reading.len());
        if times != commands || times != readings {
            return Err(PressureRecordError::Lengths { times, commands, readings });
        }
        let is_wrong = |k: &usize| {
            let ascends = *k == 0 || self.time[*k] > self.time[k - 1];
            !(ascends && self.time[*k].is_finite() && self.command[*k].is_finite())
        };
        if let Some(sample) = (0..times).find(is_wrong) {
            return Err(PressureRecordError::Sample { sample });
        }
        let samples = self.reading.iter().filter(|reading| reading.is_finite()).count();
        if samples < LEAST {
            return Err(PressureRecordError::TooFew { samples });
        }
        if self.command.iter().all(|command| *command == self.command[0]) {
            return Err(PressureRecordError::Constant);
        }
        Ok(())
    }

    /// Pressure behind a line of time constant, dead time and rate limit, at each time.
    fn behind<T: Real>(&self, theta: &[T; 3]) -> Vec<T> {
        let count = self.time.len();
        let piece = |k: usize, pressure: T, time: T| {
            let rate = match k + 1 {
                next if next < count => {
                    (self.command[next] - self.command[k]) / (self.time[next] - self.time[k])
                }
                _ => 0.0,
            };
            let (command, command_rate) = (T::from(self.command[k]), T::from(rate));
            PressureLine.line(&Line { pressure, command, command_rate, time }, theta)[0]
        };
        let mut begins = vec![T::from(self.command[0])];
        for k in 0..count - 1 {
            begins.push(piece(k, begins[k], T::from(self.time[k + 1] - self.time[k])));
        }
        let at = |time: &f64| {
            let sent = T::from(*time) - theta[1];
            match self.time.partition_point(|begin| *begin <= sent.re()) {
                0 => begins[0],
                next => piece(next - 1, begins[next - 1], sent - self.time[next - 1]),
            }
        };
        self.time.iter().map(at).collect()
    }

    /// Residuals of the readings with derivatives by the scaled unknowns; infinite rate limits are not unknown.
    fn residuals(&self, x: &DVector<f64>, scale: &Scale) -> (DVector<f64>, DMatrix<f64>) {
        let values = scale.values(x);
        let slopes = [values[0], scale.dead_time, values[2]];
        let by: Vec<Vec<Dual64>> = (0..3)
            .map(|k| {
                let own = |l: usize| Dual64::new(values[l], if k == l { slopes[l] } else { 0.0 });
                self.behind(&[own(0), own(1), own(2)])
            })
            .collect();
        let seen: Vec<usize> = (0..self.time.len()).filter(|k| self.reading[*k].is_finite()).collect();
        let residual = |k: &usize| self.reading[*k] - by[0][*k].re - values[3];
        let slope = |k: usize, column: usize| match column {
            3 => -scale.pressure,
            column => -by[column][k].eps,
        };
        (
            DVector::from_iterator(seen.len(), seen.iter().map(residual)),
            DMatrix::from_fn(seen.len(), UNKNOWNS, |row, column| slope(seen[row], column)),
        )
    }
}

/// From scaled unknowns to values: logarithms of the time constant and of the rate limit, dead time and offset by a size.
struct Scale {
    dead_time: f64,
    pressure: f64,
}

impl Scale {
    fn values(&self, x: &DVector<f64>) -> [f64; UNKNOWNS] {
        [x[0].exp(), self.dead_time * x[1], x[2].exp(), self.pressure * x[3]]
    }
}

/// Finds the pressure line of a record.
/// # Errors
/// [`PressureRecordError`] for one that says nothing of a line.
pub fn fit(record: &PressureRecord) -> Result<PressureLineFit, PressureRecordError> {
    record.check()?;
    let count = record.time.len();
    let span = record.time[count - 1] - record.time[0];
    let step = span / (count - 1) as f64;
    let size = record.command.iter().fold(0.0f64, |most, own| most.max((own - record.command[0]).abs()));
    let scale = Scale { dead_time: step, pressure: size };
    // As fast as the largest change within three samples, which is less than noise makes of one.
    let rates = (3..count)
        .map(|k| (record.reading[k] - record.reading[k - 3]).abs() / (record.time[k] - record.time[k - 3]));
    let fastest = rates.filter(|rate| rate.is_finite()).fold(size / span, f64::max);
    let unreached = (UNREACHED * fastest).ln();
    let evaluate = |x: &DVector<f64>| {
        let (residuals, slopes) = record.residuals(x, &scale);
        let (cost, gradient) = (0.5 * residuals.norm_squared(), slopes.tr_mul(&residuals));
        cost.is_finite().then(|| Evaluated {
            cost,
            gradient,
            hessian: slopes.tr_mul(&slopes),
            carried: residuals,
        })
    };
    let search = |start: &DVector<f64>, has_limit: bool| {
        let bounds = vec![
            ((step / 100.0).ln(), span.ln()),
            (0.0, 0.5 * span / step),
            if has_limit { ((size / span / 10.0).ln(), unreached) } else { (unreached, unreached) },
            (f64::NEG_INFINITY, f64::INFINITY),
        ];
        let search = Search {
            bounds,
            longest: vec![APART.ln(), f64::INFINITY, APART.ln(), f64::INFINITY],
            tolerance: f64::MIN_POSITIVE,
            relative: SETTLED,
            most_evaluations: 200,
            first_damping: FIRST_DAMPING,
            reuses_slopes: false,
            is_followed: false,
        };
        minimise(start, None, &search, &mut |x, _| evaluate(x))
    };
    let geometric = |from: f64| {
        std::iter::successors(Some(from), |own| Some(APART * own)).take_while(|own| *own < 0.3 * span)
    };
    let best = |limit: f64, has_limit: bool| {
        let mut starts: Vec<(f64, DVector<f64>)> = Vec::new();
        for lag in geometric(step) {
            for dead_time in std::iter::once(0.0).chain(geometric(step)) {
                let x = DVector::from_column_slice(&[lag.ln(), dead_time / scale.dead_time, limit, 0.0]);
                starts.extend(evaluate(&x).map(|at| (at.cost, x)));
            }
        }
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ends = starts.iter().take(SEARCHES).filter_map(|(_, x)| search(x, has_limit));
        ends.min_by(|a, b| a.at.cost.total_cmp(&b.at.cost))
    };
    let without = best(unreached, false).ok_or(PressureRecordError::Constant)?;
    let samples = without.at.carried.len();
    let limited = best(fastest.ln(), true).filter(|own| {
        let variance = 2.0 * own.at.cost / (samples - UNKNOWNS) as f64;
        2.0 * (without.at.cost - own.at.cost) > (samples as f64).ln() * variance
    });
    let has_limit = limited.is_some();
    let found = limited.unwrap_or(without);
    Ok(record.fitted(&found, &scale, has_limit))
}

impl PressureRecord {
    /// What was found, with errors that the correlation of what is left widens.
    fn fitted(&self, found: &Solution<DVector<f64>>, scale: &Scale, has_limit: bool) -> PressureLineFit {
        let (samples, step) = (found.at.carried.len(), scale.dead_time);
        let residuals = &found.at.carried;
        let variance = 2.0 * found.at.cost / (samples - UNKNOWNS) as f64;
        let products = residuals.iter().zip(residuals.iter().skip(1)).map(|(a, b)| a * b).sum::<f64>();
        let autocorrelation = products / residuals.norm_squared().max(f64::MIN_POSITIVE);
        let shown = autocorrelation.clamp(0.0, 1.0 - 1.0 / samples as f64);
        let inflated = variance * (1.0 + shown) / (1.0 - shown);
        let mut hessian = found.at.hessian.clone();
        if !has_limit {
            hessian.row_mut(2).fill(0.0);
            hessian.column_mut(2).fill(0.0);
        }
        let covariance = inflated * crate::calibrate::uncertainty::pseudo_inverse(&hessian).0;
        let values = scale.values(&found.x);
        let slopes = [values[0], scale.dead_time, values[2], scale.pressure];
        let estimate = |k: usize| Estimate {
            value: values[k],
            standard_error: slopes[k] * covariance[(k, k)].max(0.0).sqrt(),
        };
        let behind = self.behind(&[values[0], values[1], values[2]]);
        let rates =
            behind.windows(2).zip(self.time.windows(2)).map(|(p, t)| ((p[1] - p[0]) / (t[1] - t[0])).abs());
        let mut warnings = Vec::new();
        if autocorrelation > CORRELATED {
            warnings.push(format!(
                "what is left follows from sample to sample (correlation {autocorrelation:.2}): the line is more than a lag, a \
                 dead time and a rate limit"
            ));
        }
        if values[0] < step {
            warnings.push(format!(
                "the time constant is shorter than a sample of {step:.3} s; record faster to know it"
            ));
        }
        PressureLineFit {
            time_constant_s: estimate(0),
            dead_time_s: estimate(1),
            rate_limit_pa_per_s: has_limit.then(|| estimate(2)),
            offset_pa: estimate(3),
            fastest_pa_per_s: rates.fold(0.0, f64::max),
            rms_pa: (residuals.norm_squared() / samples as f64).sqrt(),
            autocorrelation,
            samples,
            warnings,
        }
    }
}

#[cfg(test)]
mod tests {
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::SeedableRng;

    use super::*;
    use crate::normal::normal;

    /// A square command with ramps of one sample, read with noise and an offset of the gauge.
    fn record(theta: [f64; 3], noise: f64, seed: u64) -> PressureRecord {
        let time: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
        let command =
            time.iter().map(|t| if ((0.4 * t) as u32).is_multiple_of(2) { 1e5 } else { 2.4e5 }).collect();
        let mut record = PressureRecord { time, command, reading: Vec::new() };
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let read = |pressure: &f64| pressure + 800.0 + noise * normal(&mut random);
        record.reading = record.behind(&theta).iter().map(read).collect();
        record
    }

    /// Drawn lines are found again, each unknown within its own error: the mean square of 20 draws over it has a deviation of
    /// 0.32, and four of those.
    #[test]
    fn drawn_lines_are_found_within_their_errors() {
        for theta in [[0.12, 0.035, 4e5], [0.05, 0.0, 1e12], [0.3, 0.2, 1e12], [0.02, 0.05, 8e5]] {
            let mut squares = [0.0; 3];
            for seed in 0..20 {
                let found = fit(&record(theta, 500.0, seed)).unwrap();
                assert_eq!(found.rate_limit_pa_per_s.is_some(), theta[2] < 1e9, "{found:?}");
                assert!((found.rms_pa / 500.0 - 1.0).abs() < 0.1 && found.warnings.is_empty(), "{found:?}");
                let ends = [Some(found.time_constant_s), Some(found.dead_time_s), found.rate_limit_pa_per_s];
                for ((square, own), due) in squares.iter_mut().zip(ends).zip(theta) {
                    *square += own.map_or(0.0, |own| ((own.value - due) / own.standard_error).powi(2)) / 20.0;
                }
            }
            assert!(squares.iter().all(|square| *square < 2.3), "{theta:?}: {squares:?}");
        }
    }

    #[test]
    fn a_record_that_says_nothing_is_refused() {
        let good = record([0.1, 0.0, 1e12], 500.0, 1);
        let mut constant = good.clone();
        constant.command.fill(1e5);
        assert_eq!(fit(&constant), Err(PressureRecordError::Constant));
        let mut back = good.clone();
        back.time[7] = 0.0;
        assert_eq!(fit(&back), Err(PressureRecordError::Sample { sample: 7 }));
        let short = PressureRecord { reading: vec![1e5; 3], ..good.clone() };
        assert!(matches!(fit(&short), Err(PressureRecordError::Lengths { .. })));
        let lost = PressureRecord { reading: vec![f64::NAN; 1000], ..good };
        assert_eq!(fit(&lost), Err(PressureRecordError::TooFew { samples: 0 }));
    }
}

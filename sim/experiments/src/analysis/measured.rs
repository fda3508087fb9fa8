//! A measured release: frequency from the spectrum, damping by eq. 6 and 7, and beside it damping and frequency cycle by
//! cycle, as of a simulated one.
//!
//! The coordinate is the direction in which the tip moves most about its rest. The paper's is the height.

use std::f64::consts::TAU;

use efam_core::quantile::usual_step;

use super::coordinate::{Along, Coordinate};
use super::decay::{Cycle, Decay};
use super::gaps::{self, Bridged, bridge};
use super::peaks::Peak;
use super::spectrum::Spectrum;
use super::swing::{Known, Swing, swing, swing_spectrum};
use super::{AnalysisError, Excursion};
use crate::release::Release;

/// What a measured release comes to; what it does not has its reason.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The coordinate that was analysed, positive on the side of the hold.
    pub coordinate: Coordinate,
    /// Its value at rest, m.
    pub rest: f64,
    /// The coordinate on an even clock from the release on.
    pub bridged: Bridged,
    /// Time after the release from which on spectrum and peaks count, s: 0, unless the first, large
    /// swings have so different a frequency that they and the rest have none in common.
    pub since: f64,
    /// Of the excursion from then on, up to where it is over.
    pub spectrum: Spectrum,
    /// Damped angular frequency, rad/s.
    pub damped_frequency: Result<f64, String>,
    /// Upper peaks.
    pub peaks: Vec<Peak>,
    /// Eq. 6 and 7.
    pub decay: Result<Decay, String>,
    /// Cycle by cycle.
    pub cycles: Result<Vec<Cycle>, String>,
}

/// Where a tip comes to rest.
#[derive(Clone, Copy, Debug, Default)]
pub struct KnownRest {
    /// In W, m.
    pub position: [f64; 2],
    /// Standard error of each coordinate, m; zero where it is not known.
    pub error: [f64; 2],
}

impl From<[f64; 2]> for KnownRest {
    fn from(position: [f64; 2]) -> Self {
        Self { position, error: [0.0; 2] }
    }
}

/// Longest gap that is bridged, in periods.
const LONGEST_GAP: f64 = 0.4;
/// Gap that is bridged before the period is known, in samples.
const SHORT_GAP: f64 = 6.0;
/// Periods that a stretch between longer gaps must have to be used before others.
const LEAST_PERIODS: f64 = 3.5;

/// Analyses the first track of a release, its tip, along the largest motion about its rest.
/// # Errors
/// [`AnalysisError`] if there are too few samples for a spectrum.
pub fn analyse(release: &Release, rest: impl Into<KnownRest>) -> Result<Measured, AnalysisError> {
    let rest = rest.into();
    let after = release.time.iter().zip(&release.tracks[0].position).filter(|(time, _)| **time >= 0.0);
    let path = after.filter_map(|(_, at)| *at);
    analyse_along(release, rest, Coordinate::largest_motion(path, rest.position))
}

/// The same along a coordinate of choice: what is compared has to be of one.
/// # Errors
/// As [`analyse`].
pub fn analyse_along(
    release: &Release,
    rest: impl Into<KnownRest>,
    coordinate: Coordinate,
) -> Result<Measured, AnalysisError> {
    let (tip, KnownRest { position: rest, error }) = (&release.tracks[0], rest.into());
    let too_short = AnalysisError::TooShort { samples: release.time.len(), least: 4 };
    let step = usual_step(&release.time).ok_or(too_short)?;
    let held = tip.position.iter().flatten().next().map_or([0.0; 2], |at| [at[0] - rest[0], at[1] - rest[1]]);
    // Upper peaks are on the side of the hold.
    let coordinate = coordinate.towards(held);
    let rest = coordinate.of(rest);
    let values: Vec<_> = tip.position.iter().map(|at| at.map(|at| coordinate.of(at))).collect();
    let about =
        |from: f64, longest: f64, frequency: Option<f64>| -> Result<(Bridged, Excursion), AnalysisError> {
            let time: Vec<f64> = release.time.iter().map(|t| t - from).collect();
            let mut bridged = bridge(&time, &values, step, longest, frequency)?;
            bridged.cut_at = bridged.cut_at.map(|at| at + from);
            let excursion = Excursion::about(rest, &bridged.values, step)?;
            Ok((bridged, excursion))
        };
    // First with short gaps alone; then with gaps that the period admits, which the longest stretch without one shows.
    let (mut found, mut from) = (about(0.0, SHORT_GAP * step, None), 0.0);
    if found.as_ref().map_or(true, |(bridged, _)| bridged.cut_at.is_some() || bridged.longest > 0.0) {
        let stretches = |longest: f64| gaps::stretches(&release.time, &values, longest.max(1.5 * step));
        let longest =
            stretches(SHORT_GAP * step).into_iter().max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
        let part = longest.and_then(|[from, _]| about(from, SHORT_GAP * step, None).ok());
        if let Some(Ok(peak)) = part.map(|(_, part)| swing_spectrum(&part, None).peak()) {
            let period = TAU / peak.frequency;
            // What swings most is used, of what is long enough for peaks.
            let energy = |[from, to]: &[f64; 2]| {
                let within = release.time.iter().zip(&values).filter(|(t, _)| (*from..=*to).contains(*t));
                within.filter_map(|(_, value)| Some(((*value)? - rest).powi(2))).sum::<f64>()
            };
            let is_enough = |[from, to]: &[f64; 2]| to - from > LEAST_PERIODS * period;
            let used = stretches(LONGEST_GAP * period)
                .into_iter()
                .max_by(|a, b| is_enough(a).cmp(&is_enough(b)).then(energy(a).total_cmp(&energy(b))));
            from = used.map_or(0.0, |[from, _]| from);
            found = about(from, LONGEST_GAP * period, Some(peak.frequency));
        }
    }
    let (bridged, excursion) = found?;
    let known = Known {
        mode: None,
        noise: tip.noise,
        rest_error: (coordinate.direction[0] * error[0]).hypot(coordinate.direction[1] * error[1]),
        has_bumps: coordinate.along == Along::Height,
    };
    let (mut own, mut since) = (swing(&excursion, &known), from);
    // Where the first, large swings have another frequency than the rest, they are left out.
    let period = own.spectrum.peak().map_or(0.0, |peak| TAU / peak.frequency);
    for skipped in 1..=MOST_SKIPPED {
        if own.decay.is_ok() || period == 0.0 {
            break;
        }
        let first = (0.5 * skipped as f64 * period / step).round() as usize;
        let Some(values) = excursion.values().get(first..) else { break };
        let Ok(later) = Excursion::about(0.0, values, step) else { break };
        let other = swing(&later, &known);
        if other.decay.is_ok() {
            (own, since) = (other, from + first as f64 * step);
        }
    }
    let Swing { spectrum, damped_frequency, peaks, decay, cycles } = own;
    let later = |time: f64| time + since;
    Ok(Measured {
        coordinate,
        rest,
        bridged,
        since,
        spectrum,
        damped_frequency,
        peaks: peaks
            .unwrap_or_default()
            .iter()
            .map(|peak| Peak { time: later(peak.time), turn: later(peak.turn), ..*peak })
            .collect(),
        decay: decay.map(|decay| decay.later(since)),
        cycles: cycles
            .map(|all| all.iter().map(|cycle| Cycle { time: later(cycle.time), ..*cycle }).collect()),
    })
}

/// Half periods that may be left out at the start.
const MOST_SKIPPED: usize = 6;

/// Why a swing may be counted from later than its release.
pub const COUNTED_LATER: &str = "the swings before have another frequency, or end in a long gap";

impl Measured {
    /// Samples in a period, if there is a frequency.
    pub fn samples_in_a_period(&self) -> Option<f64> {
        self.damped_frequency.as_ref().ok().map(|omega| TAU / omega / self.bridged.step)
    }

    /// Natural angular frequency by eq. 7, rad/s.
    pub fn natural_frequency(&self) -> Option<f64> {
        self.decay.as_ref().ok().map(|decay| decay.natural_frequency)
    }

    /// Standard error of the mean frequency of the cycles, as a share: their scatter and their trend.
    pub fn frequency_error(&self) -> Option<f64> {
        let cycles = self.cycles.as_ref().ok().filter(|cycles| cycles.len() >= 3)?;
        let count = cycles.len() as f64;
        let mean = cycles.iter().map(|cycle| cycle.damped_frequency).sum::<f64>() / count;
        let square = cycles.iter().map(|cycle| (cycle.damped_frequency / mean - 1.0).powi(2)).sum::<f64>();
        Some((square / (count - 1.0) / count).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::release::{OutOfPlane, Point, Track};

    /// A damped cosine in z, or level under a hanging clamp, with bursts of samples lost.
    fn release(level: bool, lost: impl Fn(usize) -> bool) -> Release {
        let time: Vec<f64> = (0..1200).map(|i| 0.01 * i as f64 - 0.3037).collect();
        let swing = |t: f64| if t < 0.0 { 1.0 } else { (-0.3 * t).exp() * (8.0 * t).cos() };
        let at = |t: f64| {
            let s = 0.1 * swing(t);
            if level { [s, -0.3 + s * s] } else { [0.15 - 0.1 * s, s - 0.1] }
        };
        let position = time.iter().enumerate().map(|(i, t)| (!lost(i)).then(|| at(*t))).collect();
        Release {
            name: "made up".to_owned(),
            time,
            release_uncertainty: 1e-3,
            tracks: vec![Track {
                marker: "tip".to_owned(),
                at: Point::Tip,
                position,
                noise: 1e-6,
                discrepancy: 0.0,
            }],
            pressure: None,
            payload: 0.0,
            held_out: false,
            out_of_plane: OutOfPlane::default(),
        }
    }

    #[test]
    fn masked_samples_do_not_move_frequency_and_damping() {
        for level in [false, true] {
            let rest = if level { [0.0, -0.3] } else { [0.15, -0.1] };
            let whole = analyse(&release(level, |_| false), rest).unwrap();
            let holes = analyse(&release(level, |i| i % 97 < 4 || (300..312).contains(&i)), rest).unwrap();
            // Level, or along the line of the made-up swing.
            let expected = if level { 0.0 } else { 1f64.atan2(-0.1) };
            assert!((holes.coordinate.angle() - expected).abs() < 0.01, "{}", holes.coordinate.name());
            assert!(holes.bridged.filled > 40 && holes.bridged.cut_at.is_none(), "{:?}", holes.bridged);
            for measured in [&whole, &holes] {
                let decay = measured.decay.as_ref().unwrap();
                // The spectrum's own bias is below 1e-4; a bridged peak is off by 1e-3 of its height at most.
                assert!((decay.damped_frequency / 8.0 - 1.0).abs() < 1e-3, "{decay:?}");
                assert!((decay.damping_ratio / (0.3 / 8.0) - 1.0).abs() < 1e-2, "{decay:?}");
            }
            assert!(whole.frequency_error().unwrap() < 1e-3);
        }
    }

    /// A gap of half a period in the first cycle, at whatever rate, leaves the later cycles, and the limit is in periods.
    #[test]
    fn a_gap_in_the_first_cycle_leaves_the_others() {
        for step in [0.002, 0.01, 0.04] {
            for (from, to) in [(0.1, 0.55), (0.1, 0.25), (-0.1, 0.3)] {
                let mut own = release(true, |_| false);
                own.time = (0..(12.0 / step) as usize).map(|i| step * i as f64 - 0.3037).collect();
                let at = |t: &f64| {
                    let s = 0.1 * if *t < 0.0 { 1.0 } else { (-0.3 * t).exp() * (8.0 * t).cos() };
                    (!(from..to).contains(t)).then_some([s, -0.3 + s * s])
                };
                own.tracks[0].position = own.time.iter().map(at).collect();
                let measured = analyse(&own, [0.0, -0.3]).unwrap();
                let decay = measured.decay.as_ref().unwrap_or_else(|why| panic!("{step} {from} {to}: {why}"));
                // Of a tenth of a period to a sample the spectrum and the parabola are good to a per cent.
                assert!((decay.damped_frequency / 8.0 - 1.0).abs() < 2e-3, "{step} {from}: {decay:?}");
                assert!((decay.damping_ratio / (0.3 / 8.0) - 1.0).abs() < 2e-2, "{step} {from}: {decay:?}");
            }
        }
    }

    #[test]
    fn too_little_is_an_error_and_no_panic() {
        let mut short = release(false, |_| false);
        short.time.truncate(1);
        short.tracks[0].position.truncate(1);
        assert!(analyse(&short, [0.0; 2]).is_err());
        assert!(analyse(&release(false, |_| true), [0.0; 2]).is_err());
    }
}

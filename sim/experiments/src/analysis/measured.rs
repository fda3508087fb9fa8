//! A measured release the paper's way: frequency from the spectrum, damping by eq. 6 and 7, and beside
//! it damping and frequency cycle by cycle.
//!
//! The coordinate is the height, as in the paper. Where the tip hangs and swings level instead, its
//! height has two bumps in each swing, and the level coordinate is taken.

use std::f64::consts::TAU;

use efam_core::quantile::usual_step;

use super::decay::{self, Cycle, Decay};
use super::gaps::{Bridged, bridge};
use super::peaks::Peak;
use super::spectrum::Spectrum;
use super::swing::{level_swing, swing, swing_spectrum};
use super::{AnalysisError, Excursion};
use crate::release::Release;

/// What a measured release comes to; what it does not has its reason.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The coordinate that was analysed.
    pub coordinate: Coordinate,
    /// Its value at rest in W, m.
    pub rest: f64,
    /// Which side of the rest the hold was on, 1 or −1; upper peaks are on it.
    pub side: f64,
    /// The coordinate times `side` on an even clock from the release on.
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

/// A coordinate of W.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// Level, away from the clamp.
    X,
    /// Height.
    Z,
}

/// Range of the height in that of the level coordinate, late in the swing, below which a tip hangs.
const HANGS: f64 = 0.3;
/// Longest gap that is bridged, in periods.
const LONGEST_GAP: f64 = 0.4;
/// Shortest gap that may be bridged whatever the period, in samples.
const SHORT_GAP: f64 = 6.0;
/// Amplitude at which peaks are no longer counted: so many standard deviations of the noise.
const LEAST_PEAK: f64 = 6.0;

/// Analyses the first track of a release, its tip; `rest` is where it comes to rest, in W, m.
/// # Errors
/// [`AnalysisError`] if there are too few samples for a spectrum.
pub fn analyse(release: &Release, rest: [f64; 2]) -> Result<Measured, AnalysisError> {
    let coordinate = coordinate(&release.time, &release.tracks[0].position);
    analyse_along(release, rest, coordinate)
}

/// The same along a coordinate of choice: what is compared has to be of one.
/// # Errors
/// As [`analyse`].
pub fn analyse_along(
    release: &Release,
    rest: [f64; 2],
    coordinate: Coordinate,
) -> Result<Measured, AnalysisError> {
    let tip = &release.tracks[0];
    let too_short = AnalysisError::TooShort { samples: release.time.len(), least: 4 };
    let step = usual_step(&release.time).ok_or(too_short)?;
    let k = usize::from(coordinate == Coordinate::Z);
    let held_above = tip.position.iter().flatten().next().is_none_or(|first| first[k] >= rest[k]);
    // Upper peaks are on the side of the hold.
    let sign = if held_above { 1.0 } else { -1.0 };
    let values: Vec<_> = tip.position.iter().map(|at| at.map(|at| sign * at[k])).collect();
    let about = |longest: f64, frequency: Option<f64>| -> Result<(Bridged, Excursion), AnalysisError> {
        let bridged = bridge(&release.time, &values, step, longest, frequency)?;
        let excursion = Excursion::about(sign * rest[k], &bridged.values, step)?;
        Ok((bridged, excursion))
    };
    // First with short gaps alone, for the period; then with gaps that it admits.
    let (mut bridged, mut excursion) = about(SHORT_GAP * step, None)?;
    if bridged.cut_at.is_some() || bridged.longest > 0.0 {
        let wide = about(20.0 * step, None)?.1;
        if let Ok(peak) = swing_spectrum(&wide).peak() {
            let longest = (LONGEST_GAP * TAU / peak.frequency).max(SHORT_GAP * step);
            (bridged, excursion) = about(longest, Some(peak.frequency))?;
        }
    }
    let mut swing = one_swing(&excursion, 0.0, tip.noise, coordinate);
    // Where the first, large swings have another frequency than the rest, they are left out.
    let period = swing.spectrum.peak().map_or(0.0, |peak| TAU / peak.frequency);
    for skipped in 1..=MOST_SKIPPED {
        if swing.decay.is_ok() || period == 0.0 {
            break;
        }
        let since = 0.5 * skipped as f64 * period;
        let first = (since / step).round() as usize;
        let Some(values) = excursion.values().get(first..) else { break };
        let Ok(later) = Excursion::about(0.0, values, step) else { break };
        let other = one_swing(&later, first as f64 * step, tip.noise, coordinate);
        if other.decay.is_ok() {
            swing = other;
        }
    }
    let OneSwing { since, spectrum, damped_frequency, peaks, decay, cycles } = swing;
    Ok(Measured {
        coordinate,
        rest: rest[k],
        side: sign,
        bridged,
        since,
        spectrum,
        damped_frequency,
        peaks,
        decay,
        cycles,
    })
}

/// Half periods that may be left out at the start.
const MOST_SKIPPED: usize = 6;

struct OneSwing {
    since: f64,
    spectrum: Spectrum,
    damped_frequency: Result<f64, String>,
    peaks: Vec<Peak>,
    decay: Result<Decay, String>,
    cycles: Result<Vec<Cycle>, String>,
}

/// The swing of an excursion that begins `since` after the release, s.
fn one_swing(excursion: &Excursion, since: f64, noise: f64, coordinate: Coordinate) -> OneSwing {
    let spectrum = swing_spectrum(excursion);
    let (damped_frequency, upper) = match coordinate {
        Coordinate::X => level_swing(excursion, &spectrum),
        Coordinate::Z => swing(excursion, &spectrum),
    };
    let mut peaks = upper.clone().unwrap_or_default();
    let least = LEAST_PEAK * noise;
    peaks.truncate(peaks.iter().position(|peak| peak.height < least).unwrap_or(peaks.len()));
    peaks.iter_mut().for_each(|peak| peak.time += since);
    let decay = match &damped_frequency {
        Ok(damped) => decay::fit_decay(&peaks, *damped).map_err(|error| error.to_string()),
        Err(why) => Err(why.clone()),
    };
    let cycles = upper.and_then(|_| decay::cycles(&peaks).map_err(|error| error.to_string()));
    OneSwing { since, spectrum, damped_frequency, peaks, decay, cycles }
}

impl Coordinate {
    /// Its letter.
    pub fn name(self) -> &'static str {
        match self {
            Coordinate::X => "x",
            Coordinate::Z => "z",
        }
    }
}

impl Measured {
    /// The rest times [`Self::side`], m.
    pub fn rest_on_side(&self) -> f64 {
        self.side * self.rest
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

/// The coordinate in which the tip swings once it has lost its first, large swings.
fn coordinate(time: &[f64], position: &[Option<[f64; 2]>]) -> Coordinate {
    let end = time.last().copied().unwrap_or(0.0);
    let late = time.iter().zip(position).filter(|(t, _)| **t > 0.15 * end && **t < 0.5 * end);
    let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for at in late.filter_map(|(_, at)| *at) {
        for k in 0..2 {
            range[k] = [range[k][0].min(at[k]), range[k][1].max(at[k])];
        }
    }
    let [x, z] = range.map(|[low, high]| (high - low).max(0.0));
    if z < HANGS * x { Coordinate::X } else { Coordinate::Z }
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
            assert_eq!(holes.coordinate, if level { Coordinate::X } else { Coordinate::Z });
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

    #[test]
    fn too_little_is_an_error_and_no_panic() {
        let mut short = release(false, |_| false);
        short.time.truncate(1);
        short.tracks[0].position.truncate(1);
        assert!(analyse(&short, [0.0; 2]).is_err());
        assert!(analyse(&release(false, |_| true), [0.0; 2]).is_err());
    }
}

//! Features: the numbers that an expert compares in a recording and in a simulation of it.
//!
//! Rest, drift, first turns, frequency and decrement by amplitude, harmonics, and how the other coordinates move with the
//! leading one. One extractor serves both tracks, at the same times. Windows follow the track's own turns: cycles are
//! counted, not seconds, so no phase is lost and features are smooth in all parameters of a model.
//!
//! Coordinates are q along the first principal axis of the leading marker's path and p across it, of every marker.

pub mod covariance;
mod noise;
mod track;
pub mod turns;
mod wander;
pub mod window;

use efam_experiments::release::Release;
pub use noise::Noise;
use track::{axes, range, seen, turned};
use wander::Wander;
use window::{Fitted, Span};

/// Turns, counted from one, between which windows reach: 1, 2, 4, 8 and 16 cycles. Each begins where the one before ends, and
/// is twice as long, for frequency and loss change with the amplitude, which falls by shares.
const WINDOWS: [(usize, usize); 5] = [(1, 3), (3, 7), (7, 15), (15, 31), (31, 63)];
/// A swing back by so many standard deviations of the noise is a turn: noise alone does not do it.
const HYSTERESIS_NOISE: f64 = 6.0;
/// The same as a share of the range: below that the rest is as large as the swing.
const HYSTERESIS_SHARE: f64 = 0.015;
/// The same of a simulated track, which has no noise: a strongly damped model still has turns.
const HYSTERESIS_SIMULATED: f64 = 0.03;
/// Shares of the record at its end of which the rest, and what the drift compares it with, are weighted means.
const REST: f64 = 0.7;
const BEFORE_REST: f64 = 0.4;
/// Change of the track, over the first swing, by which differences of features are taken.
const DIFFERENCE: f64 = 1e-5;
/// Turns without which a track shows no swing.
const LEAST_TURNS: usize = 2;

/// What a feature is. Coordinates are counted over markers, q and p of each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// Coordinate at the first sample, of a rod that is held bent.
    Start { coordinate: usize },
    /// Coordinate at the first or second turn.
    Turn { turn: usize, coordinate: usize },
    /// Logarithm of the time of the first turn.
    FirstTurn,
    /// Logarithm of the time between the first and the second turn.
    FirstHalfPeriod,
    /// Logarithm of the frequency in a window.
    Frequency { window: usize },
    /// Logarithm of the amplitude in the first window, of its ratio to the window before in others.
    Amplitude { window: usize },
    /// Damping ratio in a window.
    Damping { window: usize },
    /// Mean of a coordinate in a window.
    Mean { window: usize, coordinate: usize },
    /// Swing of a coordinate in phase with the leading one.
    Swing { window: usize, coordinate: usize },
    /// Second harmonic of a coordinate, in phase with the square of the leading one.
    Second { window: usize, coordinate: usize },
    /// Mean of a coordinate at the end of the record.
    Rest { coordinate: usize },
    /// The same less the mean before.
    Drift { coordinate: usize },
}

/// What is looked at in a release, from its recording alone.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Tracks of the release that take part, the leading one first.
    pub tracks: Vec<usize>,
    /// Places of the samples in the release's time.
    pub samples: Vec<usize>,
    /// Times of the samples, s, and after them times up to which a slower model swings.
    pub time: Vec<f64>,
    /// Recorded coordinates `[coordinate][sample]`, m.
    pub recorded: Vec<Vec<f64>>,
    /// Features, their recorded values, and what each is worth, in its unit.
    pub features: Vec<What>,
    pub values: Vec<f64>,
    pub scales: Vec<f64>,
    /// Size of the first swing, m; frequency of the recorded swing, Hz.
    pub first_swing: f64,
    pub frequency: f64,
    /// Noise of its coordinates, and slow wander beside it.
    pub noise: Noise,
    pub wander: Wander,
    axes: [[f64; 2]; 2],
    hysteresis: f64,
    windows: Vec<(usize, usize)>,
    count: usize,
    first_turn: f64,
    end: f64,
    interval: f64,
    is_held: bool,
}

/// Features of one track, and where its turns and windows are.
#[derive(Clone, Debug, PartialEq)]
pub struct Extraction {
    /// In the order of [`Plan::features`]; not a number where the track has no such feature.
    pub values: Vec<f64>,
    turns: Vec<f64>,
    starts: Vec<Option<(f64, f64)>>,
}

impl Plan {
    /// None for a release that shows no swing.
    pub fn of(release: &Release, is_held: bool) -> Option<Self> {
        let leading = release.leading_track();
        let (tracks, samples) = seen(release, leading)?;
        let time: Vec<f64> = samples.iter().map(|k| release.time[*k]).collect();
        let position = |track: usize, k: usize| release.tracks[track].position[k].unwrap_or([0.0; 2]);
        let tip: Vec<[f64; 2]> = samples.iter().map(|k| position(leading, *k)).collect();
        let axes = axes(&tip);
        let noise = release.tracks[leading].noise;
        let noise = if noise.is_finite() && noise > 0.0 { noise } else { 2e-4 };
        let recorded = turned(&axes, tracks.len(), samples.len(), |m, k| position(tracks[m], samples[k]));
        let range = range(&recorded[0]);
        let (begin, end) = (*time.first()?, *time.last()?);
        let interval = (end - begin) / (time.len() - 1) as f64;
        let mut plan = Self {
            tracks,
            samples,
            hysteresis: (HYSTERESIS_NOISE * noise).max(HYSTERESIS_SHARE * range),
            time,
            recorded,
            features: Vec::new(),
            values: Vec::new(),
            scales: Vec::new(),
            first_swing: 0.5 * range,
            frequency: 0.0,
            noise: Noise { deviation: noise, slow: 1.0 },
            wander: Wander::default(),
            axes,
            windows: Vec::new(),
            count: usize::MAX,
            first_turn: end,
            end,
            interval,
            is_held,
        };
        let found = turns::find(&plan.recorded[0], plan.hysteresis);
        let mut turns: Vec<f64> = found.iter().map(|k| plan.time[*k]).collect();
        turns::refine(&plan.time, &plan.recorded[0], &mut turns, plan.interval);
        if turns.len() < LEAST_TURNS || !turns.windows(2).all(|two| two[0] < two[1]) {
            return None;
        }
        plan.first_swing = 0.5 * (plan.recorded[0][0] - plan.recorded[0][found[0]]).abs();
        plan.frequency = 0.5 * (turns.len() - 1) as f64 / (turns[turns.len() - 1] - turns[0]);
        plan.noise = Noise::of(&plan.time, &plan.recorded, plan.frequency, noise);
        plan.windows = windows(turns.len());
        // Turns beyond the last window are not needed, of a model neither.
        plan.count = plan.windows.last().map_or(turns.len(), |(_, last)| last + 2).min(turns.len());
        plan.first_turn = turns[0].max(plan.interval);
        plan.list();
        let own = plan.extract(&plan.time, &plan.recorded, 1.0, None);
        plan.keep(&own);
        let last = turns[plan.count - 1];
        plan.lengthen(last);
        Some(plan)
    }

    /// Sets [`Noise::slow`], and the wander beside that noise.
    pub fn with_slow_noise(&mut self, slow: f64) {
        self.noise.slow = slow;
        self.wander = Wander::of(&self.time[..self.samples.len()], self.frequency, &self.noise);
    }

    /// Coordinates of positions `[marker][sample]`, m, in the axes of the recording.
    pub fn coordinates(&self, position: &dyn Fn(usize, usize) -> [f64; 2], samples: usize) -> Vec<Vec<f64>> {
        turned(&self.axes, self.tracks.len(), samples, position)
    }

    /// Name of a coordinate of a release: q and p, and the marker where there are several.
    pub fn name_of(&self, release: &Release, coordinate: usize) -> String {
        let letter = ["q", "p"][coordinate % 2];
        match self.tracks.len() {
            1 => letter.to_owned(),
            _ => format!("{letter} of {}", release.tracks[self.tracks[coordinate / 2]].marker),
        }
    }

    /// Features of a simulated track at [`Plan::time`], shape `[coordinate][sample]`.
    pub fn simulated(&self, coordinates: &[Vec<f64>]) -> Extraction {
        self.extract(&self.time, coordinates, HYSTERESIS_SIMULATED, None)
    }

    /// Derivatives of features of a track along a movement of it, shape as the track: by a difference, no run is needed.
    pub fn along(&self, coordinates: &[Vec<f64>], at: &Extraction, movement: &[Vec<f64>]) -> Vec<f64> {
        let farthest = movement.iter().flatten().fold(0.0f64, |most, x| most.max(x.abs()));
        if !(farthest > 0.0 && farthest.is_finite()) {
            return vec![0.0; at.values.len()];
        }
        let step = DIFFERENCE * self.first_swing / farthest;
        let moved: Vec<Vec<f64>> = coordinates
            .iter()
            .zip(movement)
            .map(|(q, dq)| q.iter().zip(dq).map(|(q, dq)| q + step * dq).collect())
            .collect();
        let there = self.extract(&self.time, &moved, HYSTERESIS_SIMULATED, Some(at));
        there.values.iter().zip(&at.values).map(|(there, here)| (there - here) / step).collect()
    }

    /// Features of recorded coordinates that were disturbed, near those of the recording itself.
    fn disturbed(&self, coordinates: &[Vec<f64>], near: &Extraction) -> Extraction {
        self.extract(&self.time[..self.samples.len()], coordinates, 1.0, Some(near))
    }

    /// Features of the recording, with its turns.
    fn of_recording(&self) -> Extraction {
        self.extract(&self.time[..self.samples.len()], &self.recorded, 1.0, None)
    }

    /// All features that this release may have.
    fn list(&mut self) {
        let coordinates = 0..self.recorded.len();
        let each = |of: &dyn Fn(usize) -> What| coordinates.clone().map(of).collect::<Vec<_>>();
        let mut all = Vec::new();
        if self.is_held {
            all.extend(each(&|coordinate| What::Start { coordinate }));
        }
        for turn in 0..2 {
            all.extend(each(&|coordinate| What::Turn { turn, coordinate }));
        }
        all.extend([What::FirstTurn, What::FirstHalfPeriod]);
        for (window, (first, last)) in self.windows.iter().enumerate() {
            all.extend([What::Frequency { window }, What::Amplitude { window }]);
            if last - first >= 4 {
                all.push(What::Damping { window });
            }
            all.extend(each(&|coordinate| What::Mean { window, coordinate }));
            all.extend(each(&|coordinate| What::Swing { window, coordinate }).into_iter().skip(1));
            all.extend(each(&|coordinate| What::Second { window, coordinate }));
        }
        all.extend(each(&|coordinate| What::Rest { coordinate }));
        all.extend(each(&|coordinate| What::Drift { coordinate }));
        self.features = all;
    }

    /// Keeps the features that the recording has, with what each is worth.
    fn keep(&mut self, own: &Extraction) {
        let first = self.first_swing;
        let mut amplitude = vec![first; self.windows.len()];
        for (what, value) in self.features.iter().zip(&own.values) {
            if let What::Amplitude { window } = *what
                && value.is_finite()
            {
                amplitude[window] = value.exp() * if window == 0 { 1.0 } else { amplitude[window - 1] };
            }
        }
        let scale = |(what, value): (&What, f64)| match *what {
            What::Start { .. } => 0.1 * first,
            What::Turn { .. } => first,
            What::FirstTurn | What::FirstHalfPeriod | What::Frequency { .. } => 1.0,
            What::Amplitude { window: 0 } => 1.0,
            What::Amplitude { .. } => 1.0 + value.abs(),
            What::Damping { .. } => 0.25,
            What::Mean { window, .. } | What::Swing { window, .. } | What::Second { window, .. } => {
                amplitude[window] + 0.2 * first
            }
            What::Rest { .. } | What::Drift { .. } => 0.3 * first,
        };
        let kept: Vec<(What, f64)> = self
            .features
            .iter()
            .copied()
            .zip(own.values.iter().copied())
            .filter(|(_, v)| v.is_finite())
            .collect();
        self.scales = kept.iter().map(|(what, value)| scale((what, *value))).collect();
        (self.features, self.values) = kept.into_iter().unzip();
    }

    /// Appends times up to which a model that swings a third slower reaches the last turn.
    fn lengthen(&mut self, last_turn: f64) {
        let until = (1.35 * last_turn).max(self.end);
        let step = self.interval.max(0.02 / self.frequency.max(1e-3));
        let mut time = self.end + step;
        while time <= until {
            self.time.push(time);
            time += step;
        }
    }

    /// The extractor. `near` gives turns and starts of a track that differs little.
    fn extract(&self, time: &[f64], q: &[Vec<f64>], share: f64, near: Option<&Extraction>) -> Extraction {
        let leading = &q[0];
        let mut instants = match near {
            Some(near) => near.turns.clone(),
            None => {
                let found = turns::find(leading, share * self.hysteresis);
                found.into_iter().take(self.count.saturating_add(1)).map(|k| time[k]).collect()
            }
        };
        turns::refine(time, leading, &mut instants, self.interval);
        let periods = if instants.len() > 1 { turns::periods(&instants) } else { Vec::new() };
        let fits: Vec<Option<Fitted>> = (self.windows.iter().enumerate())
            .map(|(w, (first, last))| {
                let (begin, end) = (*instants.get(*first)?, *instants.get(*last)?);
                let half_period = (end - begin) / (last - first) as f64;
                let span = Span { begin, end, half_period };
                let start = match near {
                    Some(near) => near.starts[w]?,
                    None => (0.5 / half_period, self.loss(time, leading, &instants, *first, *last)),
                };
                (half_period > 0.0).then(|| window::fit(time, q, &span, start)).flatten()
            })
            .collect();
        let mut values = vec![f64::NAN; self.features.len()];
        for (value, what) in values.iter_mut().zip(&self.features) {
            *value = self.value(*what, time, q, &instants, &periods, &fits).unwrap_or(f64::NAN);
        }
        let starts = fits.iter().map(|fit| fit.as_ref().map(|fit| (fit.frequency, fit.loss))).collect();
        Extraction { values, turns: instants, starts }
    }

    /// A first value of the loss, from the swings at the ends of a window.
    fn loss(&self, time: &[f64], q: &[f64], turns: &[f64], first: usize, last: usize) -> f64 {
        let at = |k: usize| {
            let place = time.partition_point(|t| *t < turns[k]).min(q.len() - 1);
            q[place]
        };
        let (early, late) = ((at(first) - at(first + 1)).abs(), (at(last) - at(last - 1)).abs());
        let half = (turns[last] - turns[first]) / (last - first) as f64;
        // Refined turns of a track that hardly swings may change places: such a window has no fit.
        if half.is_nan() || half <= 0.0 {
            return 0.0;
        }
        let span = turns[last] - turns[first] - half;
        let loss =
            if span > 0.0 && late > 0.0 && early > 0.0 { (early / late).ln() / span } else { 0.2 / half };
        loss.clamp(-0.1 / half, 1.5 / half)
    }

    fn value(
        &self,
        what: What,
        time: &[f64],
        q: &[Vec<f64>],
        turns: &[f64],
        periods: &[f64],
        fits: &[Option<Fitted>],
    ) -> Option<f64> {
        let of = |window: usize| fits.get(window).and_then(Option::as_ref);
        let amplitude = |fit: &Fitted| fit.coefficients[0][1].hypot(fit.coefficients[0][2]);
        match what {
            What::Start { coordinate } => q[coordinate].first().copied(),
            What::Turn { turn, coordinate } => {
                let [mean, cosine, _] = turns::local(
                    time,
                    &q[coordinate],
                    *turns.get(turn)?,
                    *periods.get(turn)?,
                    self.interval,
                )?;
                Some(mean + cosine)
            }
            // A little is added, so that a push that brings the first turn to the start keeps a logarithm.
            What::FirstTurn => Some((turns.first()?.max(0.0) + 0.02 * self.first_turn).ln()),
            What::FirstHalfPeriod => Some((turns.get(1)? - turns.first()?).ln()),
            What::Frequency { window } => Some(of(window)?.frequency.ln()),
            What::Amplitude { window: 0 } => Some(amplitude(of(0)?).ln()),
            What::Amplitude { window } => Some((amplitude(of(window)?) / amplitude(of(window - 1)?)).ln()),
            What::Damping { window } => {
                of(window).map(|fit| fit.loss / (std::f64::consts::TAU * fit.frequency))
            }
            What::Mean { window, coordinate } => Some(of(window)?.coefficients[coordinate][0]),
            What::Swing { window, coordinate } => {
                let (fit, [cosine, sine]) = (of(window)?, phase(of(window)?));
                let [_, a, b, ..] = fit.coefficients[coordinate];
                Some(a * cosine + b * sine)
            }
            What::Second { window, coordinate } => {
                let (fit, [cosine, sine]) = (of(window)?, phase(of(window)?));
                let [.., a, b] = fit.coefficients[coordinate];
                Some(a * (cosine * cosine - sine * sine) + b * 2.0 * sine * cosine)
            }
            What::Rest { coordinate } => self.mean(time, &q[coordinate], REST, 1.0),
            What::Drift { coordinate } => {
                let rest = self.mean(time, &q[coordinate], REST, 1.0)?;
                Some(rest - self.mean(time, &q[coordinate], BEFORE_REST, REST)?)
            }
        }
    }

    /// Mean of a coordinate over shares of the record under a `sin²` window.
    fn mean(&self, time: &[f64], q: &[f64], from: f64, to: f64) -> Option<f64> {
        let begin = self.time[0];
        let at = |share: f64| begin + share * (self.end - begin);
        let (from, to) = (at(from), at(to));
        let (mut sum, mut weights) = (0.0, 0.0);
        for (t, q) in time.iter().zip(q).filter(|(t, _)| (from..=to).contains(*t)) {
            let weight = (std::f64::consts::PI * (t - from) / (to - from)).sin().powi(2);
            sum += weight * q;
            weights += weight;
        }
        (weights > 0.0).then(|| sum / weights)
    }
}

/// Cosine and sine of the phase of the leading coordinate in the middle of a window.
fn phase(fit: &Fitted) -> [f64; 2] {
    let [_, a, b, ..] = fit.coefficients[0];
    let amplitude = a.hypot(b);
    [a / amplitude, b / amplitude]
}

/// Windows of a track of so many turns, by places of turns; the last may be shorter.
fn windows(count: usize) -> Vec<(usize, usize)> {
    let mut all = Vec::new();
    for (first, last) in WINDOWS {
        if last <= count {
            all.push((first - 1, last - 1));
            continue;
        }
        let left = count.saturating_sub(first);
        let even = left - left % 2;
        if even >= 2 && even >= 2 + (last - first) / 3 - (last - first) / 3 % 2 {
            all.push((first - 1, first - 1 + even));
        }
        break;
    }
    all
}

#[cfg(test)]
pub(crate) mod tests;

//! How well an experiment repeats: below that no right model can be distinguished from a wrong one.
//!
//! Two releases of one condition differ by the noise of the camera and by what no model of either predicts: the hand,
//! the clamp, what the material remembers. Their root mean square distance over √2, beside the stiffness, damping, start,
//! instant and place of each (`pure_error.rs`), is what one of them deviates from a right model. Stiffnesses and dampings that
//! differ are unknowns of each release: what a law describes need not be taken for error.

use models::digits::significant;
use models::effects::tip_hold::PULL;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ghosts::known;
use super::hold;
use super::problem::{Problem, Trial, is_same};
use super::pure_error::Difference;
use crate::normal::NORMAL_95_ONE_SIDED;

/// How well an experiment repeats.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Repeats {
    /// Root mean square distance of a release from what a right model predicts, the camera's noise in it, mm.
    pub distance_mm: f64,
    /// What of that is the camera's noise, mm.
    pub noise_mm: f64,
    /// Where that is known from.
    pub source: Source,
    /// Pairs of releases of one condition.
    pub pairs: usize,
    /// Standard deviation of a release's frequency from that of its condition, over it; the distance is what is left
    /// beside that.
    #[serde(default)]
    pub frequency_share: f64,
    /// Standard deviation of the rate at which a release's swing decays from that of its condition, 1/s: half of its mass
    /// damping α. The distance is what is left beside that.
    #[serde(default)]
    pub decay_rate: f64,
}

/// Where it is known from how well an experiment repeats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// The experiment's `calibrate.repeatability`.
    Stated,
    /// Releases of one condition.
    Measured,
}

/// Angle of release within which two releases are of one condition, rad.
const SAME_ANGLE: f64 = 0.05;

impl Repeats {
    /// As it is stated, m.
    pub(super) fn stated(problem: &Problem, distance: f64) -> Self {
        Self::new(problem, distance, Source::Stated)
    }

    /// By what releases of one condition differ by; none without any.
    pub(super) fn measured(problem: &Problem, differences: &[Difference]) -> Option<Self> {
        if differences.is_empty() {
            return None;
        }
        let pairs = differences.len();
        // Each of two has half the variance of their difference.
        let deviation = |square: fn(&Difference) -> f64| {
            (differences.iter().map(square).sum::<f64>() / (2 * pairs) as f64).sqrt()
        };
        let (distance, noise) = (deviation(|own| own.square), noise(problem));
        // Two recordings of one path differ by their noise, which has a spread of its own, and have one frequency.
        let samples = problem.trials.iter().map(|trial| known(&trial.release).len()).sum::<usize>() as f64;
        let is_noise = distance < noise * (1.0 + NORMAL_95_ONE_SIDED / (2.0 * samples).sqrt());
        let distance = if is_noise { noise } else { distance };
        let beside = |square| if is_noise { 0.0 } else { deviation(square) };
        Some(Self {
            pairs,
            frequency_share: beside(|own| (0.5 * own.stiffness).powi(2)),
            decay_rate: beside(|own| (0.5 * own.mass_damping).powi(2)),
            ..Self::new(problem, distance, Source::Measured)
        })
    }

    fn new(problem: &Problem, distance: f64, source: Source) -> Self {
        let (distance_mm, noise_mm) = (1e3 * distance, 1e3 * noise(problem).min(distance));
        Self { distance_mm, noise_mm, source, pairs: 0, frequency_share: 0.0, decay_rate: 0.0 }
    }

    /// The problem with what does not repeat beside the noise of each track. A release differs from another by few numbers, so many
    /// samples share each of them.
    pub(crate) fn beside_noise(&self, problem: &Problem) -> Problem {
        let mut problem = problem.clone();
        let beyond = 1e-6 * (self.distance_mm.powi(2) - self.noise_mm.powi(2));
        for release in problem.trials_mut().map(|trial| &mut trial.release) {
            let coordinates = 2.0 * known(release).len() as f64;
            let shared = (coordinates / NUMBERS).max(1.0);
            for track in &mut release.tracks {
                track.discrepancy = (0.5 * beyond * shared).sqrt();
            }
        }
        problem
    }

    /// By how much the frequencies and dampings of repeated releases differ, as a clause behind others; empty where they do not.
    pub fn between(&self) -> String {
        let frequency = (self.frequency_share > 0.0)
            .then(|| format!("frequencies vary by {} %", significant(1e2 * self.frequency_share, 2)));
        let decay = (self.decay_rate > 0.0)
            .then(|| format!("decay rates by {} 1/s", significant(self.decay_rate, 2)));
        let both: Vec<String> = frequency.into_iter().chain(decay).collect();
        if both.is_empty() { String::new() } else { format!("; {} between repeats", both.join(" and ")) }
    }
}

/// Numbers that a release differs by from another, beside its frequency and damping: size and phase of its swing in each coordinate.
const NUMBERS: f64 = 4.0;

/// Root mean square distance of a tip from its path by the cameras' noise, m.
fn noise(problem: &Problem) -> f64 {
    let tracks = problem.trials.iter().map(|trial| &trial.release.tracks[trial.release.leading_track()]);
    (2.0 * tracks.map(|tip| tip.noise * tip.noise).sum::<f64>() / problem.trials.len() as f64).sqrt()
}

/// Places of releases of one condition, of each condition that was repeated.
pub(super) fn conditions(problem: &Problem) -> Vec<Vec<usize>> {
    let mut conditions = grouped(problem, |_| true, is_one_condition);
    conditions.retain(|own| own.len() > 1);
    conditions
}

/// Places of the releases that count, those that are alike together.
pub(crate) fn grouped(
    problem: &Problem,
    counts: impl Fn(&Trial) -> bool,
    is_alike: impl Fn(&Trial, &Trial) -> bool,
) -> Vec<Vec<usize>> {
    grouped_trials(problem.trials(), counts, is_alike)
}

/// The same of trials.
pub(crate) fn grouped_trials<'a>(
    trials: impl Iterator<Item = &'a Trial>,
    counts: impl Fn(&Trial) -> bool,
    is_alike: impl Fn(&Trial, &Trial) -> bool,
) -> Vec<Vec<usize>> {
    let mut groups: Vec<(&Trial, Vec<usize>)> = Vec::new();
    for (k, trial) in trials.enumerate().filter(|(_, trial)| counts(trial)) {
        match groups.iter_mut().find(|(first, _)| is_alike(first, trial)) {
            Some((_, own)) => own.push(k),
            None => groups.push((trial, vec![k])),
        }
    }
    groups.into_iter().map(|(_, own)| own).collect()
}

/// Whether two releases are of one rod, pressure, payload and posture: whether their models differ in nothing but how
/// they are let go.
pub(crate) fn is_one_condition(a: &Trial, b: &Trial) -> bool {
    let is_same = |k: usize| {
        let [one, other] = [a, b].map(|trial| trial.model.theta[k]);
        match a.model.parameters[k].path.as_str() {
            path if path != b.model.parameters[k].path => false,
            "release.angle" => (one - other).abs() < SAME_ANGLE,
            path if path.starts_with("release.") => true,
            path if path.starts_with("effects.tip_hold.") => is_same_hand(a, path, one - other),
            // A rod that states no diameter has none.
            _ => is_same(one, other) || one.is_nan() && other.is_nan(),
        }
    };
    let count = a.model.parameters.len();
    // A swing that begins anywhere is compared with no other.
    !a.is_in_motion() && !b.is_in_motion() && count == b.model.parameters.len() && (0..count).all(is_same)
}

/// Whether a difference in what the hand does before the release bends the rod by no more than the angle of a release may
/// differ. The rates are part of how it lets go, as an angular velocity is.
fn is_same_hand(trial: &Trial, path: &str, difference: f64) -> bool {
    let Ok(sizes) = hold::sizes(&trial.model) else { return false };
    let own = PULL.iter().zip(sizes).find(|(own, _)| **own == path);
    own.is_none_or(|(own, size)| own.contains("rate") || difference.abs() < SAME_ANGLE * size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Nuisances;
    use crate::calibrate::pure_error::tests::released;

    /// A quarter of the square of 0.1 mm is the camera's: the rest is four numbers that 401 samples of two coordinates
    /// share.
    #[test]
    fn what_does_not_repeat_is_few_numbers() {
        let repeats = Repeats {
            distance_mm: 0.1,
            noise_mm: 0.05,
            source: Source::Measured,
            pairs: 1,
            frequency_share: 0.0,
            decay_rate: 0.0,
        };
        let trial = released(&[], 0.0, 1);
        let problem =
            Problem { trials: vec![trial.into()], parameters: Vec::new(), nuisances: Nuisances::default() };
        let wider = repeats.beside_noise(&problem);
        let found = wider.trials[0].release.tracks[0].discrepancy;
        assert!((found - 1e-3 * (0.5 * 0.0075f64 * 200.5).sqrt()).abs() < 1e-12, "{found}");
        // A rod without a diameter is the same rod.
        let mut without = Trial::clone(&problem.trials[0]);
        without.model.theta[0] = f64::NAN;
        assert!(is_one_condition(&without, &without) && !is_one_condition(&without, &problem.trials[0]));
        // Two hands never hold a rod with the same force.
        let held = |share: f64| {
            let mut trial = Trial::clone(&problem.trials[0]);
            let force = share * hold::sizes(&trial.model).unwrap()[1];
            trial.model =
                trial.model.with_effect("tip_hold", &[("force_z", force), ("rate_z", 1e2 * share)]).unwrap();
            trial
        };
        assert!(is_one_condition(&held(1.0), &held(1.02)) && !is_one_condition(&held(1.0), &held(1.2)));
    }
}

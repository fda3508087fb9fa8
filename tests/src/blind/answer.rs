//! An answer to a case, and what it is worth.

use efam_inference::diagnose::verdict::{Member, Separation};
use efam_inference::diagnose::{Curve, Diagnosis, DiagnosisOutcome, Verdict};
use efam_sweeps::diagnosed;

use super::case::Case;
use super::truth::Truth;
use crate::twin::drawn::Drawn;
use crate::twin::hidden::Hidden;

/// Distance from which on two effects are distinguishable, standard deviations.
pub const TOLD_APART: f64 = 5.0;

/// What was said of a case, and what there was to say.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Name of the request.
    pub case: Case,
    /// Distance of what is hidden from its nearest, standard deviations, where that was foreseen.
    pub distance: Option<f64>,
    /// Whether it is large enough to be seen.
    pub is_visible: bool,
    /// What was said.
    pub diagnosis: Diagnosis,
    /// Noise-free root mean square distance after repair over the noise, of what was fitted and of held-out releases;
    /// not a number where the repaired model is not at hand.
    pub noise_free: [f64; 2],
    /// How long it took, s.
    pub seconds: f64,
}

impl Answer {
    /// Puts together what was said with what was drawn.
    pub fn new(truth: Truth, drawn: &Drawn, outcome: DiagnosisOutcome, seconds: f64) -> Self {
        let noise_free = [false, true].map(|held_out| noise_free(drawn, &outcome.curves, held_out));
        Self::of(truth, outcome.diagnosis, noise_free, seconds)
    }

    /// The same of a row of a sweep; nothing of one without an answer.
    pub fn swept(truth: Truth, said: &diagnosed::Answer) -> Option<Self> {
        let member = |effect: &String| Member { effect: effect.clone(), behind: f64::NAN, distance: None };
        let separating_experiment = said.separation.map(|distance| Separation {
            what: String::new(),
            distance,
            distance_now: f64::NAN,
        });
        let diagnosis = Diagnosis {
            verdict: said.verdict?,
            effects: said.effects.clone(),
            members: said.members.iter().map(member).collect(),
            separating_experiment,
            ..Diagnosis::default()
        };
        Some(Self::of(truth, diagnosis, [f64::NAN; 2], said.seconds.unwrap_or(f64::NAN)))
    }

    fn of(truth: Truth, diagnosis: Diagnosis, noise_free: [f64; 2], seconds: f64) -> Self {
        let Truth { case, distance, is_visible } = truth;
        Self { case, distance, is_visible, diagnosis, noise_free, seconds }
    }

    /// Names of the effects that were added.
    pub fn named(&self) -> Vec<&str> {
        self.diagnosis.effects.iter().map(|added| added.effect.as_str()).collect()
    }

    /// Whether the answer is one name or several, or a class.
    pub fn is_a_name(&self) -> bool {
        matches!(self.diagnosis.verdict, Verdict::Named | Verdict::Incomplete | Verdict::Class)
    }

    /// Whether the answer is a class, complete or not.
    pub fn is_a_class(&self) -> bool {
        let has_members = self.is_a_name() && !self.diagnosis.members.is_empty();
        has_members || self.diagnosis.verdict == Verdict::Class
    }

    /// Whether what is hidden is distinguishable from all else.
    pub fn is_separable(&self) -> bool {
        self.distance.is_some_and(|distance| distance >= TOLD_APART)
    }

    /// Whether the first name is right.
    pub fn is_right(&self) -> bool {
        let first = self.named().first().copied();
        self.is_a_name() && first.is_some() && first == self.case.hidden.first().map(|(name, _)| *name)
    }

    /// Whether all that is hidden is among the names, or in the class.
    pub fn holds_the_truth(&self) -> bool {
        let has = |name: &str| {
            self.named().contains(&name) || self.diagnosis.members.iter().any(|member| member.effect == name)
        };
        self.is_a_name() && self.case.hidden.iter().all(|(name, _)| has(name))
    }

    /// Whether something was named that is not there.
    pub fn has_a_false_name(&self) -> bool {
        let is_hidden =
            |name: &str| !self.case.is_robbed && self.case.hidden.iter().any(|(own, _)| *own == name);
        let is_excused = self.is_a_class() && !self.case.hidden.is_empty() && self.holds_the_truth();
        self.is_a_name() && !is_excused && self.named().iter().any(|name| !is_hidden(name))
    }

    /// The strength that was found where the name is right, with its interval.
    fn strength(&self) -> Option<(f64, [f64; 2])> {
        let (name, size) = self.case.hidden.first().filter(|_| self.is_right())?;
        let parameter = Hidden::named(name, *size)?.parameter();
        let mut values = self.diagnosis.effects.first()?.parameters.iter();
        let value = values.find(|value| value.name == parameter)?;
        Some((value.value, value.interval_95?))
    }

    /// The strength that was found over the hidden one where the name is right, with its interval. None of what has
    /// another size at each release.
    pub fn relative_strength(&self) -> Option<(f64, [f64; 2])> {
        let (name, size) = self.case.hidden.first()?;
        let hidden = Hidden::named(name, *size)?;
        if matches!(hidden, Hidden::ReleaseDrift { .. }) {
            return None;
        }
        let truth = hidden.strength();
        let (value, interval) = self.strength()?;
        let [low, high] = interval.map(|bound| bound / truth);
        Some((value / truth, if truth < 0.0 { [high, low] } else { [low, high] }))
    }

    /// In a few words.
    pub fn said(&self) -> String {
        let members: Vec<&str> = self.diagnosis.members.iter().map(|member| member.effect.as_str()).collect();
        diagnosed::in_short(self.diagnosis.verdict, &self.named(), &members)
    }
}

/// Distance of what is predicted in the end from what would have been seen without noise, over the noise.
fn noise_free(drawn: &Drawn, curves: &[Curve], held_out: bool) -> f64 {
    let (mut squares, mut count) = (0.0, 0.0f64);
    for curve in curves.iter().filter(|curve| curve.held_out == held_out) {
        let Some(release) = drawn.releases.iter().find(|drawn| drawn.release.name == curve.release) else {
            continue;
        };
        let tracks = &release.release.tracks;
        let Some(track) = tracks.iter().position(|track| track.marker == curve.marker) else { continue };
        for sample in curve.seen() {
            let k = release.release.time.partition_point(|time| *time < sample.time - 1e-6);
            let Some([x, z]) = release.truth[track].get(k).copied() else { continue };
            let [dx, dz] = [sample.after[0] - x, sample.after[1] - z];
            squares += 0.5 * (dx * dx + dz * dz) / (curve.noise * curve.noise);
            count += 1.0;
        }
    }
    (squares / count.max(1.0)).sqrt()
}

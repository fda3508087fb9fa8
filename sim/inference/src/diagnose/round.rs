//! One round: score, fit the shortlist, choose.

use models::effects::Kind;

use super::candidate::{candidates, has_several_pressures};
use super::design_matrix::predictions;
use super::localise::shapes;
use super::mesh_check::LAW;
use super::score::scores_of;
use super::shortlist::{Best, Entry, LITTLE, RoundOutcome, best_tries, choose, fit_best};
use super::stop::is_interrupted;
use super::validation::HeldOut;
use super::verdict::{Evidence, Shape};
use super::{DiagnosisSettings, Listener};
use crate::calibrate::CalibrateError;
use crate::calibrate::joint::Joint;

/// What a round found.
pub(super) struct Round {
    /// Score that had to be exceeded.
    pub threshold: f64,
    /// Every candidate, the best by each effect.
    pub evidence: Vec<Evidence>,
    /// Patterns of the residual, whatever their cause.
    pub shapes: Vec<Shape>,
    /// Whether a shape exceeds its threshold, by more than an error of the laws that were found.
    pub is_shaped: bool,
    /// Whether a candidate or a shape exceeds its threshold, by however little.
    pub is_heard: bool,
    /// What stands out, and is too small beside what was found before to be more than an error of its law.
    pub negligible: Option<&'static str>,
    /// Result of the round.
    pub outcome: RoundOutcome,
}

/// Why one is not the answer where the search was not to go on.
pub(super) const NO_MORE: &str = "the limit of added effects is reached";

/// Which round it is.
#[derive(Clone, Copy)]
pub(super) struct RoundRequest {
    /// From 1.
    pub number: usize,
    /// Whether no more may be added.
    pub is_last: bool,
    /// Whether effects of the rod's material have a strength for each pressure.
    pub is_widened: bool,
}

/// Share of the false-alarm level that is left to shapes: they hear small errors of the setup, too, for
/// which the baseline has no unknown.
pub(super) const RARER: f64 = 0.01;
/// Share of an error of laws from which on a predicted gain is worth a fit: beside friction, scores were seen to predict a
/// third of what a fit then keeps.
const PROMISING: f64 = 0.25;
/// Share of the χ² that was explained before below which a shape is no sign of anything more: it fits whatever is there.
const NEGLIGIBLE_SHAPE: f64 = 0.02;

/// χ² that errors of the laws of found effects may leave, given the kind of each effect and the χ² that it explains. Smaller effects
/// are not looked for.
pub(super) fn negligible(found: impl Iterator<Item = (Kind, f64)>) -> f64 {
    LAW * LAW * found.filter(|(kind, _)| kind.is_law()).map(|(_, gain)| gain).sum::<f64>()
}

/// Looks for one effect beside those that the problem's models have, `added` among them; or for one of these that
/// is not as strong at one pressure as at another. `before` is how they meet held-out releases.
pub(super) fn round(
    fit: &Joint,
    before: Option<&HeldOut>,
    added: &[Best],
    RoundRequest { number, is_last, is_widened }: RoundRequest,
    settings: &DiagnosisSettings,
    listener: &dyn Listener,
) -> Result<Round, CalibrateError> {
    let tell = |what: &str| listener.doing(&format!("round {number}: {what}"));
    let off = predictions(fit).ok_or_else(|| fit.objective.refusal(&fit.found.x))?;
    let shapes = shapes(fit, &off, number, RARER * settings.false_alarm);
    let mut candidates = candidates(&fit.problem, settings);
    if is_widened {
        candidates.iter_mut().for_each(|own| *own = own.of_each_pressure().unwrap_or_else(|| own.clone()));
    }
    if has_several_pressures(&fit.problem) {
        candidates.extend(added.iter().filter_map(|best| best.candidate.of_each_pressure()));
    }
    let explained = added.iter().map(|best| best.gain).sum::<f64>();
    let negligible = negligible(added.iter().map(|best| (best.candidate.effect.about().kind, best.gain)));
    let tell_score = |name: &str| tell(&format!("score of {name}"));
    let scores = scores_of(&candidates, fit, &off, settings.false_alarm, &tell_score);
    let mut entries = best_tries(candidates, &scores);
    if is_interrupted(&fit.problem) {
        // Some of them were not scored, and the others say little without them.
        entries.iter_mut().for_each(Entry::cut_short);
    }
    let ranked = |entries: &[Entry]| {
        let evidence: Vec<Evidence> = entries.iter().map(|entry| entry.evidence(number)).collect();
        listener.ranked(scores.threshold, &evidence);
        evidence
    };
    ranked(&entries);
    let is_loud = |entry: &Entry| entry.score.size > scores.threshold;
    let promise = entries.iter().filter(|entry| is_loud(entry)).map(|entry| entry.score.decrease);
    let promise = promise.fold(f64::NEG_INFINITY, f64::max);
    let loudest = entries.first().filter(|entry| is_loud(entry)).map(|entry| entry.candidate.name());
    let one_more = loudest.filter(|_| is_last && promise >= negligible);
    let loudest_shape = shapes.iter().filter(|shape| shape.score > shape.threshold).map(|shape| shape.score);
    let loudest_shape = loudest_shape.reduce(f64::max);
    let is_shaped = loudest_shape.is_some_and(|score| score.powi(2) >= NEGLIGIBLE_SHAPE * explained);
    let outcome = if let Some(name) = one_more {
        entries.iter_mut().for_each(|entry| entry.reject(NO_MORE));
        RoundOutcome::LimitReached(name)
    } else if !is_last && promise >= PROMISING * negligible {
        let tell_fit = |entry: &Entry| match entry.realised {
            None => tell(&format!("fit of {}", entry.candidate.name())),
            Some(_) => drop(ranked(std::slice::from_ref(entry))),
        };
        let fitted = fit_best(&mut entries, fit, &scores, &tell_fit)?;
        choose(fitted, fit, &scores, before, negligible, &tell)?
    } else {
        for entry in &mut entries {
            entry.reject(if is_loud(entry) { LITTLE } else { "its score is below the threshold" });
        }
        RoundOutcome::Nothing
    };
    let is_little = !added.is_empty() && matches!(outcome, RoundOutcome::Nothing);
    let negligible = loudest.filter(|_| is_little);
    let (threshold, evidence) = (scores.threshold, ranked(&entries));
    // A fit may find that a score was noise.
    let is_beyond_noise = |own: &Evidence| own.rejected.as_deref() == Some(LITTLE);
    let is_heard = one_more.is_some() || loudest_shape.is_some() || evidence.iter().any(is_beyond_noise);
    Ok(Round { threshold, evidence, shapes, is_shaped, is_heard, negligible, outcome })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mass has no error of a law, however much it explains.
    #[test]
    fn a_mass_hides_nothing() {
        assert_eq!(negligible([(Kind::Inertial, 1e6), (Kind::Measurement, 1e6)].into_iter()), 0.0);
        let with_laws = [(Kind::Inertial, 1e6), (Kind::Dissipative, 1e3), (Kind::Elastic, 1e3)];
        assert!((negligible(with_laws.into_iter()) - 20.0).abs() < 1e-9);
    }
}

//! Whether an effect that was added is as strong in one release as in another.
//!
//! What is there has one strength. What stands in for something else would have another in each release, that from a
//! higher hold or at a higher pressure, and one for all leaves a trace. With its parameters free in each release but the
//! first, the residual asks for that as it asks for a candidate (`score.rs`); of all releases, held-out ones
//! among them, since nothing is chosen here. A law that is not quite right errs alike in all releases: this
//! tells a similar effect from friction that turns round in another way, where the size of what is left does not.

use super::candidate::Candidate;
use super::design_matrix::{Column, of_releases};
use super::refit::places_of;
use super::round::{RARER, negligible};
use super::score::{RESOLVED, Subject, scores};
use super::shortlist::Best;
use crate::calibrate::joint::Joint;

/// Why an effect is not believed that would have to differ from release to release.
pub(super) const INCONSTANT: &str = "its strength would have to differ between releases";

/// Share of its size by which an effect that is not believed differs between releases. Correct effects were seen to need up to a
/// seventh, similar effects a quarter or more.
pub(super) const UNLIKE: f64 = 0.2;

/// The effects of a fit whose strength would have to differ between releases by more than noise gives, than a fifth of their
/// size, and than the errors of the laws of all of them: a small effect takes up the error of a large one's law.
pub(super) fn inconstant(fit: &Joint, added: &[Best], false_alarm: f64) -> Vec<&'static str> {
    let added: Vec<_> = added.iter().map(|best| (&best.candidate, best.gain)).collect();
    found(fit, &added, RARER * false_alarm)
}

/// The same of candidates, each with what it explains of χ².
fn found(fit: &Joint, added: &[(&Candidate, f64)], level: f64) -> Vec<&'static str> {
    let of = |(place, (candidate, _)): (usize, &(&Candidate, f64))| {
        // The first release has the value of the fit, and the others may have another.
        places_of(fit, candidate)
            .flat_map(move |unknown| of_releases(fit, unknown, place).into_iter().skip(1))
    };
    let columns: Vec<Column> = added.iter().enumerate().flat_map(of).collect();
    let subjects = vec![Subject { own: RESOLVED, ..Subject::default() }; added.len()];
    let scores = scores(fit, &subjects, &columns, level);
    let negligible = negligible(added.iter().map(|(own, gain)| (own.effect.about().kind, *gain)));
    let pairs = added.iter().zip(&scores.each);
    pairs
        .filter(|((_, gain), score)| {
            score.size > scores.threshold && score.decrease >= negligible.max(UNLIKE * UNLIKE * gain)
        })
        .map(|((candidate, _), _)| candidate.name())
        .collect()
}

#[cfg(test)]
pub(super) mod tests {
    use std::ops::ControlFlow;

    use efam_core::example::muscle_at_15_psi;
    use efam_core::forward::{Run, forward, uniform};
    use efam_experiments::release::{Point, Track};

    use super::*;
    use crate::calibrate::prediction::Slopes;
    use crate::calibrate::refine::LAST;
    use crate::calibrate::{FittedParameter, Nuisances, Problem, Scope, Trial};
    use crate::diagnose::DiagnosisSettings;
    use crate::diagnose::candidate::candidates;
    use crate::example;

    const NOISE: f64 = 3e-4;

    /// A release seen through cameras whose scale is off; `count` goes on with each number.
    fn release(relative_error: f64, count: &mut f64) -> Trial {
        let (model, run) = (muscle_at_15_psi(), Run::release(3.0, 40.0));
        let seen = Run { points: vec![Point::Tip], ..run.clone() };
        let path = forward(&model, &seen, &mut |_| ControlFlow::Continue(())).unwrap();
        let mut measured = |x: f64| {
            *count += 1.0;
            (1.0 + relative_error) * x + NOISE * std::f64::consts::SQRT_2 * (*count * *count).sin()
        };
        let position = path.points.iter().map(|at| Some(at[0].map(&mut measured))).collect();
        let (marker, at) = ("tip".to_owned(), Point::Tip);
        let track = Track { marker, at, position, noise: NOISE, discrepancy: 0.0 };
        let release = example::release(uniform(3.0, 40.0), vec![track]);
        Trial { release, model, run }
    }

    /// A scale fitted to three releases where it is what is given.
    pub fn fitted(relative_error: [f64; 3]) -> (Joint, Candidate) {
        let mut count = 0.0;
        let base = Problem {
            trials: relative_error.map(|own| release(own, &mut count).into()).to_vec(),
            parameters: vec![FittedParameter::new("rod.bending_stiffness", Scope::Shared)],
            nuisances: Nuisances {
                release_instant: true,
                hold_angle: Some(4e-3),
                offset: Some(2e-4),
                ..Nuisances::default()
            },
        };
        let all = candidates(&base, &DiagnosisSettings::default());
        let scale = all.iter().find(|own| own.name() == "scale").unwrap();
        let problem = scale.added_to(&base, 0.01).unwrap();
        (Joint::at(&problem, &[], Slopes::Variational, LAST).unwrap(), scale.clone())
    }

    /// What of that would have to differ.
    fn asked(relative_error: [f64; 3]) -> Vec<&'static str> {
        let (fit, scale) = fitted(relative_error);
        found(&fit, &[(&scale, 1e3)], 1e-4)
    }

    #[test]
    fn what_suits_no_two_releases_alike_is_not_believed() {
        assert!(asked([0.01; 3]).is_empty());
        assert_eq!(asked([0.005, 0.01, 0.015]), ["scale"]);
    }
}

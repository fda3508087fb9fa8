//! How the predictions of a fit would move with a candidate's strength, at the value where it is off.

use std::sync::Arc;

use efam_core::integrate::Steps;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::candidate::Candidate;
use crate::calibrate::joint::Joint;
use crate::calibrate::prediction::{Member, Prediction};
use crate::calibrate::problem::is_same_pressure;
use crate::calibrate::view::Series;
use crate::calibrate::{Scope, Trial};
use crate::ordered::in_order;

/// Derivatives of the predictions by one strength, in units of the noise, shape
/// `[release][track][sample]` of the samples that are fitted.
#[derive(Clone)]
pub(super) struct Column {
    /// Place of what it belongs to among all that is scored.
    pub of: usize,
    /// Its place among those of the same.
    pub part: usize,
    pub slopes: Vec<Moved>,
}

/// Movements of the points of a release by one parameter, shape `[track][sample]` of the samples that are fitted.
type Moved = Vec<Vec<[f64; 2]>>;

/// How the predictions move with the strengths of candidates, each from where it is off, in units of the noise and for each
/// release; none for a candidate whose models cannot be run, or whose strength is fitted already. An effect that is off leaves
/// the rod as it is, so one run has many side by side.
pub(super) fn movements(
    fit: &Joint,
    candidates: &[Candidate],
    tell: &(dyn Fn(&str) + Sync),
) -> Vec<Option<Vec<Moved>>> {
    let mut moved = vec![None; candidates.len()];
    for together in side_by_side(fit, candidates) {
        let all: Vec<&Candidate> = together.iter().map(|c| &candidates[*c]).collect();
        match movements_of(fit, &all) {
            Some(found) => together.iter().zip(found).for_each(|(c, found)| moved[*c] = Some(found)),
            // One of them cannot be run; the others can.
            None => together.iter().for_each(|c| {
                moved[*c] = movements_of(fit, &[&candidates[*c]]).and_then(|mut found| found.pop());
            }),
        }
        all.iter().for_each(|candidate| tell(candidate.name()));
    }
    moved
}

/// The columns of all candidates, of their movements: one, or one a release or a pressure where each has its own value. One
/// whose strength is fitted already has none for the first pressure.
pub(super) fn columns(fit: &Joint, candidates: &[Candidate], moved: &[Option<Vec<Moved>>]) -> Vec<Column> {
    let of_candidate = |(c, (candidate, moved)): (usize, (&Candidate, &Option<Vec<Moved>>))| {
        if let Some(place) = place_among_unknowns(fit, candidate) {
            return of_pressures(fit, &fitted(fit, place), c).into_iter().skip(1).collect();
        }
        let Some(all) = moved else { return Vec::new() };
        match candidate.scope {
            Scope::PerRelease => {
                (0..all.len()).map(|own| Column::only(c, own, all, |release| release == own)).collect()
            }
            _ if candidate.is_widened() => of_pressures(fit, all, c),
            Scope::Shared | Scope::PerPressure => vec![Column { of: c, part: 0, slopes: all.clone() }],
        }
    };
    candidates.iter().zip(moved).enumerate().flat_map(of_candidate).collect()
}

fn place_among_unknowns(fit: &Joint, candidate: &Candidate) -> Option<usize> {
    fit.objective.part.unknowns.iter().position(|own| own.name == candidate.path())
}

/// Which of the candidates that are not fitted one model can have side by side: those of different effects.
fn side_by_side(fit: &Joint, candidates: &[Candidate]) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = Vec::new();
    for (c, candidate) in candidates.iter().enumerate() {
        if place_among_unknowns(fit, candidate).is_some() {
            continue;
        }
        let is_apart =
            |own: &&mut Vec<usize>| own.iter().all(|other| candidates[*other].name() != candidate.name());
        match all.iter_mut().find(is_apart) {
            Some(own) => own.push(c),
            None => all.push(vec![c]),
        }
    }
    all
}

/// The movements of candidates of different effects, shape `[candidate][release]`.
fn movements_of(fit: &Joint, candidates: &[&Candidate]) -> Option<Vec<Vec<Moved>>> {
    let releases = 0..fit.objective.part.members.len();
    let moved = releases.into_par_iter().map(|r| movements_in(fit, candidates, r));
    let mut each = in_order::<_, Option<Vec<Vec<Moved>>>>(moved)?;
    let of_candidate = |c: usize| each.iter_mut().map(|release| std::mem::take(&mut release[c])).collect();
    Some((0..candidates.len()).map(of_candidate).collect())
}

/// The same of one release, shape `[candidate]`, from the variational equation.
fn movements_in(fit: &Joint, candidates: &[&Candidate], r: usize) -> Option<Vec<Moved>> {
    let (part, view) = (&fit.objective.part, &fit.found.view);
    let mut trial = Trial::clone(&part.members[r]);
    for candidate in candidates {
        trial = candidate.on(&trial, candidate.null_value).ok()?;
    }
    let strength = |candidate: &&Candidate| trial.model.index(&candidate.path()).ok();
    let strengths: Vec<usize> = candidates.iter().map(strength).collect::<Option<_>>()?;
    let member = Member { trial: &trial, ..fit.objective.member(r) };
    let (theta, instant) = member.values(&fit.found.x);
    // Memories that the fit has not may need shorter steps.
    let request = view.request(r, view.steps_as(Steps::Given, r));
    let path = member.simulate(&theta, instant, request, strengths).ok()?;
    let seen = path.points_by_parameters;
    let is_finite = seen.iter().flatten().flatten().flatten().all(|slope| slope.is_finite());
    let moved = |c: usize| in_noise(fit, r, |t, k| seen[k][t][c]);
    is_finite.then(|| (0..candidates.len()).map(moved).collect())
}

/// Movement of the prediction, m, by which a difference is taken: the rounding of a run, some 1e-11 m, and its curvature are
/// both a small part of that.
const WANTED: f64 = 1e-6;

/// The movements with a candidate's strength by differences of runs on the same steps, which are those of the prediction
/// itself, to five digits; `off` is what the fit predicts, `near` what they are about. None where the models cannot be run,
/// or not on these steps: a memory that the fit has not may need shorter ones.
pub(super) fn differences(
    fit: &Joint,
    off: &[Prediction],
    candidate: &Candidate,
    near: &[Moved],
) -> Option<Vec<Moved>> {
    let of_release = |r: usize| {
        let noise = &fit.objective.measured[r].noise;
        let in_track = |(track, noise): (&Vec<[f64; 2]>, &f64)| {
            track.iter().map(|[x, z]| noise * x.hypot(*z)).fold(0.0, f64::max)
        };
        let farthest = near[r].iter().zip(noise).map(in_track).fold(0.0, f64::max);
        let room = room(candidate);
        // A power of two, so that rounding of the movement changes no bit of it.
        let wanted = (WANTED / farthest).log2().round().exp2();
        let step = wanted.min(room.abs()).copysign(room);
        let on = candidate.on(&fit.objective.part.members[r], candidate.null_value + step).ok()?;
        let aside = run(fit, &on, r, Steps::Given(off[r].steps.clone()))?;
        let moved = |t: usize, k: usize| {
            let (aside, off) = (aside.position[t][k], off[r].position[t][k]);
            [0, 1].map(|axis| (aside[axis] - off[axis]) / step)
        };
        (aside.steps.len() == off[r].steps.len()).then(|| in_noise(fit, r, moved))
    };
    in_order((0..off.len()).into_par_iter().map(of_release))
}

/// How far the strength may go from off, with its sign.
fn room(candidate: &Candidate) -> f64 {
    let (low, high) = candidate.believed();
    if high > candidate.null_value { high - candidate.null_value } else { low - candidate.null_value }
}

impl Column {
    /// What moves in some of the releases alone.
    fn only(of: usize, part: usize, all: &[Moved], is_own: impl Fn(usize) -> bool) -> Self {
        let still = |track: &Vec<[f64; 2]>| vec![[0.0; 2]; track.len()];
        let slopes = all.iter().enumerate().map(|(r, release)| {
            if is_own(r) { release.clone() } else { release.iter().map(still).collect() }
        });
        Self { of, part, slopes: slopes.collect() }
    }
}

/// The columns of an unknown that is fitted, for each release that has it, in units of its value: how the predictions
/// would move if this release had another value than the others.
pub(super) fn of_releases(fit: &Joint, place: usize, of: usize) -> Vec<Column> {
    let all = fitted(fit, place);
    let has_it = |r: &usize| fit.objective.part.locals[*r].iter().any(|local| local.unknown == place);
    let column = |(part, own): (usize, usize)| Column::only(of, part, &all, |release| release == own);
    (0..all.len()).filter(has_it).enumerate().map(column).collect()
}

/// Of what moves in all releases a column for each pressure.
fn of_pressures(fit: &Joint, all: &[Moved], of: usize) -> Vec<Column> {
    let pressure = |trial: &Arc<Trial>| trial.release.pressure;
    let members = &fit.objective.part.members;
    let mut pressures: Vec<f64> = members.iter().filter_map(pressure).collect();
    pressures.sort_by(f64::total_cmp);
    pressures.dedup_by(|a, b| is_same_pressure(*a, *b));
    let column = |(number, own): (usize, &f64)| {
        Column::only(of, number, all, |r| {
            pressure(&members[r]).is_some_and(|there| is_same_pressure(there, *own))
        })
    };
    pressures.iter().enumerate().map(column).collect()
}

/// How the predictions move with the value of an unknown that is fitted.
fn fitted(fit: &Joint, place: usize) -> Vec<Moved> {
    let part = &fit.objective.part;
    let per = part.unknowns[place].scaled.slope(fit.found.x[place]).recip();
    let of_release = |(r, block): (usize, &Vec<Series>)| {
        let local = part.locals[r].iter().position(|local| local.unknown == place);
        let of_sample =
            |slopes: &Vec<[f64; 2]>| local.map_or([0.0; 2], |k| slopes[k].map(|slope| per * slope));
        block.iter().map(|series| series.slopes.iter().map(of_sample).collect()).collect()
    };
    fit.found.at.carried.blocks.iter().enumerate().map(of_release).collect()
}

/// The places of the columns of one candidate among all.
pub(super) fn places(columns: &[Column], of: usize) -> Vec<usize> {
    (0..columns.len()).filter(|k| columns[*k].of == of).collect()
}

/// The residuals of the fit with the slopes of all columns behind those of the unknowns.
pub(super) fn extended(fit: &Joint, columns: &[Column]) -> Vec<Vec<Series>> {
    let mut blocks = fit.found.at.carried.blocks.clone();
    for (r, block) in blocks.iter_mut().enumerate() {
        for (t, series) in block.iter_mut().enumerate() {
            for (k, slopes) in series.slopes.iter_mut().enumerate() {
                slopes.extend(columns.iter().map(|column| column.slopes[r][t][k]));
            }
        }
    }
    blocks
}

/// Normal equations of a fit with columns behind its unknowns.
pub(super) fn normal_equations(
    fit: &Joint,
    blocks: &[Vec<Series>],
    columns: usize,
) -> (DVector<f64>, DMatrix<f64>) {
    fit.objective.normal_equations(blocks, &fit.found.x, &fit.found.view.loss, columns)
}

/// What a fit predicts of all its releases; none where it cannot be run.
pub(super) fn predictions(fit: &Joint) -> Option<Vec<Prediction>> {
    let members = &fit.objective.part.members;
    let of = |(r, trial): (usize, &Arc<Trial>)| run(fit, trial, r, fit.found.view.steps_of(r));
    in_order(members.par_iter().enumerate().map(of))
}

/// Movements of the points of a release by track and place among its samples, m, in units of the noise
/// where they are fitted.
pub(super) fn in_noise(fit: &Joint, r: usize, moved: impl Fn(usize, usize) -> [f64; 2]) -> Moved {
    let of_track = |(t, series): (usize, &Series)| {
        let per = fit.objective.measured[r].noise[t].recip();
        series.samples.iter().map(|k| moved(t, *k).map(|moved| per * moved)).collect()
    };
    fit.found.at.carried.blocks[r].iter().enumerate().map(of_track).collect()
}

/// The prediction of the `r`-th release.
fn run(fit: &Joint, trial: &Trial, r: usize, steps: Steps) -> Option<Prediction> {
    let member = Member { trial, ..fit.objective.member(r) };
    member.predict(&fit.found.x, fit.found.view.request(r, steps), None).ok()
}

#[cfg(test)]
mod tests {
    use efam_core::example::muscle_at_15_psi;
    use efam_core::forward::{Run, uniform};
    use efam_experiments::release::{Point, Release, Track};

    use super::*;
    use crate::calibrate::prediction::{Fidelity, Slopes};
    use crate::calibrate::{FittedParameter, Nuisances, Problem};
    use crate::diagnose::DiagnosisSettings;
    use crate::diagnose::candidate::candidates;
    use crate::example;

    const NOISE: f64 = 3e-4;

    fn problem() -> Problem {
        let time = uniform(0.6, 40.0);
        let track = |marker: &str, at: Point| Track {
            marker: marker.to_owned(),
            at,
            position: vec![Some([0.0; 2]); time.len()],
            noise: NOISE,
            discrepancy: 0.0,
        };
        let tracks = vec![track("tip", Point::Tip), track("middle", Point::Along(0.5))];
        let release = Release { pressure: Some(1e5), ..example::release(time, tracks) };
        Problem {
            trials: vec![Trial { release, model: muscle_at_15_psi(), run: Run::release(0.6, 40.0) }.into()],
            parameters: vec![FittedParameter::new("rod.bending_stiffness", Scope::Shared)],
            nuisances: Nuisances::default(),
        }
    }

    /// All candidates in one run against a run of each with a little of it, on fine steps. What acts on the fastest modes, and
    /// friction, which turns round within a step, is good to an eighth, most others to a hundredth.
    #[test]
    #[ignore = "long; .ci/thorough runs it"]
    fn movements_side_by_side_are_those_of_each_alone() {
        let problem = problem();
        let fine = Fidelity { tolerance: 1e-7, refinement: 1 };
        let fit = Joint::at(&problem, &[], Slopes::Variational, fine).unwrap();
        let all = candidates(&problem, &DiagnosisSettings::default());
        let moved = movements(&fit, &all, &|_| ());
        let flat = |moved: Moved| DVector::from_vec(moved.concat().concat());
        let mut exact = 0;
        for (candidate, moved) in all.iter().zip(moved) {
            let moved = flat(moved.unwrap().remove(0));
            let step =
                (20.0 * WANTED / (NOISE * moved.amax())).min(room(candidate).abs()).copysign(room(candidate));
            let on = candidate.on(&problem.trials[0], candidate.null_value + step).unwrap();
            let aside = run(&fit, &on, 0, fit.found.view.steps_of(0)).unwrap();
            // On the steps of that run, with those that it halved.
            let off = run(&fit, &problem.trials[0], 0, Steps::Repeated(aside.steps)).unwrap();
            let difference = in_noise(&fit, 0, |t, k| {
                let (aside, off) = (aside.position[t][k], off.position[t][k]);
                [0, 1].map(|axis| (aside[axis] - off[axis]) / step)
            });
            let error = (flat(difference) - &moved).norm() / moved.norm();
            assert!(error < 0.125, "{} {error}", candidate.name());
            exact += usize::from(error < 0.01);
        }
        assert!(2 * exact > all.len(), "{exact} of {}", all.len());
    }
}

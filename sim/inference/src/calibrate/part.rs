//! Parts of a problem that share no unknown: each is calibrated by itself.

use std::sync::Arc;

use super::problem::{Problem, Trial};
use super::unknowns::{Local, Unknown, Unknowns};

/// Releases that hang together by common unknowns.
#[derive(Clone)]
pub(crate) struct Part {
    /// The releases, as places in the problem.
    pub trials: Vec<usize>,
    /// The same, themselves.
    pub members: Vec<Arc<Trial>>,
    /// The unknowns, as places among all.
    pub places: Vec<usize>,
    /// The same, themselves.
    pub unknowns: Vec<Unknown>,
    /// How they act in each release.
    pub locals: Vec<Vec<Local>>,
}

/// All fitted releases as one part, whether or not they share an unknown.
pub(crate) fn whole(problem: &Problem, unknowns: Unknowns) -> Part {
    let trials: Vec<usize> =
        (0..problem.trials.len()).filter(|t| !problem.trials[*t].release.held_out).collect();
    Part {
        members: trials.iter().map(|t| problem.trials[*t].clone()).collect(),
        locals: trials.iter().map(|t| unknowns.of_trial[*t].clone()).collect(),
        places: (0..unknowns.list.len()).collect(),
        unknowns: unknowns.list,
        trials,
    }
}

/// The parts in the order of their first release.
pub(crate) fn parts(problem: &Problem, unknowns: &Unknowns) -> Vec<Part> {
    let count = problem.trials.len();
    let mut part_of: Vec<usize> = (0..count).collect();
    for unknown in 0..unknowns.list.len() {
        let has = |t: &usize| unknowns.of_trial[*t].iter().any(|local| local.unknown == unknown);
        let sharing: Vec<usize> = (0..count).filter(has).collect();
        let merged: Vec<usize> = sharing.iter().map(|t| part_of[*t]).collect();
        let Some(&first) = merged.iter().min() else { continue };
        for part in part_of.iter_mut().filter(|part| merged.contains(part)) {
            *part = first;
        }
    }
    let fitted = |t: &usize| !unknowns.of_trial[*t].is_empty();
    let mut parts = Vec::new();
    for first in 0..count {
        let trials: Vec<usize> = (0..count).filter(|t| part_of[*t] == first && fitted(t)).collect();
        if trials.is_empty() {
            continue;
        }
        let acts =
            |u: &usize| trials.iter().any(|t| unknowns.of_trial[*t].iter().any(|local| local.unknown == *u));
        let places: Vec<usize> = (0..unknowns.list.len()).filter(acts).collect();
        let own = |local: &Local| Local {
            unknown: places.iter().position(|place| *place == local.unknown).unwrap_or_default(),
            ..*local
        };
        parts.push(Part {
            members: trials.iter().map(|t| problem.trials[*t].clone()).collect(),
            unknowns: places.iter().map(|u| unknowns.list[*u].clone()).collect(),
            locals: trials.iter().map(|t| unknowns.of_trial[*t].iter().map(own).collect()).collect(),
            trials,
            places,
        });
    }
    parts
}

//! What mesh and step of the integrator do to a fit, and its removal.
//!
//! A fit is a weighted mean over thousands of samples, so it feels errors of the model far below the
//! noise of one. So a finer run corrects the prediction: `d = y_fine − y + (y_fine − y_same) / (2^p − 1)`, with
//! `y_same` on the fit's own mesh and `y_fine` on one of half the edge length, both with a fraction of
//! the step error; the last term is Richardson's, for an error of order `p` in the edge length. The
//! fit is then repeated with d held fixed, and belongs to a rod without mesh.

use efam_core::accuracy;
use efam_core::integrate::Steps;
use nalgebra::DVector;
use rayon::prelude::*;

use super::objective::Objective;
use super::prediction::{Fidelity, Prediction, RunRequest};
use super::view::View;

/// Error admitted in a step of the finer runs.
const TIGHT: f64 = 2e-6;

/// What a finer run says of each release.
#[derive(Clone, Debug, Default)]
pub(crate) struct Correction {
    /// What to add to each prediction, m, shape `[release][track][sample]`.
    pub corrections: Vec<Vec<Vec<[f64; 2]>>>,
    /// Root mean square of that, m, of each release.
    pub error: Vec<f64>,
    /// What may be left of the mesh's error, m, root mean square: Richardson's term, which is the error of the finer run.
    pub left: Vec<f64>,
    /// Steps of each release's run on the fit's own mesh, s.
    pub own_steps: Vec<Vec<f64>>,
}

/// Compares each release's prediction with finer runs; none where one cannot be made.
/// With `keep_mesh` only the step is made finer.
pub(crate) fn correction(
    objective: &Objective,
    x: &DVector<f64>,
    view: &View,
    keep_mesh: bool,
) -> Option<Correction> {
    let releases = objective.part.members.len();
    let each: Vec<Option<[Prediction; 3]>> = (0..releases)
        .into_par_iter()
        .map(|r| {
            let tight = Fidelity { tolerance: TIGHT, refinement: 1 };
            let fine = Fidelity { refinement: if keep_mesh { 1 } else { 2 }, ..tight };
            let run = |fidelity, steps| {
                let request = RunRequest { fidelity, ..view.request(r, steps) };
                objective.member(r).predict(x, request, None).ok()
            };
            let same = run(tight, Steps::Adaptive)?;
            let finer = if keep_mesh { same.clone() } else { run(fine, Steps::Adaptive)? };
            Some([run(view.fidelity, view.steps_as(Steps::Given, r))?, same, finer])
        })
        .collect();
    let mut correction = Correction::default();
    for one in each {
        let [own, same, fine] = one?;
        objective.count_steps(own.steps.len() + same.steps.len() + fine.steps.len());
        let order = accuracy::order(&objective.part.members[0].model);
        let (mut all, mut error, mut left) = (Vec::new(), Mean::default(), Mean::default());
        for track in 0..own.position.len() {
            let of = |k: usize| {
                let (own, same, fine) =
                    (own.position[track][k], same.position[track][k], fine.position[track][k]);
                let richardson = [0, 1].map(|axis| (fine[axis] - same[axis]) / (2f64.powf(order) - 1.0));
                let whole = [0, 1].map(|axis| fine[axis] - own[axis] + richardson[axis]);
                (whole, richardson)
            };
            let of_track: Vec<_> = (0..own.position[track].len()).map(of).collect();
            of_track.iter().for_each(|(whole, richardson)| {
                error.add(whole);
                left.add(richardson);
            });
            all.push(of_track.into_iter().map(|(whole, _)| whole).collect());
        }
        correction.corrections.push(all);
        correction.error.push(error.root());
        correction.left.push(left.root());
        correction.own_steps.push(own.steps);
    }
    Some(correction)
}

#[derive(Default)]
struct Mean {
    sum: f64,
    count: usize,
}

impl Mean {
    fn add(&mut self, [x, z]: &[f64; 2]) {
        self.sum += x * x + z * z;
        self.count += 1;
    }

    /// Root mean square distance.
    fn root(&self) -> f64 {
        (self.sum / self.count.max(1) as f64).sqrt()
    }
}

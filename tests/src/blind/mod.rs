//! Drawn experiments as a diagnosis gets them, without what is hidden, and the score of its answers.

pub mod answer;
pub mod case;
pub mod files;
pub mod setup;
pub mod tally;
pub mod truth;

use std::sync::Arc;

use efam_core::forward::Run;
use efam_experiments::cleaning::mask_spurious;
use efam_experiments::release::Release;
use efam_inference::calibrate::{FittedParameter, Nuisances, Prior, Problem, Scope, Trial};
use models::model::Model;

use crate::twin::drawn::{Drawn, DrawnRelease};

/// What a diagnosis is given of a drawn experiment. The middle pressure and one release more are held out.
/// # Panics
/// If the paper's muscle is no model.
pub fn problem(drawn: &Drawn) -> Problem {
    let pressures: Vec<f64> = drawn.releases.iter().filter_map(|drawn| drawn.release.pressure).collect();
    let middle = {
        let mut sorted = pressures.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    };
    let last = drawn.releases.len() - 1;
    let trial = |(k, drawn): (usize, &DrawnRelease)| {
        let mut release = drawn.release.clone();
        mask(&mut release);
        release.held_out = release.pressure == Some(middle) || k == last;
        let duration = release.time.last().copied().unwrap_or(0.0);
        let model = Model::new(&drawn.nominal).expect("the paper's muscle");
        Trial { release, model, run: Run::release(duration, 100.0) }
    };
    let trials: Vec<Arc<Trial>> = drawn.releases.iter().enumerate().map(trial).map(Arc::new).collect();
    // A balance: to a per cent.
    let weighed = |path: &str| {
        let model = &trials[0].model;
        let mean = model.value(path).expect("there");
        let prior = Some(Prior { mean, deviation: 0.01 * mean / 3f64.sqrt() });
        FittedParameter { prior, ..FittedParameter::new(path, Scope::Shared) }
    };
    let parameters = vec![
        FittedParameter::new("rod.bending_stiffness", Scope::PerPressure),
        FittedParameter::new("effects.rayleigh_mass.alpha", Scope::Shared),
        FittedParameter::new("effects.rayleigh_stiffness.beta", Scope::Shared),
        weighed("rod.mass"),
        weighed("effects.end_fitting.mass"),
    ];
    let nuisances = Nuisances {
        release_instant: true,
        hold_angle: Some(0.25f64.to_radians()),
        offset: Some(2e-4),
        ..Nuisances::default()
    };
    Problem { trials, parameters, nuisances }
}

/// Takes out what the cleaning takes for no marker.
fn mask(release: &mut Release) {
    let step = release.time[1] - release.time[0];
    for track in &mut release.tracks {
        let mut path: Vec<_> = track.position.iter().map(|at| at.map(|[x, z]| [x, 0.0, z])).collect();
        mask_spurious(&release.time, step, &mut path);
        track.position = path.into_iter().map(|at| at.map(|[x, _, z]| [x, z])).collect();
    }
}

/// The same with nothing held out.
pub fn all_fitted(drawn: &Drawn) -> Problem {
    let mut problem = problem(drawn);
    problem.trials_mut().for_each(|trial| trial.release.held_out = false);
    problem
}

/// What a careless user makes of it: starts that are off by 30 %, and a coarse mesh.
/// # Panics
/// If the models have no such parameters.
pub fn decoyed(problem: &mut Problem) {
    for trial in problem.trials_mut() {
        trial.model = trial.model.with_nodes(16).expect("a mesh");
    }
    let model = problem.trials[0].model.clone();
    let starts = [
        ("rod.bending_stiffness", 1.3),
        ("effects.rayleigh_mass.alpha", 0.7),
        ("effects.rayleigh_stiffness.beta", 1.3),
    ];
    for (path, off) in starts {
        let start = off * model.value(path).expect("there");
        let own = problem.parameters.iter_mut().filter(|parameter| parameter.path == path);
        own.for_each(|parameter| parameter.start = Some(start));
    }
}

//! How releases are looked at, and what is seen.

use efam_core::integrate::Steps;
use efam_core::loss::{Huber, spread};

use super::prediction::{FIT, Fidelity, RunRequest, Slopes};

/// How the data are looked at.
#[derive(Clone, Debug)]
pub(crate) struct View {
    /// How finely the model is run.
    pub fidelity: Fidelity,
    /// How slopes are found.
    pub slopes: Slopes,
    /// Samples of each release that count, from the first.
    pub counts: Vec<usize>,
    /// Steps of each release's run. A search keeps them: with steps chosen anew at each point the
    /// cost is rough, by more than the last steps of the search lower it.
    pub steps: Option<Vec<Vec<f64>>>,
    /// Loss of each release.
    pub loss: Vec<Huber>,
    /// What a finer run adds to each prediction, m, shape `[release][track][sample]`.
    pub corrections: Option<Vec<Vec<Vec<[f64; 2]>>>>,
}

impl View {
    /// The first samples of each release, as the fit of an unknown model sees them.
    pub fn of_all(counts: Vec<usize>) -> Self {
        Self {
            fidelity: FIT,
            slopes: Slopes::Variational,
            steps: None,
            loss: vec![Huber::for_spread(1.0); counts.len()],
            counts,
            corrections: None,
        }
    }

    /// The same on the steps of what was seen, with a loss for its spreads.
    pub fn like(mut self, seen: Evaluation) -> Self {
        self.loss = seen.spreads().into_iter().map(Huber::for_spread).collect();
        self.steps = Some(seen.steps);
        self
    }

    /// A run of the `r`-th release on some steps.
    pub fn request(&self, r: usize, steps: Steps) -> RunRequest {
        RunRequest { count: self.counts[r], fidelity: self.fidelity, steps }
    }

    /// The steps of the `r`-th release. A halved step moves the cost by more than the last steps of a search lower it, and a
    /// correction is for the steps it was found with: where slopes are those of the prediction, steps are too.
    pub fn steps_of(&self, r: usize) -> Steps {
        match self.slopes {
            Slopes::Variational => self.steps_as(Steps::Given, r),
            Slopes::Differences => self.steps_as(Steps::Repeated, r),
        }
    }

    /// The steps of the `r`-th release for a model that may need others, if there are any.
    pub fn steps_as(&self, kind: fn(Vec<f64>) -> Steps, r: usize) -> Steps {
        self.steps.as_ref().map_or(Steps::Adaptive, |steps| kind(steps[r].clone()))
    }
}

/// Residuals of one track in units of its noise: measurement minus prediction.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Series {
    /// Places among the samples of the release that are fitted.
    pub samples: Vec<usize>,
    /// Residual of each.
    pub residual: Vec<[f64; 2]>,
    /// Derivatives of the prediction by the release's unknowns, in units of the noise.
    pub slopes: Vec<Vec<[f64; 2]>>,
}

/// What a point was found to be worth.
#[derive(Clone, Debug, Default)]
pub(crate) struct Evaluation {
    /// Residuals, shape `[release][track]`.
    pub blocks: Vec<Vec<Series>>,
    /// Steps of each release's run, s.
    pub steps: Vec<Vec<f64>>,
}

impl Series {
    pub fn lengths(&self) -> impl Iterator<Item = f64> {
        self.residual.iter().map(|[x, z]| x.hypot(*z))
    }
}

impl Evaluation {
    /// Robust spread of the residuals of each release, in units of the noise.
    pub fn spreads(&self) -> Vec<f64> {
        let of = |block: &Vec<Series>| spread(block.iter().flat_map(Series::lengths).collect());
        self.blocks.iter().map(of).collect()
    }
}

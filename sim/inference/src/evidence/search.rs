//! The search for the optimum of a hypothesis in the space of features, and its evidence there.
//!
//! Levenberg and Marquardt at a given share s, then the share with the largest evidence, and so on. s falls with the misfit,
//! which anneals the search. All unknowns are standard normal, so no scales are needed.

use std::sync::Arc;

use efam_core::levenberg_marquardt::{Evaluated, minimise};
use nalgebra::DVector;

use super::data::Data;
use super::hypothesis::Hypothesis;
use super::likelihood::{Compared, evidence, expand};

/// Share with which a search from the priors' means begins: first tracks are off by several per cent.
pub const FIRST_SHARE: f64 = 0.05;
/// Change of the share in one round, at most: a factor.
const SHARE_STEP: f64 = 3.0;
/// Factor of the share within which a round has not changed it.
const SETTLED: f64 = 1.05;
/// Predicted decrease of the cost that is not worth a step, nats.
const TOLERANCE: f64 = 0.05;
/// Longest step of an unknown, prior standard deviations.
const LONGEST: f64 = 2.0;
/// Rounds of share and steps, at most.
const MOST_ROUNDS: usize = 5;

/// How much a fit may cost: evaluations in each round.
#[derive(Clone, Copy, Debug)]
pub struct Effort(pub usize);

/// A fitted hypothesis.
#[derive(Clone)]
pub struct Fit {
    pub hypothesis: Arc<Hypothesis>,
    pub z: DVector<f64>,
    pub share: f64,
    /// Logarithm of the evidence.
    pub evidence: f64,
    /// Differences and slopes at the optimum.
    pub compared: Arc<Compared>,
}

/// The optimum from a start, of which it may be known how it compares; none where the start cannot be run.
pub fn fit(
    data: &Data,
    hypothesis: &Arc<Hypothesis>,
    start: &DVector<f64>,
    mut known: Option<Arc<Compared>>,
    share: f64,
    effort: Effort,
) -> Option<Fit> {
    let all = |_: usize| true;
    let (mut z, mut share) = (start.clone(), share);
    for _ in 0..MOST_ROUNDS {
        let search = hypothesis.search(LONGEST, TOLERANCE, effort.0);
        let (begin, first) = (z.clone(), known.take());
        let mut evaluate = |x: &DVector<f64>,
                            reused: Option<&Arc<Compared>>|
         -> Option<Evaluated<Arc<Compared>>> {
            let compared = match (&first, reused) {
                (Some(known), None) if *x == begin => known.clone(),
                (_, None) => data.compare(hypothesis, x, &all)?.into(),
                (_, Some(reused)) => {
                    let here = data.compare(hypothesis, x, &|_| false)?;
                    Arc::new(Compared { slopes: reused.slopes.clone(), ..here })
                }
            };
            let at = expand(&compared, &data.weights, x, share);
            Some(Evaluated { cost: at.cost, gradient: at.gradient, hessian: at.hessian, carried: compared })
        };
        let found = minimise(&z, None, &search, &mut evaluate)?;
        z = found.x;
        // The share and the evidence take slopes of the very point.
        let is_there = found.home.as_ref() == Some(&z);
        let compared = if is_there { found.at.carried } else { data.compare(hypothesis, &z, &all)?.into() };
        let (_, best) = evidence(&compared, &data.weights, &hypothesis.unknowns, &z, share, SHARE_STEP);
        let is_settled = (best / share).ln().abs() < SETTLED.ln();
        share = best;
        known = Some(compared);
        if is_settled && found.converged {
            break;
        }
    }
    let compared = known?;
    let (value, share) = evidence(&compared, &data.weights, &hypothesis.unknowns, &z, share, SHARE_STEP);
    Some(Fit { hypothesis: hypothesis.clone(), z, share, evidence: value, compared })
}

//! Bending stiffness from the tip at rest: least squares on one parameter, as the paper has it.
//!
//! An EI belongs to the model that it was fitted with, and to the mesh and root of that.
//!
//! Source: Bending Properties of an Extensile Fluidic Artificial Muscle, Modeling.

use std::cell::Cell;

use models::statics::euler_bernoulli::EulerBernoulli;

use super::{
    AnalysisError,
    nelder_mead::{Stalled, minimize},
};

/// The bending stiffness whose tip is nearest to the measured one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessFit {
    /// EI, N m².
    pub bending_stiffness: f64,
    /// Measured tip minus predicted, in W, m.
    pub residual: [f64; 2],
    /// Tips that were predicted on the way.
    pub evaluations: usize,
}

/// Fits any model of the tip at rest.
///
/// `tip` is measured, in W, m; `predict` gives the tip for an EI, N m², or nothing if the model has
/// no equilibrium there; `start` is a first EI.
/// # Errors
/// [`AnalysisError::SearchStalled`], also if the measured tip wants an EI of zero or infinity.
pub fn fit(
    tip: [f64; 2],
    start: f64,
    predict: impl Fn(f64) -> Option<[f64; 2]>,
) -> Result<StiffnessFit, AnalysisError> {
    let residual = |bending_stiffness: f64| -> Option<[f64; 2]> {
        let predicted = predict(bending_stiffness)?;
        Some([tip[0] - predicted[0], tip[1] - predicted[1]])
    };
    let scale = tip[0] * tip[0] + tip[1] * tip[1];
    let cost = |p: &[f64]| {
        let misfit = if p[0] > 0.0 { residual(start * p[0]) } else { None };
        misfit.map_or(f64::INFINITY, |[x, z]| (x * x + z * z) / scale)
    };
    let stalled = |evaluations| AnalysisError::SearchStalled { wanted: "bending stiffness", evaluations };
    let minimum = minimize(&[1.0], cost).map_err(|Stalled { evaluations }| stalled(evaluations))?;
    let bending_stiffness = start * minimum.parameters[0];
    Ok(StiffnessFit {
        bending_stiffness,
        residual: residual(bending_stiffness).ok_or_else(|| stalled(minimum.evaluations))?,
        evaluations: minimum.evaluations,
    })
}

/// The same as [`fit`] by Gauss and Newton, on the logarithm of EI: a few evaluations where the search
/// by simplex takes dozens. A step is halved until the tip comes nearer.
/// # Errors
/// As [`fit`].
pub fn fit_gauss_newton(
    tip: [f64; 2],
    start: f64,
    predict: impl Fn(f64) -> Option<[f64; 2]>,
) -> Result<StiffnessFit, AnalysisError> {
    let evaluations = Cell::new(0);
    let stalled =
        || AnalysisError::SearchStalled { wanted: "bending stiffness", evaluations: evaluations.get() };
    let residual = |logarithm: f64| -> Option<[f64; 2]> {
        evaluations.set(evaluations.get() + 1);
        let predicted = predict(start * logarithm.exp())?;
        Some([tip[0] - predicted[0], tip[1] - predicted[1]])
    };
    let cost = |[x, z]: [f64; 2]| x * x + z * z;
    let scale = tip[0].hypot(tip[1]);
    let (mut at, mut here) = (0.0, residual(0.0).ok_or_else(stalled)?);
    for _ in 0..MOST_STEPS {
        // Central differences: wrong by the square of a ten-thousandth.
        let (less, more) = (residual(at - DIFFERENCE), residual(at + DIFFERENCE));
        let (less, more) = (less.ok_or_else(stalled)?, more.ok_or_else(stalled)?);
        let slope: [f64; 2] = std::array::from_fn(|k| (more[k] - less[k]) / (2.0 * DIFFERENCE));
        let square = cost(slope);
        if square <= (1e-12 * scale).powi(2) {
            return Err(stalled());
        }
        let mut step = (-(here[0] * slope[0] + here[1] * slope[1]) / square).clamp(-1.0, 1.0);
        let mut halvings = 0;
        let next = loop {
            match residual(at + step).filter(|next| cost(*next) <= cost(here)) {
                Some(next) => break Some(next),
                None if halvings == MOST_HALVINGS => break None,
                None => (step, halvings) = (0.5 * step, halvings + 1),
            }
        };
        if let Some(next) = next {
            (at, here) = (at + step, next);
        }
        if next.is_none() || step.abs() < SETTLED {
            return if step.abs() < 1e-4 {
                Ok(StiffnessFit {
                    bending_stiffness: start * at.exp(),
                    residual: here,
                    evaluations: evaluations.get(),
                })
            } else {
                Err(stalled())
            };
        }
    }
    Err(stalled())
}

const MOST_STEPS: usize = 50;
const MOST_HALVINGS: usize = 30;
/// Step of the differences in the logarithm of EI.
const DIFFERENCE: f64 = 1e-4;
/// Step in it that counts as none.
const SETTLED: f64 = 1e-9;

/// Fits the paper's Euler-Bernoulli beam to the tracked tip: the end fitting's centre of mass.
///
/// `tip` is measured, in W, m; `beam` gives all but the bending stiffness, of which it has a start.
/// # Errors
/// [`AnalysisError::TipOutOfReach`] if the tip is not below the clamp or is farther from it than
/// the muscle is long; [`AnalysisError::SearchStalled`].
pub fn fit_euler_bernoulli(tip: [f64; 2], beam: &EulerBernoulli) -> Result<StiffnessFit, AnalysisError> {
    let reach = beam.length + beam.tip_offset;
    if tip[1] >= 0.0 || tip[0].hypot(tip[1]) > reach {
        return Err(AnalysisError::TipOutOfReach { tip, reach });
    }
    fit(tip, beam.bending_stiffness, |bending_stiffness| {
        Some(EulerBernoulli { bending_stiffness, ..*beam }.tip().position)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The row of 25 psi in Table 2, where the muscle hangs lowest.
    const AT_25_PSI: EulerBernoulli = EulerBernoulli {
        bending_stiffness: 0.00517,
        length: 9.69 * 0.0254,
        weight_per_length: 0.14227 * 9.81,
        tip_weight: 0.05492 * 9.81,
        tip_offset: 0.662 * 0.0254,
    };

    #[test]
    fn a_beam_is_recovered_from_its_own_tip() {
        for start in [1e-4, 0.005, 0.5] {
            let beam = EulerBernoulli { bending_stiffness: start, ..AT_25_PSI };
            let fit = fit_euler_bernoulli(AT_25_PSI.tip().position, &beam).unwrap();
            assert!((fit.bending_stiffness / 0.00517 - 1.0).abs() < 1e-6, "{fit:?}");
        }
    }

    /// Both searches minimise the same, so they end at the same EI, off the path of the tip as well.
    #[test]
    fn gauss_newton_ends_where_the_simplex_does_in_fewer_evaluations() {
        let [x, z] = AT_25_PSI.tip().position;
        for off in [0.0, 0.01] {
            for start in [1e-3, 0.005, 0.05] {
                let predict =
                    |ei: f64| Some(EulerBernoulli { bending_stiffness: ei, ..AT_25_PSI }.tip().position);
                let newton = fit_gauss_newton([x - off, z], start, predict).unwrap();
                let simplex = fit([x - off, z], start, predict).unwrap();
                // The simplex settles to 1e-6; where the two differ more, one of them is not at the minimum.
                let ratio = newton.bending_stiffness / simplex.bending_stiffness;
                assert!((ratio - 1.0).abs() < 3e-6, "{newton:?} {simplex:?}");
                assert!(newton.evaluations < simplex.evaluations, "{newton:?} {simplex:?}");
            }
        }
        assert!(fit_gauss_newton([0.1, -0.1], 0.01, |_| None).is_err());
    }

    /// Where no EI reproduces the tip, the residual is normal to the path of the tip over EI.
    #[test]
    fn a_tip_off_the_path_gets_the_nearest_point_of_it() {
        let [x, z] = AT_25_PSI.tip().position;
        let fit = fit_euler_bernoulli([x - 0.02, z], &AT_25_PSI).unwrap();
        let tip = |factor: f64| {
            let bending_stiffness = factor * fit.bending_stiffness;
            EulerBernoulli { bending_stiffness, ..AT_25_PSI }.tip().position
        };
        let (less, more) = (tip(1.0 - 1e-4), tip(1.0 + 1e-4));
        let path = [more[0] - less[0], more[1] - less[1]];
        let [rx, rz] = fit.residual;
        let cosine = (rx * path[0] + rz * path[1]) / (rx.hypot(rz) * path[0].hypot(path[1]));
        assert!(rx.hypot(rz) > 1e-3 && cosine.abs() < 1e-4, "{fit:?}, cosine {cosine}");
    }

    #[test]
    fn a_tip_above_the_clamp_or_out_of_reach_is_refused() {
        assert_eq!(
            fit_euler_bernoulli([0.2, 0.01], &AT_25_PSI).unwrap_err().to_string(),
            "measured tip at x = 0.2000 m, z = 0.0100 m: must hang below the clamp, no farther \
             than 0.2629 m from it"
        );
        assert!(fit_euler_bernoulli([0.2, -0.3], &AT_25_PSI).is_err());
    }

    #[test]
    fn a_model_without_any_equilibrium_stalls() {
        let error = fit([0.1, -0.1], 0.01, |_| None).unwrap_err();
        assert!(matches!(error, AnalysisError::SearchStalled { wanted: "bending stiffness", .. }));
    }
}

//! Residuals of a calibration at any values of its unknowns, for solvers other than ours.

use nalgebra::DVector;

use super::error::CalibrateError;
use super::objective::Objective;
use super::part::whole;
use super::prediction::Slopes;
use super::problem::Problem;
use super::unknowns::Unknowns;
use super::view::View;

/// The residuals of a problem: parameters, nuisance parameters and priors included.
pub struct Residuals {
    problem: Problem,
    /// Name of each unknown, with what it belongs to.
    pub names: Vec<String>,
    /// SI unit of each unknown.
    pub units: Vec<&'static str>,
    /// Where a search starts, SI.
    pub start: Vec<f64>,
    /// Admissible values of each, SI.
    pub bounds: Vec<[f64; 2]>,
    /// Steps of each release's run at the start. With steps chosen anew at each point the residuals are rough.
    steps: Option<Vec<Vec<f64>>>,
}

/// Residuals and their derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Measurement minus prediction over the noise, x and z of each sample of each track; then of each prior, the mean
    /// minus the value over the deviation.
    pub residuals: Vec<f64>,
    /// Derivatives by the unknowns in SI, shape `[residuals][unknowns]`.
    pub jacobian: Vec<f64>,
}

impl Residuals {
    /// Of all releases that are not held out.
    /// # Errors
    /// [`CalibrateError`] for a problem that makes no sense.
    pub fn of(problem: Problem) -> Result<Self, CalibrateError> {
        if problem.parameters.is_empty() {
            return Err(CalibrateError::NoParameters);
        }
        let list = Unknowns::of(&problem)?.list;
        let bounds = list.iter().map(|unknown| {
            let (low, high) = unknown.bounds;
            [low, high].map(|x| unknown.scaled.value(x))
        });
        let mut residuals = Self {
            names: list.iter().map(|unknown| unknown.label()).collect(),
            units: list.iter().map(|unknown| unknown.unit).collect(),
            start: list.iter().map(|unknown| unknown.start).collect(),
            bounds: bounds.collect(),
            steps: None,
            problem,
        };
        residuals.steps = residuals.steps_at_start()?;
        Ok(residuals)
    }

    fn steps_at_start(&self) -> Result<Option<Vec<Vec<f64>>>, CalibrateError> {
        let objective = Objective::new(whole(&self.problem, Unknowns::of(&self.problem)?))?;
        let seen = objective.see(&objective.start(), &View::of_all(objective.all()), None);
        Ok(seen.map(|seen| seen.steps))
    }

    /// Residuals at values of the unknowns, SI; none where a release cannot be simulated.
    ///
    /// The Jacobian is that of the exact solution, some per cent off at the tolerance of a fit. An `exact` one is that of
    /// these residuals, from a run more for each unknown of a release.
    /// # Errors
    /// [`CalibrateError`] for a release that cannot be fitted.
    /// # Panics
    /// If there are not as many values as unknowns.
    pub fn at(&self, values: &[f64], exact: bool) -> Result<Option<Evaluation>, CalibrateError> {
        let objective = Objective::new(whole(&self.problem, Unknowns::of(&self.problem)?))?;
        let unknowns = &objective.part.unknowns;
        assert_eq!(values.len(), unknowns.len(), "a value for each unknown");
        let scaled = unknowns.iter().zip(values).map(|(unknown, value)| unknown.scaled.variable(*value));
        let x = DVector::from_iterator(unknowns.len(), scaled);
        let mut view = View { steps: self.steps.clone(), ..View::of_all(objective.all()) };
        if exact {
            // Differences repeat the steps, so these must be good here, and not at the start alone.
            let Some(seen) = objective.see(&x, &view, None) else { return Ok(None) };
            view = View { steps: Some(seen.steps), slopes: Slopes::Differences, ..view };
        }
        let Some(seen) = objective.see(&x, &view, Some(view.slopes)) else { return Ok(None) };
        let width = unknowns.len();
        let (mut residuals, mut jacobian) = (Vec::new(), Vec::new());
        // By the value itself, where the search goes by its logarithm or its size.
        let per_value = |k: usize| unknowns[k].scaled.slope(x[k]).recip();
        for (release, block) in seen.blocks.iter().enumerate() {
            let places = objective.places(release, 0);
            for series in block {
                for (residual, slopes) in series.residual.iter().zip(&series.slopes) {
                    for axis in 0..2 {
                        residuals.push(residual[axis]);
                        let row = jacobian.len();
                        jacobian.resize(row + width, 0.0);
                        for (slope, place) in slopes.iter().zip(&places) {
                            jacobian[row + place] -= slope[axis] * per_value(*place);
                        }
                    }
                }
            }
        }
        for (k, residual, slope) in objective.prior_residuals(&x) {
            residuals.push(residual);
            let row = jacobian.len();
            jacobian.resize(row + width, 0.0);
            jacobian[row + k] = -slope * per_value(k);
        }
        Ok(Some(Evaluation { residuals, jacobian }))
    }
}

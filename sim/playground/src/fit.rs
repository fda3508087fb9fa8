//! Parameters fitted to a measured path of the tip, by the core's sensitivities and its least squares.
//!
//! The fit begins with the first swings and takes in more and more of the path: over many swings a wrong frequency runs
//! out of phase, and the cost has a valley for each whole swing. In the end a robust loss keeps samples that are far from
//! the rest from pulling harder than others, as in the program.

use std::ops::ControlFlow;

use efam_core::forward::forward;
use efam_core::levenberg_marquardt::{Evaluated, FIRST_DAMPING, Search, Solution, minimise};
use efam_core::loss::{Huber, spread};
use efam_core::models::model::Model;
use efam_core::point::Point;
use efam_core::rest::rest;
use efam_core::run::{DEFAULT_TOLERANCE, Run};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use crate::error::PlaygroundError;
use crate::setup::Setup;

/// A requested fit.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fit {
    /// Where it begins, and what stays as it is.
    pub setup: Setup,
    /// Parameters, by their paths such as `rod.bending_stiffness` or `effects.rayleigh_mass.alpha`.
    pub unknowns: Vec<String>,
    /// Times after the release, s, ascending.
    pub time: Vec<f64>,
    /// Measured tip in the frame at the clamp, m.
    pub tip: Vec<[f64; 2]>,
}

/// A fitted parameter.
#[derive(Clone, Debug, Serialize)]
pub struct Found {
    /// Its path.
    pub path: String,
    /// SI unit.
    pub unit: &'static str,
    /// Where it began.
    pub start: f64,
    /// Its value, SI.
    pub value: f64,
    /// Its standard error, as if the residuals were independent; none where the path does not determine it.
    pub standard_error: Option<f64>,
    /// Whether it hit the end of its range.
    pub at_bound: bool,
}

/// What a fit found.
#[derive(Clone, Debug, Serialize)]
pub struct Fitted {
    /// The parameters.
    pub found: Vec<Found>,
    /// Root mean square of the distance before, mm.
    pub before_mm: f64,
    /// The same after, mm.
    pub after_mm: f64,
    /// The fitted path at the times of the measured one, m.
    pub tip: Vec<[f64; 2]>,
    /// Runs that were made.
    pub evaluations: usize,
    /// Whether no step promises more.
    pub converged: bool,
}

/// Residuals are in units of that, m, until their spread is known.
const MILLIMETRE: f64 = 1e-3;
/// Rounds in which the loss follows that spread: the second sees a fit that ghosts no longer pull.
const ROUNDS: usize = 2;
/// Swings that the fit begins with, and the share by which it goes on.
const FIRST_SWINGS: f64 = 1.5;
const GROWTH: f64 = 3.0;
/// Runs of each stage at most.
const MOST_EVALUATIONS: usize = 40;
/// Decrease of the cost that is worth another step, as a share of it.
const WORTH: f64 = 1e-7;
/// Samples that are fitted at most: more add little about smooth curves.
const MOST_SAMPLES: usize = 2000;

/// How a parameter is varied: by its logarithm where it is positive by nature, so that steps are shares.
#[derive(Clone, Copy)]
struct Unknown {
    theta: usize,
    scale: Option<f64>,
}

impl Unknown {
    fn value(self, x: f64) -> f64 {
        self.scale.map_or_else(|| x.exp(), |scale| x * scale)
    }

    fn variable(self, value: f64) -> f64 {
        self.scale.map_or_else(|| value.ln(), |scale| value / scale)
    }

    /// Derivative of the value by the variable.
    fn slope(self, x: f64) -> f64 {
        self.scale.unwrap_or_else(|| x.exp())
    }
}

/// A model, and the path that it is compared with.
struct Problem<'f> {
    setup: &'f Setup,
    model: Model,
    unknowns: Vec<Unknown>,
    time: Vec<f64>,
    tip: Vec<[f64; 2]>,
    /// Unit of the residuals, m.
    unit: f64,
    loss: Huber,
}

impl Fit {
    /// Fits.
    pub fn run(&self) -> Result<Fitted, PlaygroundError> {
        let mut problem = self.problem()?;
        let theta = |k: usize| problem.model.theta[problem.unknowns[k].theta];
        let range = |k: usize| problem.model.parameters[problem.unknowns[k].theta].range;
        let n = problem.unknowns.len();
        let start = DVector::from_fn(n, |k, _| problem.unknowns[k].variable(theta(k)));
        let bounds = (0..n).map(|k| {
            let (low, high) = range(k);
            // The logarithm of nothing is no bound.
            let low = if problem.unknowns[k].scale.is_none() { low.max(1e-12) } else { low };
            (problem.unknowns[k].variable(low), problem.unknowns[k].variable(high))
        });
        let search = Search {
            bounds: bounds.collect(),
            longest: problem.unknowns.iter().map(|u| if u.scale.is_none() { 0.4 } else { 4.0 }).collect(),
            tolerance: 0.0,
            relative: WORTH,
            most_evaluations: MOST_EVALUATIONS,
            first_damping: FIRST_DAMPING,
            reuses_slopes: false,
            is_followed: false,
        };
        let all = problem.time.len();
        let before = problem.evaluate(&start, all).ok_or(PlaygroundError::NoStart)?;
        let (mut x, mut evaluations, mut last) = (start.clone(), 1, None);
        for count in problem.stages() {
            let stage = Search { relative: if count < all { 1e-3 } else { WORTH }, ..search.clone() };
            let mut evaluate = |x: &DVector<f64>, _: Option<&Vec<[f64; 2]>>| problem.evaluate(x, count);
            let solution = minimise(&x, None, &stage, &mut evaluate).ok_or(PlaygroundError::NoStart)?;
            evaluations += solution.evaluations;
            x = solution.x.clone();
            last = Some(solution);
        }
        let mut solution = last.ok_or(PlaygroundError::NoStart)?;
        for _ in 0..ROUNDS {
            problem.weigh_by(&solution.at.carried);
            let mut evaluate = |x: &DVector<f64>, _: Option<&Vec<[f64; 2]>>| problem.evaluate(x, all);
            solution = minimise(&x, None, &search, &mut evaluate).ok_or(PlaygroundError::NoStart)?;
            evaluations += solution.evaluations;
            x = solution.x.clone();
        }
        Ok(Fitted {
            found: self.found(&problem, &search, &solution),
            before_mm: problem.rms_mm(&before.carried),
            after_mm: problem.rms_mm(&solution.at.carried),
            tip: solution.at.carried,
            evaluations,
            converged: solution.converged,
        })
    }

    fn problem(&self) -> Result<Problem<'_>, PlaygroundError> {
        let ascends = |k: usize| k == 0 || self.time[k] > self.time[k - 1];
        let is_good = |k: &usize| {
            ascends(*k) && self.time[*k].is_finite() && self.tip[*k].iter().all(|x| x.is_finite())
        };
        let samples = self.time.len().min(self.tip.len());
        if let Some(bad) = (0..samples).find(|k| !is_good(k)) {
            return Err(PlaygroundError::BadSample { sample: bad + 1 });
        }
        let after: Vec<usize> = (0..samples).filter(|k| self.time[*k] >= 0.0).collect();
        let unknowns = self.unknowns.len();
        if after.len() < 4 + unknowns || unknowns == 0 {
            return Err(PlaygroundError::TooShort { samples: after.len(), unknowns });
        }
        let every = after.len().div_ceil(MOST_SAMPLES);
        let kept: Vec<usize> = after.into_iter().step_by(every).collect();
        let mut model = self.setup.model()?;
        // A parameter may belong to an effect that the setup does not have yet, such as the clock.
        for path in &self.unknowns {
            if let Some((effect, _)) = path.strip_prefix("effects.").and_then(|path| path.split_once('.'))
                && model.effect(effect).is_none()
            {
                model = with_effect_off(&model, effect)?;
            }
        }
        let unknown = |path: &String| {
            let theta = model.index(path)?;
            let p = &model.parameters[theta];
            let is_positive = path.starts_with("rod.") && p.range.0 >= 0.0;
            Ok(Unknown { theta, scale: (!is_positive).then_some(p.scale) })
        };
        let unknowns: Result<Vec<_>, PlaygroundError> = self.unknowns.iter().map(unknown).collect();
        Ok(Problem {
            setup: &self.setup,
            unknowns: unknowns?,
            model,
            time: kept.iter().map(|k| self.time[*k]).collect(),
            tip: kept.iter().map(|k| self.tip[*k]).collect(),
            unit: MILLIMETRE,
            loss: Huber { threshold: f64::INFINITY },
        })
    }

    fn found(&self, problem: &Problem, search: &Search, solution: &Solution<Vec<[f64; 2]>>) -> Vec<Found> {
        let is_bound = |k: usize| {
            let (low, high) = search.bounds[k];
            solution.x[k] <= low || solution.x[k] >= high
        };
        // What hit its bound is held there: the others are as certain as without it.
        let free: Vec<usize> = (0..problem.unknowns.len()).filter(|k| !is_bound(*k)).collect();
        let freedom = (2 * problem.time.len()).saturating_sub(free.len()).max(1) as f64;
        let hessian = solution.at.hessian.select_rows(&free).select_columns(&free);
        let covariance = hessian.try_inverse().map(|inverse| inverse * (2.0 * solution.at.cost / freedom));
        let variance = |k: usize| {
            let place = free.iter().position(|free| *free == k)?;
            Some(covariance.as_ref()?[(place, place)])
        };
        let found = |(k, path): (usize, &String)| {
            let (unknown, x) = (problem.unknowns[k], solution.x[k]);
            Found {
                path: path.clone(),
                unit: problem.model.parameters[unknown.theta].unit,
                start: problem.model.theta[unknown.theta],
                value: unknown.value(x),
                standard_error: variance(k).filter(|v| *v > 0.0).map(|v| v.sqrt() * unknown.slope(x).abs()),
                at_bound: is_bound(k),
            }
        };
        self.unknowns.iter().enumerate().map(found).collect()
    }
}

/// The model with an effect that does nothing yet, so that a fit begins where the setup is.
fn with_effect_off(model: &Model, name: &str) -> Result<Model, PlaygroundError> {
    let parameters =
        efam_core::models::effects::by_name(name).map_or(&[][..], |effect| effect.about().parameters);
    let off: Vec<_> = parameters.iter().filter_map(|p| Some((p.name, p.null_value?))).collect();
    Ok(model.with_effect(name, &off)?)
}

impl Problem<'_> {
    /// Samples of the stages: the first swings, three times as many, and so on to all.
    fn stages(&self) -> Vec<usize> {
        let all = self.time.len();
        let slowest = rest(&self.model, 0.0, 1).ok().and_then(|rest| Some(rest.modes.ok()?.first()?.0));
        let Some(frequency) = slowest.filter(|f| *f > 0.0) else { return vec![all] };
        let mut stages = Vec::new();
        let mut end = FIRST_SWINGS / frequency;
        loop {
            let count = self.time.partition_point(|time| *time <= end);
            if count >= all {
                stages.push(all);
                return stages;
            }
            if count > 4 + self.unknowns.len() {
                stages.push(count);
            }
            end *= GROWTH;
        }
    }

    /// Cost and slopes of the first samples; nothing where there is no such rod.
    fn evaluate(&self, x: &DVector<f64>, count: usize) -> Option<Evaluated<Vec<[f64; 2]>>> {
        let mut model = self.model.clone();
        for (unknown, x) in self.unknowns.iter().zip(x.iter()) {
            let path = model.parameters[unknown.theta].path.clone();
            model.set(&path, unknown.value(*x)).ok()?;
        }
        let samples = self.time[..count].to_vec();
        let run = Run {
            tolerance: DEFAULT_TOLERANCE,
            duration: *samples.last()?,
            samples,
            energy: false,
            trace_step: None,
            points: vec![Point::Tip],
            sensitivities: self.unknowns.iter().map(|unknown| unknown.theta).collect(),
            ..self.setup.run(&model).ok()?
        };
        let found = forward(&model, &run, &mut |_| ControlFlow::Continue(())).ok()?;
        let n = self.unknowns.len();
        let (mut gradient, mut hessian) = (DVector::zeros(n), DMatrix::zeros(n, n));
        let mut cost = 0.0;
        let carried: Vec<[f64; 2]> = found.points.iter().map(|points| points[0]).collect();
        for (k, length) in self.lengths(&carried).enumerate() {
            cost += self.loss.cost(length / self.unit);
            let weight = self.loss.weight(length / self.unit);
            for axis in 0..2 {
                let residual = (self.tip[k][axis] - carried[k][axis]) / self.unit;
                let by = |j: usize| self.unknowns[j].slope(x[j]) / self.unit;
                let row = DVector::from_fn(n, |j, _| -found.points_by_parameters[k][0][j][axis] * by(j));
                gradient += weight * residual * &row;
                hessian += weight * &row * row.transpose();
            }
        }
        cost.is_finite().then_some(Evaluated { cost, gradient, hessian, carried })
    }

    /// Distances of the first samples from a path, m.
    fn lengths(&self, path: &[[f64; 2]]) -> impl Iterator<Item = f64> {
        self.tip.iter().zip(path).map(|(measured, path)| (measured[0] - path[0]).hypot(measured[1] - path[1]))
    }

    /// Puts residuals in units of their spread about a path, from where on the loss is robust.
    fn weigh_by(&mut self, path: &[[f64; 2]]) {
        let spread = spread(self.lengths(path).collect());
        if spread > 0.0 {
            (self.unit, self.loss) = (spread, Huber::for_spread(1.0));
        }
    }

    /// Root mean square distance from a path, mm.
    fn rms_mm(&self, path: &[[f64; 2]]) -> f64 {
        let squares: f64 = self.lengths(path).map(|length| length * length).sum();
        1e3 * (squares / path.len().max(1) as f64).sqrt()
    }
}

//! The cost of a part at a point: all its releases simulated side by side, compared, and summed in
//! the order of their index, so that the number of threads changes no bit.

use std::sync::atomic::{AtomicUsize, Ordering};

use efam_core::integrate::Steps;
use efam_core::levenberg_marquardt::Evaluated;
use efam_core::loss::Huber;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::error::CalibrateError;
use super::part::Part;
use super::prediction::{FIT, Measured, Member, RunRequest, Slopes};
use super::unknowns::Acts;
use super::view::{Evaluation, Series, View};

/// The cost of a part.
pub(crate) struct Objective {
    pub part: Part,
    /// Of each release.
    pub measured: Vec<Measured>,
    effort: [AtomicUsize; 2],
}

impl Objective {
    /// The cost of a part.
    /// # Errors
    /// [`CalibrateError`] for a release that cannot be fitted.
    pub fn new(part: Part) -> Result<Self, CalibrateError> {
        let measured = part.members.iter().map(|trial| Measured::of(trial)).collect::<Result<_, _>>()?;
        Ok(Self { part, measured, effort: Default::default() })
    }

    /// Points at which all releases were simulated so far, and steps of the integrator in all runs.
    pub fn effort(&self) -> [usize; 2] {
        self.effort.each_ref().map(|count| count.load(Ordering::Relaxed))
    }

    /// One of its releases.
    pub fn member(&self, r: usize) -> Member<'_> {
        Member {
            trial: &self.part.members[r],
            measured: &self.measured[r],
            locals: &self.part.locals[r],
            unknowns: &self.part.unknowns,
        }
    }

    /// Samples of each release.
    pub fn all(&self) -> Vec<usize> {
        self.measured.iter().map(|measured| measured.samples.len()).collect()
    }

    /// Adds to the steps of the integrator.
    pub fn count_steps(&self, steps: usize) {
        self.effort[1].fetch_add(steps, Ordering::Relaxed);
    }

    /// The unknowns at their start.
    pub fn start(&self) -> DVector<f64> {
        let unknowns = &self.part.unknowns;
        let starts = unknowns.iter().map(|unknown| unknown.scaled.variable(unknown.start));
        DVector::from_iterator(unknowns.len(), starts)
    }

    /// Why nothing was found: the start cannot be simulated, or leads nowhere.
    pub fn refusal(&self, start: &DVector<f64>) -> CalibrateError {
        for r in 0..self.part.members.len() {
            let member = self.member(r);
            let (count, steps) = (member.measured.samples.len(), Steps::Adaptive);
            let run = member.predict(start, RunRequest { count, fidelity: FIT, steps }, None);
            if let Err(error) = run {
                let release = member.trial.release.name.clone();
                return CalibrateError::Forward { release, error: error.into() };
            }
        }
        CalibrateError::NoFit { release: self.part.members[0].release.name.clone() }
    }

    /// Residuals, and slopes if requested; nothing where a release cannot be simulated.
    pub fn see(&self, x: &DVector<f64>, view: &View, slopes: Option<Slopes>) -> Option<Evaluation> {
        self.effort[0].fetch_add(1, Ordering::Relaxed);
        let releases = self.part.members.len();
        let each: Vec<Option<(Vec<Series>, Vec<f64>)>> =
            (0..releases).into_par_iter().map(|r| self.see_one(r, x, view, slopes)).collect();
        let mut seen = Evaluation::default();
        for one in each {
            let (block, steps) = one?;
            seen.blocks.push(block);
            seen.steps.push(steps);
        }
        Some(seen)
    }

    fn see_one(
        &self,
        r: usize,
        x: &DVector<f64>,
        view: &View,
        slopes: Option<Slopes>,
    ) -> Option<(Vec<Series>, Vec<f64>)> {
        let member = self.member(r);
        let Member { trial, measured, locals, unknowns } = member;
        let prediction = member.predict(x, view.request(r, view.steps_of(r)), slopes).ok()?;
        self.count_steps(prediction.steps_in_all);
        let mut block = Vec::with_capacity(trial.release.tracks.len());
        for (t, track) in trial.release.tracks.iter().enumerate() {
            let mut offset = [0.0; 2];
            for local in locals {
                if let Acts::Offset { track, axis } = local.acts
                    && track == t
                {
                    offset[axis] = unknowns[local.unknown].scaled.value(x[local.unknown]);
                }
            }
            let per_noise = measured.noise[t].recip();
            let mut series = Series::default();
            for k in 0..view.counts[r] {
                let Some(seen) = track.position[measured.samples[k]] else { continue };
                let correction = view.corrections.as_ref().map_or([0.0; 2], |all| all[r][t][k]);
                let residual = |axis: usize| {
                    let predicted = prediction.position[t][k][axis] + correction[axis] + offset[axis];
                    (seen[axis] - predicted) * per_noise
                };
                let residual = [residual(0), residual(1)];
                if !residual.iter().all(|r| r.is_finite()) {
                    return None;
                }
                series.samples.push(k);
                series.residual.push(residual);
                if slopes.is_some() {
                    let scaled = |slope: &[f64; 2]| slope.map(|slope| slope * per_noise);
                    series.slopes.push(prediction.slopes[t][k].iter().map(scaled).collect());
                }
            }
            block.push(series);
        }
        Some((block, prediction.steps))
    }

    /// Cost alone.
    pub fn cost(&self, seen: &Evaluation, x: &DVector<f64>, view: &View) -> f64 {
        let of_release = |(block, loss): (&Vec<Series>, &Huber)| -> f64 {
            block.iter().flat_map(Series::lengths).map(|length| loss.cost(length)).sum()
        };
        let data: f64 = seen.blocks.iter().zip(&view.loss).map(of_release).sum();
        data + self.prior_residuals(x).map(|(_, residual, _)| 0.5 * residual * residual).sum::<f64>()
    }

    /// Cost with its derivatives, by the slopes of this point, or by those of another one.
    pub fn evaluate(
        &self,
        x: &DVector<f64>,
        view: &View,
        reused: Option<&Evaluation>,
    ) -> Option<Evaluated<Evaluation>> {
        let mut seen = self.see(x, view, reused.is_none().then_some(view.slopes))?;
        if let Some(reused) = reused {
            let others = reused.blocks.iter().flatten();
            for (series, other) in seen.blocks.iter_mut().flatten().zip(others) {
                assert_eq!(series.samples, other.samples, "the same samples are looked at");
                series.slopes.clone_from(&other.slopes);
            }
        }
        let (gradient, hessian) = self.normal_equations(&seen.blocks, x, &view.loss, 0);
        let cost = self.cost(&seen, x, view);
        Some(Evaluated { cost, gradient, hessian, carried: seen })
    }

    /// Gradient and `JᵀWJ`, priors included, of blocks whose slopes are by the unknowns of their release and
    /// then by `columns` more that all releases share: those come behind the unknowns.
    pub fn normal_equations(
        &self,
        blocks: &[Vec<Series>],
        x: &DVector<f64>,
        loss: &[Huber],
        columns: usize,
    ) -> (DVector<f64>, DMatrix<f64>) {
        let size = x.len() + columns;
        let (mut gradient, mut hessian) = (DVector::zeros(size), DMatrix::zeros(size, size));
        let of = |(r, block): (usize, &Vec<Series>)| {
            let places = self.places(r, columns);
            let (own_gradient, own_hessian) = normal_equations_of(block, places.len(), loss[r]);
            (places, own_gradient, own_hessian)
        };
        let each: Vec<_> = blocks.par_iter().enumerate().map(of).collect();
        for (places, own_gradient, own_hessian) in each {
            for (a, place) in places.iter().enumerate() {
                gradient[*place] += own_gradient[a];
            }
            add_at(&places, &own_hessian, &mut hessian);
        }
        for (k, residual, slope) in self.prior_residuals(x) {
            gradient[k] -= residual * slope;
            hessian[(k, k)] += slope * slope;
        }
        (gradient, hessian)
    }

    /// Where the slopes of a release belong: its unknowns among all, then `columns` behind those.
    pub fn places(&self, release: usize, columns: usize) -> Vec<usize> {
        let unknowns = self.part.unknowns.len();
        let locals = self.part.locals[release].iter().map(|local| local.unknown);
        locals.chain(unknowns..unknowns + columns).collect()
    }

    /// Of each prior: the unknown, mean minus value over the deviation, and how the value moves.
    pub fn prior_residuals(&self, x: &DVector<f64>) -> impl Iterator<Item = (usize, f64, f64)> {
        let of = |(k, unknown): (usize, &super::unknowns::Unknown)| {
            let prior = unknown.prior?;
            let (value, slope) = (unknown.scaled.value(x[k]), unknown.scaled.slope(x[k]));
            Some((k, (prior.mean - value) / prior.deviation, slope / prior.deviation))
        };
        self.part.unknowns.iter().enumerate().filter_map(of).collect::<Vec<_>>().into_iter()
    }
}

/// Adds a matrix of one release to that of all.
pub(crate) fn add_at(places: &[usize], own: &DMatrix<f64>, all: &mut DMatrix<f64>) {
    for (a, row) in places.iter().enumerate() {
        for (b, column) in places.iter().enumerate() {
            all[(*row, *column)] += own[(a, b)];
        }
    }
}

/// Gradient and `JᵀWJ` of one release by as many unknowns as its slopes have.
fn normal_equations_of(block: &[Series], locals: usize, loss: Huber) -> (DVector<f64>, DMatrix<f64>) {
    let (mut gradient, mut hessian) = (DVector::zeros(locals), DMatrix::zeros(locals, locals));
    for series in block {
        for (residual, slopes) in series.residual.iter().zip(&series.slopes) {
            let weight = loss.weight(residual[0].hypot(residual[1]));
            for (a, own) in slopes.iter().enumerate() {
                let own = own.map(|slope| weight * slope);
                gradient[a] -= own[0] * residual[0] + own[1] * residual[1];
                for (b, other) in slopes[..=a].iter().enumerate() {
                    hessian[(a, b)] += own[0] * other[0] + own[1] * other[1];
                }
            }
        }
    }
    hessian.fill_upper_triangle_with_lower_triangle();
    (gradient, hessian)
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use efam_core::example::muscle_at_15_psi;
    use efam_core::forward::{Run, forward, uniform};
    use efam_experiments::release::{OutOfPlane, Point, Release, Track};

    use super::*;
    use crate::calibrate::part::parts;
    use crate::calibrate::prediction::Fidelity;
    use crate::calibrate::unknowns::Unknowns;
    use crate::calibrate::{FittedParameter, Nuisances, Prior, Problem, Scope, Trial};

    /// Two releases that share EI and have a loss each, seen at the tip and half-way, with a ghost.
    fn problem() -> Problem {
        let mut model = muscle_at_15_psi();
        model.set("effects.rayleigh_stiffness.beta", 0.004).unwrap();
        let trial = |number: usize| {
            let points = vec![Point::Tip, Point::Along(0.5)];
            let run = Run { points, ..Run::release(1.0, 20.0) };
            let path = forward(&model, &run, &mut |_| ControlFlow::Continue(())).unwrap();
            let track = |p: usize, at: Point| Track {
                marker: format!("marker {p}"),
                at,
                position: (path.points.iter().enumerate())
                    .map(|(k, seen)| {
                        let far = if k == 9 { 0.1 } else { 0.001 * (k as f64).sin() };
                        (k != 7).then_some([seen[p][0] + far, seen[p][1] - far])
                    })
                    .collect(),
                discrepancy: 0.0,
                noise: 5e-4,
            };
            let release = Release {
                name: format!("made-up#{number}"),
                time: uniform(1.0, 20.0),
                release_uncertainty: 0.01,
                tracks: vec![track(0, Point::Tip), track(1, Point::Along(0.5))],
                pressure: None,
                payload: 0.0,
                held_out: false,
                out_of_plane: OutOfPlane::default(),
            };
            Trial { release, model: model.clone(), run: Run::release(1.0, 20.0) }
        };
        let prior = Some(Prior { mean: 0.008, deviation: 0.001 });
        let stiffness =
            FittedParameter { prior, ..FittedParameter::new("rod.bending_stiffness", Scope::Shared) };
        Problem {
            trials: vec![trial(1).into(), trial(2).into()],
            parameters: vec![
                stiffness,
                FittedParameter::new("effects.rayleigh_mass.alpha", Scope::PerRelease),
                FittedParameter::new("rod.base_angle", Scope::Shared),
            ],
            nuisances: Nuisances::default(),
        }
    }

    /// The slopes hold to the third order of their steps; with steps of a tolerance of 1e-8 that is far
    /// below the tolerance here.
    #[test]
    fn the_gradient_is_that_of_the_cost() {
        let problem = problem();
        let unknowns = Unknowns::of(&problem).unwrap();
        let mut parts = parts(&problem, &unknowns);
        assert_eq!(parts.len(), 1, "EI joins the two");
        let objective = Objective::new(parts.remove(0)).unwrap();
        // EI, two losses, base angle; instant, angle and two offsets of two tracks of two releases.
        let mut x = objective.start();
        assert_eq!(x.len(), 4 + 2 * (2 + 4));
        for (k, x) in x.iter_mut().enumerate() {
            *x += 0.01 * (k as f64 + 1.0);
        }
        let mut view = View {
            fidelity: Fidelity { tolerance: 1e-8, refinement: 1 },
            slopes: Slopes::Variational,
            counts: objective.all(),
            steps: None,
            loss: vec![Huber::for_spread(2.0); 2],
            corrections: None,
        };
        let seen = objective.see(&x, &view, None).unwrap();
        view.steps = Some(seen.steps.clone());
        assert!(seen.blocks[0][0].lengths().any(|length| length > view.loss[0].threshold), "the ghost");
        let found = objective.evaluate(&x, &view, None).unwrap();
        for k in 0..x.len() {
            let cost = |sign: f64| {
                let mut moved = x.clone();
                moved[k] += sign * 1e-4;
                objective.cost(&objective.see(&moved, &view, None).unwrap(), &moved, &view)
            };
            let slope = (cost(1.0) - cost(-1.0)) / 2e-4;
            let tolerance = 1e-4 * found.hessian[(k, k)].sqrt() * found.cost.sqrt();
            let name = &objective.part.unknowns[k].name;
            assert!(
                (found.gradient[k] - slope).abs() < tolerance,
                "{name}: {} against {slope}",
                found.gradient[k]
            );
        }
    }

    #[test]
    fn without_the_shared_stiffness_the_releases_are_apart() {
        let mut problem = problem();
        problem.parameters.remove(2);
        problem.parameters[0].scope = Scope::PerRelease;
        let unknowns = Unknowns::of(&problem).unwrap();
        let parts = parts(&problem, &unknowns);
        assert_eq!(parts.iter().map(|part| part.trials.clone()).collect::<Vec<_>>(), [[0], [1]]);
    }
}

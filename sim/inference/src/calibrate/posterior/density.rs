//! The density of a posterior, in coordinates that have no bounds and in which Laplace's approximation is a standard normal distribution.

use efam_core::loss::Huber;
use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::PredictedMarker;
use crate::calibrate::PartFit;
use crate::calibrate::numerics::correction;
use crate::calibrate::objective::Objective;
use crate::calibrate::prediction::{FIT, Slopes};
use crate::calibrate::unknowns::Unknown;
use crate::calibrate::view::{Series, View};
use crate::normal::normal;
use crate::nuts::Chain;

/// The posterior of a part in whitened coordinates.
pub struct PartDensity<'a> {
    fit: &'a PartFit,
    objective: &'a Objective,
    view: View,
    /// Coordinates without bounds at the fit.
    center: DVector<f64>,
    /// From whitened coordinates to those without bounds, by the curvature of the cost.
    root: DMatrix<f64>,
    /// The same by the covariance that the calibration states.
    stated: DMatrix<f64>,
    /// Slopes of the fit in units of the noise, of each release, shape `[samples of all tracks, x and z][locals]`.
    slopes: Vec<DMatrix<f64>>,
}

impl<'a> PartDensity<'a> {
    pub fn of(fit: &'a PartFit, keep_mesh: bool) -> Option<Self> {
        let PartFit { objective, found, uncertainty, .. } = fit;
        let hessian = &found.at.hessian;
        let coordinates = || objective.part.unknowns.iter().map(Coordinate::of);
        // A fit at a bound has no coordinate: the center is one standard error inside.
        let center = DVector::from_iterator(
            found.x.len(),
            coordinates().enumerate().map(|(k, own)| {
                let deviation = hessian[(k, k)].sqrt().recip();
                own.inside(found.x[k], if deviation.is_finite() { deviation } else { f64::INFINITY })
            }),
        );
        let slopes = DVector::from_iterator(
            center.len(),
            coordinates().zip(center.iter()).map(|(own, y)| own.slope(*y)),
        );
        let bends = DVector::from_iterator(
            center.len(),
            coordinates().zip(center.iter()).map(|(own, y)| own.bend(*y)),
        );
        let by_slopes = |matrix: &DMatrix<f64>| {
            DMatrix::from_fn(center.len(), center.len(), |a, b| slopes[a] * matrix[(a, b)] * slopes[b])
        };
        let bends = DMatrix::from_diagonal(&bends);
        let factor = Cholesky::new(by_slopes(hessian) + &bends)?.l();
        let root = factor.transpose().try_inverse()?;
        // In whitened coordinates the cost has the covariance one; the calibration states another one there.
        let spread = hessian * &uncertainty.covariance * hessian;
        let stated = root.transpose() * (by_slopes(&spread) + &bends) * &root;
        let eigen = SymmetricEigen::new(stated);
        let roots = DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0).sqrt()));
        let stated = &root * (&eigen.eigenvectors * roots * eigen.eigenvectors.transpose());
        let view = View { fidelity: FIT, steps: None, slopes: Slopes::Variational, ..found.view.clone() };
        let view = match &found.view.corrections {
            // What finer meshes and steps add to the coarse runs of the sampler, at the fit.
            Some(_) => {
                let finer = correction(objective, &found.x, &view, keep_mesh)?;
                View { steps: Some(finer.own_steps), corrections: Some(finer.corrections), ..view }
            }
            None => View { steps: Some(objective.see(&found.x, &view, None)?.steps), ..view },
        };
        let slopes = found.at.carried.blocks.iter().map(|block| {
            let rows = || block.iter().flat_map(|series| &series.slopes);
            let columns = rows().next().map_or(0, Vec::len);
            let values = rows().flat_map(|own| (0..2).flat_map(move |axis| own.iter().map(move |s| s[axis])));
            DMatrix::from_row_iterator(2 * rows().count(), columns, values)
        });
        let slopes = slopes.collect();
        Some(Self { fit, objective, view, center, root, stated, slopes })
    }

    fn coordinates(&self) -> impl Iterator<Item = Coordinate> {
        self.objective.part.unknowns.iter().map(Coordinate::of)
    }

    /// Scaled unknowns at coordinates without bounds.
    fn unknowns(&self, y: &DVector<f64>) -> DVector<f64> {
        DVector::from_iterator(y.len(), self.coordinates().zip(y.iter()).map(|(own, y)| own.variable(*y)))
    }

    /// Logarithms of the density and of the likelihood of each release, with a force by the slopes of the fit: the prediction is
    /// simulated at each place, and its slopes are those of the fit, which are a run for each unknown.
    pub fn at(&self, u: &[f64], force: &mut [f64]) -> Option<(f64, Vec<f64>)> {
        let y = &self.center + &self.root * DVector::from_column_slice(u);
        let x = self.unknowns(&y);
        if !x.iter().all(|x| x.is_finite()) {
            return None;
        }
        let seen = self.objective.see(&x, &self.view, None)?;
        let likelihood = |(block, loss): (&Vec<Series>, &Huber)| {
            -block.iter().flat_map(Series::lengths).map(|length| loss.cost(length)).sum::<f64>()
        };
        let likelihoods: Vec<f64> = seen.blocks.iter().zip(&self.view.loss).map(likelihood).collect();
        let mut logarithm: f64 = likelihoods.iter().sum();
        let mut by_x = DVector::<f64>::zeros(x.len());
        for (r, block) in seen.blocks.iter().enumerate() {
            let weighted = |residual: &[f64; 2]| {
                let weight = self.view.loss[r].weight(residual[0].hypot(residual[1]));
                residual.map(|own| weight * own)
            };
            let residuals = block.iter().flat_map(|series| series.residual.iter().flat_map(weighted));
            let residuals = DVector::from_iterator(self.slopes[r].nrows(), residuals);
            let own = self.slopes[r].tr_mul(&residuals);
            self.objective.places(r, 0).iter().zip(own.iter()).for_each(|(place, own)| by_x[*place] += own);
        }
        for (k, residual, slope) in self.objective.prior_residuals(&x) {
            // A prior is one of the value.
            let (by_value, by_logarithm) = self.objective.part.unknowns[k].scaled.logarithm_of_slope(x[k]);
            logarithm += by_value - 0.5 * residual * residual;
            by_x[k] += by_logarithm + residual * slope;
        }
        logarithm += self.coordinates().zip(y.iter()).map(|(own, y)| own.logarithm(*y)).sum::<f64>();
        let by_y = self.coordinates().zip(y.iter()).zip(by_x.iter());
        let by_y = by_y.map(|((own, y), by_x)| own.logarithm_slope(*y) + by_x * own.slope(*y));
        force.copy_from_slice((self.root.transpose() * DVector::from_iterator(y.len(), by_y)).as_slice());
        Some((logarithm, likelihoods))
    }

    /// Scaled unknowns of a draw, with the covariance that the calibration states.
    fn drawn(&self, u: &[f64]) -> DVector<f64> {
        self.unknowns(&(&self.center + &self.stated * DVector::from_column_slice(u)))
    }

    /// Their values.
    pub fn values(&self, u: &[f64]) -> Vec<f64> {
        let x = self.drawn(u);
        let unknowns = self.objective.part.unknowns.iter().zip(x.iter());
        unknowns.map(|(unknown, x)| unknown.scaled.value(*x)).collect()
    }

    /// What some draws of each chain predict.
    pub fn markers(
        &self,
        chains: &[(Chain, Vec<Vec<f64>>)],
        count: usize,
        random: &mut Xoshiro256PlusPlus,
    ) -> Option<Vec<PredictedMarker>> {
        let mut markers = Vec::new();
        for (r, trial) in self.objective.part.members.iter().enumerate() {
            for track in &trial.release.tracks {
                let samples = self.objective.measured[r].samples.iter().take(self.view.counts[r]);
                let seen = samples.filter_map(|k| Some((trial.release.time[*k], track.position[*k]?)));
                let (time_s, recorded_m) = seen.unzip();
                let (release, marker) = (trial.release.name.clone(), track.marker.clone());
                let predicted_m = vec![Vec::new(); chains.len()];
                markers.push(PredictedMarker { release, marker, time_s, recorded_m, predicted_m });
            }
        }
        for (c, (chain, _)) in chains.iter().enumerate() {
            for k in 0..count {
                let x = self.drawn(&chain.draws[k * chain.draws.len() / count]);
                let seen = self.objective.see(&x, &self.view, None)?;
                let tracks = self.fit.uncertainty.tracks.iter().flatten();
                let noise = self.objective.measured.iter().flat_map(|measured| &measured.noise);
                let series = seen.blocks.iter().flatten().zip(noise).zip(tracks);
                for (marker, ((series, noise), track)) in markers.iter_mut().zip(series) {
                    let mut again = |(recorded, residual): (&[f64; 2], &[f64; 2])| {
                        let one = |axis: usize| {
                            recorded[axis] - noise * residual[axis] + track.noise * normal(random)
                        };
                        [0, 1].map(one)
                    };
                    let own = marker.recorded_m.iter().zip(&series.residual).map(&mut again).collect();
                    marker.predicted_m[c].push(own);
                }
            }
        }
        Some(markers)
    }
}

/// A coordinate without bounds of an unknown that has some.
#[derive(Clone, Copy, Debug)]
enum Coordinate {
    Free,
    /// Above or below a bound, by `exp`.
    Above(f64),
    Below(f64),
    /// Between two, by the logistic function.
    Between(f64, f64),
}

impl Coordinate {
    fn of(unknown: &Unknown) -> Self {
        match unknown.bounds {
            (low, high) if low.is_finite() && high.is_finite() => Self::Between(low, high),
            (low, _) if low.is_finite() => Self::Above(low),
            (_, high) if high.is_finite() => Self::Below(high),
            _ => Self::Free,
        }
    }

    /// Of a scaled unknown, moved so far inside that it has a distance from its bounds; half-way between two at most.
    fn inside(self, x: f64, distance: f64) -> f64 {
        match self {
            Self::Free => x,
            Self::Above(low) => (x - low).max(distance.min(1.0)).ln(),
            Self::Below(high) => (high - x).max(distance.min(1.0)).ln(),
            Self::Between(low, high) => {
                let width = high - low;
                let distance = distance.min(0.5 * width);
                let share = ((x - low).clamp(distance, width - distance)) / width;
                (share / (1.0 - share)).ln()
            }
        }
    }

    fn variable(self, y: f64) -> f64 {
        match self {
            Self::Free => y,
            Self::Above(low) => low + y.exp(),
            Self::Below(high) => high - y.exp(),
            Self::Between(low, high) => low + (high - low) * logistic(y),
        }
    }

    /// Derivative of the scaled unknown.
    fn slope(self, y: f64) -> f64 {
        match self {
            Self::Free => 1.0,
            Self::Above(_) => y.exp(),
            Self::Below(_) => -y.exp(),
            Self::Between(low, high) => (high - low) * logistic(y) * logistic(-y),
        }
    }

    /// Logarithm of the size of that, which makes a density flat in the unknown.
    fn logarithm(self, y: f64) -> f64 {
        match self {
            Self::Free => 0.0,
            Self::Above(_) | Self::Below(_) => y,
            Self::Between(low, high) => (high - low).ln() + logistic(y).ln() + logistic(-y).ln(),
        }
    }

    fn logarithm_slope(self, y: f64) -> f64 {
        match self {
            Self::Free => 0.0,
            Self::Above(_) | Self::Below(_) => 1.0,
            Self::Between(..) => 1.0 - 2.0 * logistic(y),
        }
    }

    /// Curvature of its negative.
    fn bend(self, y: f64) -> f64 {
        match self {
            Self::Between(..) => 2.0 * logistic(y) * logistic(-y),
            _ => 0.0,
        }
    }
}

fn logistic(y: f64) -> f64 {
    (1.0 + (-y).exp()).recip()
}

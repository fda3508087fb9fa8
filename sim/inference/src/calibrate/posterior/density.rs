//! The density of a posterior, in coordinates that have no bounds and in which Laplace's approximation is a standard normal distribution.

use efam_core::loss::Huber;
use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::PredictedMarker;
use crate::calibrate::PartFit;
use crate::calibrate::numerics::correction;
use crate::calibrate::objective::Objective;
use crate::calibrate::prediction::{FIT, Slopes};
use crate::calibrate::unknowns::{Scaled, Unknown};
use crate::calibrate::view::{Series, View};
use crate::normal::normal;
use crate::nuts::Chain;

/// The posterior of a part in whitened coordinates.
pub struct PartDensity<'a> {
    fit: &'a PartFit,
    objective: &'a Objective,
    view: View,
    coordinates: Vec<Coordinate>,
    /// Their values at the fit.
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
        let unknowns = objective.part.unknowns.iter().enumerate();
        // The larger error, since draws are stretched to the one that is stated. A fit at a bound may have none: what is scaled has a
        // typical size of one.
        let variance = |k: usize| uncertainty.plain[(k, k)].max(uncertainty.covariance[(k, k)]);
        let size = |k: usize| Some(variance(k).sqrt()).filter(|size| *size > 0.0);
        let coordinates: Vec<Coordinate> =
            unknowns.map(|(k, own)| Coordinate::of(own, found.x[k], size(k).unwrap_or(1.0))).collect();
        let each = |of: &dyn Fn(usize, Coordinate) -> f64| {
            DVector::from_iterator(
                coordinates.len(),
                coordinates.iter().enumerate().map(|(k, own)| of(k, *own)),
            )
        };
        // A fit at a bound has no coordinate: the center is one standard error inside.
        let center = each(&|k, own| {
            let deviation = hessian[(k, k)].sqrt().recip();
            own.inside(found.x[k], if deviation.is_finite() { deviation } else { f64::INFINITY })
        });
        let slopes = each(&|k, own| own.slope(center[k]));
        let bends = each(&|k, own| own.bend(center[k]));
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
        Some(Self { fit, objective, view, coordinates, center, root, stated, slopes })
    }

    /// Scaled unknowns at coordinates without bounds.
    fn unknowns(&self, y: &DVector<f64>) -> DVector<f64> {
        DVector::from_iterator(
            y.len(),
            self.coordinates.iter().zip(y.iter()).map(|(own, y)| own.variable(*y)),
        )
    }

    /// Logarithms of the density and of the likelihood of each release, with a force by the slopes of the fit: the prediction is
    /// simulated at each place, and its slopes are those of the fit, which are a run for each unknown.
    pub fn at(&self, u: &[f64], force: &mut [f64]) -> Option<(f64, Vec<f64>)> {
        let y = &self.center + &self.root * DVector::from_column_slice(u);
        let x = self.unknowns(&y);
        let unknowns = &self.objective.part.unknowns;
        if !x.iter().zip(unknowns).all(|(x, own)| x.is_finite() && (own.bounds.0..=own.bounds.1).contains(x))
        {
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
            let (by_value, by_logarithm) = unknowns[k].scaled.logarithm_of_slope(x[k]);
            logarithm += by_value - 0.5 * residual * residual;
            by_x[k] += by_logarithm + residual * slope;
        }
        logarithm += self.coordinates.iter().zip(y.iter()).map(|(own, y)| own.logarithm(*y)).sum::<f64>();
        let by_y = self.coordinates.iter().zip(y.iter()).zip(by_x.iter());
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

/// Standard errors between a fit and its bounds from which on a draw beyond them is one in a million, and has no density.
const FAR: f64 = 5.0;

/// A coordinate without bounds of an unknown. Losses add up: what leaves their sum is straight in values, and bent in logarithms, so
/// that a coordinate is the value wherever it can be.
#[derive(Clone, Copy, Debug)]
enum Coordinate {
    /// The unknown itself, whose bounds are far.
    Free,
    /// Above a bound, `bound + size ln(1 + exp y)`: many times the size above it, the unknown itself.
    Above { bound: f64, size: f64 },
    /// Below a bound, alike.
    Below { bound: f64, size: f64 },
    /// Between two, by the logistic function.
    Between(f64, f64),
    /// The logarithm of a value that is above zero in the same way, with the logarithm of its size.
    Value(f64),
}

impl Coordinate {
    /// Of an unknown with its fit and the error of that, both scaled.
    fn of(unknown: &Unknown, x: f64, size: f64) -> Self {
        let (low, high) = unknown.bounds;
        match (x - low > FAR * size, high - x > FAR * size) {
            (true, true) if unknown.scaled == Scaled::Logarithmic => Self::Value(x + size.ln()),
            (true, true) => Self::Free,
            (false, true) => Self::Above { bound: low, size },
            (true, false) => Self::Below { bound: high, size },
            (false, false) => Self::Between(low, high),
        }
    }

    /// Coordinate of a value, which is moved inside the bounds by a distance.
    fn inside(self, x: f64, distance: f64) -> f64 {
        match self {
            Self::Free => x,
            Self::Above { bound, size } => softplus_inverse((x - bound).max(distance.min(size)) / size),
            Self::Below { bound, size } => softplus_inverse((bound - x).max(distance.min(size)) / size),
            Self::Between(low, high) => {
                let width = high - low;
                let distance = distance.min(0.5 * width);
                let share = ((x - low).clamp(distance, width - distance)) / width;
                (share / (1.0 - share)).ln()
            }
            Self::Value(size) => softplus_inverse((x - size).exp()),
        }
    }

    fn variable(self, y: f64) -> f64 {
        match self {
            Self::Free => y,
            Self::Above { bound, size } => bound + size * softplus(y),
            Self::Below { bound, size } => bound - size * softplus(y),
            Self::Between(low, high) => low + (high - low) * logistic(y),
            Self::Value(size) => size + softplus(y).ln(),
        }
    }

    /// Derivative of the value by the coordinate.
    fn slope(self, y: f64) -> f64 {
        match self {
            Self::Free => 1.0,
            Self::Above { size, .. } => size * logistic(y),
            Self::Below { size, .. } => -size * logistic(y),
            Self::Between(low, high) => (high - low) * logistic(y) * logistic(-y),
            Self::Value(_) => logistic(y) / softplus(y),
        }
    }

    /// Logarithm of the size of that derivative, and its own derivative.
    fn logarithm(self, y: f64) -> f64 {
        match self {
            Self::Between(low, high) => (high - low).ln() + logistic(y).ln() + logistic(-y).ln(),
            _ => self.slope(y).abs().ln(),
        }
    }

    fn logarithm_slope(self, y: f64) -> f64 {
        match self {
            Self::Free => 0.0,
            Self::Above { .. } | Self::Below { .. } => logistic(-y),
            Self::Between(..) => 1.0 - 2.0 * logistic(y),
            Self::Value(_) => logistic(-y) - self.slope(y),
        }
    }

    /// Minus its derivative once more: what the coordinate adds to the curvature of the cost.
    fn bend(self, y: f64) -> f64 {
        let bend = logistic(y) * logistic(-y);
        match self {
            Self::Free => 0.0,
            Self::Above { .. } | Self::Below { .. } => bend,
            Self::Between(..) => 2.0 * bend,
            Self::Value(_) => self.slope(y) * (logistic(-y) - self.slope(y)) + bend,
        }
    }
}

fn logistic(y: f64) -> f64 {
    (1.0 + (-y).exp()).recip()
}

/// `ln(1 + exp y)`.
fn softplus(y: f64) -> f64 {
    y.max(0.0) + (-y.abs()).exp().ln_1p()
}

fn softplus_inverse(value: f64) -> f64 {
    value + (-(-value).exp()).ln_1p()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each coordinate leads back to its unknown, and its derivatives are differences.
    #[test]
    fn derivatives_of_coordinates_are_differences() {
        let all = [
            Coordinate::Free,
            Coordinate::Above { bound: -0.4, size: 0.7 },
            Coordinate::Below { bound: 1.3, size: 2.0 },
            Coordinate::Between(-2.0, 1.5),
            Coordinate::Value(-1.7),
        ];
        let step = 1e-5;
        for own in all {
            for y in [-1.2, 0.3, 9.0] {
                let slope = |of: &dyn Fn(f64) -> f64| (of(y + step) - of(y - step)) / (2.0 * step);
                let is_near = |a: f64, b: f64| (a - b).abs() < 1e-7 * (1.0 + a.abs());
                assert!(is_near(slope(&|y| own.variable(y)), own.slope(y)), "{own:?} {y}");
                assert!(is_near(own.slope(y).abs().ln(), own.logarithm(y)), "{own:?} {y}");
                assert!(is_near(slope(&|y| own.logarithm(y)), own.logarithm_slope(y)), "{own:?} {y}");
                assert!(is_near(-slope(&|y| own.logarithm_slope(y)), own.bend(y)), "{own:?} {y}");
                assert!((own.inside(own.variable(y), 1e-6) - y).abs() < 1e-3, "{own:?} {y}");
            }
        }
    }
}

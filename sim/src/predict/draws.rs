//! Draws from the errors of a calibration.

use models::model::Model;
use models::muscle::Known;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use super::{Settings, value};
use crate::normal::normal;
use crate::scenario::Case;

/// Share of its value below which what describes rod and bodies is not drawn.
const LEAST: f64 = 1e-3;

/// Models that a calibration admits.
pub(super) struct Draws<'a> {
    model: &'a Model,
    /// Of each parameter that is drawn its path, its value in the model, and the least that it may be.
    drawn: Vec<(String, [f64; 2])>,
    /// Takes independent normal numbers to errors.
    root: DMatrix<f64>,
    seed: u64,
    /// Paths of those that the data did not determine.
    pub undetermined: Vec<String>,
}

impl<'a> Draws<'a> {
    /// Draws at the pressure of a case.
    pub fn new(known: &Known, case: &'a Case, settings: &Settings) -> Self {
        let at = known.at(case.pressure.unwrap_or(0.0));
        // A parameter that the model has not is none of its errors.
        let own: Vec<usize> =
            (0..at.paths.len()).filter(|k| case.model.index(&at.paths[*k]).is_ok()).collect();
        let drawn = |k: &usize| {
            let path = &at.paths[*k];
            let value = value(&case.model, path);
            let is_loss = path.starts_with("effects.rayleigh");
            (path.clone(), [value, if is_loss { 0.0 } else { LEAST * value }])
        };
        let covariance = DMatrix::from_fn(own.len(), own.len(), |a, b| at.covariance[own[a]][own[b]]);
        // Numbers of very different size: the root is taken of the correlations.
        let deviations = covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
        let scaled = DMatrix::from_fn(own.len(), own.len(), |a, b| {
            covariance[(a, b)] / (deviations[a] * deviations[b]).max(f64::MIN_POSITIVE)
        });
        let eigen = SymmetricEigen::new(scaled);
        let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
        let root = DMatrix::from_diagonal(&deviations) * &eigen.eigenvectors * DMatrix::from_diagonal(&roots);
        Self {
            model: &case.model,
            drawn: own.iter().map(drawn).collect(),
            root,
            seed: settings.seed,
            undetermined: at.undetermined,
        }
    }

    /// The model of a draw, the same whoever asks for it; none that makes no sense.
    pub fn model(&self, draw: usize) -> Option<Model> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(self.seed.wrapping_add((draw as u64) << 20));
        let errors = &self.root * DVector::from_fn(self.drawn.len(), |_, _| normal(&mut random));
        let mut model = self.model.clone();
        for ((path, [value, least]), error) in self.drawn.iter().zip(errors.iter()) {
            model.set(path, (value + error).max(*least)).ok()?;
        }
        Some(model)
    }
}

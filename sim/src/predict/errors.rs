//! Models that the errors of a calibration admit: drawn, or one standard deviation off along each direction.

use models::model::Model;
use models::muscle::Known;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use super::simulated::value;
use crate::normal::normal;
use crate::scenario::Case;

/// Share of its value below which what describes the rod is not drawn.
const LEAST: f64 = 1e-3;

/// Draws after which one that is not admitted is put on its bounds.
const TRIES: usize = 10_000;
/// Share of a standard deviation below which a step along a direction says nothing.
const LEAST_SHARE: f64 = 1e-3;

/// The errors of a calibration at the pressure of a case.
pub(crate) struct Errors<'a> {
    model: &'a Model,
    /// Of each parameter that is drawn its path, its value in the model, and what it may be.
    drawn: Vec<(String, f64, [f64; 2])>,
    /// Takes independent normal numbers to errors; its columns are those of a standard deviation along each direction.
    root: DMatrix<f64>,
    /// Paths of those that the data did not determine.
    pub undetermined: Vec<String>,
}

impl<'a> Errors<'a> {
    /// Those of a case.
    pub fn new(known: &Known, case: &'a Case) -> Self {
        let at = known.at(case.pressure.unwrap_or(0.0));
        // A parameter that the model has not is none of its errors.
        let own: Vec<usize> =
            (0..at.paths.len()).filter(|k| case.model.index(&at.paths[*k]).is_ok()).collect();
        let drawn = |k: &usize| {
            let path = &at.paths[*k];
            let value = value(&case.model, path);
            let (low, high) =
                case.model.index(path).map_or((value, value), |k| case.model.parameters[k].range);
            let least = if path.starts_with("rod.") { LEAST * value } else { low };
            (path.clone(), value, [least.max(low), high])
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
            undetermined: at.undetermined,
        }
    }

    /// The model of a draw, the same whoever asks for it; none that makes no sense. Errors that take a number
    /// out of what it may be are drawn anew: of two that move against one another, neither gives way alone.
    pub fn drawn(&self, seed: u64, draw: usize) -> Option<Model> {
        self.model(&self.errors(seed, draw))
    }

    /// What the model of a draw has of its own: paths and values.
    pub fn values(&self, seed: u64, draw: usize) -> Vec<(String, f64)> {
        let errors = self.errors(seed, draw);
        self.with(&errors).map(|(path, value)| (path.to_owned(), value)).collect()
    }

    /// Paths and values with these errors, as far as the values may go.
    fn with(&self, errors: &DVector<f64>) -> impl Iterator<Item = (&str, f64)> {
        let pairs = self.drawn.iter().zip(errors.iter());
        pairs.map(|((path, value, [least, most]), error)| (&path[..], (value + error).clamp(*least, *most)))
    }

    fn errors(&self, seed: u64, draw: usize) -> DVector<f64> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_add((draw as u64) << 20));
        let mut draw = || &self.root * DVector::from_fn(self.drawn.len(), |_, _| normal(&mut random));
        let mut errors = draw();
        for _ in 0..TRIES {
            if self.admits(&errors) {
                break;
            }
            errors = draw();
        }
        errors
    }

    /// How many directions there are.
    pub fn directions(&self) -> usize {
        self.drawn.len()
    }

    /// The model one standard deviation along a direction, or as far as its numbers may go, with how far that is;
    /// none that makes no sense or cannot go at all.
    pub fn along(&self, direction: usize, side: f64) -> Option<(Model, f64)> {
        let errors = side * self.root.column(direction);
        let reach = |((_, value, [least, most]), error): (&(String, f64, [f64; 2]), &f64)| {
            let room = if *error > 0.0 { most - value } else { value - least };
            if *error == 0.0 { 1.0 } else { (room / error.abs()).clamp(0.0, 1.0) }
        };
        let share = self.drawn.iter().zip(errors.iter()).map(reach).fold(1.0, f64::min);
        (share >= LEAST_SHARE).then_some(())?;
        Some((self.model(&(share * errors))?, share))
    }

    fn admits(&self, errors: &DVector<f64>) -> bool {
        let mut pairs = self.drawn.iter().zip(errors.iter());
        pairs.all(|((_, value, [least, most]), error)| (*least..=*most).contains(&(value + error)))
    }

    fn model(&self, errors: &DVector<f64>) -> Option<Model> {
        let mut model = self.model.clone();
        for (path, value) in self.with(errors) {
            model.set(path, value).ok()?;
        }
        Some(model)
    }
}

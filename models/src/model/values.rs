//! The values of a model's parameters, by their paths.

use super::{Model, ModelParameter};
use crate::error::ModelError;

impl Model {
    /// Place of a parameter in `theta`.
    /// # Errors
    /// [`ModelError::UnknownParameter`], with the paths that there are.
    pub fn index(&self, path: &str) -> Result<usize, ModelError> {
        self.place(path).ok_or_else(|| {
            let known: Vec<_> = self.parameters.iter().map(|p| p.path.as_str()).collect();
            ModelError::UnknownParameter { path: path.to_owned(), known: known.join(", ") }
        })
    }

    /// A parameter, SI.
    /// # Errors
    /// [`ModelError::UnknownParameter`], with the paths that there are.
    pub fn value(&self, path: &str) -> Result<f64, ModelError> {
        Ok(self.theta[self.index(path)?])
    }

    /// A parameter, SI; zero where the model lacks its effect.
    pub fn value_or_zero(&self, path: &str) -> f64 {
        self.place(path).map_or(0.0, |k| self.theta[k])
    }

    fn place(&self, path: &str) -> Option<usize> {
        self.parameters.iter().position(|own| own.path == path)
    }

    /// Sets a parameter, SI.
    /// # Errors
    /// [`ModelError::UnknownParameter`] or [`ModelError::OutOfRange`].
    pub fn set(&mut self, path: &str, value: f64) -> Result<(), ModelError> {
        let k = self.index(path)?;
        self.theta[k] = value;
        self.check_parameter(k)
    }

    pub(super) fn check(&self) -> Result<(), ModelError> {
        (0..self.theta.len()).try_for_each(|k| self.check_parameter(k))
    }

    fn check_parameter(&self, k: usize) -> Result<(), ModelError> {
        let ModelParameter { path, unit, range: (low, high), .. } = &self.parameters[k];
        let value = self.theta[k];
        if (*low..=*high).contains(&value) {
            return Ok(());
        }
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        Err(ModelError::OutOfRange { path: path.clone(), value, low: *low, high: *high, unit })
    }
}

//! What a model is built from.

use std::sync::Arc;

use super::{Schedule, Scheme};
use crate::effects::{Catalogue, Rod};

/// What a model is built from.
#[derive(Clone)]
pub struct ModelSpec {
    /// Number of nodes, clamp and end fitting included.
    pub nodes: usize,
    /// The rod at release.
    pub rod: Rod<f64>,
    /// Angle of the clamp above the horizontal, rad.
    pub base_angle: f64,
    /// Angle above the horizontal at which the straight rod is let go, rad.
    pub release_angle: f64,
    /// Angular velocity with which it is let go, rad/s.
    pub release_rate: f64,
    /// How the rod is made discrete.
    pub scheme: Scheme,
    /// Distance of the observed tip beyond the end of the active length, m.
    pub tip_distance: f64,
    /// Effects beside the baseline, and parameters of any effect that differ from its defaults.
    pub effects: Vec<(String, Vec<(String, f64)>)>,
    /// The effects that there are.
    pub catalogue: Catalogue,
    /// A pressure that changes.
    pub schedule: Option<Arc<dyn Schedule>>,
}

impl ModelSpec {
    /// A rod clamped level and let go level and straight, with 32 nodes, a bare end and no loss: what of it is
    /// different is set on top, as in `ModelSpec { nodes: 12, ..ModelSpec::of(rod) }`.
    pub fn of(rod: Rod<f64>) -> Self {
        Self {
            nodes: 32,
            rod,
            base_angle: 0.0,
            release_angle: 0.0,
            release_rate: 0.0,
            scheme: Scheme::Consistent,
            tip_distance: 0.0,
            effects: Vec::new(),
            catalogue: Catalogue::default(),
            schedule: None,
        }
    }

    /// The same with parameters of effects, by their paths such as `rayleigh_mass.alpha`, SI; an effect is added by
    /// its first parameter.
    /// # Panics
    /// If a path has no dot.
    pub fn with(mut self, parameters: &[(&str, f64)]) -> Self {
        self.effects.extend(parameters.iter().map(|(path, value)| {
            let (effect, key) = path.split_once('.').expect("effect.parameter");
            (effect.to_owned(), vec![(key.to_owned(), *value)])
        }));
        self
    }
}

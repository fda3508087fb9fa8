//! Maps the rod to a recording of it: where a point is seen, and when.

use crate::effects::{CATALOGUE, Place, Scalar, Sight};
use crate::model::{Active, Model};

/// The effects on what is observed, over one scalar.
#[derive(Clone)]
pub struct Sensor<T> {
    /// In the order of the catalogue: a marker must be offset before the frame is turned, whatever the
    /// order in which a model came by its effects.
    effects: Vec<Active>,
    theta: Vec<T>,
}

impl<T: Scalar> Sensor<T> {
    /// Those of a model, with all its parameters.
    pub fn new(model: &Model, theta: Vec<T>) -> Self {
        let name = |active: &Active| active.effect.about().name;
        let of_model = |registered: &str| model.effects.iter().find(|active| name(active) == registered);
        let sensors = CATALOGUE
            .iter()
            .map(|effect| effect.about())
            .filter(|about| about.places.contains(&Place::Sensor));
        Self { effects: sensors.filter_map(|about| of_model(about.name).cloned()).collect(), theta }
    }

    /// Where a point is seen in W, m, that is at `at`.
    pub fn see(&self, at: Sight<T>) -> [T; 2] {
        let through = |at: Sight<T>, active: &Active| Sight {
            position: T::laws(active.effect).sensor(&at, &self.theta[active.theta.clone()]),
            ..at
        };
        self.effects.iter().fold(at, through).position
    }

    /// Time since release, s, of what is seen at a time of the recording.
    pub fn instant(&self, recorded: T) -> T {
        let through =
            |time: T, active: &Active| T::laws(active.effect).clock(time, &self.theta[active.theta.clone()]);
        self.effects.iter().fold(recorded, through)
    }
}

//! Whether a run comes to its end: its pace, in steps for a period.

use models::model::Model;

use crate::integrate::{Effort, IntegrateError, Stiff};
use crate::rest::slowest_frequency;

/// Attempts at steps that have to span a period: the paper's muscle takes some hundred, and a few thousand at the finest
/// tolerances.
const PER_PERIOD: usize = 100_000;
/// The same as a share of the steps that a run may take, if that is more.
const SHARE: f64 = 0.01;

/// The cost of a run when its pace was last checked, and the time of that check.
pub(super) struct Patience {
    window: usize,
    attempts: usize,
    time: f64,
    /// Period of the slowest mode, s, once it was needed.
    period: Option<f64>,
}

impl Patience {
    pub fn new(most_steps: usize) -> Self {
        let window = PER_PERIOD.max((most_steps as f64 * SHARE) as usize);
        Self { window, attempts: 0, time: 0.0, period: None }
    }

    /// Gives up where the last steps, accepted or not, did not span a period, and as many more would not do.
    pub fn follow(
        &mut self,
        model: &Model,
        effort: Effort,
        time: f64,
        end: f64,
    ) -> Result<(), IntegrateError> {
        let attempts = effort.steps + effort.rejected;
        if attempts < self.attempts + self.window {
            return Ok(());
        }
        let spanned = time - self.time;
        (self.attempts, self.time) = (attempts, time);
        let period = *self.period.get_or_insert_with(|| period(model));
        if spanned >= period || spanned >= end - time {
            return Ok(());
        }
        Err(IntegrateError::TooSlow { time, steps: self.window, spanned, period, stiff: Stiff::default() })
    }
}

/// Period of the slowest mode, s; without a rest that of a pendulum as long as the rod.
fn period(model: &Model) -> f64 {
    let pendulum = || std::f64::consts::TAU * (model.rod().length / 9.81).sqrt();
    slowest_frequency(model).map_or_else(pendulum, f64::recip)
}

#[cfg(test)]
mod tests {
    use models::effects::Rod;
    use models::model::ModelSpec;

    use super::*;

    /// The window is checked as a whole: steps that span a period go on, shorter ones end the run unless the end is near.
    #[test]
    fn a_run_ends_where_its_steps_do_not_span_a_period() {
        let rod = Rod::plain(0.2, 0.02, 5e-3);
        let model = Model::new(&ModelSpec { nodes: 8, ..ModelSpec::of(rod) }).unwrap();
        let period = period(&model);
        let mut patience = Patience::new(1000);
        let mut follow = |windows: usize, time: f64, end: f64| {
            let effort = Effort { steps: windows * PER_PERIOD, ..Effort::default() };
            patience.follow(&model, effort, time, end)
        };
        assert_eq!(follow(1, 1.1 * period, 20.0), Ok(()));
        assert_eq!(follow(2, 1.2 * period, 1.25 * period), Ok(()));
        let error = follow(3, 1.3 * period, 20.0).unwrap_err();
        assert!(matches!(error, IntegrateError::TooSlow { steps: PER_PERIOD, .. }), "{error}");
    }
}

//! How far a run depends on its steps: the same run again, with steps twice as long.
//!
//! A method of order p leaves an error of the step to the power of p, so what twice as long steps change is
//! 2^p − 1 times what is wrong with the run itself: 15 times for RODAS4, 3 times for Verlet. The check costs half a
//! run, and is on the safe side where that holds. Where it does not, and the answer hangs on every digit, as it does
//! for a rod that loses nothing, it shows.

use std::ops::ControlFlow;

use models::model::Model;
use serde::{Deserialize, Serialize};

use crate::forward::{ForwardError, Run, Sample, forward};
use crate::integrate::Method;
use crate::schema::JsonSchema;
use crate::trajectory::{Status, Trajectory};

/// What twice as long steps do to a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StepCheck {
    /// Farthest that the tip is elsewhere, at the samples.
    pub tip_moves_m: f64,
    /// When that is, after release.
    pub time_s: f64,
    /// When and why a run with such steps could not go on; what it did before is compared.
    pub fails: Option<String>,
    /// Whether that is much: a thousandth of the rod's length, which a camera sees, or a run that failed.
    pub depends_on_step: bool,
}

/// Share of the rod's length by which a tip may be elsewhere.
const MUCH: f64 = 1e-3;

impl StepCheck {
    /// What to know before the run is used, if it depends on its steps.
    pub fn warning(&self, run: &Run, model: &Model) -> Option<String> {
        let found = match &self.fails {
            Some(why) => format!("with steps twice as long it fails: {why}"),
            None => {
                let moved = 1e3 * self.tip_moves_m;
                format!("steps twice as long move the tip by {moved:.2} mm at {:.2} s", self.time_s)
            }
        };
        let next = match (run.fixed_step, run.method.of(model)) {
            (Some(step), _) => format!("give integrator.fixed_step = \"{} ms\"", 500.0 * step),
            (None, Method::Verlet) => {
                "without any loss every digit counts; give it some damping, or believe the first swings only"
                    .to_owned()
            }
            (None, _) => format!("give integrator.tolerance = {:.0e}", run.tolerance / ALLOWED),
        };
        self.depends_on_step.then(|| format!("the result depends on the step: {found}; {next}"))
    }
}

/// By how much the error that is allowed in a step grows with twice its length: methods that judge a step by a
/// result of third order.
const ALLOWED: f64 = 16.0;
/// The same of second order.
const ALLOWED_TR_BDF2: f64 = 8.0;

/// Repeats a run that came to its end with steps twice as long. None where the run did not, or `see` breaks off.
pub fn step_check(
    model: &Model,
    run: &Run,
    trajectory: &Trajectory,
    see: &mut dyn FnMut(&mut Sample) -> ControlFlow<()>,
) -> Option<StepCheck> {
    if trajectory.status != Status::Complete {
        return None;
    }
    let (longer, fails) = match forward(model, &longer(model, run, trajectory), see) {
        Ok(longer) if longer.status == Status::Complete => (longer, None),
        Err(ForwardError::Integrate { trajectory, error }) => (*trajectory, Some(error.to_string())),
        _ => return None,
    };
    let both = trajectory.tip.iter().zip(&longer.tip);
    let moves = both.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
    let farthest = trajectory.times.iter().zip(moves).max_by(|a, b| a.1.total_cmp(&b.1));
    let (time_s, tip_moves_m) = farthest.map_or((0.0, 0.0), |(time, moved)| (*time, moved));
    let depends_on_step = fails.is_some() || tip_moves_m > MUCH * model.rod().length;
    Some(StepCheck { tip_moves_m, time_s, fails, depends_on_step })
}

fn longer(model: &Model, run: &Run, trajectory: &Trajectory) -> Run {
    let mean = || trajectory.times.last().map(|end| end / trajectory.effort.steps.max(1) as f64);
    let (fixed_step, tolerance) = match (run.fixed_step, run.method.of(model)) {
        (Some(step), _) => (Some(2.0 * step), run.tolerance),
        (None, Method::Verlet) => (mean().map(|step| 2.0 * step), run.tolerance),
        (None, Method::TrBdf2) => (None, ALLOWED_TR_BDF2 * run.tolerance),
        (None, _) => (None, ALLOWED * run.tolerance),
    };
    let (energy, keep_steps, sensitivities) = (false, false, Vec::new());
    Run { fixed_step, tolerance, energy, keep_steps, sensitivities, ..run.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::tests::muscle_at_15_psi;

    fn simulate(run: &Run) -> Trajectory {
        forward(&muscle_at_15_psi(), run, &mut |_| ControlFlow::Continue(())).expect("it can be run")
    }

    fn checked(run: &Run) -> StepCheck {
        let see: &mut dyn FnMut(&mut Sample) -> ControlFlow<()> = &mut |_| ControlFlow::Continue(());
        step_check(&muscle_at_15_psi(), run, &simulate(run), see).expect("it came to its end")
    }

    /// What the check says is more than what is wrong: the distance from a run with steps of a fifth.
    #[test]
    fn it_is_on_the_safe_side_and_falls_with_the_order() {
        let of = |step: f64| Run { fixed_step: Some(step), ..Run::release(2.0, 100.0) };
        let exact = simulate(&of(2e-4));
        let wrong = |step: f64| {
            let both = simulate(&of(step)).tip.into_iter().zip(&exact.tip);
            both.map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).fold(0.0, f64::max)
        };
        let [two, one] = [2e-3, 1e-3].map(|step| checked(&of(step)).tip_moves_m);
        assert!(two > 5.0 * wrong(2e-3) && one > 5.0 * wrong(1e-3), "{two} {one}");
        assert!((8.0..32.0).contains(&(two / one)), "fourth order: {two} {one}");
    }

    #[test]
    fn who_takes_long_steps_is_warned_and_told_of_shorter_ones() {
        let model = muscle_at_15_psi();
        let usual = Run::release(4.0, 100.0);
        assert_eq!(checked(&usual).warning(&usual, &model), None);
        let long = Run { fixed_step: Some(0.02), ..usual.clone() };
        let warning = checked(&long).warning(&long, &model).expect("one");
        assert!(warning.contains("integrator.fixed_step = \"10 ms\""), "{warning}");
        let loose = Run { tolerance: 1e-2, ..usual };
        let warning = checked(&loose).warning(&loose, &model).expect("one");
        assert!(warning.contains("integrator.tolerance = 6e-4"), "{warning}");
    }
}

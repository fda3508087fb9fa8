//! The size of one rod's steps, from their errors.

use super::span::Span;
use super::tableau::Tableau;
use super::{Control, Effort, IntegrateError, Reached, State, Steps, Stiff};

/// Error, over what is admitted, from on a given step is halved, and the same of
/// the memory as a share of its largest value.
const POOR: f64 = 10.0;
const POOR_MEMORY: f64 = 0.3;
/// For the memory such steps are not halved below this, s.
const SMALLEST_MEMORY_STEP: f64 = 1e-5;
/// The first step of a run, s, if its steps are adaptive.
const FIRST_STEP: f64 = 1e-4;
/// Steps below this, s, lead nowhere.
const SMALLEST_STEP: f64 = 1e-12;

/// How long the steps of a rod are, and which of them are kept.
pub(super) struct Stride {
    pub control: Control,
    pub effort: Effort,
    /// Size of the next step, s.
    pub step: f64,
    order: f64,
    last_error: f64,
    scale_q: f64,
    scale_v: f64,
    length: f64,
    /// Whether the step that is tried was rejected before.
    rejected: bool,
}

/// The end of an attempt at a step, as the stages left it.
pub(super) struct Attempt {
    /// Where it began, s.
    pub time: f64,
    /// Its size, s.
    pub h: f64,
    /// What was left to the stop, s.
    pub to_stop: f64,
    /// Error of the step against what is admitted, and the node where it is largest.
    pub error: f64,
    pub node: usize,
    /// Error of the memory, as a share of its largest value; taken where steps are given.
    pub memory_error: f64,
}

impl Stride {
    /// The first steps of a rod of a length, m.
    pub fn new(tableau: &Tableau, length: f64, control: Control) -> Self {
        Self {
            order: tableau.order as f64,
            effort: Effort::default(),
            step: first_step(&control),
            last_error: 1.0,
            scale_q: control.tolerance * length,
            // Velocities count at a hundredth of the speed of a fall over the rod's length: those of
            // the fast modes, which no position shows, would else set the step. Of the weights 1,
            // 0.1 and 0.01 this one reaches 0.05 mm at the tip, and a budget of energy closed to
            // 1e-6, in the fewest steps.
            scale_v: control.tolerance * 100.0 * (length * 9.81).sqrt(),
            length: (control.tolerance * length) / control.tolerance,
            rejected: false,
            control,
        }
    }

    /// Where the step that begins at a time has to end at the latest, s; none where the rod is there already.
    /// # Errors
    /// [`IntegrateError::TooManySteps`].
    pub fn begin(&mut self, time: f64, stop: f64) -> Result<Option<f64>, IntegrateError> {
        let stop = self.control.steps.stop_after(time, stop);
        if stop <= time {
            return Ok(None);
        }
        if self.effort.steps >= self.control.most_steps {
            let steps = self.effort.steps;
            return Err(IntegrateError::TooManySteps { time, steps, stiff: Stiff::default() });
        }
        self.rejected = false;
        Ok(Some(stop))
    }

    /// Size of the next attempt, s, with so much left to the stop.
    pub fn size(&self, to_stop: f64) -> f64 {
        // The last two steps before a stop share what is left.
        if self.step >= to_stop * (1.0 - 1e-10) {
            to_stop
        } else if self.step > 0.5 * to_stop && self.control.steps == Steps::Adaptive {
            0.5 * to_stop
        } else {
            self.step
        }
    }

    /// Error of a step against what is admitted, and the node where it is largest, from the last stage, `[q, v, …]`.
    pub fn error(&self, nq: usize, last: impl Fn(usize) -> f64) -> (f64, usize) {
        let mut sum = 0.0;
        let mut worst = (0.0, 0);
        for k in 0..nq {
            // The angle of the end body counts as a length at the rod's radius.
            let radius = if k == nq - 1 { self.length } else { 1.0 };
            let e_q = last(k) * radius / self.scale_q;
            let e_v = last(nq + k) * radius / self.scale_v;
            let e = e_q * e_q + e_v * e_v;
            if e > worst.0 || e.is_nan() {
                worst = (e, (k / 2 + 1).min(nq / 2));
            }
            sum += e;
        }
        ((sum / nq as f64).sqrt(), worst.1)
    }

    /// Whether the error of a step includes its memory.
    pub fn judges_memory(&self) -> bool {
        matches!(self.control.steps, Steps::Given(_))
    }

    /// Whether a step is kept; the size of the next attempt follows.
    /// # Errors
    /// [`IntegrateError`] where no step leads on.
    pub fn judge(&mut self, attempt: &Attempt) -> Result<bool, IntegrateError> {
        let Attempt { time, h, to_stop, error, node, memory_error } = *attempt;
        let is_poor = match self.control.steps {
            Steps::Adaptive => error > 1.0 || error.is_nan(),
            // Where the other run had nothing to resolve and this one has.
            Steps::Given(_) => {
                let keeps_memory = h <= SMALLEST_MEMORY_STEP || memory_error <= POOR_MEMORY;
                h > SMALLEST_STEP && !(error <= POOR && keeps_memory)
            }
            Steps::Fixed(_) | Steps::Repeated(_) => false,
        };
        if is_poor {
            self.effort.rejected += 1;
            self.rejected = true;
            self.step = h * self.shrink(error);
            if self.step < SMALLEST_STEP && self.control.steps == Steps::Adaptive {
                let (step, stiff) = (self.step, Stiff::default());
                return Err(IntegrateError::StepTooSmall { time, step, node, stiff });
            }
            return Ok(false);
        }
        if !error.is_finite() {
            return Err(IntegrateError::NotFinite { time, node });
        }
        // The error of the step is as large as the rod: nothing after it would mean anything.
        if error * self.control.tolerance > 1.0 {
            return Err(IntegrateError::StepTooLong { time, step: h, node });
        }
        self.effort.steps += 1;
        match self.control.steps {
            Steps::Given(_) | Steps::Repeated(_) if h == to_stop => self.step = f64::INFINITY,
            // After a part of a given step, too: its rest may allow longer steps.
            Steps::Adaptive | Steps::Given(_) => self.step = self.grown(h, error),
            Steps::Repeated(_) | Steps::Fixed(_) => {}
        }
        Ok(true)
    }

    /// Share of a rejected step that is tried next.
    fn shrink(&self, error: f64) -> f64 {
        if self.control.steps != Steps::Adaptive {
            return 0.5;
        }
        let shrink = if error.is_finite() { 0.9 * error.powf(-1.0 / self.order) } else { 0.1 };
        shrink.clamp(0.1, 0.9)
    }

    /// Step size after an accepted step of size `h`: the usual law for the error, held back by
    /// Gustafsson's prediction where the error grows.
    fn grown(&mut self, h: f64, error: f64) -> f64 {
        let error = error.max(1e-6);
        let growth = 0.9 * error.powf(-1.0 / self.order);
        let predicted = growth * (self.last_error / error).powf(1.0 / self.order);
        self.last_error = error;
        h * growth.min(predicted.max(0.2)).clamp(0.2, if self.rejected { 1.0 } else { 5.0 })
    }
}

/// A rod that makes its steps by a [`Stride`], wherever these are computed.
pub(super) trait Stepping {
    /// Its last step.
    fn span(&self) -> &Span;
    /// How it chose its size, and chooses the next.
    fn stride(&self) -> &Stride;
}

impl<T: Stepping> Reached for T {
    fn state(&self) -> &State {
        &self.span().end
    }

    fn step_start(&self) -> f64 {
        self.span().start.time
    }

    fn interpolate(&mut self, time: f64, into: &mut State) {
        self.span().interpolate(time, into);
    }

    fn interpolate_end(&mut self, time: f64, into: &mut State) {
        self.span().interpolate_from(into.q.len() - 3, time, into);
    }

    fn next_step(&self) -> f64 {
        self.stride().step
    }

    fn effort(&self) -> Effort {
        self.stride().effort
    }
}

/// Error of the memory in a step, as a share of its largest value, from the last stage's, and the values before and after.
pub(super) fn memory_error(last: &[f64], before: &[f64], after: &[f64]) -> f64 {
    let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, z| most.max(z.abs()));
    largest(last) / largest(before).max(largest(after)).max(f64::MIN_POSITIVE)
}

/// The size of the first step, s; the end of a given step limits it.
fn first_step(control: &Control) -> f64 {
    match control.steps {
        Steps::Adaptive => control.first_step.unwrap_or(FIRST_STEP),
        Steps::Fixed(step) => step,
        Steps::Given(_) | Steps::Repeated(_) => f64::INFINITY,
    }
}

//! Work of simulations, counted in place of seconds.
//!
//! A search that ends after some seconds gives another answer on a slower machine, under load, or with other threads. A
//! search that ends after some work does not. The unit is the node step: one node through one step of the integrator,
//! rejected steps included, and once more for each parameter by which the run is differentiated. The cost of a step
//! grows in proportion to the nodes, so node steps are near to processor time, and they are integers that no clock
//! touches. A step of Verlet's method counts as one of RODAS4's, though it costs less.
//!
//! How to limit a search: give all its runs one counter ([`Run::work`](crate::run::Run::work)); every run adds to it,
//! also one that fails. Look at [`Work::is_spent`] only between parts of the search, when no run is in progress. Never
//! stop a part that runs beside others by it: which of them came first depends on the threads. Parts that run beside
//! others must all be done, also where one fails (collect their results, then look for the first failure).
//!
//! ```
//! use std::ops::ControlFlow;
//!
//! use efam_core::example::muscle_at_15_psi;
//! use efam_core::forward::forward;
//! use efam_core::run::Run;
//! use efam_core::work::Work;
//!
//! let work = Work::limited(100_000);
//! let run = Run { work: work.clone(), ..Run::release(0.5, 100.0) };
//! let mut made = 0;
//! while !work.is_spent() {
//!     forward(&muscle_at_15_psi(), &run, &mut |_| ControlFlow::Continue(()))?;
//!     made += 1;
//! }
//! println!("{made} runs, {} node steps", work.node_steps());
//! # Ok::<(), efam_core::forward::ForwardError>(())
//! ```

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::integrate::Effort;

/// A counter of node steps that runs share, with the most that they may take. By default it counts nothing.
#[derive(Clone, Debug, Default)]
pub struct Work(Option<Arc<Counter>>);

#[derive(Debug)]
struct Counter {
    node_steps: AtomicU64,
    most: u64,
}

impl Work {
    /// A new counter, spent from so many node steps on.
    pub fn limited(most: u64) -> Self {
        Self(Some(Arc::new(Counter { node_steps: AtomicU64::new(0), most })))
    }

    /// Adds a run, by its nodes and the parameters by which it was differentiated.
    pub fn add(&self, effort: &Effort, nodes: usize, parameters: usize) {
        if let Some(counter) = &self.0 {
            let node_steps = (effort.steps + effort.rejected) * nodes * (1 + parameters);
            counter.node_steps.fetch_add(node_steps as u64, Ordering::Relaxed);
        }
    }

    /// Node steps of all runs that have ended; the same on any number of threads where no run is in progress.
    pub fn node_steps(&self) -> u64 {
        self.0.as_ref().map_or(0, |counter| counter.node_steps.load(Ordering::Relaxed))
    }

    /// Whether no more work may begin. Only to be used where no run is in progress; see the head of this module.
    pub fn is_spent(&self) -> bool {
        self.0.as_ref().is_some_and(|counter| self.node_steps() >= counter.most)
    }
}

/// A number of node steps as people read it, such as `2.00e9`.
pub fn written(node_steps: u64) -> String {
    if node_steps < 100_000 { node_steps.to_string() } else { format!("{:.2e}", node_steps as f64) }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::example::muscle_at_15_psi;
    use crate::forward::{ForwardError, Run, forward};

    fn counted(run: Run, observe: ControlFlow<()>) -> (u64, Result<Effort, ForwardError>) {
        let work = Work::limited(1);
        let done = forward(&muscle_at_15_psi(), &Run { work: work.clone(), ..run }, &mut |_| observe);
        assert_eq!(work.is_spent(), work.node_steps() >= 1);
        (work.node_steps(), done.map(|trajectory| trajectory.effort))
    }

    /// By hand from the run's effort: with two parameters, each step of each node counts three times.
    #[test]
    fn a_run_counts_its_steps_times_nodes_times_solutions() {
        let model = muscle_at_15_psi();
        let nodes = model.edges + 1;
        let sensitivities =
            ["rod.bending_stiffness", "rod.mass"].map(|path| model.index(path).unwrap()).to_vec();
        for (sensitivities, solutions) in [(Vec::new(), 1), (sensitivities, 3)] {
            let run = Run { sensitivities, ..Run::release(0.5, 50.0) };
            let (node_steps, effort) = counted(run, ControlFlow::Continue(()));
            let effort = effort.unwrap();
            assert!(effort.steps > 10);
            assert_eq!(node_steps as usize, (effort.steps + effort.rejected) * nodes * solutions);
        }
    }

    /// What fails or is broken off has cost as much as it did.
    #[test]
    fn a_run_that_does_not_end_counts_as_well() {
        let nodes = muscle_at_15_psi().edges as u64 + 1;
        let run = Run { most_steps: 12, ..Run::release(5.0, 50.0) };
        let (node_steps, failed) = counted(run, ControlFlow::Continue(()));
        let Err(ForwardError::Integrate { trajectory, .. }) = failed else { panic!("12 steps do for 5 s") };
        let steps = (trajectory.effort.steps + trajectory.effort.rejected) as u64;
        assert!(steps >= 12 && node_steps == nodes * steps, "{node_steps} {steps}");
        let later = Run { samples: vec![0.3], ..Run::release(5.0, 50.0) };
        let (node_steps, broken_off) = counted(later, ControlFlow::Break(()));
        assert!(node_steps > 0 && broken_off.is_ok());
    }

    #[test]
    fn a_counter_without_a_limit_counts_nothing() {
        let work = Work::default();
        work.add(&Effort { steps: 5, ..Effort::default() }, 10, 0);
        assert!(work.node_steps() == 0 && !work.is_spent());
        assert_eq!([99_999, 2_000_000_000].map(written), ["99999", "2.00e9"]);
    }
}

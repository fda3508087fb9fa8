//! The last step of one rod: its ends, and the dense output between them.

use super::State;

/// A step that was kept.
pub(super) struct Span {
    pub start: State,
    pub end: State,
    /// Coefficients of the dense output, one power after another, each `[q, v, z]`.
    pub dense: Vec<Vec<f64>>,
}

impl Span {
    /// A step of no length at a state, for a method with so many powers.
    pub fn at(state: State, powers: usize) -> Self {
        let width = state.q.len() + state.v.len() + state.z.len();
        Self { start: state.clone(), end: state, dense: vec![vec![0.0; width]; powers] }
    }

    /// The state at a time within it, written into one of the same size.
    pub fn interpolate(&self, time: f64, into: &mut State) {
        self.interpolate_from(0, time, into);
    }

    /// Of that state the coordinates and velocities from one on; with the first of them the memory, too.
    pub fn interpolate_from(&self, first: usize, time: f64, into: &mut State) {
        let Self { start, end, dense } = self;
        let h = end.time - start.time;
        let s = if h > 0.0 { (time - start.time) / h } else { 1.0 };
        into.time = time;
        let nq = start.q.len();
        let first_memory = if first == 0 { 0 } else { start.z.len() };
        let parts = [
            (&mut into.q, &start.q, &end.q, 0, first),
            (&mut into.v, &start.v, &end.v, nq, first),
            (&mut into.z, &start.z, &end.z, 2 * nq, first_memory),
        ];
        for (into, start, end, offset, first) in parts {
            let own = offset + first..offset + into.len();
            let into = &mut into[first..];
            for ((into, start), end) in into.iter_mut().zip(&start[first..]).zip(&end[first..]) {
                *into = (1.0 - s) * start + s * end;
            }
            let mut weight = (1.0 - s) * s;
            for dense in dense {
                for (into, term) in into.iter_mut().zip(&dense[own.clone()]) {
                    *into += weight * term;
                }
                weight *= s;
            }
        }
    }
}

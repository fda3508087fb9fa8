//! Derivatives of moments and axial forces by turning angles and edge lengths, and rows of a matrix by edge vectors.

use crate::banded::Banded;
use crate::number::Plain;

/// Two rows of two.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Block<T>(pub [[T; 2]; 2]);

impl<T: Plain> Block<T> {
    /// `a bᵀ`.
    #[inline(always)]
    pub fn outer(a: [T; 2], b: [T; 2]) -> Self {
        Self([[a[0] * b[0], a[0] * b[1]], [a[1] * b[0], a[1] * b[1]]])
    }

    #[inline(always)]
    pub fn add(&mut self, other: Self) {
        for k in 0..2 {
            for l in 0..2 {
                self.0[k][l] += other.0[k][l];
            }
        }
    }

    #[inline(always)]
    pub fn subtract(&mut self, other: Self) {
        for k in 0..2 {
            for l in 0..2 {
                self.0[k][l] -= other.0[k][l];
            }
        }
    }

    #[inline(always)]
    pub fn times(mut self, scale: T) -> Self {
        for k in 0..2 {
            for l in 0..2 {
                self.0[k][l] = self.0[k][l] * scale;
            }
        }
        self
    }

    #[inline(always)]
    pub fn transpose(self) -> Self {
        let [[a, b], [c, d]] = self.0;
        Self([[a, c], [b, d]])
    }
}

/// Edges that an edge's torque knows: itself and three to each side.
pub(crate) const REACH: usize = 7;
pub(crate) const HALF_REACH: usize = 3;

/// What turning angles and edge lengths do to the moments at the turning angles and to the axial forces:
/// second derivatives of an energy, or the same of a dissipation. A bend's stencil joins three angles, so each
/// moment knows five; an edge's arc joins its length with the angles at its ends.
#[derive(Clone, Debug, Default)]
pub(crate) struct ByTurns<T = f64> {
    /// Moments by angles: entry `k` of row `i` is that by angle `i + k − 2`.
    pub angles: Vec<[T; 5]>,
    /// Moments by the lengths of the edges before and after.
    angle_by_length: Vec<[T; 2]>,
    /// Axial forces by the angles at both ends.
    length_by_angle: Vec<[T; 2]>,
    /// Axial forces by the edge's own length.
    pub lengths: Vec<T>,
}

impl<T: Plain> ByTurns<T> {
    pub fn new(edges: usize) -> Self {
        Self {
            angles: vec![[T::default(); 5]; edges + 1],
            angle_by_length: vec![[T::default(); 2]; edges + 1],
            length_by_angle: vec![[T::default(); 2]; edges],
            lengths: vec![T::default(); edges],
        }
    }

    pub fn clear(&mut self) {
        self.angles.fill([T::default(); 5]);
        self.angle_by_length.fill([T::default(); 2]);
    }

    /// Adds a matrix of the three angles from `first` on.
    #[inline(always)]
    pub fn add_angles(&mut self, first: usize, entries: &[[T; 3]; 3]) {
        for k in 0..3 {
            for l in 0..3 {
                self.angles[first + k][l + 2 - k] += entries[k][l];
            }
        }
    }

    /// Adds a matrix of the angles at both ends of an edge and of its length.
    #[inline(always)]
    pub fn add_edge(&mut self, j: usize, entries: &[[T; 3]; 3]) {
        for k in 0..2 {
            for l in 0..2 {
                self.angles[j + k][l + 2 - k] += entries[k][l];
            }
            self.angle_by_length[j + k][1 - k] += entries[k][2];
            self.length_by_angle[j][k] = entries[2][k];
        }
        self.lengths[j] = entries[2][2];
    }

    /// Torque on edge `j`, the end body for the last, by the angles of the edges from `j − 3` to `j + 3`.
    #[inline(always)]
    pub fn turn_by_turns(&self, j: usize) -> [T; REACH] {
        let mut by_bends = [T::default(); REACH + 1];
        for (sum, entry) in by_bends[1..].iter_mut().zip(&self.angles[j]) {
            *sum += *entry;
        }
        if let Some(next) = self.angles.get(j + 1) {
            for (sum, entry) in by_bends[2..].iter_mut().zip(next) {
                *sum -= *entry;
            }
        }
        let mut by_turns = [T::default(); REACH];
        for k in 0..REACH {
            by_turns[k] = by_bends[k] - by_bends[k + 1];
        }
        by_turns
    }

    /// Torque on edge `j`, the end body for the last, by the lengths of the edges from `j − 1` to `j + 1`.
    #[inline(always)]
    pub fn turn_by_lengths(&self, j: usize) -> [T; 3] {
        let [before, own] = self.angle_by_length[j];
        let [next_before, next] = self.angle_by_length.get(j + 1).copied().unwrap_or_default();
        [before, own - next_before, -next]
    }

    /// Axial force in edge `j` by the angles of the edges from `j − 1` to `j + 1`.
    #[inline(always)]
    pub fn length_by_turns(&self, j: usize) -> [T; 3] {
        let [before, after] = self.length_by_angle[j];
        [-before, before - after, after]
    }
}

/// An edge's row of a matrix over edge vectors, the blocks from `j − 3` to `j + 3`.
pub(crate) type EdgeRow<T> = [Block<T>; REACH];

/// A matrix over edge vectors, given row by row.
pub(crate) trait EdgeRows<T> {
    /// Writes the row of an edge.
    fn write(&self, j: usize, row: &mut EdgeRow<T>);
}

/// Overwrites a matrix over coordinates by one over edge vectors: `e = x[j+1] − x[j]`,
/// so that each block of two nodes joins up to four of two edges. The angle's row becomes zero.
#[inline(always)]
pub(crate) fn place_edges<T: Plain>(matrix: &mut Banded<T>, n: usize, rows: &impl EdgeRows<T>) {
    let zero = T::default();
    // Those of the edges before and after a node.
    let mut edges = [[Block::<T>::default(); REACH]; 2];
    for i in 0..=n {
        if i < n {
            rows.write(i, &mut edges[i % 2]);
        } else {
            edges[i % 2].fill(Block::default());
        }
        if i == 0 {
            continue;
        }
        let (inner, outer) = (&edges[(i + 1) % 2], &edges[i % 2]);
        for k in 0..2 {
            let band = matrix.row_mut(2 * i - 2 + k);
            band.fill(zero);
            for l in 0..2 {
                // The row of the node over edges from `i − 4` to `i + 3`, then over nodes from `i − 4` to `i + 4`.
                let mut over_edges = [zero; REACH + 1];
                for at in 0..REACH {
                    over_edges[at] = inner[at].0[k][l];
                }
                for at in 0..REACH {
                    over_edges[at + 1] -= outer[at].0[k][l];
                }
                for at in 0..REACH + 2 {
                    // Node 0 is clamped.
                    if i + at >= HALF_REACH + 2 {
                        let end = if at > 0 { over_edges[at - 1] } else { zero };
                        let start = if at <= REACH { over_edges[at] } else { zero };
                        band[2 * at + l + 2 - k] = end - start;
                    }
                }
            }
        }
    }
    matrix.row_mut(2 * n).fill(zero);
}

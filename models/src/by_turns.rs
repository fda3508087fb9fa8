//! Derivatives of moments and axial forces by turning angles and edge lengths, and rows of a matrix by edge vectors.

use nalgebra::Matrix2;

use crate::banded::Banded;

pub(crate) type Block = Matrix2<f64>;

/// Edges that an edge's torque knows: itself and three to each side.
pub(crate) const REACH: usize = 7;
pub(crate) const HALF_REACH: usize = 3;

/// What turning angles and edge lengths do to the moments at the turning angles and to the axial forces:
/// second derivatives of an energy, or the same of a dissipation. A bend's stencil joins three angles, so each
/// moment knows five; an edge's arc joins its length with the angles at its ends.
#[derive(Clone, Debug, Default)]
pub(crate) struct ByTurns {
    /// Moments by angles: entry `k` of row `i` is that by angle `i + k − 2`.
    pub angles: Vec<[f64; 5]>,
    /// Moments by the lengths of the edges before and after.
    angle_by_length: Vec<[f64; 2]>,
    /// Axial forces by the angles at both ends.
    length_by_angle: Vec<[f64; 2]>,
    /// Axial forces by the edge's own length.
    pub lengths: Vec<f64>,
}

impl ByTurns {
    pub fn new(edges: usize) -> Self {
        Self {
            angles: vec![[0.0; 5]; edges + 1],
            angle_by_length: vec![[0.0; 2]; edges + 1],
            length_by_angle: vec![[0.0; 2]; edges],
            lengths: vec![0.0; edges],
        }
    }

    pub fn clear(&mut self) {
        self.angles.fill([0.0; 5]);
        self.angle_by_length.fill([0.0; 2]);
    }

    /// Adds a matrix of the three angles from `first` on.
    #[inline]
    pub fn add_angles(&mut self, first: usize, entry: impl Fn(usize, usize) -> f64) {
        for k in 0..3 {
            for l in 0..3 {
                self.angles[first + k][l + 2 - k] += entry(k, l);
            }
        }
    }

    /// Adds a matrix of the angles at both ends of an edge and of its length.
    #[inline]
    pub fn add_edge(&mut self, j: usize, entry: impl Fn(usize, usize) -> f64) {
        for k in 0..2 {
            for l in 0..2 {
                self.angles[j + k][l + 2 - k] += entry(k, l);
            }
            self.angle_by_length[j + k][1 - k] += entry(k, 2);
            self.length_by_angle[j][k] = entry(2, k);
        }
        self.lengths[j] = entry(2, 2);
    }

    /// Torque on edge `j`, the end body for the last, by the angles of the edges from `j − 3` to `j + 3`.
    #[inline]
    pub fn turn_by_turns(&self, j: usize) -> [f64; REACH] {
        let mut by_bends = [0.0; REACH + 1];
        for (sum, entry) in by_bends[1..].iter_mut().zip(&self.angles[j]) {
            *sum += entry;
        }
        if let Some(next) = self.angles.get(j + 1) {
            for (sum, entry) in by_bends[2..].iter_mut().zip(next) {
                *sum -= entry;
            }
        }
        std::array::from_fn(|k| by_bends[k] - by_bends[k + 1])
    }

    /// Torque on edge `j`, the end body for the last, by the lengths of the edges from `j − 1` to `j + 1`.
    #[inline]
    pub fn turn_by_lengths(&self, j: usize) -> [f64; 3] {
        let [before, own] = self.angle_by_length[j];
        let [next_before, next] = self.angle_by_length.get(j + 1).copied().unwrap_or_default();
        [before, own - next_before, -next]
    }

    /// Axial force in edge `j` by the angles of the edges from `j − 1` to `j + 1`.
    #[inline]
    pub fn length_by_turns(&self, j: usize) -> [f64; 3] {
        let [before, after] = self.length_by_angle[j];
        [-before, before - after, after]
    }
}

/// An edge's row of a matrix over edge vectors, the blocks from `j − 3` to `j + 3`.
pub(crate) type EdgeRow = [Block; REACH];

/// Overwrites a matrix over coordinates by one over edge vectors, given row by row: `e = x[j+1] − x[j]`,
/// so that each block of two nodes joins up to four of two edges. The angle's row becomes zero.
pub(crate) fn place_edges(matrix: &mut Banded, n: usize, row: impl Fn(usize) -> EdgeRow) {
    let mut inner = row(0);
    for i in 1..=n {
        let outer = if i < n { row(i) } else { EdgeRow::default() };
        // The row of the node over edges from `i − 4` to `i + 3`, then over nodes from `i − 4` to `i + 4`.
        let mut over_edges = [Block::zeros(); REACH + 1];
        over_edges[..REACH].copy_from_slice(&inner);
        for (block, outer) in over_edges[1..].iter_mut().zip(&outer) {
            *block -= outer;
        }
        let over_nodes = |at: usize| {
            // Node 0 is clamped.
            if i + at < HALF_REACH + 2 {
                return Block::zeros();
            }
            let end = if at > 0 { over_edges[at - 1] } else { Block::zeros() };
            let start = if at <= REACH { over_edges[at] } else { Block::zeros() };
            end - start
        };
        let blocks: [Block; REACH + 2] = std::array::from_fn(over_nodes);
        for k in 0..2 {
            let entries = std::array::from_fn(|at| blocks[at / 2][(k, at % 2)]);
            matrix.set_row::<{ 2 * (REACH + 2) }>(2 * i - 2 + k, 2 - k, entries);
        }
        inner = outer;
    }
    matrix.set_row(2 * n, 0, []);
}

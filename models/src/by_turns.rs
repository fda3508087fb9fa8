//! What turning angles and edge lengths do to moments and axial forces, and that by edges.

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

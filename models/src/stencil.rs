//! From turning angles to curvatures: the stencil of the bends.
//!
//! Nodes lie on the rod's curve, an edge is a chord of it. The angle between two chords then holds the curvature
//! averaged over both with a hat for its weight, `φ_i = ℓ κ_i + ℓ³ κ''_i / 12 + …`, and a chord is shorter than
//! its arc by `ℓ³ κ² / 24`. A rod whose curvature is `φ/ℓ` and whose stretch is that of the chord therefore has
//! errors of second order. Both are taken back here, by the two nearest bends and no more:
//!
//! ```text
//! κ_i = (−φ_{i−1} + 14 φ_i − φ_{i+1}) / (12 ℓ),        1 + stretch_j = |e_j| (1 + (φ_j² + φ_{j+1}²)/48) / ℓ
//! ```
//!
//! The moments act on the turning angles through the transpose, so that forces stay the gradient of the energy.
//! At an end the first angle spans half a cell. Four numbers of its stencil, the place `x ℓ` of the first bend
//! and the lengths that the first two represent follow from four demands each: curvature linear in arc length is
//! recovered, a linear bending moment is balanced, and the sum over bends integrates parabolas exactly:
//!
//! ```text
//! κ_0 (25/48) ℓ = 5/4 φ_0 − 5/48 φ_1                at s = ℓ/5
//! κ_1 (47/48) ℓ = −1/4 φ_0 + 19/16 φ_1 − 1/12 φ_2   at s = ℓ
//! ```
//!
//! The turning angle itself is taken by a quotient that needs no trigonometric function, `φ (1 + O(φ⁶))`, and that
//! grows without bound towards a fold: with `h = tan(φ/2)`, `φ ≈ 2h (15 + 4h²) / (15 + 9h²)` (Padé's for atan).
//!
//! The paper's rod is the other scheme: `κ_i = 2 tan(φ_i/2)`, a whole Voronoi length at the root, chords for arcs
//! (Garbulinski and Wereley 2022, eq. 4 and 5). It is of first order in the edge length.

use crate::number::Number;
use crate::pack::{Pack, RODS};

/// How the continuous rod is made discrete, see [this page](self).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scheme {
    /// Curvatures from three turning angles, arcs over chords, and half a cell at each end: ours.
    #[default]
    Consistent,
    /// The paper's: curvature `2 tan(φ/2)`, a whole Voronoi length at the root, as a ghost edge behind the
    /// wall gives, and chords. First order in the edge length.
    ///
    /// The bending stiffnesses of its Table 2 belong to this scheme, with 32 nodes, the resting mass per
    /// length and a rod that hardly stretches: the Euler column then follows from the PDER column
    /// to within 0.3 to 6.1 % (median 3.0 %), against 6 to 15 % with the consistent scheme. The bend at the end
    /// fitting keeps half a Voronoi length, which the tables do not distinguish from a whole one or from none:
    /// the difference is 0.03 % of EI.
    Paper,
}

/// The stencil of one rod, with the clamp's compliance in its first rows.
///
/// A compliant clamp is in series with the rod: of the turning angle at the root it takes
/// `compliance · m`, where `m` is the elastic moment that the rest of that angle causes. The split is
/// kept for every other moment of the root.
#[derive(Clone, Debug)]
pub struct Stencil<T> {
    scheme: Scheme,
    edges: usize,
    /// Rows of the first two bends, for the first three angles.
    root: [[T; 3]; 2],
    /// Moment of the clamp over the first three angles, N m.
    clamp: [T; 3],
    /// Compliance of the clamp, rad/(N m).
    compliance: T,
}

/// Rows of the first two bends for a stiff clamp; those of the last two mirror them.
const END: [[f64; 3]; 2] = [[5.0 / 4.0, -5.0 / 48.0, 0.0], [-1.0 / 4.0, 19.0 / 16.0, -1.0 / 12.0]];
const INNER: [f64; 3] = [-1.0 / 12.0, 7.0 / 6.0, -1.0 / 12.0];
const END_WEIGHTS: [f64; 2] = [25.0 / 48.0, 47.0 / 48.0];
const ALONE: [f64; 3] = [0.0, 1.0, 0.0];
/// Place of the first bend, in edge lengths from the clamp.
const FIRST: f64 = 0.2;
/// Distance of the centre of mass of the last half cell before the last node, in edge lengths: with it the
/// masses of the nodes integrate parabolas exactly.
const LAST_HALF_CELL: f64 = 1.0 / 6.0;

impl<T: Number> Stencil<T> {
    /// The stencil for a clamp that does not give.
    pub(crate) fn new(scheme: Scheme, edges: usize) -> Self {
        let root = match scheme {
            Scheme::Consistent => END,
            Scheme::Paper => [[1.0, 0.0, 0.0], ALONE],
        };
        let zero = T::from(0.0);
        let root = root.map(|row| row.map(T::from));
        Self { scheme, edges, root, clamp: [zero; 3], compliance: zero }
    }

    /// Puts the clamp in series with a root of bending stiffness `stiffness`, N m², and edges of `rest_length`, m.
    pub(crate) fn set_clamp(&mut self, compliance: T, stiffness: T, rest_length: T) {
        let stiff = Self::new(self.scheme, self.edges);
        let per_length = stiffness / rest_length;
        // Elastic moment at the root over the first three angles, the clamp held.
        let moment = [0, 1, 2].map(|k| {
            let by_row = |i: usize| stiff.root[i][0] * stiff.root[i][k] / self.weight(i);
            (by_row(0) + by_row(1)) * per_length
        });
        let share = (compliance * moment[0] + 1.0).recip();
        self.clamp = moment.map(|moment| moment * share);
        self.compliance = compliance;
        self.root = stiff.root.map(|row| [0, 1, 2].map(|k| row[k] - row[0] * compliance * self.clamp[k]));
    }

    /// Length of rod that a bend represents, over the edge length.
    #[inline(always)]
    pub fn weight(&self, bend: usize) -> f64 {
        let from_end = bend.min(self.edges - bend);
        match self.scheme {
            Scheme::Consistent => END_WEIGHTS.get(from_end).copied().unwrap_or(1.0),
            Scheme::Paper => {
                if bend == self.edges {
                    0.5
                } else {
                    1.0
                }
            }
        }
    }

    /// Place of a bend along the rod, from 0 at the clamp to 1 at the end fitting.
    pub fn position(&self, bend: usize) -> f64 {
        let at = match (self.scheme, bend) {
            (Scheme::Consistent, 0) => FIRST,
            (Scheme::Consistent, bend) if bend == self.edges => bend as f64 - FIRST,
            (_, bend) => bend as f64,
        };
        at / self.edges as f64
    }

    /// How far before the last node the last half cell has its centre of mass, in edge lengths.
    pub(crate) fn last_half_cell(&self) -> f64 {
        match self.scheme {
            Scheme::Consistent => LAST_HALF_CELL,
            Scheme::Paper => 0.0,
        }
    }

    /// First angle of a bend's row.
    #[inline(always)]
    pub(crate) fn first(&self, bend: usize) -> usize {
        bend.saturating_sub(1).min(self.edges - 2)
    }

    /// A bend's row: what the three angles from [`first`](Self::first) on count.
    #[inline(always)]
    pub(crate) fn row(&self, bend: usize) -> [T; 3] {
        match (bend, self.scheme) {
            (0 | 1, _) => self.root[bend],
            (bend, Scheme::Consistent) => {
                let row = match self.edges - bend {
                    0 => mirrored(END[0]),
                    1 => mirrored(END[1]),
                    _ => INNER,
                };
                row.map(T::from)
            }
            (bend, Scheme::Paper) => if bend == self.edges { [0.0, 0.0, 1.0] } else { ALONE }.map(T::from),
        }
    }

    /// Integrated curvatures from turning angles, or their rates, shape `[N+1]` each.
    #[inline(always)]
    pub(crate) fn curvatures(&self, angles: &[T], curvatures: &mut [T]) {
        for (i, curvature) in curvatures.iter_mut().enumerate() {
            let first = self.first(i);
            let row = self.row(i);
            *curvature = angles[first] * row[0] + angles[first + 1] * row[1] + angles[first + 2] * row[2];
        }
    }

    /// Moments at the turning angles from those of the bends, shape `[N+1]` each: the transpose.
    #[inline(always)]
    pub(crate) fn moments(&self, of_bends: &[T], moments: &mut [T]) {
        moments.fill(T::from(0.0));
        for (i, of_bend) in of_bends.iter().enumerate() {
            let first = self.first(i);
            for (moment, weight) in moments[first..].iter_mut().zip(self.row(i)) {
                *moment += *of_bend * weight;
            }
        }
    }

    /// Adds what the clamp adds to the moments at the turning angles.
    #[inline(always)]
    pub(crate) fn add_clamp(&self, angles: &[T], moments: &mut [T]) {
        let turn = self.compliance * self.clamp_moment(angles);
        for (moment, weight) in moments.iter_mut().zip(self.clamp) {
            *moment += turn * weight;
        }
    }

    /// Energy that the clamp stores, J.
    pub(crate) fn clamp_energy(&self, angles: &[T]) -> T {
        let moment = self.clamp_moment(angles);
        self.compliance * moment * moment * 0.5
    }

    /// Second derivative of that energy by the first three angles, N m.
    #[inline(always)]
    pub(crate) fn clamp_stiffness(&self) -> [[T; 3]; 3] {
        self.clamp.map(|a| self.clamp.map(|b| self.compliance * a * b))
    }

    /// Moment at the clamp, N m.
    #[inline(always)]
    fn clamp_moment(&self, angles: &[T]) -> T {
        angles[0] * self.clamp[0] + angles[1] * self.clamp[1] + angles[2] * self.clamp[2]
    }

    /// What the squares of the angles at both ends of an edge count in its arc, `1 + Σ w φ²`. The angles at the
    /// ends of the rod hold half a cell, and at the root the clamp's turn, so their neighbours replace them.
    #[inline(always)]
    pub(crate) fn arc(&self, edge: usize) -> [f64; 2] {
        match self.scheme {
            Scheme::Consistent if edge == 0 => [0.0, 1.0 / 24.0],
            Scheme::Consistent if edge + 1 == self.edges => [1.0 / 24.0, 0.0],
            Scheme::Consistent => [1.0 / 48.0; 2],
            Scheme::Paper => [0.0; 2],
        }
    }

    /// Turning angle as the scheme takes it, and its derivative by the turning angle, from `h = tan(φ/2)`.
    #[inline(always)]
    pub(crate) fn angle(&self, h: T) -> (T, T) {
        let square = h * h;
        match self.scheme {
            Scheme::Consistent => {
                let per = (square * 3.0 + 5.0).recip();
                let slope = square * square * square * per * per * 4.0 + 1.0;
                (h * (square * (8.0 / 3.0) + 10.0) * per, slope)
            }
            Scheme::Paper => (h * 2.0, square + 1.0),
        }
    }

    /// Its second derivative by the turning angle.
    #[inline(always)]
    pub(crate) fn angle_curve(&self, h: T) -> T {
        let square = h * h;
        match self.scheme {
            Scheme::Consistent => {
                let per = (square * 3.0 + 5.0).recip();
                square * square * (square + 5.0) * h * (square + 1.0) * per * per * per * 12.0
            }
            Scheme::Paper => h * (square + 1.0),
        }
    }
}

impl Stencil<Pack> {
    /// Those of several rods with equal meshes.
    pub(crate) fn of(rods: [&Stencil<f64>; RODS]) -> Self {
        let each = |of: &dyn Fn(&Stencil<f64>) -> f64| Pack(rods.map(of));
        Self {
            scheme: rods[0].scheme,
            edges: rods[0].edges,
            root: [0, 1].map(|row| [0, 1, 2].map(|k| each(&|rod| rod.root[row][k]))),
            clamp: [0, 1, 2].map(|k| each(&|rod| rod.clamp[k])),
            compliance: each(&|rod| rod.compliance),
        }
    }
}

fn mirrored([a, b, c]: [f64; 3]) -> [f64; 3] {
    [c, b, a]
}

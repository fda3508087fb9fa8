//! Square matrices with a narrow band, and their factors.

use std::ops::{Index, IndexMut};

use crate::number::Plain;
use crate::pack::{Pack, RODS};

/// Entries to each side of the diagonal. A bend's stencil joins five nodes, and the tangent nodes that are four
/// apart, nine coordinates; the end body has three, hence one more.
pub const HALF_BANDWIDTH: usize = 10;
const WIDTH: usize = 2 * HALF_BANDWIDTH + 1;

/// A square matrix whose entries lie within [`HALF_BANDWIDTH`] of the diagonal.
#[derive(Clone, Debug, Default)]
pub struct Banded<T = f64> {
    rows: Vec<[T; WIDTH]>,
}

impl<T: Plain> Banded<T> {
    /// Zero, of `n` rows.
    pub fn zeros(n: usize) -> Self {
        Self { rows: vec![[T::default(); WIDTH]; n] }
    }

    /// Number of rows.
    pub fn dim(&self) -> usize {
        self.rows.len()
    }

    /// Sets every entry to zero.
    pub fn clear(&mut self) {
        self.rows.fill([T::default(); WIDTH]);
    }

    /// The entry, zero outside the band.
    pub fn get(&self, row: usize, column: usize) -> T {
        if row.abs_diff(column) > HALF_BANDWIDTH { T::default() } else { self[(row, column)] }
    }

    /// A row's entries, of the whole band.
    #[inline(always)]
    pub(crate) fn row_mut(&mut self, row: usize) -> &mut [T; WIDTH] {
        &mut self.rows[row]
    }

    /// `self = a² diag + a damping + stiffness`, the matrix of an implicit step.
    #[inline(always)]
    pub fn combine(&mut self, a: T, diagonal: &[T], damping: &Banded<T>, stiffness: &Banded<T>) {
        for (i, row) in self.rows.iter_mut().enumerate() {
            let (damping, stiffness) = (&damping.rows[i], &stiffness.rows[i]);
            for k in 0..WIDTH {
                row[k] = a * damping[k] + stiffness[k];
            }
            row[HALF_BANDWIDTH] += a * a * diagonal[i];
        }
    }

    /// Adds `scale · diagonal`.
    #[inline(always)]
    pub fn add_diagonal(&mut self, scale: T, diagonal: &[T]) {
        for (row, d) in self.rows.iter_mut().zip(diagonal) {
            row[HALF_BANDWIDTH] += scale * *d;
        }
    }

    /// Factors in place without pivoting: `L` below the diagonal, `U` on and above it. The matrices
    /// of implicit steps are dominated by mass and stiffness; near a singular one a pivot
    /// collapses. `check` sees the row, its pivot and its largest entry, and ends the work by `false`.
    #[inline(always)]
    pub(crate) fn eliminate(&mut self, mut check: impl FnMut(usize, T, T) -> bool) {
        let n = self.dim();
        for k in 0..n {
            let (head, tail) = self.rows.split_at_mut(k + 1);
            let pivot_row = &mut head[k];
            let pivot = pivot_row[HALF_BANDWIDTH];
            let size = |m: T, a: &T| m.max(a.map(f64::abs));
            let largest = pivot_row[HALF_BANDWIDTH..].iter().fold(T::default(), size);
            if !check(k, pivot, largest) {
                return;
            }
            let per_pivot = pivot.recip();
            let upper: [T; HALF_BANDWIDTH] = std::array::from_fn(|c| pivot_row[HALF_BANDWIDTH + 1 + c]);
            pivot_row[HALF_BANDWIDTH] = per_pivot;
            for (r, row) in tail.iter_mut().take(HALF_BANDWIDTH).enumerate() {
                let at = HALF_BANDWIDTH - 1 - r;
                let factor = row[at] * per_pivot;
                row[at] = factor;
                for (entry, u) in row[at + 1..at + 1 + HALF_BANDWIDTH].iter_mut().zip(&upper) {
                    *entry -= factor * *u;
                }
            }
        }
    }

    /// Solves with the factors of [`factorize`](Self::factorize), in place.
    #[inline(always)]
    pub fn solve(&self, x: &mut [T]) {
        // Each row waits for the one before: the window stays in registers, and its newest value is
        // taken last. Outside the matrix both the window and the rows are zero.
        let mut window = [T::default(); HALF_BANDWIDTH];
        for (x, row) in x.iter_mut().zip(&self.rows) {
            for k in 0..HALF_BANDWIDTH {
                *x -= row[k] * window[k];
            }
            window = std::array::from_fn(|k| if k + 1 < HALF_BANDWIDTH { window[k + 1] } else { *x });
        }
        window.fill(T::default());
        for (x, row) in x.iter_mut().zip(&self.rows).rev() {
            for k in (0..HALF_BANDWIDTH).rev() {
                *x -= row[HALF_BANDWIDTH + 1 + k] * window[k];
            }
            *x = *x * row[HALF_BANDWIDTH];
            window = std::array::from_fn(|k| if k > 0 { window[k - 1] } else { *x });
        }
    }

    /// Solves for `P` right-hand sides at once, which costs little more than one.
    pub fn solve_many<const P: usize>(&self, x: &mut [[T; P]]) {
        for (i, row) in self.rows.iter().enumerate() {
            let (done, rest) = x.split_at_mut(i);
            let below = &row[..HALF_BANDWIDTH];
            match done.last_chunk::<HALF_BANDWIDTH>() {
                Some(done) => subtract_product(&mut rest[0], below, done),
                None => subtract_product(&mut rest[0], &below[HALF_BANDWIDTH - i..], done),
            }
        }
        for (i, row) in self.rows.iter().enumerate().rev() {
            let (rest, done) = x.split_at_mut(i + 1);
            let above = &row[HALF_BANDWIDTH + 1..];
            match done.first_chunk::<HALF_BANDWIDTH>() {
                Some(done) => subtract_product(&mut rest[i], above, done),
                None => subtract_product(&mut rest[i], above, done),
            }
            rest[i] = rest[i].map(|x| x * row[HALF_BANDWIDTH]);
        }
    }

    /// `y += self · x`, for `P` columns at once.
    #[inline(always)]
    pub fn multiply_add<const P: usize>(&self, x: &[[T; P]], y: &mut [[T; P]]) {
        for (i, (row, y)) in self.rows.iter().zip(y).enumerate() {
            let window = i.checked_sub(HALF_BANDWIDTH).and_then(|first| x[first..].first_chunk::<WIDTH>());
            match window {
                Some(x) => add_row(y, row, x),
                None => {
                    let first = i.saturating_sub(HALF_BANDWIDTH);
                    add_product(y, &row[first + HALF_BANDWIDTH - i..], &x[first..]);
                }
            }
        }
    }
}

impl Banded {
    /// Factors in place without pivoting: `L` below the diagonal, `U` on and above it.
    /// # Errors
    /// [`Singular`] with the row whose pivot is not finite or vanishes against the row.
    pub fn factorize(&mut self) -> Result<(), Singular> {
        let mut done = Ok(());
        self.eliminate(|row, pivot, largest| {
            if vanishes(pivot, largest) {
                done = Err(Singular { row });
            }
            done.is_ok()
        });
        done
    }

    /// Number of negative pivots of the factors: of a symmetric matrix, that of its negative
    /// eigenvalues (Sylvester).
    pub fn negative_pivots(&self) -> usize {
        self.rows.iter().filter(|row| row[HALF_BANDWIDTH] < 0.0).count()
    }
}

impl Banded<Pack> {
    /// Factors in place; for each rod whether its matrix is regular.
    #[inline(always)]
    pub(crate) fn factorize_all(&mut self) -> [bool; RODS] {
        let mut is_regular = [true; RODS];
        self.eliminate(|_, pivot, largest| {
            for (rod, is_regular) in is_regular.iter_mut().enumerate() {
                *is_regular &= !vanishes(pivot[rod], largest[rod]);
            }
            true
        });
        is_regular
    }
}

/// Whether a pivot is none, against the largest entry of its row.
#[inline(always)]
fn vanishes(pivot: f64, largest: f64) -> bool {
    !pivot.is_finite() || pivot.abs() <= 1e-14 * largest || pivot == 0.0
}

/// `sum += Σ row x` over a whole row. Four sums side by side, so that an addition need not wait for the
/// one before; with places known when compiled they stay in registers.
#[inline(always)]
fn add_row<T: Plain, const P: usize>(sum: &mut [T; P], row: &[T; WIDTH], x: &[[T; P]; WIDTH]) {
    const PARTS: usize = 4;
    for p in 0..P {
        let mut parts = [T::default(); PARTS];
        for first in (0..WIDTH - 1).step_by(PARTS) {
            for (part, k) in parts.iter_mut().zip(first..) {
                *part += row[k] * x[k][p];
            }
        }
        sum[p] += (parts[0] + parts[1]) + (parts[2] + parts[3]) + row[WIDTH - 1] * x[WIDTH - 1][p];
    }
}

/// `sum += Σ row x`, as far as both go.
#[inline(always)]
fn add_product<T: Plain, const P: usize>(sum: &mut [T; P], row: &[T], x: &[[T; P]]) {
    for (a, x) in row.iter().zip(x) {
        for p in 0..P {
            sum[p] += *a * x[p];
        }
    }
}

/// `sum −= Σ row x`, as far as both go; inlined, so that the length of a window is known.
#[inline(always)]
fn subtract_product<T: Plain, const P: usize>(sum: &mut [T; P], row: &[T], x: &[[T; P]]) {
    let mut own = *sum;
    for (a, x) in row.iter().zip(x) {
        for p in 0..P {
            own[p] -= *a * x[p];
        }
    }
    *sum = own;
}

impl<T> Index<(usize, usize)> for Banded<T> {
    type Output = T;

    fn index(&self, (row, column): (usize, usize)) -> &T {
        &self.rows[row][column + HALF_BANDWIDTH - row]
    }
}

impl<T> IndexMut<(usize, usize)> for Banded<T> {
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut T {
        &mut self.rows[row][column + HALF_BANDWIDTH - row]
    }
}

/// A pivot vanished.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is singular at row {row}")]
pub struct Singular {
    /// The row.
    pub row: usize,
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    fn sample(n: usize) -> Banded {
        let mut a = Banded::zeros(n);
        for i in 0..n {
            for j in i.saturating_sub(HALF_BANDWIDTH)..(i + HALF_BANDWIDTH + 1).min(n) {
                a[(i, j)] = ((i * 7 + j * 13) % 11) as f64 - 5.0 + if i == j { 40.0 } else { 0.0 };
            }
        }
        a
    }

    #[test]
    fn solves_what_a_dense_matrix_solves() {
        let n = 23;
        let a = sample(n);
        let dense = DMatrix::from_fn(n, n, |i, j| a.get(i, j));
        let b: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let expected = dense.clone().lu().solve(&nalgebra::DVector::from_vec(b.clone())).unwrap();
        let mut factors = a.clone();
        factors.factorize().unwrap();
        let mut x = b.clone();
        factors.solve(&mut x);
        let mut many: Vec<[f64; 3]> = b.iter().map(|b| [*b, 2.0 * b, -b]).collect();
        factors.solve_many(&mut many);
        for i in 0..n {
            assert!((x[i] - expected[i]).abs() < 1e-13);
            assert!((many[i][1] - 2.0 * expected[i]).abs() < 1e-13);
        }
        let mut y = vec![[0.0; 3]; n];
        a.multiply_add(&many, &mut y);
        for i in 0..n {
            assert!((y[i][2] + b[i]).abs() < 1e-12);
        }
    }

    #[test]
    fn a_vanishing_pivot_is_reported() {
        let mut a = Banded::zeros(8);
        a[(0, 0)] = 1.0;
        assert_eq!(a.factorize(), Err(Singular { row: 1 }));
    }
}

//! Square matrices with a narrow band, and their factors.

use std::ops::{Index, IndexMut};

/// Entries to each side of the diagonal. A bend's stencil joins five nodes, and the tangent nodes that are four
/// apart, nine coordinates; the end body has three, hence one more.
pub const HALF_BANDWIDTH: usize = 10;
const WIDTH: usize = 2 * HALF_BANDWIDTH + 1;

/// A square matrix whose entries stand within [`HALF_BANDWIDTH`] of the diagonal.
#[derive(Clone, Debug, Default)]
pub struct Banded {
    rows: Vec<[f64; WIDTH]>,
}

impl Banded {
    /// Zero, of `n` rows.
    pub fn zeros(n: usize) -> Self {
        Self { rows: vec![[0.0; WIDTH]; n] }
    }

    /// Number of rows.
    pub fn dim(&self) -> usize {
        self.rows.len()
    }

    /// Sets every entry to zero.
    pub fn clear(&mut self) {
        self.rows.fill([0.0; WIDTH]);
    }

    /// The entry, zero outside the band.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        if row.abs_diff(column) > HALF_BANDWIDTH { 0.0 } else { self[(row, column)] }
    }

    /// Overwrites a row: `entries` from the `start`-th of the band on, zero elsewhere.
    pub(crate) fn set_row<const P: usize>(&mut self, row: usize, start: usize, entries: [f64; P]) {
        let band = &mut self.rows[row];
        *band = [0.0; WIDTH];
        band[start..start + P].copy_from_slice(&entries);
    }

    /// `self = a² diag + a damping + stiffness`, the matrix of an implicit step.
    pub fn combine(&mut self, a: f64, diagonal: &[f64], damping: &Banded, stiffness: &Banded) {
        for (i, row) in self.rows.iter_mut().enumerate() {
            for (k, entry) in row.iter_mut().enumerate() {
                *entry = a * damping.rows[i][k] + stiffness.rows[i][k];
            }
            row[HALF_BANDWIDTH] += a * a * diagonal[i];
        }
    }

    /// Adds `scale · diagonal`.
    pub fn add_diagonal(&mut self, scale: f64, diagonal: &[f64]) {
        for (row, d) in self.rows.iter_mut().zip(diagonal) {
            row[HALF_BANDWIDTH] += scale * d;
        }
    }

    /// Factors in place without pivoting: `L` below the diagonal, `U` on and above it. The matrices
    /// of implicit steps are dominated by mass and stiffness; near a singular one a pivot
    /// collapses, which is reported.
    /// # Errors
    /// [`Singular`] with the row whose pivot is not finite or vanishes against the row.
    pub fn factorize(&mut self) -> Result<(), Singular> {
        let n = self.dim();
        for k in 0..n {
            let (head, tail) = self.rows.split_at_mut(k + 1);
            let pivot_row = &mut head[k];
            let pivot = pivot_row[HALF_BANDWIDTH];
            let largest = pivot_row[HALF_BANDWIDTH..].iter().fold(0.0_f64, |m, a| m.max(a.abs()));
            if !pivot.is_finite() || pivot.abs() <= 1e-14 * largest || pivot == 0.0 {
                return Err(Singular { row: k });
            }
            let per_pivot = 1.0 / pivot;
            let upper: [f64; HALF_BANDWIDTH] = std::array::from_fn(|c| pivot_row[HALF_BANDWIDTH + 1 + c]);
            pivot_row[HALF_BANDWIDTH] = per_pivot;
            for (r, row) in tail.iter_mut().take(HALF_BANDWIDTH).enumerate() {
                let at = HALF_BANDWIDTH - 1 - r;
                let factor = row[at] * per_pivot;
                row[at] = factor;
                for (entry, u) in row[at + 1..at + 1 + HALF_BANDWIDTH].iter_mut().zip(&upper) {
                    *entry -= factor * u;
                }
            }
        }
        Ok(())
    }

    /// Number of negative pivots of the factors: of a symmetric matrix, that of its negative
    /// eigenvalues (Sylvester).
    pub fn negative_pivots(&self) -> usize {
        self.rows.iter().filter(|row| row[HALF_BANDWIDTH] < 0.0).count()
    }

    /// Solves with the factors of [`factorize`](Self::factorize), in place.
    pub fn solve(&self, x: &mut [f64]) {
        // Each row waits for the one before: the window stays in registers, and its newest value is
        // taken last. Outside the matrix both the window and the rows are zero.
        let mut window = [0.0; HALF_BANDWIDTH];
        for (x, row) in x.iter_mut().zip(&self.rows) {
            for k in 0..HALF_BANDWIDTH {
                *x -= row[k] * window[k];
            }
            window = std::array::from_fn(|k| if k + 1 < HALF_BANDWIDTH { window[k + 1] } else { *x });
        }
        window.fill(0.0);
        for (x, row) in x.iter_mut().zip(&self.rows).rev() {
            for k in (0..HALF_BANDWIDTH).rev() {
                *x -= row[HALF_BANDWIDTH + 1 + k] * window[k];
            }
            *x *= row[HALF_BANDWIDTH];
            window = std::array::from_fn(|k| if k > 0 { window[k - 1] } else { *x });
        }
    }

    /// Solves for `P` right-hand sides at once, which costs little more than one.
    pub fn solve_many<const P: usize>(&self, x: &mut [[f64; P]]) {
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
    pub fn multiply_add<const P: usize>(&self, x: &[[f64; P]], y: &mut [[f64; P]]) {
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

/// `sum += Σ row x` over a whole row. Four sums side by side, so that an addition need not wait for the
/// one before; with places known when compiled they stay in registers.
#[inline(always)]
fn add_row<const P: usize>(sum: &mut [f64; P], row: &[f64; WIDTH], x: &[[f64; P]; WIDTH]) {
    const PARTS: usize = 4;
    for p in 0..P {
        let mut parts = [0.0; PARTS];
        for first in (0..WIDTH - 1).step_by(PARTS) {
            for (part, k) in parts.iter_mut().zip(first..) {
                *part += row[k] * x[k][p];
            }
        }
        sum[p] += (parts[0] + parts[1]) + (parts[2] + parts[3]) + row[WIDTH - 1] * x[WIDTH - 1][p];
    }
}

/// `sum += Σ row x`, as far as both go.
fn add_product<const P: usize>(sum: &mut [f64; P], row: &[f64], x: &[[f64; P]]) {
    for (a, x) in row.iter().zip(x) {
        for p in 0..P {
            sum[p] += a * x[p];
        }
    }
}

/// `sum −= Σ row x`, as far as both go; inlined, so that the length of a window is known.
#[inline(always)]
fn subtract_product<const P: usize>(sum: &mut [f64; P], row: &[f64], x: &[[f64; P]]) {
    let mut own = *sum;
    for (a, x) in row.iter().zip(x) {
        for p in 0..P {
            own[p] -= a * x[p];
        }
    }
    *sum = own;
}

impl Index<(usize, usize)> for Banded {
    type Output = f64;

    fn index(&self, (row, column): (usize, usize)) -> &f64 {
        &self.rows[row][column + HALF_BANDWIDTH - row]
    }
}

impl IndexMut<(usize, usize)> for Banded {
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut f64 {
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

//! Band matrices with one product of two vectors beside them: `A = B + u wᵀ`.
//!
//! A law that sees a mean over the whole rod joins every coordinate with every other, but only through
//! that one number. So its tangent is a product of two vectors, and a solution costs one more
//! back-substitution a factorisation and two products a solution (Sherman and Morrison 1950, Ann.
//! Math. Statist. 21, 124):
//!
//! `A⁻¹ r = x − y (w·x)/(1 + w·y)`, with `B x = r` and `B y = u`.

use crate::banded::{Banded, Singular};
use crate::number::Plain;
use crate::pack::{Pack, RODS};

/// A matrix with a narrow band and, where something sees the whole rod, a product of two vectors.
#[derive(Clone, Debug, Default)]
pub struct Coupled<T = f64> {
    /// The band.
    pub band: Banded<T>,
    product: Product<T>,
}

/// `u wᵀ`, and what solves with it.
#[derive(Clone, Debug, Default)]
struct Product<T> {
    /// Whether there is any: then the vectors are as long as the band.
    acts: bool,
    column: Vec<T>,
    row: Vec<T>,
    /// `B⁻¹ u` of the factors.
    answer: Vec<T>,
    /// `1 + w·B⁻¹u`.
    pole: T,
}

/// Share of what it is made of below which `1 + w·B⁻¹u` counts as zero.
const COLLAPSED: f64 = 1e-14;

impl<T: Plain> Coupled<T> {
    /// Zero, of `n` rows.
    pub fn zeros(n: usize) -> Self {
        let zeros = vec![T::default(); n];
        let product =
            Product { column: zeros.clone(), row: zeros.clone(), answer: zeros, ..Product::default() };
        Self { band: Banded::zeros(n), product }
    }

    /// Replaces the product beside the band by `column rowᵀ`.
    pub(crate) fn put_beside(&mut self, write: impl FnOnce(&mut [T], &mut [T])) {
        self.product.acts = true;
        write(&mut self.product.column, &mut self.product.row);
    }

    /// Leaves the band alone.
    pub(crate) fn put_nothing_beside(&mut self) {
        self.product.acts = false;
    }

    /// `self = a² diag + a damping + stiffness`, the matrix of an implicit step.
    #[inline(always)]
    pub fn combine(&mut self, a: T, diagonal: &[T], damping: &Banded<T>, stiffness: &Coupled<T>) {
        self.band.combine(a, diagonal, damping, &stiffness.band);
        self.product.acts = stiffness.product.acts;
        if stiffness.product.acts {
            self.product.column.copy_from_slice(&stiffness.product.column);
            self.product.row.copy_from_slice(&stiffness.product.row);
        }
    }

    /// Solves with the factors of [`factorize`](Self::factorize), in place.
    #[inline(always)]
    pub fn solve(&self, x: &mut [T]) {
        self.band.solve(x);
        self.product.correct(x.as_chunks_mut::<1>().0);
    }

    /// Solves for `P` right-hand sides at once, which costs little more than one.
    pub fn solve_many<const P: usize>(&self, x: &mut [[T; P]]) {
        self.band.solve_many(x);
        self.product.correct(x);
    }

    /// `y += self · x`, for `P` columns at once.
    #[inline(always)]
    pub fn multiply_add<const P: usize>(&self, x: &[[T; P]], y: &mut [[T; P]]) {
        self.band.multiply_add(x, y);
        let Product { acts: true, column, row, .. } = &self.product else { return };
        let along = products(row, x);
        for (y, u) in y.iter_mut().zip(column) {
            for p in 0..P {
                y[p] += *u * along[p];
            }
        }
    }
}

impl Coupled {
    /// Factors in place, see [`Banded::factorize`].
    /// # Errors
    /// [`Singular`] with the row where a pivot of the band vanishes, or the last where the whole does.
    pub fn factorize(&mut self) -> Result<(), Singular> {
        self.band.factorize()?;
        let Product { acts: true, column, row, answer, pole } = &mut self.product else { return Ok(()) };
        answer.copy_from_slice(column);
        self.band.solve(answer);
        let size: f64 = row.iter().zip(&*answer).map(|(w, y)| (w * y).abs()).sum();
        *pole = 1.0 + product(row, answer);
        if collapses(*pole, size) {
            return Err(Singular { row: self.band.dim() - 1 });
        }
        Ok(())
    }

    /// Whether a symmetric matrix of these factors is positive definite. An added product can lift one
    /// eigenvalue above zero, a subtracted one can lower one. The sign of the determinant, `det A = det B (1
    /// + w·B⁻¹u)`, shows whether it did.
    pub fn is_positive(&self) -> bool {
        let negative = self.band.negative_pivots();
        let Product { acts: true, column, row, pole, .. } = &self.product else { return negative == 0 };
        match (*pole > 0.0, product(column, row) > 0.0) {
            (true, _) => negative == 0,
            (false, is_added) => is_added && negative == 1,
        }
    }
}

impl Coupled<Pack> {
    /// Factors in place; for each rod whether its matrix is regular.
    #[inline(always)]
    pub(crate) fn factorize_all(&mut self) -> [bool; RODS] {
        let mut is_regular = self.band.factorize_all();
        let Product { acts: true, column, row, answer, pole } = &mut self.product else { return is_regular };
        answer.copy_from_slice(column);
        self.band.solve(answer);
        let sizes = row.iter().zip(&*answer).map(|(w, y)| (*w * *y).map(f64::abs));
        let size = sizes.fold(Pack::default(), |sum, size| sum + size);
        *pole = product(row, answer) + 1.0;
        for (rod, is_regular) in is_regular.iter_mut().enumerate() {
            *is_regular &= !collapses(pole[rod], size[rod]);
        }
        is_regular
    }
}

/// Whether `1 + w·B⁻¹u` is zero, against the size of what it is made of.
fn collapses(pole: f64, size: f64) -> bool {
    !pole.is_finite() || pole.abs() <= COLLAPSED * (1.0 + size)
}

impl<T: Plain> Product<T> {
    /// From solutions with the band to those with the whole.
    #[inline(always)]
    fn correct<const P: usize>(&self, x: &mut [[T; P]]) {
        if !self.acts {
            return;
        }
        let along = products(&self.row, x).map(|along| along / self.pole);
        for (x, y) in x.iter_mut().zip(&self.answer) {
            for p in 0..P {
                x[p] -= *y * along[p];
            }
        }
    }
}

#[inline(always)]
fn product<T: Plain>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::from(-0.0), |sum, (a, b)| sum + *a * *b)
}

#[inline(always)]
fn products<T: Plain, const P: usize>(row: &[T], x: &[[T; P]]) -> [T; P] {
    let mut sum = [T::default(); P];
    for (w, x) in row.iter().zip(x) {
        for p in 0..P {
            sum[p] += *w * x[p];
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::banded::HALF_BANDWIDTH;

    const N: usize = 23;

    /// A symmetric band, shifted, and `scale u uᵀ` beside it.
    fn sample(shift: f64, scale: f64) -> Coupled {
        let mut a = Coupled::zeros(N);
        for i in 0..N {
            for j in i.saturating_sub(HALF_BANDWIDTH)..(i + HALF_BANDWIDTH + 1).min(N) {
                a.band[(i, j)] = ((i * j) as f64).sin() + if i == j { 12.0 + shift } else { 0.0 };
            }
        }
        a.put_beside(|column, row| {
            for k in 0..N {
                row[k] = (0.7 * k as f64).cos();
                column[k] = scale * row[k];
            }
        });
        a
    }

    fn dense(a: &Coupled) -> DMatrix<f64> {
        let mut dense = DMatrix::zeros(N, N);
        for k in 0..N {
            let mut unit = vec![[0.0]; N];
            let mut column = vec![[0.0]; N];
            unit[k] = [1.0];
            a.multiply_add(&unit, &mut column);
            dense.column_mut(k).copy_from_slice(column.as_flattened());
        }
        dense
    }

    #[test]
    fn solves_what_a_dense_matrix_solves() {
        let a = sample(0.0, 3.0);
        let b: Vec<f64> = (0..N).map(|i| (i as f64).sin()).collect();
        let due = dense(&a).lu().solve(&DVector::from_vec(b.clone())).unwrap();
        let mut factors = a.clone();
        factors.factorize().unwrap();
        let mut x = b.clone();
        factors.solve(&mut x);
        let mut many: Vec<[f64; 3]> = b.iter().map(|b| [*b, 2.0 * b, -b]).collect();
        factors.solve_many(&mut many);
        for i in 0..N {
            assert!((x[i] - due[i]).abs() < 1e-13 && (many[i][1] - 2.0 * due[i]).abs() < 1e-13);
        }
    }

    /// Through every sign of band and product: shifts that leave the band none, one or more negative
    /// eigenvalues, products that are added or taken away.
    #[test]
    fn positive_is_what_its_eigenvalues_are() {
        let mut seen = [0; 2];
        for k in 0..60 {
            for scale in [-4.0, -0.3, 0.3, 4.0, 40.0] {
                let a = sample(-0.25 * f64::from(k), scale);
                let is_positive = dense(&a).symmetric_eigenvalues().min() > 0.0;
                let mut factors = a;
                if factors.factorize().is_ok() {
                    assert_eq!(factors.is_positive(), is_positive, "shift {k}, scale {scale}");
                    seen[usize::from(is_positive)] += 1;
                }
            }
        }
        assert!(seen.into_iter().all(|count| count > 20), "{seen:?}");
    }

    #[test]
    fn what_the_product_makes_singular_is_reported() {
        let mut a = Coupled::zeros(8);
        a.band.add_diagonal(1.0, &[1.0; 8]);
        a.put_beside(|column, row| {
            column.fill(0.0);
            row.fill(0.0);
            (column[3], row[3]) = (-1.0, 1.0);
        });
        assert_eq!(a.factorize(), Err(Singular { row: 7 }));
    }
}

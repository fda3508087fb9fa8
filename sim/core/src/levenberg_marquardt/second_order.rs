//! What Gauss's and Newton's approximation leaves out of the second derivatives: residuals times their own curvatures.
//!
//! Where a model misses the data, or in a curved valley, that is as large as what it keeps, and steps without it come nearer
//! by a constant factor only. Slopes `J` taken anew at a point that the last ones were `s` away from show it along `s`: with
//! the same residuals `r`, `S s = (J - J_before)ᵀ r`. The update is the least one that says so, in a metric in which `s`
//! becomes the whole change of the gradient, `y = JᵀJ s + S s`.
//! Source: Dennis, Gay and Welsch (1981), ACM Transactions on Mathematical Software 7, 348-368.

use nalgebra::{DMatrix, DVector};

/// The matrix S.
pub struct SecondOrder(DMatrix<f64>);

impl SecondOrder {
    /// Nothing is known of it.
    pub fn none(size: usize) -> Self {
        Self(DMatrix::zeros(size, size))
    }

    /// The matrix.
    pub fn matrix(&self) -> &DMatrix<f64> {
        &self.0
    }

    /// Whether anything is.
    pub fn is_known(&self) -> bool {
        self.0.iter().any(|entry| *entry != 0.0)
    }

    /// Forgets all.
    pub fn forget(&mut self) {
        self.0.fill(0.0);
    }

    /// Learns from new slopes at a point that the last ones were `moved` away from: the gradient there `changed` by so much,
    /// the residuals being the same, and `hessian` is the new `JᵀJ`.
    pub fn learn(&mut self, moved: &DVector<f64>, changed: &DVector<f64>, hessian: &DMatrix<f64>) {
        let whole = hessian * moved + changed;
        let curvature = whole.dot(moved);
        // A metric needs a cost that bends upwards along the way.
        if !(curvature > 0.0 && curvature.is_finite()) {
            return;
        }
        // What was larger along the way before shrinks first.
        let own = moved.dot(&(&self.0 * moved)).abs();
        if own > 0.0 {
            self.0 *= (moved.dot(changed).abs() / own).min(1.0);
        }
        let missed = changed - &self.0 * moved;
        let whole = whole / curvature;
        let both = &missed * whole.transpose();
        self.0 += &both + both.transpose() - moved.dot(&missed) * &whole * whole.transpose();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// After one way the matrix is right along it, and stays symmetric.
    #[test]
    fn what_was_seen_along_a_way_is_known() {
        let truth = DMatrix::from_row_slice(3, 3, &[2.0, -1.0, 0.5, -1.0, 3.0, 0.0, 0.5, 0.0, -1.0]);
        let hessian = DMatrix::from_diagonal(&DVector::from_column_slice(&[4.0, 1.0, 9.0]));
        let mut own = SecondOrder::none(3);
        assert!(!own.is_known());
        for moved in [[1.0, 0.0, 0.0], [0.2, 1.0, -0.4], [0.0, -0.3, 1.0]] {
            let moved = DVector::from_column_slice(&moved);
            own.learn(&moved, &(&truth * &moved), &hessian);
            assert!((own.matrix() * &moved - &truth * &moved).norm() < 1e-12);
            assert!((own.matrix() - own.matrix().transpose()).norm() < 1e-12);
        }
        assert!(own.is_known());
        own.forget();
        assert!(!own.is_known());
    }
}

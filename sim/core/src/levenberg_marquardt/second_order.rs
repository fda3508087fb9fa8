//! The terms of second order that the approximation of Gauss and Newton omits: residuals times their second derivatives.
//!
//! With large residuals, or in a curved valley, they are as large as `JᵀJ`. Without them a search converges linearly. New slopes
//! `J` at a distance `s` from the last ones give them along `s`: `S s = (J - J_before)ᵀ r`, with the same residuals `r`. The
//! update is the smallest one with this property, in a metric that maps `s` to the change of the gradient, `y = JᵀJ s + S s`.
//! Source: Dennis, Gay and Welsch (1981), ACM Transactions on Mathematical Software 7, 348-368.

use nalgebra::{DMatrix, DVector};

/// An estimate of the matrix S.
pub struct SecondOrder(DMatrix<f64>);

impl SecondOrder {
    /// Zero.
    pub fn none(size: usize) -> Self {
        Self(DMatrix::zeros(size, size))
    }

    /// The matrix.
    pub fn matrix(&self) -> &DMatrix<f64> {
        &self.0
    }

    /// Whether it is not zero.
    pub fn is_known(&self) -> bool {
        self.0.iter().any(|entry| *entry != 0.0)
    }

    /// Sets it to zero.
    pub fn forget(&mut self) {
        self.0.fill(0.0);
    }

    /// Updates it with new slopes, taken where the search has `moved` from the last ones. The new slopes `changed` the gradient
    /// there, and `hessian` is the new `JᵀJ`.
    pub fn learn(&mut self, moved: &DVector<f64>, changed: &DVector<f64>, hessian: &DMatrix<f64>) {
        let whole = hessian * moved + changed;
        let curvature = whole.dot(moved);
        // The metric needs a positive curvature.
        if !(curvature > 0.0 && curvature.is_finite()) {
            return;
        }
        // A larger curvature along the same direction shrinks first.
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

    /// After an update the matrix is right along that direction, and symmetric.
    #[test]
    fn an_update_is_right_along_its_direction() {
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

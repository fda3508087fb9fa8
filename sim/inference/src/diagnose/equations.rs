//! Normal equations of all samples of a release, with the parts that wander has.

use nalgebra::{DMatrix, DVector};

use super::data::{Comparison, Squares};
use super::slopes::chosen;
use crate::features::Plan;

/// With slopes J and differences d: `JᵀJ`, `Jᵀd` and `dᵀd`.
pub struct Equations {
    pub jj: DMatrix<f64>,
    pub jd: DVector<f64>,
    pub dd: f64,
}

/// Those of one release, by the unknowns that act on it.
pub struct Normal {
    /// Places of these among all.
    pub places: Vec<usize>,
    /// Of all samples, as if there were no wander.
    pub all: Equations,
    pub slow: Slow,
}

/// Parts of slopes and differences that wander has, and the variance S² of each by wander, m².
pub struct Slow {
    pub slopes: DMatrix<f64>,
    pub differences: DVector<f64>,
    pub variances: DVector<f64>,
}

impl Slow {
    /// Of differences of all samples, whose slopes have these parts.
    pub fn of(plan: &Plan, slopes: DMatrix<f64>, differences: &DVector<f64>) -> Self {
        let differences = parts(plan, differences);
        let variances = plan.wander.variances(differences.len());
        Self { slopes, differences, variances }
    }

    /// Shares that the parts lose where numbers have a variance.
    pub fn lost(&self, variance: f64) -> DVector<f64> {
        self.variances.map(|own| own / (own + variance))
    }
}

/// Parts of one column of all samples that wander has.
pub fn parts(plan: &Plan, column: &DVector<f64>) -> DVector<f64> {
    let column = DMatrix::from_column_slice(column.len(), 1, column.as_slice());
    plan.wander.parts(&column).column(0).into_owned()
}

impl Normal {
    /// The equations where the slow parts lose shares.
    pub fn without(&self, lost: &DVector<f64>) -> Equations {
        let (Equations { jj, jd, dd }, Slow { slopes, differences, .. }) = (&self.all, &self.slow);
        let mut weighted = slopes.clone();
        weighted.column_iter_mut().for_each(|mut column| column.component_mul_assign(lost));
        Equations {
            jj: jj - slopes.tr_mul(&weighted),
            jd: jd - weighted.tr_mul(differences),
            dd: dd - differences.component_mul(differences).dot(lost),
        }
    }

    /// The equations beside wander, where numbers have a variance.
    pub fn beside_wander(&self, variance: f64) -> Equations {
        self.without(&self.slow.lost(variance))
    }

    /// The same after a step of the unknowns, if the slopes stay.
    pub fn after(&self, step: &DVector<f64>) -> Self {
        let step = chosen(step, &self.places);
        let (Equations { jj, jd, dd }, Slow { slopes, differences, variances }) = (&self.all, &self.slow);
        let moved = jj * &step;
        let dd = (dd + 2.0 * step.dot(jd) + step.dot(&moved)).max(0.0);
        Self {
            places: self.places.clone(),
            all: Equations { jj: jj.clone(), jd: jd + moved, dd },
            slow: Slow {
                slopes: slopes.clone(),
                differences: differences + slopes * &step,
                variances: variances.clone(),
            },
        }
    }
}

/// Those of all releases.
pub fn normals(plans: &[Plan], seen: &Comparison) -> Vec<Normal> {
    let of = |(r, plan): (usize, &Plan)| {
        let (difference, slopes) = (&seen.samples.differences[r], &seen.samples.slopes[r]);
        let Squares { jj, slow } = &seen.squares[r];
        Normal {
            places: slopes.places.clone(),
            all: Equations {
                jj: jj.clone(),
                jd: slopes.matrix.tr_mul(difference),
                dd: difference.norm_squared(),
            },
            slow: Slow::of(plan, slow.clone(), difference),
        }
    };
    plans.iter().enumerate().map(of).collect()
}

//! Fewer states for a controller: those that inputs reach and outputs see most, by balancing. The others follow at once,
//! so that the static gain stays; the bound of the error is that of balanced truncation.
//!
//! Gramians follow from the poles in closed form, `P_ij = −b_i b_j* / (λ_i + λ_j*)`. Inputs and outputs are weighed by how
//! far the one moves the other, so that units do not matter.
//!
//! Source: Moore (1981), Principal component analysis in linear systems; the bound: Enns (1984), Glover (1984); static gain
//! kept: Liu and Anderson (1989), Singular perturbation approximation of balanced systems.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::modal::{Complex, Modal};
use super::{LinearError, StateSpace};

/// A linear model with fewer states.
#[derive(Clone, Debug)]
pub struct Reduced {
    /// The matrices; the states are amplitudes without unit.
    pub matrices: StateSpace,
    /// Hankel singular values of the whole model, largest first: how much each state carries, of weighed outputs by weighed
    /// inputs.
    pub hankel: Vec<f64>,
    /// Bound of the error at every frequency, shape `[outputs, inputs]`, in the units of the static gain: from twice the
    /// sum of the singular values that are left out.
    pub error_bound: DMatrix<f64>,
}

/// Singular values below this share of the largest are rounding: square roots of it are taken.
const ROUNDING: f64 = 1e-8;
/// Outputs that move less than this share of the others do so by rounding.
const UNMOVED: f64 = 1e-9;

impl Modal {
    /// The model with `order` states.
    /// # Errors
    /// [`LinearError::NoDecay`] or [`LinearError::Order`].
    pub fn reduced(&self, order: usize) -> Result<Reduced, LinearError> {
        if self.slowest_decay() >= 0.0 {
            let slowest = format!("a pole has the real part {:.3e} 1/s", self.slowest_decay());
            return Err(LinearError::NoDecay { slowest });
        }
        let reach = self.reach();
        let least = UNMOVED * reach.max();
        let outputs = reach.row_iter().map(|row| 1.0 / row.max().max(least));
        let outputs = DVector::from_iterator(reach.nrows(), outputs);
        let weighed = DMatrix::from_diagonal(&outputs) * &reach;
        let inputs = DVector::from_iterator(reach.ncols(), weighed.column_iter().map(|own| 1.0 / own.max()));
        let p = self.gramian(&(&self.b * DMatrix::from_diagonal(&inputs).map(Complex::from)), false);
        let q = self.gramian(&(self.c.adjoint() * DMatrix::from_diagonal(&outputs).map(Complex::from)), true);
        // States in units in which inputs reach them as much as outputs see them.
        let units = DVector::from_iterator(p.nrows(), (0..p.nrows()).map(|k| unit(p[(k, k)], q[(k, k)])));
        let products = &units * units.transpose();
        let (p, q) = (root(p.component_div(&products)), root(q.component_mul(&products)));
        let svd = (q.transpose() * &p).svd(true, true);
        let hankel: Vec<f64> = svd.singular_values.iter().copied().collect();
        let most = hankel.iter().filter(|value| **value > ROUNDING * hankel[0]).count();
        if !(1..=most).contains(&order) {
            return Err(LinearError::Order { order, most });
        }
        let (u, v) = (svd.u.expect("requested"), svd.v_t.expect("requested").transpose());
        let per_root =
            DMatrix::from_diagonal(&svd.singular_values.rows(0, most).map(|value| 1.0 / value.sqrt()));
        let right = DMatrix::from_diagonal(&units) * p * v.columns(0, most) * &per_root;
        let units = units.map(|unit| 1.0 / unit);
        let left = per_root * (q * u.columns(0, most)).transpose() * DMatrix::from_diagonal(&units);
        let StateSpace { a, b, c, d } = &self.matrices;
        let balanced = StateSpace { a: &left * a * &right, b: left * b, c: c * right, d: d.clone() };
        let bound = 2.0 * hankel[order..].iter().sum::<f64>();
        Ok(Reduced {
            matrices: balanced.at_once(order)?,
            error_bound: DMatrix::from_fn(reach.nrows(), reach.ncols(), |i, j| {
                bound / (outputs[i] * inputs[j])
            }),
            hankel,
        })
    }

    /// How far each input moves each output at rest at most: all poles in the same direction.
    fn reach(&self) -> DMatrix<f64> {
        let per_pole = DMatrix::from_diagonal(&self.numbers().map(|pole| 1.0 / pole.norm()));
        self.c.map(|x| x.norm()) * per_pole * self.b.map(|x| x.norm())
    }

    /// The Gramian in the states of the model, of inputs of the amplitudes, or of outputs from them.
    fn gramian(&self, reach: &DMatrix<Complex>, of_outputs: bool) -> DMatrix<f64> {
        let (shapes, inverse) = self.shapes();
        let poles = self.numbers().map(|pole| if of_outputs { pole.conj() } else { pole });
        let decays = DMatrix::from_fn(poles.len(), poles.len(), |i, j| -(poles[i] + poles[j].conj()));
        let own = (reach * reach.adjoint()).component_div(&decays);
        let gramian =
            if of_outputs { inverse.adjoint() * own * inverse } else { shapes * own * shapes.adjoint() };
        let gramian = gramian.map(|x| x.re);
        0.5 * (&gramian + gramian.transpose())
    }
}

impl StateSpace {
    /// The model whose states beyond the first follow at once: it keeps the static gain.
    fn at_once(&self, order: usize) -> Result<StateSpace, LinearError> {
        let Self { a, b, c, d } = self;
        let rest = a.nrows() - order;
        let fast = a.view((order, order), (rest, rest)).into_owned();
        let by_states = a.view((order, 0), (rest, order));
        let solved = -fast.try_inverse().ok_or(LinearError::PoleAtZero)?;
        let (states, inputs) = (&solved * by_states, solved * b.rows(order, rest));
        let (slow, seen) = (a.view((0, order), (order, rest)), c.columns(order, rest));
        Ok(StateSpace {
            a: a.view((0, 0), (order, order)) + slow * &states,
            b: b.rows(0, order) + slow * &inputs,
            c: c.columns(0, order) + seen * states,
            d: d + seen * inputs,
        })
    }
}

/// Fourth root of how much more a state is reached than seen; one where it is neither.
fn unit(reached: f64, seen: f64) -> f64 {
    if reached > 0.0 && seen > 0.0 { (reached / seen).sqrt().sqrt() } else { 1.0 }
}

/// A factor `L` of a Gramian, `L Lᵀ`.
fn root(gramian: DMatrix<f64>) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(gramian);
    eigen.eigenvectors * DMatrix::from_diagonal(&eigen.eigenvalues.map(|x| x.max(0.0).sqrt()))
}

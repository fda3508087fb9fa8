//! A linear model by its poles: responses and samples in closed form.
//!
//! The matrix of a rod is stiff: its fastest pole is some 1e4 times its slowest. Its inverse has the slow ones as
//! its largest eigenvalues, and they come out to rounding.

use std::f64::consts::TAU;

use nalgebra::linalg::Schur;
use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{DMatrix, DVector};

use super::{LinearError, StateSpace};

/// A complex number.
pub type Complex = nalgebra::Complex<f64>;

/// A pole of a linear model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pole {
    /// Where it is, 1/s; of a pair the one with positive imaginary part.
    pub at: Complex,
    /// Undamped frequency, Hz.
    pub frequency: f64,
    /// Share of critical damping; 1 if it does not swing.
    pub damping_ratio: f64,
    /// Whether it is a vibration along the rod, which no table of modes shows.
    pub is_along: bool,
}

impl Pole {
    /// Time in which its motion decays to 5 %, s; infinite if it does not.
    pub fn settling(&self) -> f64 {
        settling(self.at.re)
    }
}

/// Time in which a motion decays to 5 %, s, by the real part of its pole, 1/s; infinite if it does not.
pub fn settling(real: f64) -> f64 {
    if real < 0.0 { 20.0_f64.ln() / -real } else { f64::INFINITY }
}

/// A linear model as a sum over its poles.
#[derive(Clone, Debug)]
pub struct Modal {
    poles: DVector<Complex>,
    is_along: Vec<bool>,
    /// Shapes in columns, and the inverse of that matrix.
    shapes: DMatrix<Complex>,
    inverse: DMatrix<Complex>,
    /// Inputs and outputs of the amplitudes of the shapes.
    pub(super) b: DMatrix<Complex>,
    pub(super) c: DMatrix<Complex>,
    /// Inputs and outputs as they were.
    pub(super) matrices: StateSpace,
}

/// Largest product of the norms of shapes and their inverse: beyond, responses lose half of their digits.
const WORST_CONDITION: f64 = 1e9;
/// Frequencies at which two models are compared.
const FREQUENCIES: usize = 1000;
/// Imaginary part over size of a pole below which it is rounding.
const REAL: f64 = 1e-9;

impl StateSpace {
    /// The same by its poles.
    /// # Errors
    /// [`LinearError::PoleAtZero`], [`LinearError::Defective`].
    pub fn modal(&self) -> Result<Modal, LinearError> {
        let mut balanced = self.a.clone();
        let scale = balance_parlett_reinsch(&mut balanced);
        let inverse = balanced.try_inverse().ok_or(LinearError::PoleAtZero)?;
        if inverse.iter().any(|x| !x.is_finite()) {
            return Err(LinearError::PoleAtZero);
        }
        let schur = Schur::try_new(complex(&inverse), f64::EPSILON, 100 * self.a.nrows());
        let (basis, triangle) = schur.ok_or(LinearError::Defective)?.unpack();
        let shapes = basis * triangle_shapes(&triangle);
        let inverse = shapes.clone().try_inverse().ok_or(LinearError::Defective)?;
        let condition = shapes.norm() * inverse.norm();
        if condition.is_nan() || condition > WORST_CONDITION {
            return Err(LinearError::Defective);
        }
        let poles = triangle.diagonal().map(|inverse| inverse.inv());
        let shapes = DMatrix::from_diagonal(&scale.map(Complex::from)) * shapes;
        let inverse = inverse * DMatrix::from_diagonal(&scale.map(|scale| Complex::from(1.0 / scale)));
        Ok(Modal {
            is_along: vec![false; poles.len()],
            b: &inverse * complex(&self.b),
            c: complex(&self.c) * &shapes,
            poles,
            shapes,
            inverse,
            matrices: self.clone(),
        })
    }
}

fn complex(matrix: &DMatrix<f64>) -> DMatrix<Complex> {
    matrix.map(Complex::from)
}

/// Eigenvectors of an upper triangular matrix, in columns of length one.
fn triangle_shapes(t: &DMatrix<Complex>) -> DMatrix<Complex> {
    let n = t.nrows();
    let smallest = f64::EPSILON * t.map(|x| x.norm()).norm();
    let mut shapes = DMatrix::identity(n, n);
    for k in 0..n {
        for i in (0..k).rev() {
            let sum: Complex = (i + 1..=k).map(|j| t[(i, j)] * shapes[(j, k)]).sum();
            let gap = t[(k, k)] - t[(i, i)];
            // Poles that coincide share a plane of shapes: any two of it do.
            let gap = if gap.norm() < smallest { Complex::from(smallest) } else { gap };
            shapes[(i, k)] = sum / gap;
        }
        let norm = shapes.column(k).norm();
        shapes.column_mut(k).unscale_mut(norm);
    }
    shapes
}

impl Modal {
    /// The poles, slowest first, each pair once.
    pub fn poles(&self) -> Vec<Pole> {
        let mut all: Vec<Pole> = (0..self.poles.len()).filter_map(|k| self.pole(k)).collect();
        all.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        all
    }

    /// Bending vibrations, slowest first.
    pub fn vibrations(&self) -> Vec<Pole> {
        self.poles().into_iter().filter(|pole| pole.at.im > 0.0 && !pole.is_along).collect()
    }

    fn pole(&self, k: usize) -> Option<Pole> {
        let pole = self.poles[k];
        let size = pole.norm();
        let is_real = pole.im.abs() <= REAL * size;
        let at = if is_real { Complex::from(pole.re) } else { pole };
        (is_real || pole.im > 0.0).then(|| Pole {
            at,
            frequency: size / TAU,
            damping_ratio: if is_real { -pole.re.signum() } else { -pole.re / size },
            is_along: self.is_along[k],
        })
    }

    /// Marks vibrations along the rod, by their poles and shapes.
    pub(super) fn mark(&mut self, mut is_along: impl FnMut(Complex, &[Complex]) -> bool) {
        for (k, pole) in self.poles.iter().enumerate() {
            let swings = pole.im.abs() > REAL * pole.norm();
            self.is_along[k] = swings && is_along(*pole, self.shapes.column(k).as_slice());
        }
    }

    /// The largest real part of a pole, 1/s: below zero if every motion decays.
    pub fn slowest_decay(&self) -> f64 {
        self.poles.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max)
    }

    pub(super) fn numbers(&self) -> &DVector<Complex> {
        &self.poles
    }

    pub(super) fn shapes(&self) -> (&DMatrix<Complex>, &DMatrix<Complex>) {
        (&self.shapes, &self.inverse)
    }

    /// `Σ c b factor(λ)` over the poles.
    fn sum(&self, factor: impl Fn(Complex) -> Complex) -> DMatrix<Complex> {
        &self.c * self.weighted(&self.b, factor)
    }

    /// Rows of amplitudes, each times a factor of its pole.
    fn weighted(&self, rows: &DMatrix<Complex>, factor: impl Fn(Complex) -> Complex) -> DMatrix<Complex> {
        let mut weighted = rows.clone();
        for (mut row, pole) in weighted.row_iter_mut().zip(&self.poles) {
            row *= factor(*pole);
        }
        weighted
    }

    /// Outputs by inputs that move as `exp(s t)`: at `s = iω` what a Bode plot shows.
    pub fn response(&self, s: Complex) -> DMatrix<Complex> {
        self.sum(|pole| (s - pole).inv()) + complex(&self.matrices.d)
    }

    /// The largest distance of the responses of two models up to a frequency, Hz, shape `[outputs, inputs]`.
    pub fn farthest(&self, other: &Modal, frequency: f64) -> DMatrix<f64> {
        let mut most = self.matrices.d.map(|_| 0.0);
        for k in 0..=FREQUENCIES {
            let s = Complex::new(0.0, TAU * frequency * k as f64 / FREQUENCIES as f64);
            let distance = (self.response(s) - other.response(s)).map(|x| x.norm());
            most = most.sup(&distance);
        }
        most
    }

    /// Outputs after long by inputs that stay.
    pub fn static_gain(&self) -> DMatrix<f64> {
        self.response(Complex::from(0.0)).map(|gain| gain.re)
    }

    /// Outputs at a time, s, by inputs that jump to one at time 0.
    pub fn step(&self, time: f64) -> DMatrix<f64> {
        self.sum(|pole| ((pole * time).exp() - 1.0) / pole).map(|x| x.re) + &self.matrices.d
    }

    /// The model with samples a time apart, s, whose inputs stay between them: zero-order hold.
    pub fn discrete(&self, sample: f64) -> StateSpace {
        let a = &self.shapes * self.weighted(&self.inverse, |pole| (pole * sample).exp());
        let b = &self.shapes * self.weighted(&self.b, |pole| ((pole * sample).exp() - 1.0) / pole);
        StateSpace { a: a.map(|x| x.re), b: b.map(|x| x.re), ..self.matrices.clone() }
    }
}

//! The rod as diffsol sees it: `y = [q; v; z]`, `ẏ = [v; f/M; g]`, and the linear solver of its
//! implicit stages.
//!
//! A stage solves `(I − cJ) u = r`. With `a = 1/c` the first rows say `u_v = a (u_q − r_q)`, and
//! the rest is the condensed step of [`models::system::System::condense`], banded in `u_q`:
//!
//! `(a²M + aD + K) u_q = a M r_v + (a M + D) a r_q`, and what `a r_z` does.
//!
//! diffsol would hand us `I − cJ` as a sparse matrix, from which velocities and memory had to be
//! picked apart again. Instead the solver and the equations share the [`Tangents`]: a request for
//! the Jacobian linearises the rod there, and of the matrix that diffsol carries only one entry is
//! real, `∂q̇₀/∂v₀ = 1`. It comes back as `−c`, which is all that the solver has to learn. So
//! memory is eliminated by the same code as for our own integrators.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use ::diffsol::{
    ConstantOp, FaerContext, FaerSparseMat, FaerVec, LaError, LaLinearOp, Matrix, MatrixCommon, NonLinearOp,
    NonLinearOpJacobian, OdeEquations, OdeEquationsRef, Op, ParameterisedOp, UnitCallable, Vector,
    VectorCommon,
};
use diffsol_la::error::LinearSolverError;
use diffsol_la::{LinearSolver, MatrixSparsity};
use models::coupled::Coupled;
use models::model::Model;
use models::system::System;

use crate::integrate::State;

type V = FaerVec<f64>;
type M = FaerSparseMat<f64>;

/// The equations of motion, the state at which they start, and what they have cost.
pub struct Equations {
    context: FaerContext,
    start: Vec<f64>,
    system: RefCell<System>,
    pub(super) tangents: Rc<RefCell<Tangents>>,
    pub(super) evaluations: Cell<usize>,
}

impl Equations {
    pub(super) fn new(model: &Model, start: &State) -> Self {
        let system = System::new(model);
        Self {
            context: FaerContext::default(),
            start: [&start.q[..], &start.v, &start.z].concat(),
            tangents: Rc::new(RefCell::new(Tangents::new(system.clone()))),
            system: RefCell::new(system),
            evaluations: Cell::new(0),
        }
    }

    pub(super) fn dof(&self) -> usize {
        self.system.borrow().mass.len()
    }

    /// See [`System::begin_step`].
    pub(super) fn begin_step(&self, time: f64) {
        self.system.borrow_mut().begin_step(time);
        self.tangents.borrow_mut().system.begin_step(time);
    }
}

/// `q`, `v` and `z` in a vector of diffsol.
pub(super) fn parts(y: &V, dof: usize) -> [&[f64]; 3] {
    split(y.inner().col_as_slice(0), dof)
}

fn split(y: &[f64], dof: usize) -> [&[f64]; 3] {
    let (q, rest) = y.split_at(dof);
    let (v, z) = rest.split_at(dof);
    [q, v, z]
}

fn split_mut(y: &mut [f64], dof: usize) -> [&mut [f64]; 3] {
    let (q, rest) = y.split_at_mut(dof);
    let (v, z) = rest.split_at_mut(dof);
    [q, v, z]
}

impl Op for Equations {
    type T = f64;
    type V = V;
    type M = M;
    type C = FaerContext;

    fn context(&self) -> &FaerContext {
        &self.context
    }
    fn nstates(&self) -> usize {
        self.start.len()
    }
    fn nout(&self) -> usize {
        self.start.len()
    }
    fn nparams(&self) -> usize {
        0
    }
}

impl NonLinearOp for Equations {
    fn call_inplace(&self, y: &V, t: f64, rate: &mut V) {
        let system = &mut *self.system.borrow_mut();
        let dof = system.mass.len();
        rate.for_each_batch_host([y], |rate, [y], _| {
            let [q, v, z] = split(y, dof);
            let [q_rate, v_rate, z_rate] = split_mut(rate, dof);
            q_rate.copy_from_slice(v);
            system.force(t, q, v, z, v_rate, z_rate);
            for (force, mass) in v_rate.iter_mut().zip(&system.mass) {
                *force /= mass;
            }
        });
        self.evaluations.set(self.evaluations.get() + 1);
    }
}

impl NonLinearOpJacobian for Equations {
    fn jac_mul_inplace(&self, _y: &V, _t: f64, _u: &V, _out: &mut V) {
        unreachable!("only sensitivities multiply by the Jacobian")
    }

    fn jacobian_inplace(&self, y: &V, t: f64, jacobian: &mut M) {
        let [q, v, z] = parts(y, self.dof());
        self.tangents.borrow_mut().linearise(t, q, v, z);
        jacobian.inner_mut()[0].val_mut()[0] = 1.0;
    }

    fn jacobian_sparsity(&self) -> Option<<M as Matrix>::Sparsity> {
        let n = self.nstates();
        let pattern =
            <<M as Matrix>::Sparsity as MatrixSparsity<M>>::try_from_indices(n, n, vec![(0, self.dof())]);
        Some(pattern.expect("one entry inside the matrix is a pattern"))
    }
}

impl ConstantOp for Equations {
    fn call_inplace(&self, _t: f64, y: &mut V) {
        y.for_each_batch_host([], |y, [], _| y.copy_from_slice(&self.start));
    }
}

impl<'a> OdeEquationsRef<'a> for Equations {
    type Mass = ParameterisedOp<'a, UnitCallable<M>>;
    type Rhs = &'a Self;
    type Root = ParameterisedOp<'a, UnitCallable<M>>;
    type Init = &'a Self;
    type Out = ParameterisedOp<'a, UnitCallable<M>>;
    type Reset = ParameterisedOp<'a, UnitCallable<M>>;
}

impl OdeEquations for Equations {
    fn rhs(&self) -> &Self {
        self
    }
    fn mass(&self) -> Option<<Self as OdeEquationsRef<'_>>::Mass> {
        None
    }
    fn init(&self) -> &Self {
        self
    }
    fn set_params(&mut self, _p: &V) {}
    fn get_params(&self, _p: &mut V) {}
}

/// Tangents where diffsol last requested the Jacobian, and the factors of its step.
pub(super) struct Tangents {
    system: System,
    factors: Coupled,
    a: f64,
    regular: bool,
    u_q: Vec<[f64; 1]>,
    u_v: Vec<[f64; 1]>,
    r_z: Vec<[f64; 1]>,
    z_rate: Vec<f64>,
    pub(super) linearisations: usize,
    pub(super) factorizations: usize,
}

impl Tangents {
    fn new(system: System) -> Self {
        let (dof, memory) = (system.model.dof(), system.model.memory());
        Self {
            system,
            factors: Coupled::zeros(dof),
            a: 0.0,
            regular: false,
            u_q: vec![[0.0]; dof],
            u_v: vec![[0.0]; dof],
            r_z: vec![[0.0]; memory],
            z_rate: vec![0.0; memory],
            linearisations: 0,
            factorizations: 0,
        }
    }

    fn linearise(&mut self, t: f64, q: &[f64], v: &[f64], z: &[f64]) {
        self.system.linearise_into(t, q, v, z, self.u_q.as_flattened_mut(), &mut self.z_rate);
        self.linearisations += 1;
    }

    fn factorize(&mut self, a: f64) {
        let Self { system, factors, .. } = self;
        system.condense(a);
        factors.combine(a, &system.mass, system.damping(), system.stiffness());
        self.regular = factors.factorize().is_ok();
        self.a = a;
        self.factorizations += 1;
    }

    /// Turns residuals into increments.
    fn solve(&mut self, [q, v, z]: [&mut [f64]; 3]) {
        let Self { system, factors, a, u_q, u_v, r_z, .. } = self;
        let a = *a;
        for (i, mass) in system.mass.iter().enumerate() {
            u_v[i] = [a * q[i]];
            u_q[i] = [a * mass * (v[i] + a * q[i])];
        }
        for (r, z) in r_z.iter_mut().zip(&*z) {
            *r = [a * z];
        }
        system.damping().multiply_add(u_v, u_q);
        system.condense_residual(a, r_z, u_q);
        factors.solve(u_q.as_flattened_mut());
        for i in 0..q.len() {
            u_v[i] = [a * (u_q[i][0] - q[i])];
        }
        system.recover_memory(a, u_q, u_v, r_z);
        q.copy_from_slice(u_q.as_flattened());
        v.copy_from_slice(u_v.as_flattened());
        z.copy_from_slice(r_z.as_flattened());
    }
}

/// Linear solver in the coordinates alone, with a narrow band. `None` only as the default that
/// diffsol requires, which it takes for copies of a whole solver: we make none.
#[derive(Default)]
pub struct BandSolver {
    tangents: Option<Rc<RefCell<Tangents>>>,
    matrix: Option<M>,
}

impl BandSolver {
    pub(super) fn new(equations: &Equations) -> Self {
        Self { tangents: Some(equations.tangents.clone()), matrix: None }
    }
}

impl LinearSolver<M> for BandSolver {
    fn set_sparsity<C: LaLinearOp<V = V, T = f64, M = M, C = FaerContext>>(&mut self, op: &C) {
        self.matrix = Some(M::new_from_sparsity(op.nrows(), op.ncols(), op.sparsity(), *op.context()));
    }

    fn set_linearisation<C: LaLinearOp<V = V, T = f64, M = M, C = FaerContext>>(&mut self, op: &C) {
        let (Some(matrix), Some(tangents)) = (&mut self.matrix, &self.tangents) else {
            unreachable!("diffsol gives the pattern before the values");
        };
        op.matrix_inplace(matrix);
        let tangents = &mut *tangents.borrow_mut();
        let dof = tangents.system.mass.len();
        // Row 0 comes first in the column of the first velocity.
        let minus_c = matrix.inner()[0].val_of_col(dof)[0];
        tangents.factorize(-1.0 / minus_c);
    }

    fn solve_in_place(&self, b: &mut V) -> Result<(), LaError> {
        let mut tangents = self.tangents.as_ref().ok_or(LinearSolverError::LuNotInitialized)?.borrow_mut();
        if !tangents.regular {
            return Err(LinearSolverError::LuSolveFailed.into());
        }
        let dof = tangents.system.mass.len();
        b.for_each_batch_host([], |b, [], _| tangents.solve(split_mut(b, dof)));
        Ok(())
    }

    fn solve_transpose_in_place(&self, _b: &mut V) -> Result<(), LaError> {
        unreachable!("only adjoints solve with the transpose")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::effects::Rod;
    use models::model::{ModelSpec, Scheme};

    /// A solution of `(I − cJ) u = r` against the rates' differences along it, in a bent rod that
    /// moves, with memory, drag, damping and a soft clamp.
    #[test]
    fn solves_the_equations_of_a_stage() {
        let effects = [
            ("viscoelastic", vec![("branch_stiffness", 0.5)]),
            ("air_drag", vec![("drag_coefficient", 2.0)]),
            ("rayleigh_mass", vec![("alpha", 3.0)]),
            ("rayleigh_stiffness", vec![("beta", 1e-3)]),
            ("clamp_compliance", vec![("compliance", 1.0)]),
            ("pressure_volume", vec![("stiffening", 0.1)]),
            ("end_fitting", vec![("mass", 0.05), ("center_of_mass", 0.017)]),
        ];
        let owned = |(name, values): (&str, Vec<(&str, f64)>)| {
            (name.to_owned(), values.into_iter().map(|(key, value)| (key.to_owned(), value)).collect())
        };
        let model = Model::new(&ModelSpec {
            nodes: 6,
            rod: Rod {
                length: 0.2,
                mass: 0.03,
                bending_stiffness: 0.008,
                axial_stiffness: 40.0,
                diameter: 0.027,
                pressure: 0.0,
            },
            base_angle: 0.1,
            release_angle: 0.2,
            release_rate: 0.3,
            scheme: Scheme::Consistent,
            tip_distance: 0.0,
            effects: effects.into_iter().map(owned).collect(),
            catalogue: Default::default(),
            schedule: None,
        })
        .unwrap();
        let wobble = |k: usize, phase: f64| ((k * k) as f64 * 0.7 + phase).sin();
        let (mut q, mut v) = System::new(&model).assembly.straight(-0.4, 0.3);
        for k in 0..model.dof() {
            q[k] += 0.008 * wobble(k, 0.3);
            v[k] += 0.3 * wobble(k, 1.1);
        }
        let z: Vec<f64> = (0..model.memory()).map(|k| 2.0 * wobble(k, 2.0)).collect();
        assert!(!z.is_empty());
        let equations =
            Equations::new(&model, &State { time: 0.0, q: q.clone(), v: v.clone(), z: z.clone() });

        let (c, dof) = (3e-3, model.dof());
        let size = |k: usize| if k < dof { 1e-3 } else { 0.1 };
        let r: Vec<f64> = (0..equations.start.len()).map(|k| size(k) * wobble(k, 0.5)).collect();
        let mut u = r.clone();
        let mut tangents = equations.tangents.borrow_mut();
        tangents.linearise(0.0, &q, &v, &z);
        tangents.factorize(1.0 / c);
        tangents.solve(split_mut(&mut u, dof));

        let rates = |epsilon: f64| {
            let y = equations.start.iter().zip(&u).map(|(y, u)| y + epsilon * u).collect();
            let y = V::from_vec(y, equations.context);
            let mut rate = V::zeros(u.len(), equations.context);
            NonLinearOp::call_inplace(&equations, &y, 0.0, &mut rate);
            rate.clone_as_vec()
        };
        let step = 1e-4;
        for (k, (ahead, behind)) in rates(step).into_iter().zip(rates(-step)).enumerate() {
            let slope = (ahead - behind) / (2.0 * step);
            let imbalance = u[k] - c * slope - r[k];
            let scale = u[k].abs() + c * slope.abs() + r[k].abs();
            assert!(imbalance.abs() < 1e-6 * scale, "row {k}: {imbalance} of {scale}");
        }
    }
}

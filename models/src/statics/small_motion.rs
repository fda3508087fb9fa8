//! All small motions about a rest posture, with the memory of the laws as variables of its own:
//!
//! ```text
//! M v̇ = −K q − D v + F z + f u,    ż = G q + H v + R z + g u
//! ```
//!
//! `q` is counted from the rest. `M`, `D`, `K` are those of [`modes`](super::modes()). Memory that no moment depends on
//! is left out. Memory that neither relaxes nor follows a posture, as that of friction that sticks, is a spring:
//! `z = H q` from the rest on, so that it joins `K` and has no pole.

use std::sync::Arc;

use nalgebra::{Complex, DMatrix, DVector, Vector2};

use crate::effects::LANES;
use crate::error::ModelError;
use crate::model::{Model, Schedule};
use crate::muscle::RodSlopes;
use crate::posture::Between;
use crate::pressure::Begins;
use crate::system::{System, TimePass};

use super::Equilibrium;
use super::modes::ALONG;

/// The linear equations of motion about a rest.
///
/// Without weight and with damping by mass and stiffness, its slowest poles have the undamped frequency of the slowest mode:
///
/// ```
/// use models::effects::Rod;
/// use models::model::{Model, ModelSpec};
/// use models::statics::{SmallMotion, equilibrium, modes};
///
/// let rod = Rod { length: 0.2, mass: 0.01, bending_stiffness: 5e-3, axial_stiffness: 50.0, diameter: 0.01, pressure: 0.0 };
/// let model = Model::new(&ModelSpec { nodes: 8, ..ModelSpec::of(rod) }.with(&[("rayleigh_mass.alpha", 1.0)]))?;
/// let rest = equilibrium(&model, None)?;
/// let poles = SmallMotion::about(&model, &rest).state_matrix().complex_eigenvalues();
/// let slowest = poles.iter().map(|pole| pole.norm()).fold(f64::INFINITY, f64::min);
/// assert!((slowest / modes(&model, &rest, 1)?[0].angular_frequency - 1.0).abs() < 1e-6);
/// # Ok::<(), models::error::ModelError>(())
/// ```
pub struct SmallMotion {
    rest: Equilibrium,
    /// The same equations with their room, the pressure kept.
    system: System,
    /// Diagonal of the mass matrix, kg and kg m².
    mass: Vec<f64>,
    stiffness: DMatrix<f64>,
    damping: DMatrix<f64>,
    /// Forces by each memory, shape `[2N+1, memory]`.
    by_memory: DMatrix<f64>,
    /// Rates of each memory by coordinates and by velocities, shape `[memory, 2N+1]`.
    by_position: DMatrix<f64>,
    by_velocity: DMatrix<f64>,
    /// By itself, 1/s.
    relaxation: Vec<f64>,
    /// Memories that are variables, and that are springs, as indices into those of the model.
    memory: Vec<usize>,
    springs: Vec<usize>,
}

impl SmallMotion {
    /// The equations about an equilibrium of the model.
    pub fn about(model: &Model, rest: &Equilibrium) -> Self {
        // A pressure that will change is at its value of the rest.
        let mut system = System::at_rest(&model.under(None));
        let dof = model.dof();
        system.linearise(rest.time, &rest.q, &vec![0.0; dof], &rest.z, &mut vec![0.0; dof]);
        // A step of no length leaves memory no time to answer.
        system.condense(f64::INFINITY);
        let [mut stiffness, mut damping] = [(); 2].map(|()| DMatrix::zeros(dof, dof));
        for k in 0..dof {
            let [mut by_stiffness, mut by_damping] = [(); 2].map(|()| vec![[0.0]; dof]);
            system.stiffness().multiply_add(&unit(dof, k), &mut by_stiffness);
            system.damping().multiply_add(&unit(dof, k), &mut by_damping);
            stiffness.column_mut(k).copy_from_slice(by_stiffness.as_flattened());
            damping.column_mut(k).copy_from_slice(by_damping.as_flattened());
        }
        let mut motion = Self {
            rest: rest.clone(),
            mass: system.mass.clone(),
            stiffness,
            damping,
            by_memory: DMatrix::zeros(dof, model.memory()),
            by_position: DMatrix::zeros(model.memory(), dof),
            by_velocity: DMatrix::zeros(model.memory(), dof),
            relaxation: system.tangent.memory_slopes().collect(),
            memory: Vec::new(),
            springs: Vec::new(),
            system,
        };
        motion.couple_memory();
        motion
    }

    /// How forces depend on memory and memory on motion: from the solution of a step, whose factor `1/(a − g_z)` is undone.
    fn couple_memory(&mut self) {
        let Self { system, relaxation, .. } = self;
        let (dof, count) = (self.mass.len(), relaxation.len());
        let a = 1.0 + relaxation.iter().fold(0.0_f64, |most, slope| most.max(*slope));
        for k in 0..count {
            let mut residual = vec![[0.0]; count];
            residual[k] = [a - relaxation[k]];
            let mut force = vec![[0.0]; dof];
            system.condense_residual(a, &residual, &mut force);
            self.by_memory.column_mut(k).copy_from_slice(force.as_flattened());
        }
        for l in 0..dof {
            let (still, moves) = (unit(dof, dof), unit(dof, l));
            for (by, q, v) in
                [(&mut self.by_position, &moves, &still), (&mut self.by_velocity, &still, &moves)]
            {
                let mut rates = vec![[0.0]; count];
                system.recover_memory(a, q, v, &mut rates);
                for (k, [rate]) in rates.into_iter().enumerate() {
                    by[(k, l)] = rate * (a - relaxation[k]);
                }
            }
        }
        for k in 0..count {
            if self.by_memory.column(k).iter().all(|x| *x == 0.0) {
                continue;
            }
            if self.relaxation[k] == 0.0 && self.by_position.row(k).iter().all(|x| *x == 0.0) {
                self.stiffness -= self.by_memory.column(k) * self.by_velocity.row(k);
                self.springs.push(k);
            } else {
                self.memory.push(k);
            }
        }
    }

    /// Number of coordinates, `2N+1`.
    pub fn dof(&self) -> usize {
        self.mass.len()
    }

    /// Which of the model's memories are variables.
    pub fn memory(&self) -> &[usize] {
        &self.memory
    }

    /// The matrix of the equations of `[q, v, z]`.
    pub fn state_matrix(&self) -> DMatrix<f64> {
        let (n, m) = (self.dof(), self.memory.len());
        let per_mass = DVector::from_iterator(n, self.mass.iter().map(|mass| 1.0 / mass));
        let accelerations = |forces: DMatrix<f64>| DMatrix::from_diagonal(&per_mass) * forces;
        let rows = |of: &DMatrix<f64>| of.select_rows(&self.memory);
        let mut a = DMatrix::zeros(2 * n + m, 2 * n + m);
        a.view_mut((0, n), (n, n)).fill_with_identity();
        a.view_mut((n, 0), (n, n)).copy_from(&-accelerations(self.stiffness.clone()));
        a.view_mut((n, n), (n, n)).copy_from(&-accelerations(self.damping.clone()));
        a.view_mut((n, 2 * n), (n, m)).copy_from(&accelerations(self.by_memory.select_columns(&self.memory)));
        a.view_mut((2 * n, 0), (m, n)).copy_from(&rows(&self.by_position));
        a.view_mut((2 * n, n), (m, n)).copy_from(&rows(&self.by_velocity));
        for (at, k) in (2 * n..).zip(&self.memory) {
            a[(at, at)] = self.relaxation[*k];
        }
        a
    }

    /// Rates of `[q, v, z]` by a parameter, as an index into `theta`.
    /// # Errors
    /// [`ModelError::NoInput`] for one that moves coordinates or masses.
    pub fn by_parameter(&mut self, parameter: usize) -> Result<DVector<f64>, ModelError> {
        if self.system.model.is_geometric(parameter) {
            let path = self.system.model.parameters[parameter].path.clone();
            return Err(ModelError::NoInput { path });
        }
        let Equilibrium { q, z, time, .. } = &self.rest;
        self.system.watch(&[Some(parameter)]);
        let mut force = vec![[0.0; LANES]; q.len()];
        let mut rates = vec![[0.0; LANES]; z.len()];
        self.system.by_parameters(0, *time, q, &vec![0.0; q.len()], z, &mut force, &mut rates);
        let first = |all: Vec<[f64; LANES]>| all.into_iter().map(|lanes| lanes[0]).collect::<Vec<_>>();
        Ok(self.rates(&first(force), &first(rates)))
    }

    /// Rates of `[q, v, z]` by an acceleration of the clamp along a direction in W, whose frame moves with it.
    pub fn by_acceleration(&self, direction: [f64; 2]) -> DVector<f64> {
        let last = self.dof() - 1;
        let force = |k: usize| if k < last { -direction[k % 2] * self.mass[k] } else { 0.0 };
        self.rates(&(0..=last).map(force).collect::<Vec<_>>(), &vec![0.0; self.rest.z.len()])
    }

    /// Rates `b` of `[q, v, z]` by the pressure, 1/Pa, of a rod with these slopes; and `e`, by which velocities and memory
    /// jump with the pressure: damping and memory see the rate of the rest length. With `x = x̃ + e p`, `x̃` obeys
    /// `x̃' = A x̃ + (b + A e) p`.
    pub fn by_pressure(&self, slopes: RodSlopes) -> [DVector<f64>; 2] {
        let [by_value, by_rate] = [true, false].map(|at_once| {
            let changes = Begins { slopes, at_once };
            let [with, without] = [Some(Arc::new(changes) as Arc<dyn Schedule>), None].map(|schedule| {
                let model = self.system.model.under(schedule);
                // A law may depend on time itself: that is no part of the answer.
                let system = if at_once { System::at_rest(&model) } else { System::new(&model) };
                let Equilibrium { q, z, time, .. } = &self.rest;
                let (mut force, mut rates) = (vec![0.0; q.len()], vec![0.0; z.len()]);
                let room = &mut TimePass::new(&model);
                system.by_time(room, *time, q, &vec![0.0; q.len()], z, &mut force, &mut rates);
                (DVector::from(force), DVector::from(rates))
            });
            (with.0 - without.0, with.1 - without.1)
        });
        let mut force = by_value.0;
        for k in &self.springs {
            force += self.by_memory.column(*k) * by_rate.1[*k];
        }
        [
            self.rates(force.as_slice(), by_value.1.as_slice()),
            self.rates(by_rate.0.as_slice(), by_rate.1.as_slice()),
        ]
    }

    fn rates(&self, force: &[f64], memory: &[f64]) -> DVector<f64> {
        let n = self.dof();
        let accelerations = force.iter().zip(&self.mass).map(|(force, mass)| force / mass);
        let memory = self.memory.iter().map(|k| memory[*k]);
        let all = std::iter::repeat_n(0.0, n).chain(accelerations).chain(memory);
        DVector::from_iterator(2 * n + self.memory.len(), all)
    }

    /// Whether a vibration is one along the rod, as [`modes`](super::modes()) leaves them out: of its pole, 1/s, and its
    /// shape, increments of `[q, v, z]`.
    pub fn is_along(&mut self, pole: Complex<f64>, shape: &[Complex<f64>]) -> bool {
        let (mut stretch, mut motion) = (0.0, 0.0);
        for part in [|x: &Complex<f64>| x.re, |x: &Complex<f64>| x.im] {
            let part: Vec<f64> = shape[..self.dof()].iter().map(part).collect();
            stretch += self.system.stretch_energy(self.rest.time, &self.rest.q, &part);
            motion += part.iter().zip(&self.mass).map(|(x, mass)| mass * x * x).sum::<f64>();
        }
        stretch >= ALONG * pole.norm_sqr() * motion
    }

    /// The observed tip at the rest, m, and how that moves along x and z with the coordinates, shape `[2, 2N+1]`.
    pub fn tip(&mut self) -> ([f64; 2], DMatrix<f64>) {
        self.point(|system, q, v| system.observed_tip(q, v))
    }

    /// The same of a point of the axis, at a share of the active length, 0 at the clamp.
    pub fn along(&mut self, share: f64) -> ([f64; 2], DMatrix<f64>) {
        let between = Between::of(share, self.system.model.edges);
        self.point(|system, q, v| {
            let posture = system.assembly.posture(q, v);
            (between.of_nodes(|node| posture.nodes[node]), between.of_nodes(|node| posture.velocities[node]))
        })
    }

    /// Velocities are linear in those of the coordinates.
    fn point(
        &mut self,
        see: impl Fn(&mut System, &[f64], &[f64]) -> ([f64; 2], [f64; 2]),
    ) -> ([f64; 2], DMatrix<f64>) {
        let dof = self.dof();
        let mut of = |k| see(&mut self.system, &self.rest.q, unit(dof, k).as_flattened());
        let position = of(dof).0;
        let columns: Vec<_> = (0..dof).map(|k| Vector2::from(of(k).1)).collect();
        (position, DMatrix::from_fn(2, dof, |axis, k| columns[k][axis]))
    }
}

fn unit(length: usize, one: usize) -> Vec<[f64; 1]> {
    (0..length).map(|k| [if k == one { 1.0 } else { 0.0 }]).collect()
}

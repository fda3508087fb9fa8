//! The equations of motion `q̇ = v`, `M v̇ = f(q, v, z, t; theta)`, `ż = g(q, v, z, t; theta)`.

use num_dual::Dual64;

use crate::assembly::{Acting, Assembly};
use crate::context::Context;
use crate::effects::{LANES, Lanes, Scalar};
use crate::lanes::{seeded, slopes, with_slopes};
use crate::model::Model;
use crate::posture::Posture;
use crate::tangent::Tangent;

/// The equations of motion of one model, with room to evaluate them: one for each thread.
#[derive(Clone)]
pub struct System {
    /// The model.
    pub model: Model,
    /// Kinematics and laws over plain numbers.
    pub assembly: Assembly<f64>,
    /// Diagonal of the mass matrix, shape `[2N+1]`, kg and kg m².
    pub mass: Vec<f64>,
    pub(crate) tangent: Tangent,
    lanes: Vec<Pass<Lanes>>,
}

/// An evaluation of the equations over a scalar that carries derivatives.
#[derive(Clone)]
struct Pass<T> {
    assembly: Assembly<T>,
    mass: Vec<T>,
    q: Vec<T>,
    v: Vec<T>,
    z: Vec<T>,
    force: Vec<T>,
    z_rate: Vec<T>,
}

impl System {
    /// Sets up the equations of a model.
    pub fn new(model: &Model) -> Self {
        let assembly = Assembly::new(model, model.theta.clone(), Acting::new(model));
        let mass = assembly.context.mass();
        let tangent = Tangent::new(model);
        Self { model: model.clone(), assembly, mass, tangent, lanes: Vec::new() }
    }

    /// Sets up the equations of a model whose pressure stays as it is at any time: for statics.
    pub fn at_rest(model: &Model) -> Self {
        let mut system = Self::new(model);
        system.assembly.stands_still = true;
        system
    }

    /// From now on evaluations belong to a step that starts at `time`: where a rate of the pressure
    /// jumps at its end, they see the rate before.
    pub fn begin_step(&mut self, time: f64) {
        self.assembly.since = Some(time);
    }

    /// Generalised forces, shape `[2N+1]`, and rates of the memory.
    pub fn force(
        &mut self,
        time: f64,
        q: &[f64],
        v: &[f64],
        z: &[f64],
        force: &mut [f64],
        z_rate: &mut [f64],
    ) {
        self.assembly.force(&self.model, time, q, v, z, force, z_rate);
    }

    /// Makes room for derivatives by parameters: `indices` into `theta`, in groups of [`LANES`];
    /// `None` leaves a lane at zero.
    pub fn watch(&mut self, indices: &[Option<usize>]) {
        self.lanes = indices.chunks(LANES).map(|group| Pass::for_parameters(&self.model, group)).collect();
    }

    /// Derivatives of the forces and of the rates of memory at a fixed state, by the `group`-th [`LANES`] watched
    /// parameters; of the rates as many as there is room for.
    #[expect(clippy::too_many_arguments, reason = "a state and the derivatives of its two rates")]
    pub fn by_parameters(
        &mut self,
        group: usize,
        time: f64,
        q: &[f64],
        v: &[f64],
        z: &[f64],
        force: &mut [[f64; LANES]],
        z_rate: &mut [[f64; LANES]],
    ) {
        let pass = &mut self.lanes[group];
        pass.assembly.since = self.assembly.since;
        pass.evaluate(&self.model, time.into(), q, v, z);
        for (out, f) in force.iter_mut().zip(&pass.force) {
            *out = slopes(f);
        }
        for (out, rate) in z_rate.iter_mut().zip(&pass.z_rate) {
            *out = slopes(rate);
        }
    }

    /// Derivatives of the masses by the `group`-th [`LANES`] watched parameters, over the masses.
    pub fn mass_by_parameters(&self, group: usize) -> impl Iterator<Item = [f64; LANES]> + '_ {
        self.lanes[group].mass.iter().map(|mass| slopes(mass).map(|slope| slope / mass.re))
    }

    /// The straight rod at its release, with the derivatives by the `group`-th [`LANES`] watched
    /// parameters.
    pub fn straight_by_parameters(&self, group: usize) -> Posture<Lanes> {
        self.lanes[group].assembly.straight_at_release()
    }

    /// A posture at rest of this system with the derivatives of its coordinates.
    pub fn posture_by_parameters(
        &mut self,
        group: usize,
        q: &[f64],
        by_theta: &[[f64; LANES]],
    ) -> Posture<Lanes> {
        let pass = &mut self.lanes[group];
        for (lifted, (q, by_theta)) in pass.q.iter_mut().zip(q.iter().zip(by_theta)) {
            *lifted = with_slopes(*q, *by_theta);
        }
        let at_rest = vec![Lanes::from(0.0); q.len()];
        pass.assembly.posture(&pass.q, &at_rest)
    }

    /// Derivatives of the coordinates and velocities with which the rod is let go from a posture.
    pub fn let_go_by_parameters(
        &self,
        group: usize,
        posture: Posture<Lanes>,
    ) -> (Vec<[f64; LANES]>, Vec<[f64; LANES]>) {
        let (q, v) = self.lanes[group].assembly.let_go(&self.model, posture);
        (q.iter().map(slopes).collect(), v.iter().map(slopes).collect())
    }

    /// Parameters, and what follows from them alone, with the derivatives by the `group`-th [`LANES`]
    /// watched ones.
    pub fn watched(&self, group: usize) -> &Context<Lanes> {
        &self.lanes[group].assembly.context
    }

    /// Rate of forces and of memory rates by time alone, at a fixed state.
    #[expect(clippy::too_many_arguments, reason = "a state and the derivatives of its two rates")]
    pub fn by_time(
        &self,
        pass: &mut TimePass,
        time: f64,
        q: &[f64],
        v: &[f64],
        z: &[f64],
        force: &mut [f64],
        z_rate: &mut [f64],
    ) {
        let pass = &mut pass.pass;
        pass.assembly.since = self.assembly.since;
        pass.assembly.stands_still = self.assembly.stands_still;
        pass.evaluate(&self.model, Dual64::from(time).derivative(), q, v, z);
        for (out, f) in force.iter_mut().zip(&pass.force) {
            *out = f.eps;
        }
        for (out, rate) in z_rate.iter_mut().zip(&pass.z_rate) {
            *out = rate.eps;
        }
    }

    /// Power that the effects dissipate and power that a changing pressure supplies, W: what the
    /// forces do that the energies do not take, and how the energies change at a fixed state. Forces
    /// of damping resist the change of the rest length, too: that much more is supplied and dissipated.
    pub fn powers(&mut self, room: &mut TimePass, time: f64, q: &[f64], v: &[f64], z: &[f64]) -> (f64, f64) {
        self.force(time, q, v, z, &mut room.force, &mut room.z_rate);
        let work: f64 = room.force.iter().zip(v).map(|(f, v)| f * v).sum();
        let pass = &mut room.pass;
        for (moving, (q, v)) in pass.q.iter_mut().zip(q.iter().zip(v)) {
            *moving = Dual64::new(*q, *v);
        }
        for (moving, (z, rate)) in pass.z.iter_mut().zip(z.iter().zip(&room.z_rate)) {
            *moving = Dual64::new(*z, *rate);
        }
        let (elastic, potential) = pass.assembly.energy(&self.model, time.into(), &pass.q, &pass.v, &pass.z);
        let dissipated = -work - (elastic + potential).eps;
        if !self.model.is_timed() {
            return (dissipated, 0.0);
        }
        pass.lift(q, v, z);
        let now = Dual64::from(time).derivative();
        let (elastic, potential) = pass.assembly.energy(&self.model, now, &pass.q, &pass.v, &pass.z);
        let resisted = self.power_by_rest_length(&mut pass.assembly, time, &pass.q, &pass.v, &pass.z);
        (dissipated + resisted, (elastic + potential).eps + resisted)
    }

    /// Power of the forces that are no gradient of an energy, as the rest length changes strains, W; at
    /// the state of the last [`force`](Self::force).
    fn power_by_rest_length(
        &self,
        assembly: &mut Assembly<Dual64>,
        time: f64,
        q: &[Dual64],
        v: &[Dual64],
        z: &[Dual64],
    ) -> f64 {
        let (c, f) = (&self.assembly.context, &self.assembly.fields);
        if c.rest_rate == 0.0 {
            return 0.0;
        }
        // Rates of strains at fixed nodes: of stretches, and of integrated curvatures.
        let stretch = |j: usize| -(1.0 + f.stretch[j]) * c.rest_rate;
        let kappa = |i: usize| -f.kappa[i] * c.rest_rate;
        let n = c.edges;
        let mut power = 0.0;
        assembly.place(&self.model, time.into(), q, v);
        for j in 0..n {
            power += f.tension[j] * stretch(j) * c.rest_length;
            assembly.fields.stretch[j].eps = stretch(j);
        }
        for i in 0..=n {
            power += f.moment[i] * kappa(i);
            assembly.fields.kappa[i].eps = kappa(i);
        }
        if !assembly.acting.whole.is_empty() {
            assembly.fields.average(&assembly.context);
        }
        let (elastic, potential) = assembly.energy_here(&self.model, q, z);
        power - (elastic + potential).eps
    }

    /// Position, m, and velocity, m/s, of the observed tip in a state.
    pub fn observed_tip(&self, q: &[f64], v: &[f64]) -> ([f64; 2], [f64; 2]) {
        let last = q.len() - 1;
        let (sin, cos) = q[last].sin_cos();
        let arm = self.assembly.context.body.arm([cos, sin]);
        let distance = self.model.tip_distance;
        let [x, z] = [distance * cos - arm[0], distance * sin - arm[1]];
        ([q[last - 2] + x, q[last - 1] + z], [v[last - 2] - z * v[last], v[last - 1] + x * v[last]])
    }

    /// Bending moment at the root in a state, N m; positive where the rod is bent towards +z.
    pub fn root_moment(&mut self, time: f64, q: &[f64], v: &[f64], z: &[f64]) -> f64 {
        self.assembly.root_moment(&self.model, time, q, v, z)
    }

    /// Kinetic, elastic and potential energy, J.
    pub fn energy(&mut self, time: f64, q: &[f64], v: &[f64], z: &[f64]) -> (f64, f64, f64) {
        let kinetic = self.mass.iter().zip(v).map(|(m, v)| 0.5 * m * v * v).sum();
        let (elastic, potential) = self.assembly.energy(&self.model, time, q, v, z);
        (kinetic, elastic, potential)
    }

    /// Force of each active effect on the nodes.
    pub fn effect_forces(
        &mut self,
        time: f64,
        q: &[f64],
        v: &[f64],
        z: &[f64],
    ) -> Vec<(&'static str, Vec<[f64; 2]>)> {
        let all = 0..self.model.effects.len();
        all.filter_map(|k| {
            let own = self.forces_of(k, time, q, v, z)?;
            Some((self.model.effects[k].effect.about().name, own))
        })
        .collect()
    }

    /// Force of one effect of the model on the nodes; none where it exerts none as the model is.
    pub fn forces_of(
        &mut self,
        effect: usize,
        time: f64,
        q: &[f64],
        v: &[f64],
        z: &[f64],
    ) -> Option<Vec<[f64; 2]>> {
        let own = Acting::only(&self.model, effect);
        let lists = [&own.bend, &own.edge, &own.flow, &own.mass, &own.tip, &own.clamp];
        if lists.iter().all(|list| list.is_empty()) {
            return None;
        }
        let (mut force, mut z_rate) = (vec![0.0; self.model.dof()], vec![0.0; self.model.memory()]);
        let all = std::mem::replace(&mut self.assembly.acting, own);
        self.force(time, q, v, z, &mut force, &mut z_rate);
        self.assembly.acting = all;
        Some(self.assembly.fields.node_forces(&self.assembly.context))
    }

    /// The memory that each bend would have if the posture had always been this one: found by
    /// Newton's method on a rate of zero; where the rate does not depend on the memory it stays.
    pub fn relax_memory(&mut self, time: f64, q: &[f64], z: &mut [f64]) {
        if z.is_empty() {
            return;
        }
        let v = vec![0.0; q.len()];
        let mut force = vec![0.0; q.len()];
        let before = std::mem::replace(&mut self.assembly.stands_still, true);
        for _ in 0..20 {
            let rate = self.linearise(time, q, &v, z, &mut force);
            let mut largest: f64 = 0.0;
            for (z, (rate, slope)) in z.iter_mut().zip(rate.into_iter().zip(self.tangent.memory_slopes())) {
                if slope.abs() > 1e-9 {
                    *z -= rate / slope;
                    largest = largest.max((rate / slope).abs() / (1.0 + z.abs()));
                }
            }
            if largest < 1e-13 {
                break;
            }
        }
        self.assembly.stands_still = before;
    }
}

/// Room for derivatives by time and by the state's own motion.
#[derive(Clone)]
pub struct TimePass {
    pass: Pass<Dual64>,
    force: Vec<f64>,
    z_rate: Vec<f64>,
}

impl TimePass {
    /// Makes the room.
    pub fn new(model: &Model) -> Self {
        let theta = model.theta.iter().map(|value| Dual64::from(*value)).collect();
        Self {
            pass: Pass::new(model, theta, Acting::new(model)),
            force: vec![0.0; model.dof()],
            z_rate: vec![0.0; model.memory()],
        }
    }
}

impl Pass<Lanes> {
    fn for_parameters(model: &Model, group: &[Option<usize>]) -> Self {
        Self::new(model, seeded(&model.theta, group), Acting::watching(model, group))
    }
}

impl<T: Scalar> Pass<T> {
    fn new(model: &Model, theta: Vec<T>, acting: Acting) -> Self {
        let assembly = Assembly::new(model, theta, acting);
        let zero = T::from(0.0);
        let (dof, memory) = (model.dof(), model.memory());
        Self {
            mass: assembly.context.mass(),
            assembly,
            q: vec![zero; dof],
            v: vec![zero; dof],
            z: vec![zero; memory],
            force: vec![zero; dof],
            z_rate: vec![zero; memory],
        }
    }

    fn lift(&mut self, q: &[f64], v: &[f64], z: &[f64]) {
        for (lifted, plain) in [(&mut self.q, q), (&mut self.v, v), (&mut self.z, z)] {
            for (lifted, plain) in lifted.iter_mut().zip(plain) {
                *lifted = T::from(*plain);
            }
        }
    }

    fn evaluate(&mut self, model: &Model, time: T, q: &[f64], v: &[f64], z: &[f64]) {
        self.lift(q, v, z);
        let Self { assembly, q, v, z, force, z_rate, .. } = self;
        assembly.force(model, time, q, v, z, force, z_rate);
    }
}

//! The equations of motion of several rods at once: geometry, tangents and factors over [`Pack`]s, laws rod by rod.
//!
//! All that a substitution or a factorisation waits for is done for every rod together. The laws stay as they are written,
//! over plain numbers with their branches: they are a tenth of the work. Every operation on a rod is the one that
//! [`System`] does, in its order, so that a rod has the same bits as alone, whatever is beside it.

use std::array::from_fn;

use multiversion::multiversion;

use crate::assembly::{Acting, Assembly};
use crate::context::Context;
use crate::coupled::Coupled;
use crate::effects::BendTangent;
use crate::kinematics::Fields;
use crate::model::Model;
use crate::pack::{HAS_PACKS, Laid, Pack, RODS};
use crate::system::System;
use crate::tangent::Tangent;

/// The equations of motion of [`RODS`] rods with the same mesh and the same effects.
pub struct Rods {
    /// Each rod alone, for its laws.
    systems: Vec<System>,
    /// Diagonals of the mass matrices, shape `[2N+1]`, kg and kg m².
    mass: Vec<Pack>,
    assembly: Assembly<Pack>,
    tangent: Tangent<Pack>,
    matrix: Coupled<Pack>,
    /// Memory of one rod, and its rates.
    z: Vec<f64>,
    z_rate: Vec<f64>,
}

/// Whether two models are one but for the values of their parameters: equal meshes, and the same effects at work.
pub fn are_alike(a: &Model, b: &Model) -> bool {
    let effects = |model: &Model| {
        let active = model.effects.iter();
        active.map(|own| (own.effect.about().name, own.theta.clone(), own.memory.clone())).collect::<Vec<_>>()
    };
    let text = |model: &Model| {
        model.effects.iter().map(|own| own.effect.text().map(str::to_owned)).collect::<Vec<_>>()
    };
    a.edges == b.edges
        && a.scheme == b.scheme
        && a.felt_memory() == b.felt_memory()
        && Acting::new(a) == Acting::new(b)
        && effects(a) == effects(b)
        && text(a) == text(b)
}

/// Whether a model can be in a pack: its laws and its rod do not change with time.
pub fn can_be_packed(model: &Model) -> bool {
    HAS_PACKS && !model.is_timed()
}

impl Rods {
    /// Room for rods that [are like](are_alike) a model, each of them that model at first.
    pub fn new(model: &Model) -> Self {
        let systems = vec![System::new(model); RODS];
        let context = Context::of(from_fn(|rod| &systems[rod].assembly.context));
        let mass = systems[0].mass.iter().map(|mass| Pack::from(*mass)).collect();
        let assembly = Assembly {
            context,
            fields: Fields::new(model.edges),
            load_share: 1.0,
            stands_still: false,
            since: None,
            acting: Acting::new(model),
        };
        Self {
            systems,
            mass,
            assembly,
            tangent: Tangent::new(model),
            matrix: Coupled::zeros(model.dof()),
            z: vec![0.0; model.memory()],
            z_rate: vec![0.0; model.memory()],
        }
    }

    /// Puts another model in the place of a rod.
    /// # Panics
    /// If it [is not like](are_alike) the others.
    pub fn put(&mut self, rod: usize, model: &Model) {
        assert!(are_alike(&self.systems[rod].model, model), "a pack has one mesh and the same effects");
        self.systems[rod] = System::new(model);
        let systems = &self.systems;
        self.assembly.context = Context::of(from_fn(|rod| &systems[rod].assembly.context));
        for (mass, own) in self.mass.iter_mut().zip(&systems[rod].mass) {
            mass[rod] = *own;
        }
    }

    /// Generalised forces, shape `[2N+1]`, and rates of the memory.
    pub fn force(&mut self, q: &[Pack], v: &[Pack], z: &[Pack], force: &mut [Pack], z_rate: &mut [Pack]) {
        place(&mut self.assembly, q, v);
        let Self { systems, assembly, .. } = self;
        let Assembly { context, fields, acting, .. } = &mut *assembly;
        let rods = Laid { each: from_fn(|rod| &systems[rod].assembly.context), all: context };
        // Alike but for their parameters: the places of these, too.
        let effects = &systems[0].model.effects;
        for active in acting.bend.iter().map(|k| &effects[*k]) {
            let own = active.memory.clone();
            let (z, z_rate) = (&z[own.clone()], &mut z_rate[own]);
            active.effect.add_moments_of(&rods, active.theta.clone(), fields, z, z_rate);
        }
        for active in acting.edge.iter().map(|k| &effects[*k]) {
            active.effect.add_tensions_of(&rods, active.theta.clone(), fields);
        }
        for active in acting.flow.iter().map(|k| &effects[*k]) {
            active.effect.add_flows_of(&rods, active.theta.clone(), fields);
        }
        for (rod, system) in systems.iter_mut().enumerate() {
            give_end(rod, assembly, &mut system.assembly.fields);
            system.assembly.add_loads(&system.model, q[q.len() - 1][rod]);
            take_loads(rod, &system.assembly.fields, &mut assembly.fields);
        }
        gather(assembly, v, force);
    }

    /// Forces and tangents of the laws at a state.
    pub fn linearise(&mut self, q: &[Pack], v: &[Pack], z: &[Pack], force: &mut [Pack], z_rate: &mut [Pack]) {
        place(&mut self.assembly, q, v);
        let Self { systems, assembly, tangent, .. } = self;
        for (rod, system) in systems.iter_mut().enumerate() {
            give(rod, assembly, &mut system.assembly.fields);
            give_end(rod, assembly, &mut system.assembly.fields);
            take_rod(rod, z, &mut self.z);
            let angle = q[q.len() - 1][rod];
            system.linearise_laws(angle, &self.z, &mut self.z_rate);
            put_rod(rod, &self.z_rate, z_rate);
            take(rod, &system.assembly.fields, assembly);
            take_tangents(rod, &system.tangent, &assembly.acting, tangent);
        }
        keep(tangent, assembly, v, force);
    }

    /// Makes and factors the matrix of a step with `a = 1/(γh)`, 1/s, at the state of the last
    /// [`linearise`](Self::linearise); for each rod whether it is regular.
    pub fn factorize(&mut self, a: Pack) -> [bool; RODS] {
        factorize(&mut self.tangent, &self.assembly, &self.mass, &mut self.matrix, a)
    }

    /// Diagonals of the mass matrices.
    #[inline(always)]
    pub fn mass(&self) -> &[Pack] {
        &self.mass
    }

    /// As [`System::add_damping`].
    #[inline(always)]
    pub fn add_damping(&self, v: &[Pack], sum: &mut [Pack]) {
        self.tangent.add_damping(&self.mass, columns(v), columns_mut(sum));
    }

    /// As [`System::condense_residual`].
    #[inline(always)]
    pub fn condense_residual(&mut self, a: Pack, r_z: &[Pack], r_f: &mut [Pack]) {
        self.tangent.condense_residual(&self.assembly.context, a, columns(r_z), columns_mut(r_f));
    }

    /// Solves with the factors of [`factorize`](Self::factorize), in place.
    #[inline(always)]
    pub fn solve(&self, x: &mut [Pack]) {
        self.matrix.solve(x);
    }

    /// As [`System::recover_memory`].
    #[inline(always)]
    pub fn recover_memory(&mut self, a: Pack, u_q: &[Pack], u_v: &[Pack], r_z: &mut [Pack]) {
        let c = &self.assembly.context;
        self.tangent.recover_memory(c, a, columns(u_q), columns(u_v), columns_mut(r_z));
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn place(assembly: &mut Assembly<Pack>, q: &[Pack], v: &[Pack]) {
    assembly.fields.place(&assembly.context, q, v);
    if !assembly.acting.whole.is_empty() {
        assembly.fields.average(&assembly.context);
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn gather(assembly: &mut Assembly<Pack>, v: &[Pack], force: &mut [Pack]) {
    assembly.fields.resist(&assembly.context, !assembly.acting.clamp.is_empty());
    assembly.fields.gather(&assembly.context, v, force);
}

#[multiversion(targets("x86_64+avx2"))]
fn keep(tangent: &mut Tangent<Pack>, assembly: &mut Assembly<Pack>, v: &[Pack], force: &mut [Pack]) {
    tangent.keep(assembly, v, force);
}

#[multiversion(targets("x86_64+avx2"))]
fn factorize(
    tangent: &mut Tangent<Pack>,
    assembly: &Assembly<Pack>,
    mass: &[Pack],
    matrix: &mut Coupled<Pack>,
    a: Pack,
) -> [bool; RODS] {
    tangent.condense(assembly, mass, a);
    matrix.combine(a, mass, &tangent.damping, &tangent.stiffness);
    matrix.factorize_all()
}

/// Gives a rod what its laws see of the posture.
fn give(rod: usize, from: &Assembly<Pack>, to: &mut Fields<f64>) {
    let (n, acting, from) = (from.context.edges, &from.acting, &from.fields);
    if !acting.bend.is_empty() {
        take_rod(rod, &from.kappa, &mut to.kappa);
        take_rod(rod, &from.kappa_rate, &mut to.kappa_rate);
        to.mean_square_curvature = from.mean_square_curvature[rod];
    }
    if !acting.edge.is_empty() {
        take_rod(rod, &from.stretch, &mut to.stretch);
        take_rod(rod, &from.stretch_rate, &mut to.stretch_rate);
    }
    let pair = |pair: [Pack; 2]| pair.map(|x| x[rod]);
    if !acting.flow.is_empty() {
        for j in 0..n {
            to.tangent[j] = pair(from.tangent[j]);
            to.velocity[j] = pair(from.velocity[j]);
        }
    }
    to.clear();
}

/// Gives a rod what the loads on its end body see, without any of them.
fn give_end(rod: usize, from: &Assembly<Pack>, to: &mut Fields<f64>) {
    let (n, from) = (from.context.edges, &from.fields);
    let pair = |pair: [Pack; 2]| pair.map(|x| x[rod]);
    to.position[n] = pair(from.position[n]);
    to.velocity[n] = pair(from.velocity[n]);
    to.body_axis = pair(from.body_axis);
    to.body_rate = from.body_rate[rod];
    to.tip = [0.0; 3];
    to.acceleration = [0.0; 2];
    to.decay_rate = 0.0;
}

/// Takes what the laws of a rod say.
fn take(rod: usize, from: &Fields<f64>, to: &mut Assembly<Pack>) {
    let has_flow = !to.acting.flow.is_empty();
    let to = &mut to.fields;
    put_rod(rod, &from.moment, &mut to.moment);
    put_rod(rod, &from.tension, &mut to.tension);
    if has_flow {
        for (to, from) in to.outer.iter_mut().zip(&from.outer) {
            put_rod(rod, from, to);
        }
    }
    take_loads(rod, from, to);
}

/// Takes the loads of a rod.
fn take_loads(rod: usize, from: &Fields<f64>, to: &mut Fields<Pack>) {
    put_rod(rod, &from.tip, &mut to.tip);
    put_rod(rod, &from.acceleration, &mut to.acceleration);
    to.decay_rate[rod] = from.decay_rate;
}

/// Takes the tangents of the laws of a rod.
fn take_tangents(rod: usize, from: &Tangent, acting: &Acting, to: &mut Tangent<Pack>) {
    put_rod(rod, &from.by_kappa, &mut to.by_kappa);
    put_rod(rod, &from.by_kappa_rate, &mut to.by_kappa_rate);
    if !acting.whole.is_empty() {
        put_rod(rod, &from.by_mean, &mut to.by_mean);
    }
    put_rod(rod, &from.by_stretch, &mut to.by_stretch);
    put_rod(rod, &from.by_stretch_rate, &mut to.by_stretch_rate);
    if !acting.flow.is_empty() {
        for (to, from) in to.flow.iter_mut().flatten().zip(from.flow.iter().flatten()) {
            put_rod(rod, from, to);
        }
    }
    for (to, from) in to.tip.iter_mut().zip(&from.tip) {
        put_rod(rod, from, to);
    }
    for (to, BendTangent { moment, memory_rate }) in to.memory.iter_mut().zip(&from.memory) {
        put_rod(rod, moment, &mut to.moment);
        put_rod(rod, memory_rate, &mut to.memory_rate);
    }
}

/// Numbers of one rod, from packs.
pub fn take_rod(rod: usize, from: &[Pack], to: &mut [f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = from[rod];
    }
}

/// Numbers of one rod, into packs.
pub fn put_rod(rod: usize, from: &[f64], to: &mut [Pack]) {
    for (to, from) in to.iter_mut().zip(from) {
        to[rod] = *from;
    }
}

#[inline(always)]
fn columns(x: &[Pack]) -> &[[Pack; 1]] {
    x.as_chunks().0
}

#[inline(always)]
fn columns_mut(x: &mut [Pack]) -> &mut [[Pack; 1]] {
    x.as_chunks_mut().0
}

//! From an author's generic [`Law`] to an [`Effect`]: each method is one loop over the rod, compiled for
//! one law and one scalar.

use std::marker::PhantomData;

use nalgebra::SVector;
use num_dual::{Derivative, Dual64, DualSVec64};

use super::erased::{BendTangent, Effect, EffectFor, MOST_PARAMETERS};
use super::law::{Bend, Body, Edge, Flow, Law, LineMass, Mass, MassLoad, Release, Rod, Sight, Tip, TipLoad};
use super::{About, Place, Real};
use crate::kinematics::Fields;
use crate::system::Context;

/// A law with its source text, as the catalogue holds it.
pub struct Registered<L> {
    source: &'static str,
    law: PhantomData<fn() -> L>,
}

impl<L: Law> Registered<L> {
    /// Registers a law with the text of its file, whose `//!` lines are its page.
    pub const fn new(source: &'static str) -> Self {
        Self { source, law: PhantomData }
    }
}

/// Whether a law acts at a place. Asked of constants, so that no loop is compiled for a place where a law
/// does not act: with forty laws and five scalars that is most of them.
const fn acts<L: Law>(place: Place) -> bool {
    let mut k = 0;
    while k < L::ABOUT.places.len() {
        if L::ABOUT.places[k] as u8 == place as u8 {
            return true;
        }
        k += 1;
    }
    false
}

/// Memories of a law at every bend, counted as one where it has none: its loops run once for each.
const fn branches<L: Law>() -> usize {
    if L::ABOUT.memory == 0 { 1 } else { L::ABOUT.memory }
}

/// Bend `i` as a law sees it, with one of its memories `z`, shape `[memories, N+1]`.
fn bend_at<'a, T: Real>(c: &'a Context<T>, f: &Fields<T>, i: usize, branch: usize, z: &[T]) -> Bend<'a, T> {
    let per_length = c.per_voronoi[i];
    let kappa = f.kappa[i] * per_length;
    Bend {
        kappa,
        kappa_rate: f.kappa_rate[i] * per_length - kappa * c.rest_rate,
        mean_square_curvature: f.mean_square_curvature,
        branch,
        memory: z.get(branch * (c.edges + 1) + i).copied().unwrap_or_else(|| T::from(0.0)),
        position: c.stencil.position(i),
        time: c.time,
        rod: &c.rod,
    }
}

fn edge_at<'a, T: Real>(c: &'a Context<T>, f: &Fields<T>, j: usize) -> Edge<'a, T> {
    Edge {
        stretch: f.stretch[j],
        stretch_rate: f.stretch_rate[j] - (f.stretch[j] + 1.0) * c.rest_rate,
        position: (j as f64 + 0.5) * c.per_edges,
        time: c.time,
        rod: &c.rod,
    }
}

fn flow_at<'a, T: Real>(c: &'a Context<T>, f: &Fields<T>, j: usize) -> Flow<'a, T> {
    let [tangential_velocity, normal_velocity] = f.midpoint_velocity(j);
    Flow {
        tangential_velocity,
        normal_velocity,
        position: (j as f64 + 0.5) * c.per_edges,
        time: c.time,
        rod: &c.rod,
    }
}

impl<L: Law, T: Real> EffectFor<T> for Registered<L> {
    fn add_moments(&self, c: &Context<T>, theta: &[T], f: &mut Fields<T>, z: &[T], z_rate: &mut [T]) {
        if const { !acts::<L>(Place::Bend) } {
            return;
        }
        for branch in 0..branches::<L>() {
            for i in 0..=c.edges {
                let law = L::bend(&bend_at(c, f, i, branch, z), theta);
                f.moment[i] += law.moment;
                if let Some(rate) = z_rate.get_mut(branch * (c.edges + 1) + i) {
                    *rate = law.memory_rate;
                }
            }
        }
    }

    fn add_tensions(&self, c: &Context<T>, theta: &[T], f: &mut Fields<T>) {
        if const { !acts::<L>(Place::Edge) } {
            return;
        }
        for j in 0..c.edges {
            let tension = L::edge(&edge_at(c, f, j), theta);
            f.tension[j] += tension;
        }
    }

    fn add_flows(&self, c: &Context<T>, theta: &[T], f: &mut Fields<T>) {
        if const { !acts::<L>(Place::Flow) } {
            return;
        }
        for j in 0..c.edges {
            let [along, across] = L::flow(&flow_at(c, f, j), theta);
            f.add_outer_force(j, along * c.rest_length, across * c.rest_length);
        }
    }

    fn flow(&self, at: &Flow<T>, theta: &[T]) -> [T; 2] {
        L::flow(at, theta)
    }

    fn mass(&self, at: &Mass<T>, theta: &[T]) -> MassLoad<T> {
        L::mass(at, theta)
    }

    fn tip(&self, at: &Tip<T>, theta: &[T]) -> TipLoad<T> {
        L::tip(at, theta)
    }

    fn body(&self, theta: &[T]) -> Body<T> {
        L::body(theta)
    }

    fn shift(&self, theta: &[T]) -> T {
        L::shift(theta)
    }

    fn inertia(&self, at_release: &Rod<T>, theta: &[T]) -> LineMass<T> {
        L::inertia(at_release, theta)
    }

    fn clamp(&self, theta: &[T]) -> T {
        L::clamp(theta)
    }

    fn sensor(&self, at: &Sight<T>, theta: &[T]) -> [T; 2] {
        L::sensor(at, theta)
    }

    fn clock(&self, recorded: T, theta: &[T]) -> T {
        L::clock(recorded, theta)
    }

    fn release(&self, theta: &[T]) -> Release<T> {
        L::release(theta)
    }

    fn energy(&self, c: &Context<T>, theta: &[T], f: &Fields<T>, z: &[T], tip: &Tip<T>) -> T {
        let mut energy = L::tip_energy(tip, theta);
        if const { acts::<L>(Place::Bend) } {
            for branch in 0..branches::<L>() {
                for i in 0..=c.edges {
                    energy += L::bend_energy(&bend_at(c, f, i, branch, z), theta) / c.per_voronoi[i];
                }
            }
        }
        if const { acts::<L>(Place::Edge) } {
            for j in 0..c.edges {
                energy += L::edge_energy(&edge_at(c, f, j), theta) * c.rest_length;
            }
        }
        energy
    }
}

/// The `k`-th of `N` independent variables of a local law.
fn variable<const N: usize>(value: f64, k: usize) -> DualSVec64<N> {
    let mut eps = SVector::zeros();
    eps[k] = 1.0;
    DualSVec64::new(value, Derivative::some(eps))
}

/// The rate of a strain, the second variable, which falls as the strain, the first one, grows against a
/// rest length that changes.
fn strain_rate<const N: usize>(value: f64, by_strain: f64) -> DualSVec64<N> {
    let mut eps = SVector::zeros();
    eps[0] = by_strain;
    eps[1] = 1.0;
    DualSVec64::new(value, Derivative::some(eps))
}

fn derivative<const N: usize>(x: &DualSVec64<N>) -> [f64; N] {
    x.eps.0.map_or([0.0; N], |eps| eps.data.0[0])
}

impl<L: Law> Effect for Registered<L> {
    fn about(&self) -> &'static About {
        &L::ABOUT
    }

    fn page(&self) -> String {
        let lines = self.source.lines().map_while(|line| line.strip_prefix("//!"));
        let text: Vec<_> = lines.map(|line| line.strip_prefix(' ').unwrap_or(line)).collect();
        text.join("\n")
    }

    fn linearise_moments(
        &self,
        c: &Context<f64>,
        theta: &[f64],
        f: &mut Fields<f64>,
        z: &[f64],
        by_kappa: &mut [f64],
        by_rate: &mut [f64],
        memory: &mut [BendTangent],
        z_rate: &mut [f64],
    ) {
        if const { !acts::<L>(Place::Bend) } {
            return;
        }
        let rod = c.rod.map(DualSVec64::<3>::from);
        let theta = lifted(theta);
        let theta = &theta[..L::ABOUT.parameters.len()];
        for branch in 0..branches::<L>() {
            for i in 0..=c.edges {
                let here = bend_at(c, f, i, branch, z);
                let law = L::bend(
                    &Bend {
                        kappa: variable(here.kappa, 0),
                        kappa_rate: strain_rate(here.kappa_rate, -c.rest_rate),
                        mean_square_curvature: here.mean_square_curvature.into(),
                        branch,
                        memory: variable(here.memory, 2),
                        position: here.position,
                        time: here.time.into(),
                        rod: &rod,
                    },
                    theta,
                );
                let per_length = c.per_voronoi[i];
                let [mut a, mut b, m_z] = derivative(&law.moment);
                a *= per_length;
                b *= per_length;
                f.moment[i] += law.moment.re;
                by_kappa[i] += a;
                by_rate[i] += b;
                let own = branch * (c.edges + 1) + i;
                if let Some(tangent) = memory.get_mut(own) {
                    let [g_kappa, g_rate, g_z] = derivative(&law.memory_rate);
                    tangent.moment = [a, b, m_z];
                    tangent.memory_rate = [g_kappa * per_length, g_rate * per_length, g_z];
                    z_rate[own] = law.memory_rate.re;
                }
            }
        }
    }

    fn linearise_by_mean(
        &self,
        c: &Context<f64>,
        theta: &[f64],
        f: &Fields<f64>,
        z: &[f64],
        by_mean: &mut [f64],
    ) {
        if const { !acts::<L>(Place::Whole) } {
            return;
        }
        let rod = c.rod.map(Dual64::from);
        let theta = lifted(theta);
        let theta = &theta[..L::ABOUT.parameters.len()];
        let bends = (0..branches::<L>()).flat_map(|branch| (0..=c.edges).map(move |i| (branch, i)));
        for (branch, i) in bends {
            let here = bend_at(c, f, i, branch, z);
            let law = L::bend(
                &Bend {
                    kappa: here.kappa.into(),
                    kappa_rate: here.kappa_rate.into(),
                    mean_square_curvature: Dual64::from(here.mean_square_curvature).derivative(),
                    branch,
                    memory: here.memory.into(),
                    position: here.position,
                    time: here.time.into(),
                    rod: &rod,
                },
                theta,
            );
            assert!(
                law.memory_rate.eps == 0.0,
                "{}: the rate of a memory depends on the whole rod",
                L::ABOUT.name
            );
            by_mean[i] += law.moment.eps;
        }
    }

    fn linearise_tensions(
        &self,
        c: &Context<f64>,
        theta: &[f64],
        f: &mut Fields<f64>,
        by_stretch: &mut [f64],
        by_rate: &mut [f64],
    ) {
        if const { !acts::<L>(Place::Edge) } {
            return;
        }
        let rod = c.rod.map(DualSVec64::<2>::from);
        let theta = lifted(theta);
        let theta = &theta[..L::ABOUT.parameters.len()];
        for j in 0..c.edges {
            let here = edge_at(c, f, j);
            let tension = L::edge(
                &Edge {
                    stretch: variable(here.stretch, 0),
                    stretch_rate: strain_rate(here.stretch_rate, -c.rest_rate),
                    position: here.position,
                    time: here.time.into(),
                    rod: &rod,
                },
                theta,
            );
            let [a, b] = derivative(&tension);
            f.tension[j] += tension.re;
            by_stretch[j] += a;
            by_rate[j] += b;
        }
    }

    fn linearise_flows(
        &self,
        c: &Context<f64>,
        theta: &[f64],
        f: &mut Fields<f64>,
        by_velocity: &mut [[[f64; 2]; 2]],
    ) {
        if const { !acts::<L>(Place::Flow) } {
            return;
        }
        let rod = c.rod.map(DualSVec64::<2>::from);
        let theta = lifted(theta);
        let theta = &theta[..L::ABOUT.parameters.len()];
        for j in 0..c.edges {
            let here = flow_at(c, f, j);
            let force = L::flow(
                &Flow {
                    tangential_velocity: variable(here.tangential_velocity, 0),
                    normal_velocity: variable(here.normal_velocity, 1),
                    position: here.position,
                    time: here.time.into(),
                    rod: &rod,
                },
                theta,
            );
            f.add_outer_force(j, force[0].re * c.rest_length, force[1].re * c.rest_length);
            for (row, force) in by_velocity[j].iter_mut().zip(&force) {
                for (entry, slope) in row.iter_mut().zip(derivative(force)) {
                    *entry += slope * c.rest_length;
                }
            }
        }
    }

    fn linearise_tip(&self, at: &Tip<f64>, theta: &[f64]) -> [[f64; 6]; 3] {
        if const { !acts::<L>(Place::Tip) } {
            return [[0.0; 6]; 3];
        }
        let rod = at.rod.map(DualSVec64::<6>::from);
        let theta = lifted(theta);
        let load = L::tip(
            &Tip {
                position: [variable(at.position[0], 0), variable(at.position[1], 1)],
                angle: variable(at.angle, 2),
                velocity: [variable(at.velocity[0], 3), variable(at.velocity[1], 4)],
                angular_velocity: variable(at.angular_velocity, 5),
                center: at.center.map(DualSVec64::<6>::from),
                time: at.time.into(),
                rod: &rod,
            },
            &theta[..L::ABOUT.parameters.len()],
        );
        [&load.force[0], &load.force[1], &load.moment].map(derivative)
    }
}

/// An effect's parameters as constants of another scalar, without allocation.
fn lifted<T: Real>(theta: &[f64]) -> [T; MOST_PARAMETERS] {
    let mut lifted = [T::from(0.0); MOST_PARAMETERS];
    for (lifted, value) in lifted.iter_mut().zip(theta) {
        *lifted = T::from(*value);
    }
    lifted
}

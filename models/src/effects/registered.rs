//! From laws over a generic scalar to an [`Effect`]: each method is one loop over the rod, compiled for
//! one [`Law`] and one scalar.

use std::ops::Range;

use nalgebra::SVector;
use num_dual::{Derivative, Dual64, DualSVec64};

use super::about::{About, Place};
use super::erased::{BendTangent, Effect, EffectFor, MOST_PARAMETERS};
use super::law::{Bend, Body, Edge, Flow, Law, Line, LineMass, Mass, MassLoad, Release, Sight, Tip, TipLoad};
use super::packed;
use crate::context::Context;
use crate::kinematics::Fields;
use crate::pack::{HAS_PACKS, Laid, Pack};
use crate::real::Real;
use crate::rod::Rod;

/// An effect by its laws.
pub struct Registered<L> {
    law: L,
    source: &'static str,
}

impl<L: Law> Registered<L> {
    /// Registers the laws of an effect with the text of their file, whose `//!` lines are its page.
    pub const fn new(law: L, source: &'static str) -> Self {
        Self { law, source }
    }

    /// Memories of the laws at every bend, counted as one where there is none: loops run once for each.
    fn branches(&self) -> usize {
        self.law.about().memory.max(1)
    }
}

/// Whether laws can act at a place. Evaluated from constants, so that no loop is compiled for a place where
/// they cannot: with forty laws and five scalars that is most of them.
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

/// Bend `i` as a law sees it, with one of its memories `z`, shape `[memories, N+1]`.
pub(crate) fn bend_at<'a, T: Real>(
    c: &'a Context<T>,
    f: &Fields<T>,
    i: usize,
    branch: usize,
    z: &[T],
) -> Bend<'a, T> {
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

pub(crate) fn edge_at<'a, T: Real>(c: &'a Context<T>, f: &Fields<T>, j: usize) -> Edge<'a, T> {
    Edge {
        stretch: f.stretch[j],
        stretch_rate: f.stretch_rate[j] - (f.stretch[j] + 1.0) * c.rest_rate,
        position: (j as f64 + 0.5) * c.per_edges,
        time: c.time,
        rod: &c.rod,
    }
}

pub(crate) fn flow_at<'a, T: Real>(c: &'a Context<T>, f: &Fields<T>, j: usize) -> Flow<'a, T> {
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
        for branch in 0..self.branches() {
            for i in 0..=c.edges {
                let law = self.law.bend(&bend_at(c, f, i, branch, z), theta);
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
            let tension = self.law.edge(&edge_at(c, f, j), theta);
            f.tension[j] += tension;
        }
    }

    fn add_flows(&self, c: &Context<T>, theta: &[T], f: &mut Fields<T>) {
        if const { !acts::<L>(Place::Flow) } {
            return;
        }
        for j in 0..c.edges {
            let [along, across] = self.law.flow(&flow_at(c, f, j), theta);
            f.add_outer_force(j, along * c.rest_length, across * c.rest_length);
        }
    }

    fn flow(&self, at: &Flow<T>, theta: &[T]) -> [T; 2] {
        self.law.flow(at, theta)
    }

    fn mass(&self, at: &Mass<T>, theta: &[T]) -> MassLoad<T> {
        self.law.mass(at, theta)
    }

    fn tip(&self, at: &Tip<T>, theta: &[T]) -> TipLoad<T> {
        self.law.tip(at, theta)
    }

    fn body(&self, theta: &[T]) -> Body<T> {
        self.law.body(theta)
    }

    fn shift(&self, theta: &[T]) -> T {
        self.law.shift(theta)
    }

    fn inertia(&self, at_release: &Rod<T>, theta: &[T]) -> LineMass<T> {
        self.law.inertia(at_release, theta)
    }

    fn clamp(&self, theta: &[T]) -> T {
        self.law.clamp(theta)
    }

    fn sensor(&self, at: &Sight<T>, theta: &[T]) -> [T; 2] {
        self.law.sensor(at, theta)
    }

    fn clock(&self, recorded: T, theta: &[T]) -> T {
        self.law.clock(recorded, theta)
    }

    fn line(&self, at: &Line<T>, theta: &[T]) -> [T; 2] {
        self.law.line(at, theta)
    }

    fn dead_time(&self, theta: &[T]) -> T {
        self.law.dead_time(theta)
    }

    fn release(&self, theta: &[T]) -> Release<T> {
        self.law.release(theta)
    }

    fn energy(&self, c: &Context<T>, theta: &[T], f: &Fields<T>, z: &[T], tip: &Tip<T>) -> T {
        let mut energy = self.law.tip_energy(tip, theta);
        if const { acts::<L>(Place::Bend) } {
            for branch in 0..self.branches() {
                for i in 0..=c.edges {
                    energy += self.law.bend_energy(&bend_at(c, f, i, branch, z), theta) / c.per_voronoi[i];
                }
            }
        }
        if const { acts::<L>(Place::Edge) } {
            for j in 0..c.edges {
                energy += self.law.edge_energy(&edge_at(c, f, j), theta) * c.rest_length;
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
        self.law.about()
    }

    fn page(&self) -> String {
        let head = || {
            let lines = self.source.lines().map_while(|line| line.strip_prefix("//!"));
            lines.map(|line| line.strip_prefix(' ').unwrap_or(line)).collect::<Vec<_>>().join("\n")
        };
        self.law.page().map_or_else(head, str::to_owned)
    }

    fn text(&self) -> Option<&str> {
        self.law.text()
    }

    fn needs_diameter(&self) -> bool {
        self.law.needs_diameter()
    }

    fn add_moments_of(
        &self,
        rods: &Laid,
        theta: Range<usize>,
        f: &mut Fields<Pack>,
        z: &[Pack],
        z_rate: &mut [Pack],
    ) {
        if const { HAS_PACKS && acts::<L>(Place::Bend) } {
            packed::moments(&self.law, rods, theta, f, z, z_rate);
        }
    }

    fn add_tensions_of(&self, rods: &Laid, theta: Range<usize>, f: &mut Fields<Pack>) {
        if const { HAS_PACKS && acts::<L>(Place::Edge) } {
            packed::tensions(&self.law, rods, theta, f);
        }
    }

    fn add_flows_of(&self, rods: &Laid, theta: Range<usize>, f: &mut Fields<Pack>) {
        if const { HAS_PACKS && acts::<L>(Place::Flow) } {
            packed::flows(&self.law, rods, theta, f);
        }
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
        let theta = &theta[..self.law.about().parameters.len()];
        for branch in 0..self.branches() {
            for i in 0..=c.edges {
                let here = bend_at(c, f, i, branch, z);
                let law = self.law.bend(
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
        let theta = &theta[..self.law.about().parameters.len()];
        let bends = (0..self.branches()).flat_map(|branch| (0..=c.edges).map(move |i| (branch, i)));
        for (branch, i) in bends {
            let here = bend_at(c, f, i, branch, z);
            let law = self.law.bend(
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
                self.law.about().name
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
        let theta = &theta[..self.law.about().parameters.len()];
        for j in 0..c.edges {
            let here = edge_at(c, f, j);
            let tension = self.law.edge(
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
        let theta = &theta[..self.law.about().parameters.len()];
        for j in 0..c.edges {
            let here = flow_at(c, f, j);
            let force = self.law.flow(
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
        let load = self.law.tip(
            &Tip {
                position: [variable(at.position[0], 0), variable(at.position[1], 1)],
                angle: variable(at.angle, 2),
                velocity: [variable(at.velocity[0], 3), variable(at.velocity[1], 4)],
                angular_velocity: variable(at.angular_velocity, 5),
                center: at.center.map(DualSVec64::<6>::from),
                time: at.time.into(),
                rod: &rod,
            },
            &theta[..self.law.about().parameters.len()],
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

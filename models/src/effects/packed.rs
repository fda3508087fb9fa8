//! The loops of [`registered`](super::registered) over the rods of a pack: laws see one rod at a time, as plain numbers.

use std::ops::Range;

use multiversion::multiversion;

use super::law::{Bend, Edge, Flow, Law};
use crate::kinematics::Fields;
use crate::pack::{Laid, Pack};

/// Moments of the rods of a pack, bend by bend.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn moments<L: Law>(
    law: &L,
    rods: &Laid,
    theta: Range<usize>,
    f: &mut Fields<Pack>,
    z: &[Pack],
    z_rate: &mut [Pack],
) {
    let c = rods.all;
    for branch in 0..law.about().memory.max(1) {
        for i in 0..=c.edges {
            let per_length = c.per_voronoi[i];
            let kappa = f.kappa[i] * per_length;
            let kappa_rate = f.kappa_rate[i] * per_length - kappa * c.rest_rate;
            let memory = z.get(branch * (c.edges + 1) + i).copied().unwrap_or_default();
            let position = c.stencil.position(i);
            let (mut moment, mut rate) = (Pack::default(), Pack::default());
            for (rod, context) in rods.each.iter().enumerate() {
                let here = Bend {
                    kappa: kappa[rod],
                    kappa_rate: kappa_rate[rod],
                    mean_square_curvature: f.mean_square_curvature[rod],
                    branch,
                    memory: memory[rod],
                    position,
                    time: context.time,
                    rod: &context.rod,
                };
                let said = law.bend(&here, &context.theta[theta.clone()]);
                (moment[rod], rate[rod]) = (said.moment, said.memory_rate);
            }
            f.moment[i] += moment;
            if let Some(own) = z_rate.get_mut(branch * (c.edges + 1) + i) {
                *own = rate;
            }
        }
    }
}

/// Tensions of the rods of a pack, edge by edge.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn tensions<L: Law>(law: &L, rods: &Laid, theta: Range<usize>, f: &mut Fields<Pack>) {
    let c = rods.all;
    for j in 0..c.edges {
        let stretch = f.stretch[j];
        let stretch_rate = f.stretch_rate[j] - (stretch + 1.0) * c.rest_rate;
        let position = (j as f64 + 0.5) * c.per_edges;
        let mut tension = Pack::default();
        for (rod, context) in rods.each.iter().enumerate() {
            let here = Edge {
                stretch: stretch[rod],
                stretch_rate: stretch_rate[rod],
                position,
                time: context.time,
                rod: &context.rod,
            };
            tension[rod] = law.edge(&here, &context.theta[theta.clone()]);
        }
        f.tension[j] += tension;
    }
}

/// Outer forces on the rods of a pack, edge by edge.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn flows<L: Law>(law: &L, rods: &Laid, theta: Range<usize>, f: &mut Fields<Pack>) {
    let c = rods.all;
    for j in 0..c.edges {
        let [tangential_velocity, normal_velocity] = f.midpoint_velocity(j);
        let position = (j as f64 + 0.5) * c.per_edges;
        let (mut along, mut across) = (Pack::default(), Pack::default());
        for (rod, context) in rods.each.iter().enumerate() {
            let here = Flow {
                tangential_velocity: tangential_velocity[rod],
                normal_velocity: normal_velocity[rod],
                position,
                time: context.time,
                rod: &context.rod,
            };
            [along[rod], across[rod]] = law.flow(&here, &context.theta[theta.clone()]);
        }
        f.add_outer_force(j, along * c.rest_length, across * c.rest_length);
    }
}

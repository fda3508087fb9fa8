//! What shear and rotary inertia of the section, which the model leaves out, do to a mode: the first order of
//! Timoshenko's beam.
//!
//! Both are small terms of an energy, so the mode without them gives their first order (Rayleigh):
//!
//! ```text
//! ω² = ω₀² / (1 + x),   x = ∫ m r² φ̇² ds + E/(k G) r² ∫ V² ds / (EI ω₀²)
//! ```
//!
//! with the mode's turns φ̇ and shear forces V = dM/ds, for a modal mass of one; r² = I/A. A bare cantilever has
//! x = 4.65 (1 + E/(k G)) (r/L)² in its first mode.
//!
//! Source: Timoshenko (1921), Philosophical Magazine 41, 744-746; the shear coefficient k of a round section by Cowper
//! (1966), Journal of Applied Mechanics 33, 335-340.

use crate::model::Model;
use crate::system::System;

use super::{Equilibrium, Mode};

/// E/(k G) of a material that keeps its volume, as rubber does: E = 3 G and k = 0.9. Of a metal it is 2.9.
const SHEAR: f64 = 10.0 / 3.0;

/// x of a mode about a rest posture; none where the section is not known.
pub fn section_share(model: &Model, at: &Equilibrium, mode: &Mode) -> Option<f64> {
    let square = model.gyration_square()?;
    let mut system = System::at_rest(model);
    system.assembly.place(model, at.time, &at.q, &mode.shape);
    let (c, f) = (&system.assembly.context, &system.assembly.fields);
    let turns: f64 = f.edge_rate.iter().map(|rate| rate * rate).sum();
    let rotary = c.rod.mass * c.per_edges * turns;
    let moment = |i: usize| c.rod.bending_stiffness * f.kappa_rate[i] * c.per_voronoi[i];
    let position = |i: usize| c.stencil.position(i) * c.rod.length;
    let shear_of = |j: usize| (moment(j + 1) - moment(j)) / (position(j + 1) - position(j));
    let shear: f64 = (0..c.edges).map(|j| shear_of(j).powi(2) * c.rest_length).sum();
    let stiffness = c.rod.bending_stiffness * mode.angular_frequency.powi(2);
    Some(square * (rotary + SHEAR * shear / stiffness))
}

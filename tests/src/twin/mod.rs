//! Twins: recordings of a muscle whose every parameter is known.
//!
//! This is the one deliberate second copy of the physics. A fit that is tried on data of its own
//! model finds its own errors agreeable, so the twin shares nothing with `models` but the muscle's
//! table: another formulation (Hermite elements with gradients for a discrete rod), another mesh,
//! another integrator (SDIRK for RODAS4), another start. Where both agree, it is the continuum that
//! they agree on.
//!
//! `beam` → `motion` → `session` (a hand raises and lets go, six times) → `sensor` (what cameras make
//! of it) → a [`Recording`](efam_recordings::Recording), or `direct` to releases without any cleaning.
//! For diagnosis, `hidden` effects make a beam a `specimen`, and a plan and a seed an experiment with it:
//! `drawn`, and `lab` writes it as files.

use models::muscle::{AtPressure, Extrapolation, Muscle};

pub mod band;
pub mod beam;
pub mod direct;
pub mod drawn;
pub mod element;
pub mod hidden;
pub mod lab;
pub mod mesh;
pub mod motion;
pub mod random;
pub mod rest;
pub mod sensor;
pub mod session;
pub mod site;
pub mod specimen;
pub mod study;
pub mod text;
pub mod tracker;

/// The paper's muscle and its row at a pressure, psi: data, read from `models`.
fn table(psi: f64) -> (Muscle, AtPressure) {
    let muscle = Muscle::built_in("garbulinski-2022").expect("it is built in");
    let at = muscle.at(psi * crate::PSI, "pder_32", Extrapolation::Refused).expect("in the table");
    (muscle, at)
}

/// What the file of an experiment has to say of the muscle that [`muscle`] makes: its fitting is a point
/// mass, and no air is in it.
pub const AS_DRAWN: &str = "[effects.end_fitting]\nrotary_inertia = \"0 kg m^2\"  # as drawn: a point mass\n\n\
    [effects.enclosed_air]\ninner_diameter = \"0 m\"       # as drawn: without air\n";

/// The twin of the paper's muscle at a pressure, psi, with Rayleigh damping `alpha`, 1/s, and `beta`, s.
pub fn muscle(psi: f64, elements: usize, alpha: f64, beta: f64) -> beam::Beam {
    let (muscle, at) = table(psi);
    let fitting = muscle.end_fitting;
    let fitting = beam::Body { mass: fitting.mass, center: fitting.center_of_mass, inertia: 0.0 };
    beam::Beam {
        elements,
        length: at.length,
        mass: muscle.rest.mass_per_length * muscle.rest.length,
        bending_stiffness: at.bending_stiffness,
        axial_stiffness: at.axial_stiffness,
        axial_compliance: 0.0,
        bodies: vec![fitting],
        gravity: muscle.gravity,
        incline: 0.0,
        alpha,
        beta,
    }
}

/// One of its releases at a pressure, psi, which has a `drift` from −1 to 1 among its like.
pub fn occasion(psi: f64, drift: f64) -> hidden::Occasion {
    let (_, at) = table(psi);
    hidden::Occasion { pressure: at.pressure, diameter: at.outer_diameter, drift }
}

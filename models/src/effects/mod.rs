//! Physical effects: what may act on the rod, one file each.
//!
//! An effect says *where* it acts and *what* it does there, as a law over a generic scalar. The
//! shared stencil turns that into generalised forces, tangents and sensitivities; the catalogue,
//! scenario keys, pages and tests follow from [`About`].

mod about;
mod catalogue;
mod erased;
pub(crate) mod law;
mod memory;
mod packed;
mod registered;

pub use crate::real::Real;
pub use crate::rod::Rod;
pub use about::{About, Kind, Parameter, Per, Place, Reach, Separator};
pub use catalogue::{Catalogue, NameTaken};
pub use erased::{BendTangent, Effect, EffectFor, LANES, Lanes, MOST_PARAMETERS, Scalar};
pub use law::{
    BODY_PARAMETERS, Bend, Body, Edge, Flow, Law, Line, LineMass, Mass, MassLoad, Moment, Release, Sight,
    Tip, TipLoad, named,
};
pub use registered::Registered;
pub(crate) use registered::{bend_at, edge_at, flow_at};

/// Declares the effects' files and the catalogue that holds them.
macro_rules! catalogue {
    ($($file:ident :: $law:ident,)*) => {
        $(pub mod $file;)*

        /// Every effect that a model can have, in the order in which pages list them, and in which those
        /// on what is observed follow one another.
        pub static CATALOGUE: &[&dyn Effect] =
            &[$(&Registered::new($file::$law, include_str!(concat!(stringify!($file), ".rs"))),)*];
    };
}

catalogue! {
    stretch::Stretch,
    bend::Bending,
    gravity::Gravity,
    end_fitting::EndFitting,
    payload::Payload,
    rayleigh_mass::RayleighMass,
    rayleigh_stiffness::RayleighStiffness,
    tip_load::TipForce,
    tip_hold::TipHold,
    air_drag::AirDrag,
    viscoelastic::Viscoelastic,
    clamp_compliance::ClampCompliance,
    tip_drag::TipDrag,
    linear_drag::LinearDrag,
    braid_friction::BraidFriction,
    friction_over_pressure::FrictionOverPressure,
    hysteresis::Hysteresis,
    dahl::Dahl,
    creep::Creep,
    relaxation::Relaxation,
    structural_damping::StructuralDamping,
    cubic_stiffness::CubicStiffness,
    quadratic_stiffness::QuadraticStiffness,
    stiffness_taper::StiffnessTaper,
    clamp_friction::ClampFriction,
    hose::Hose,
    tip_mass::TipMass,
    tip_inertia::TipInertia,
    axial_compliance::AxialCompliance,
    hand_release::HandRelease,
    stiffness_drift::StiffnessDrift,
    release_drift::ReleaseDrift,
    strain_rate_cubed::StrainRateCubed,
    initial_velocity::InitialVelocity,
    set_curvature::SetCurvature,
    damping_over_pressure::DampingOverPressure,
    tip_offset::TipOffset,
    added_mass::AddedMass,
    enclosed_air::EnclosedAir,
    pressure_volume::PressureVolume,
    latent_moment::LatentMoment,
    pressure_line::PressureLine,
    // In the order in which they act between a point of the rod and its place in a recording.
    marker_offset::MarkerOffset,
    out_of_plane::OutOfPlane,
    frame_tilt::FrameTilt,
    scale::Scale,
    clock::Clock,
}

/// The effect of the catalogue of that name; laws that were read from text are in a [`Catalogue`].
pub fn by_name(name: &str) -> Option<&'static dyn Effect> {
    CATALOGUE.iter().copied().find(|effect| effect.about().name == name)
}

/// Pressure of a rod over a reference, Pa each; none below ambient, where losses would turn into gains.
fn relative_pressure<T: Real>(rod: &Rod<T>, reference: T) -> T {
    if rod.pressure.re() > 0.0 { rod.pressure / reference } else { T::from(0.0) }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::Rod;
    use crate::model::{Model, ModelSpec, Scheme};

    /// A rod of 40 edges at 2 bar with some effects, for the tests that they have of their own.
    pub(crate) fn rod_with(effects: &[(&str, &[(&str, f64)])]) -> Model {
        let owned = |(key, value): &(&str, f64)| ((*key).to_owned(), *value);
        let effects =
            effects.iter().map(|(name, values)| ((*name).to_owned(), values.iter().map(owned).collect()));
        Model::new(&ModelSpec {
            nodes: 41,
            rod: Rod {
                length: 0.3,
                mass: 0.03,
                bending_stiffness: 0.01,
                axial_stiffness: 300.0,
                diameter: 0.02,
                pressure: 2e5,
            },
            base_angle: 0.1,
            release_angle: 0.2,
            release_rate: 0.3,
            scheme: Scheme::Consistent,
            tip_distance: 0.01,
            effects: effects.collect(),
            catalogue: Default::default(),
            schedule: None,
        })
        .unwrap()
    }
}

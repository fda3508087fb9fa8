//! Physics that a twin has and the model that is fitted to it has not.
//!
//! The laws are written a second time here, on purpose: a diagnosis that is tried on the laws of its
//! own catalogue finds its own discretisation agreeable. Here they act on the beam's strains at Gauss
//! points (`strain`), on what moves through the air and on the tip (`outside`), on
//! the beam's own data, its clamp and its start (`data`), and on what the cameras see (`seen`). Parameters
//! mean what the catalogue of effects means by them; but how sharply friction turns is chosen apart,
//! because no constant that nobody has measured should be known to both sides.
//!
//! Three effects are in no catalogue: what no diagnosis can name, and should not.

mod data;
mod outside;
mod seen;
mod strain;

use std::mem::discriminant;

use models::effects::by_name;

pub use data::Occasion;
pub use outside::{Gust, Slosh, TipState};
pub use strain::Strain;

use super::element::Real;

/// Rate of curvature at which friction has three quarters of its value, 1/(m s): some two-hundredth of
/// the fastest in a swing. With a third of it a release with friction costs twice as much.
pub const TURNS_OVER: f64 = 0.3;
/// Distance from the clamp within which its friction rubs, m: about the muscle's diameter, so that
/// elements resolve it.
pub const CLAMP_RUBS: f64 = 0.03;
/// Density of the air, kg/m³.
pub const AIR: f64 = 1.2;

/// An effect, with its parameters in SI; each vanishes where its first parameter is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
#[rustfmt::skip]
pub enum Hidden {
    /// Force `−½ ρ C_d D |v_n| v_n` across the rod, per length; D its outer diameter.
    AirDrag { /** C_d */ drag_coefficient: f64 },
    /// Force `−½ ρ C_dA |v| v` on the fitting's centre of mass.
    TipDrag { /** C_d A, m² */ drag_area: f64 },
    /// Force `−c v` per length.
    LinearDrag { /** c, N s/m² */ coefficient: f64 },
    /// Mass that moves with the rod and has no weight.
    AddedMass { /** kg/m */ mass_per_length: f64 },
    /// Moment `M_f tanh(κ̇/κ̇₀)`.
    BraidFriction { /** M_f, N m */ moment: f64 },
    /// Moment `η EI |κ| tanh(κ̇/κ̇₀)`.
    Hysteresis { /** η */ loss_factor: f64 },
    /// Moment `M_f z`, `ż = (κ̇ − |κ̇| z) / κ_y`.
    Dahl { /** M_f, N m */ moment: f64, /** κ_y, 1/m */ yield_curvature: f64 },
    /// Moment `g EI (κ − z)`, `ż = (κ − z) / τ`.
    Viscoelastic { /** g */ branch_stiffness: f64, /** τ, s */ relaxation_time: f64 },
    /// The same, slowly.
    Creep { /** g */ branch_stiffness: f64, /** τ, s */ relaxation_time: f64 },
    /// Moment `EI k₃ κ³`.
    CubicStiffness { /** k₃, m² */ coefficient: f64 },
    /// Moment `EI k₂ κ²`.
    QuadraticStiffness { /** k₂, m */ coefficient: f64 },
    /// Moment `−EI (κ₀ + κ_p p)`.
    SetCurvature { /** κ₀, 1/m */ curvature: f64, /** κ_p, 1/(m Pa) */ by_pressure: f64 },
    /// Moment `EI e (s/L − ½) κ`.
    StiffnessTaper { /** e */ taper: f64 },
    /// Moment `EI c ⟨κ²⟩ κ`, the mean being over the rod.
    PressureVolume { /** c, m² */ coefficient: f64 },
    /// The clamp turns by `C M`.
    ClampCompliance { /** C, rad/(N m) */ compliance: f64 },
    /// Moment `M_c w tanh(κ̇/κ̇₀)` near the clamp, where its fitting reaches into the rod;
    /// `w = ½ (1 − s/ℓ)²` for `s < ℓ`, so that it rubs as `M_c` does over `ℓ/6 = 5 mm`.
    ClampFriction { /** M_c, N m */ moment: f64 },
    /// Force `−k (r − r₀) − c v` on the fitting's centre of mass.
    Hose { /** k, N/m */ stiffness: f64, /** c, N s/m */ damping: f64, /** r₀ in W, m */ anchor: [f64; 2] },
    /// Rotary inertia of the fitting.
    TipInertia { /** kg m² */ inertia: f64 },
    /// The fitting's centre of mass lies further out than is thought.
    TipOffset { /** m */ along: f64 },
    /// Mass at the fitting's centre of mass.
    TipMass { /** kg */ mass: f64 },
    /// A spring in series with EA, which does not rub.
    AxialCompliance { /** 1/N */ compliance: f64 },
    /// Force `F e^(−t/τ)` upwards on the fitting's centre of mass.
    HandRelease { /** F, N */ force: f64, /** τ, s */ time: f64 },
    /// Angular velocity of the straight rod when it is let go.
    InitialVelocity { /** rad/s */ rate: f64 },
    /// EI falls with time: `EI (1 − λ t)`, t after the release.
    StiffnessDrift { /** λ, 1/s */ rate: f64 },
    /// EI differs by release: `EI (1 + δ u)`, u of the release between −1 and 1.
    ReleaseDrift { /** δ */ change: f64 },
    /// α and β grow with pressure: by `a p / p_ref` and `b p / p_ref`.
    DampingOverPressure { /** b, s */ beta: f64, /** a, 1/s */ alpha: f64, /** p_ref, Pa */ reference: f64 },
    /// Moment `EI c₃ κ̇³`.
    StrainRateCubed { /** c₃, s³ m² */ coefficient: f64 },
    /// The clamp is turned, from x towards z, and the rod is held at the stated angle nevertheless.
    ClampTilt { /** rad */ angle: f64 },
    /// What is seen is turned about the clamp, from x towards z.
    FrameTilt { /** rad */ angle: f64 },
    /// What is seen is larger.
    Scale { /** share */ excess: f64 },
    /// The tip's marker sits off the tip.
    MarkerOffset { /** along the end's tangent, m */ along: f64, /** across it, m */ across: f64 },
    /// The cameras' clock runs fast.
    Clock { /** share */ excess: f64 },
    /// The plane of the swing is not the one that is seen: x is foreshortened.
    OutOfPlane { /** share */ share: f64 },
    /// In no catalogue: a part of the fitting's mass is fluid that sloshes, a mass on a spring.
    Sloshing { /** kg */ mass: f64, /** rad/s */ frequency: f64, /** damping ratio */ damping: f64 },
    /// In no catalogue: a soft wall through the clamp pushes back what of the fitting swings past it,
    /// with a force `k` times the depth.
    Wall { /** k, N/m */ stiffness: f64, /** its direction from x towards z, rad */ angle: f64 },
    /// In no catalogue: the pressure ripples, and EI with it: `EI (1 + a sin Ω t)`.
    Ripple { /** a */ share: f64, /** Ω, rad/s */ frequency: f64 },
}

use Hidden::*;

/// Every effect at `x` times a typical size, with its name; those of no catalogue last.
#[rustfmt::skip]
pub fn all(x: f64) -> [(&'static str, Hidden); 36] {
    [
        ("air_drag", AirDrag { drag_coefficient: 1.1 * x }),
        ("tip_drag", TipDrag { drag_area: 2e-3 * x }),
        ("linear_drag", LinearDrag { coefficient: 0.015 * x }),
        ("added_mass", AddedMass { mass_per_length: 1e-3 * x }),
        ("braid_friction", BraidFriction { moment: 0.5e-3 * x }),
        ("hysteresis", Hysteresis { loss_factor: 0.03 * x }),
        ("dahl", Dahl { moment: 0.5e-3 * x, yield_curvature: 0.5 }),
        ("viscoelastic", Viscoelastic { branch_stiffness: 0.1 * x, relaxation_time: 0.2 }),
        ("creep", Creep { branch_stiffness: 0.05 * x, relaxation_time: 20.0 }),
        ("cubic_stiffness", CubicStiffness { coefficient: 1e-3 * x }),
        ("quadratic_stiffness", QuadraticStiffness { coefficient: 7e-3 * x }),
        ("set_curvature", SetCurvature { curvature: 0.2 * x, by_pressure: 0.0 }),
        ("stiffness_taper", StiffnessTaper { taper: 0.15 * x }),
        ("pressure_volume", PressureVolume { coefficient: 1e-3 * x }),
        ("clamp_compliance", ClampCompliance { compliance: 0.3 * x }),
        ("clamp_friction", ClampFriction { moment: 2e-3 * x }),
        ("hose", Hose { stiffness: 0.1 * x, damping: 2e-3 * x, anchor: [0.15, -0.1] }),
        ("tip_inertia", TipInertia { inertia: 4e-5 * x }),
        ("tip_offset", TipOffset { along: 2e-3 * x }),
        ("tip_mass", TipMass { mass: 2e-3 * x }),
        ("axial_compliance", AxialCompliance { compliance: 4e-3 * x }),
        ("hand_release", HandRelease { force: 0.3 * x, time: 0.04 }),
        ("initial_velocity", InitialVelocity { rate: 0.3 * x }),
        ("stiffness_drift", StiffnessDrift { rate: 3e-3 * x }),
        ("release_drift", ReleaseDrift { change: 0.015 * x }),
        ("damping_over_pressure", DampingOverPressure { beta: 1e-3 * x, alpha: 0.06 * x, reference: 1e5 }),
        ("strain_rate_cubed", StrainRateCubed { coefficient: 1e-7 * x }),
        ("frame_tilt", FrameTilt { angle: 2e-3 * x }),
        ("clamp_tilt", ClampTilt { angle: 2e-3 * x }),
        ("scale", Scale { excess: 2e-3 * x }),
        ("marker_offset", MarkerOffset { along: 1e-3 * x, across: 0.5e-3 * x }),
        ("clock", Clock { excess: 1e-3 * x }),
        ("out_of_plane", OutOfPlane { share: 3e-3 * x }),
        ("sloshing", Sloshing { mass: 4e-3 * x, frequency: 20.0, damping: 0.05 }),
        ("wall", Wall { stiffness: 1.0 * x, angle: -1.3 }),
        ("ripple", Ripple { share: 0.03 * x, frequency: 15.0 }),
    ]
}

/// How many of [`all`] a diagnosis may know; the clamp's tilt is no effect, but a stated angle.
pub const IN_CATALOGUE: usize = 33;

impl Hidden {
    /// The effect of a name at `x` times its typical size.
    pub fn named(name: &str, x: f64) -> Option<Self> {
        all(x).into_iter().find(|(known, _)| *known == name).map(|(_, hidden)| hidden)
    }

    /// The same so many times as large; of the sizes that [`Self::named`] has.
    pub fn times(&self, factor: f64) -> Self {
        if factor == 1.0 {
            return *self;
        }
        let of = |x: f64| Self::named(self.name(), x).expect("it has a name");
        let typical = of(1.0).strength();
        // A clock's strength is no multiple of its size, to a part in a thousand.
        of(factor * self.strength() / typical)
    }

    /// What the catalogue calls [its](Self::parameter) strength.
    #[rustfmt::skip]
    pub fn strength(&self) -> f64 {
        match *self {
            // The catalogue states the length of the recording's second, the twin what is recorded for one.
            Clock { excess } => -excess / (1.0 + excess),
            AirDrag { drag_coefficient: strength }
            | TipDrag { drag_area: strength }
            | LinearDrag { coefficient: strength }
            | AddedMass { mass_per_length: strength }
            | BraidFriction { moment: strength }
            | Hysteresis { loss_factor: strength }
            | Dahl { moment: strength, .. }
            | Viscoelastic { branch_stiffness: strength, .. }
            | Creep { branch_stiffness: strength, .. }
            | CubicStiffness { coefficient: strength }
            | QuadraticStiffness { coefficient: strength }
            | SetCurvature { curvature: strength, .. }
            | StiffnessTaper { taper: strength }
            | PressureVolume { coefficient: strength }
            | ClampCompliance { compliance: strength }
            | ClampFriction { moment: strength }
            | Hose { stiffness: strength, .. }
            | TipInertia { inertia: strength }
            | TipOffset { along: strength }
            | TipMass { mass: strength }
            | AxialCompliance { compliance: strength }
            | HandRelease { force: strength, .. }
            | InitialVelocity { rate: strength }
            | StiffnessDrift { rate: strength }
            | ReleaseDrift { change: strength }
            | DampingOverPressure { beta: strength, .. }
            | StrainRateCubed { coefficient: strength }
            | FrameTilt { angle: strength }
            | ClampTilt { angle: strength }
            | Scale { excess: strength }
            | MarkerOffset { along: strength, .. }
            | OutOfPlane { share: strength }
            | Sloshing { mass: strength, .. }
            | Wall { stiffness: strength, .. }
            | Ripple { share: strength, .. } => strength,
        }
    }

    /// The parameter of the catalogue that is its strength; empty for what no catalogue holds.
    pub fn parameter(&self) -> &'static str {
        let first = by_name(self.name()).map_or("", |effect| effect.about().parameters[0].name);
        if let MarkerOffset { .. } = self { "along" } else { first }
    }

    /// The parameter of the catalogue beside its strength on which its traces depend most, with its value.
    pub fn beside(&self) -> Option<(&'static str, f64)> {
        match *self {
            Dahl { yield_curvature, .. } => Some(("yield_curvature", yield_curvature)),
            Viscoelastic { relaxation_time, .. } => Some(("relaxation_time", relaxation_time)),
            Creep { relaxation_time, .. } => Some(("creep_time", relaxation_time)),
            HandRelease { time, .. } => Some(("release_time", time)),
            _ => None,
        }
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        let is_this = |other: &Hidden| discriminant(other) == discriminant(self);
        all(1.0).into_iter().find(|(_, other)| is_this(other)).expect("every effect has a name").0
    }
}

/// The sign of a rate that turns over smoothly; far off zero `tanh` of a dual number overflows.
fn sign<T: Real>(rate: T, over: f64) -> T {
    let x = rate / over;
    if x.re().abs() > 20.0 { T::from(x.re().signum()) } else { x.tanh() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_is_found_and_is_the_effects_own() {
        for (name, hidden) in all(0.7) {
            assert_eq!(hidden.name(), name);
            assert_eq!(Hidden::named(name, 0.7), Some(hidden));
        }
        assert_eq!(Hidden::named("drag", 1.0), None);
    }
}

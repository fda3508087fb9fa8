//! A muscle: its constants, and its tables interpolated over pressure.
//!
//! Pressure is that inside above ambient, as a gauge shows it. Between the rows of a table lies the
//! monotone cubic of [`Pchip`]. The data are files of one form, in the units of their source;
//! `models/muscles/garbulinski-2022.toml` is the example, built in, and [`Muscle::from_toml`] reads
//! any other.

mod between;
mod braid;
mod error;
mod known;
mod read;
mod write;

use std::fmt::{self, Display};

use serde::{Deserialize, Serialize};

use crate::effects::Rod;
use crate::interpolate::Pchip;
use crate::model::ModelSpec;

pub use between::Interpolation;
pub use braid::{Motion, neutral_angle};
pub use error::MuscleError;
pub use known::{CalibratedParameter, Here, Known, KnownAt, Marker, Misfit};
pub use write::{CALIBRATED, CalibratedColumn, Found};

/// Names of the built-in muscles, and their data.
pub const BUILT_IN: &[(&str, &str)] = &[
    ("garbulinski-2022", include_str!("../muscles/garbulinski-2022.toml")),
    (IN_MOTION, include_str!("../muscles/garbulinski-2022-in-motion.toml")),
];

/// Name of the first with a branch that gives the paper's trends over pressure in motion.
pub const IN_MOTION: &str = "garbulinski-2022-in-motion";

/// What is known of one muscle, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Muscle {
    /// Name in scenarios and messages.
    pub name: String,
    /// Where the data come from.
    pub source: String,
    /// The muscle without pressure.
    pub rest: Rest,
    /// The rigid body at its end.
    pub end_fitting: EndFitting,
    /// Gravity where it was measured, m/s².
    pub gravity: f64,
    /// How well a calibration knows it, if one wrote it.
    pub known: Option<Known>,
    pressure: Vec<f64>,
    length: Pchip,
    inner_diameter: Pchip,
    outer_diameter: Pchip,
    axial_stiffness: Pchip,
    /// By source: `axial`, `euler`, `pder_32`, or what a calibration calls its own.
    bending_stiffness: Vec<(String, Pchip)>,
    rayleigh_mass: Option<Pchip>,
    rayleigh_stiffness: Option<Pchip>,
    /// Branch stiffness over EI, and relaxation time.
    viscoelastic: Option<[Pchip; 2]>,
}

/// The muscle without pressure; what no equation needs may be unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// Active length, m.
    pub length: f64,
    /// Mass of bladder and braid per active length, kg/m.
    pub mass_per_length: f64,
    /// Inner diameter of the bladder, m.
    pub inner_diameter: Option<f64>,
    /// Outer diameter, m.
    pub outer_diameter: Option<f64>,
    /// Angle between the fibres and the cross-section, rad.
    pub braid_angle: Option<f64>,
}

/// The rigid body at the end of the active length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndFitting {
    /// Mass, kg.
    pub mass: f64,
    /// Distance of the centre of mass beyond the end of the active length, m.
    pub center_of_mass: f64,
    /// Rotary inertia about the centre of mass, kg m²; zero is a point mass.
    pub rotary_inertia: f64,
}

/// Whether a pressure outside the table is an error or extrapolated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Extrapolation {
    /// It is an error.
    #[default]
    Refused,
    /// Each column goes on along the straight line with which it leaves the table; the result says so.
    Allowed,
}

/// A muscle at one pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtPressure {
    /// Pressure above ambient, Pa.
    pub pressure: f64,
    /// Active length, m.
    pub length: f64,
    /// Bending stiffness EI of the source that was requested, N m².
    pub bending_stiffness: f64,
    /// Axial stiffness EA, N.
    pub axial_stiffness: f64,
    /// Inner diameter of the bladder, m.
    pub inner_diameter: f64,
    /// Outer diameter, m.
    pub outer_diameter: f64,
    /// Mass-proportional Rayleigh damping, 1/s, if the muscle's table has it.
    pub rayleigh_mass: Option<f64>,
    /// Stiffness-proportional Rayleigh damping, s, if the muscle's table has it.
    pub rayleigh_stiffness: Option<f64>,
    /// Branch stiffness over EI and relaxation time, s, of the effect `viscoelastic`, if the muscle's table has them.
    pub viscoelastic: Option<[f64; 2]>,
    /// Set if the pressure lies outside the table; its text is the warning to show.
    pub extrapolated: Option<Extrapolated>,
}

/// Derivatives of [`AtPressure`] with respect to pressure: first ones, each in its unit per Pa, or
/// second ones, per Pa².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureSlopes {
    /// Of the active length, m/Pa.
    pub length: f64,
    /// Of the bending stiffness, N m²/Pa.
    pub bending_stiffness: f64,
    /// Of the axial stiffness, N/Pa.
    pub axial_stiffness: f64,
    /// Of the inner diameter, m/Pa.
    pub inner_diameter: f64,
    /// Of the outer diameter, m/Pa.
    pub outer_diameter: f64,
    /// Of the mass-proportional damping, 1/(s Pa).
    pub rayleigh_mass: Option<f64>,
    /// Of the stiffness-proportional damping, s/Pa.
    pub rayleigh_stiffness: Option<f64>,
}

/// Derivatives by pressure of length, bending stiffness, axial stiffness and diameter, over their values, 1/Pa.
pub type RodSlopes = [f64; 4];

/// That and where a table was left; displays as a warning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extrapolated {
    /// Pressure that was requested, Pa.
    pub pressure: f64,
    /// Lowest and highest pressure of the table, Pa.
    pub range: (f64, f64),
}

impl Muscle {
    /// The built-in muscle of this name.
    ///
    /// # Errors
    /// [`MuscleError::UnknownMuscle`], with the names that there are.
    pub fn built_in(name: &str) -> Result<Muscle, MuscleError> {
        match BUILT_IN.iter().find(|muscle| muscle.0 == name) {
            Some((_, text)) => Muscle::from_toml(text),
            None => Err(MuscleError::UnknownMuscle { name: name.to_string() }),
        }
    }

    /// The muscle that the text of a muscle file describes.
    ///
    /// # Errors
    /// A [`MuscleError`] that names the key, or column and row, at fault.
    pub fn from_toml(text: &str) -> Result<Muscle, MuscleError> {
        read::muscle(text)
    }

    /// Lowest and highest pressure of the table, Pa.
    pub fn pressure_range(&self) -> (f64, f64) {
        self.length.range()
    }

    /// The pressures at which the muscle was measured, Pa, increasing.
    pub fn pressures(&self) -> &[f64] {
        &self.pressure
    }

    /// Names of the estimates of bending stiffness that the table has.
    ///
    /// An estimate belongs to the model that it was fitted with: its root, its number of nodes.
    pub fn stiffness_sources(&self) -> impl Iterator<Item = &str> {
        self.bending_stiffness.iter().map(|(source, _)| source.as_str())
    }

    /// The muscle at `pressure`, Pa, with the bending stiffness of `stiffness_source`.
    ///
    /// # Errors
    /// [`MuscleError::UnknownStiffness`]; [`MuscleError::OutsideTable`] unless `extrapolation` is
    /// allowed; [`MuscleError::ExtrapolatedTooFar`] where it would give a length or stiffness that
    /// is not positive; [`MuscleError::PressureNotFinite`].
    pub fn at(
        &self,
        pressure: f64,
        stiffness_source: &str,
        extrapolation: Extrapolation,
    ) -> Result<AtPressure, MuscleError> {
        let at = self.value_and_slope(pressure, stiffness_source, extrapolation);
        at.map(|(value, _)| value)
    }

    /// The muscle at `pressure`, Pa, and how it changes with pressure. The slope is continuous; its
    /// own derivative jumps at the rows of the table.
    ///
    /// # Errors
    /// As [`Muscle::at`].
    pub fn value_and_slope(
        &self,
        pressure: f64,
        stiffness_source: &str,
        extrapolation: Extrapolation,
    ) -> Result<(AtPressure, PressureSlopes), MuscleError> {
        let derivatives = self.derivatives(pressure, stiffness_source, extrapolation);
        derivatives.map(|(value, slope, _second)| (value, slope))
    }

    /// The muscle at `pressure`, Pa, with its first and second derivatives by pressure.
    ///
    /// # Errors
    /// As [`Muscle::at`].
    pub fn derivatives(
        &self,
        pressure: f64,
        stiffness_source: &str,
        extrapolation: Extrapolation,
    ) -> Result<(AtPressure, PressureSlopes, PressureSlopes), MuscleError> {
        let bending_stiffness = self.bending_stiffness(stiffness_source)?;
        let (pressure, extrapolated) = self.admit(pressure, extrapolation)?;
        let at = |curve: &Pchip| curve.derivatives(pressure);
        let (length, bending, axial) = (at(&self.length), at(bending_stiffness), at(&self.axial_stiffness));
        let (inner, outer) = (at(&self.inner_diameter), at(&self.outer_diameter));
        let rayleigh_mass = self.rayleigh_mass.as_ref().map(at);
        let rayleigh_stiffness = self.rayleigh_stiffness.as_ref().map(at);
        let value = AtPressure {
            pressure,
            length: length[0],
            bending_stiffness: bending[0],
            axial_stiffness: axial[0],
            inner_diameter: inner[0],
            outer_diameter: outer[0],
            rayleigh_mass: rayleigh_mass.map(|at| at[0]),
            rayleigh_stiffness: rayleigh_stiffness.map(|at| at[0]),
            viscoelastic: self
                .viscoelastic
                .as_ref()
                .map(|pair| pair.each_ref().map(|curve| curve.value(pressure))),
            extrapolated,
        };
        let [first, second] = [1, 2].map(|order| PressureSlopes {
            length: length[order],
            bending_stiffness: bending[order],
            axial_stiffness: axial[order],
            inner_diameter: inner[order],
            outer_diameter: outer[order],
            rayleigh_mass: rayleigh_mass.map(|at| at[order]),
            rayleigh_stiffness: rayleigh_stiffness.map(|at| at[order]),
        });
        value.check()?;
        Ok((value, first, second))
    }

    /// How the rod of the muscle follows the pressure; see [`RodSlopes`].
    ///
    /// # Errors
    /// As [`Muscle::at`].
    pub fn rod_slopes(
        &self,
        pressure: f64,
        stiffness_source: &str,
        extrapolation: Extrapolation,
    ) -> Result<RodSlopes, MuscleError> {
        let (at, by) = self.value_and_slope(pressure, stiffness_source, extrapolation)?;
        Ok([
            by.length / at.length,
            by.bending_stiffness / at.bending_stiffness,
            by.axial_stiffness / at.axial_stiffness,
            by.outer_diameter / at.outer_diameter,
        ])
    }

    /// The rod that the muscle is: its mass is that without pressure, which stays as it lengthens.
    pub fn rod(&self, at: &AtPressure) -> Rod<f64> {
        at.rod(self.rest.mass_per_length * self.rest.length)
    }

    /// A model of the muscle, clamped and let go level: the rod with its end fitting, gravity where it was measured,
    /// and the damping of the table, if it has any. The observed tip is the fitting's centre of mass.
    pub fn spec(&self, at: &AtPressure) -> ModelSpec {
        let EndFitting { mass, center_of_mass, rotary_inertia } = self.end_fitting;
        let spec = ModelSpec { tip_distance: center_of_mass, ..ModelSpec::of(self.rod(at)) }.with(&[
            ("gravity.acceleration", self.gravity),
            ("end_fitting.mass", mass),
            ("end_fitting.center_of_mass", center_of_mass),
            ("end_fitting.rotary_inertia", rotary_inertia),
            ("rayleigh_mass.alpha", at.rayleigh_mass.unwrap_or(0.0)),
            ("rayleigh_stiffness.beta", at.rayleigh_stiffness.unwrap_or(0.0)),
        ]);
        match at.viscoelastic {
            None => spec,
            Some([stiffness, time]) => spec.with(&[
                ("viscoelastic.branch_stiffness", stiffness),
                ("viscoelastic.relaxation_time", time),
            ]),
        }
    }

    fn bending_stiffness(&self, source: &str) -> Result<&Pchip, MuscleError> {
        let known = self.bending_stiffness.iter().find(|(name, _)| name == source);
        known.map(|(_, curve)| curve).ok_or_else(|| MuscleError::UnknownStiffness {
            muscle: self.name.clone(),
            asked: source.to_string(),
            known: self.stiffness_sources().map(str::to_string).collect(),
        })
    }

    /// The pressure to look up, and whether that extrapolates.
    fn admit(
        &self,
        pressure: f64,
        extrapolation: Extrapolation,
    ) -> Result<(f64, Option<Extrapolated>), MuscleError> {
        if !pressure.is_finite() {
            return Err(MuscleError::PressureNotFinite { pressure });
        }
        let range = self.pressure_range();
        let nearest = pressure.clamp(range.0, range.1);
        if (pressure - nearest).abs() <= WRITTEN * nearest.abs() {
            return Ok((nearest, None));
        }
        match extrapolation {
            Extrapolation::Allowed => Ok((pressure, Some(Extrapolated { pressure, range }))),
            Extrapolation::Refused => {
                Err(MuscleError::OutsideTable { muscle: self.name.clone(), pressure, range })
            }
        }
    }
}

/// An end of the table in other units, written with six digits, is still that end: half a unit of
/// the sixth digit, relative to the pressure.
const WRITTEN: f64 = 5e-6;

impl AtPressure {
    /// A rod of so much distributed mass, kg.
    pub fn rod(&self, mass: f64) -> Rod<f64> {
        Rod {
            length: self.length,
            mass,
            bending_stiffness: self.bending_stiffness,
            axial_stiffness: self.axial_stiffness,
            diameter: self.outer_diameter,
            pressure: self.pressure,
        }
    }

    /// Inside a table all is positive already.
    fn check(&self) -> Result<(), MuscleError> {
        let Some(extrapolated) = self.extrapolated else {
            return Ok(());
        };
        let quantities = [
            ("length", self.length, "m"),
            ("bending stiffness", self.bending_stiffness, "N m^2"),
            ("axial stiffness", self.axial_stiffness, "N"),
            ("outer diameter", self.outer_diameter, "m"),
            ("wall thickness", (self.outer_diameter - self.inner_diameter) / 2.0, "m"),
        ];
        match quantities.into_iter().find(|(_, value, _)| *value <= 0.0) {
            None => Ok(()),
            Some((quantity, value, unit)) => {
                Err(MuscleError::ExtrapolatedTooFar { extrapolated, quantity, value, unit })
            }
        }
    }
}

impl Display for Extrapolated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (pressure, range) = (error::pressure_text(self.pressure), error::range_text(self.range));
        write!(f, "{pressure} lies outside the table, {range}: extrapolated along straight lines")
    }
}

#[cfg(test)]
mod tests;

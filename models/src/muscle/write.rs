//! A muscle file with columns from a calibration.

use std::fmt::Write;

use super::read::VISCOELASTIC;
use super::{AtPressure, Extrapolation, Known, Muscle, MuscleError, between};

/// Name of the estimate of bending stiffness that a calibration writes.
pub const CALIBRATED: &str = "calibrated";

/// A column that a table may have: its name, its SI unit, and its value.
type Other = (&'static str, &'static str, fn(&AtPressure) -> Option<f64>);

/// Columns of losses: those that no calibration found are kept.
const OTHERS: [Other; 4] = [
    ("rayleigh_mass", "1/s", |at| at.rayleigh_mass),
    ("rayleigh_stiffness", "s", |at| at.rayleigh_stiffness),
    (VISCOELASTIC[0], "", |at| Some(at.viscoelastic?[0])),
    (VISCOELASTIC[1], "s", |at| Some(at.viscoelastic?[1])),
];

/// What a calibration has found of one quantity over pressure.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibratedColumn {
    /// Name of the column: `bending_stiffness_calibrated`, `rayleigh_mass` or `rayleigh_stiffness`.
    pub name: &'static str,
    /// Pressure, Pa, ascending, and value, SI; beyond the first and last these hold.
    pub values: Vec<(f64, f64)>,
    /// Estimate of bending stiffness whose ratio to the values is interpolated between pressures, by its logarithm,
    /// so that its shape over pressure is kept; without it the values themselves are interpolated.
    pub shape: Option<String>,
}

/// What a calibration has found of a muscle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// What was found over pressure.
    pub columns: Vec<CalibratedColumn>,
    /// Distributed mass in all, kg.
    pub rod_mass: Option<f64>,
    /// Mass of the end fitting, kg.
    pub end_fitting_mass: Option<f64>,
    /// How well all that is known.
    pub known: Known,
}

impl CalibratedColumn {
    /// The value at a pressure, Pa, with the shape of a muscle.
    fn at(&self, pressure: f64, muscle: &Muscle) -> Result<f64, MuscleError> {
        let places: Vec<f64> = self.values.iter().map(|(place, _)| *place).collect();
        let weights = between::weights(&places, pressure);
        let Some(shape) = &self.shape else {
            return Ok(weights.iter().zip(&self.values).map(|(weight, (_, value))| weight * value).sum());
        };
        let published =
            |pressure: f64| muscle.at(pressure, shape, Extrapolation::Allowed).map(|at| at.bending_stiffness);
        let mut logarithm = 0.0;
        for (weight, (place, value)) in weights.iter().zip(&self.values).filter(|(weight, _)| **weight != 0.0)
        {
            // Exactly the calibrated value where it was calibrated.
            if *weight == 1.0 && *place == pressure {
                return Ok(*value);
            }
            logarithm += weight * (value / published(*place)?).ln();
        }
        Ok(published(pressure)? * logarithm.exp())
    }
}

impl Muscle {
    /// The text of a muscle file, SI, with the columns of a calibration beside what this muscle has.
    ///
    /// Its rows are all rows of this muscle, and the pressures that were calibrated. Beyond the lowest and the highest of
    /// these the calibrated ratio to this muscle's bending stiffness goes on as it is there, and so do losses; how far that
    /// may be off is the Wiener process of [`Interpolation`](super::Interpolation).
    /// # Errors
    /// [`MuscleError`] for a pressure at which this muscle is none.
    pub fn calibrated(&self, source: &str, found: &Found) -> Result<String, MuscleError> {
        let columns = &found.columns;
        let mut measured: Vec<f64> =
            columns.iter().flat_map(|column| column.values.iter().map(|(pressure, _)| *pressure)).collect();
        measured.sort_by(f64::total_cmp);
        measured.dedup();
        let mut pressures: Vec<f64> = self.pressures().iter().chain(&measured).copied().collect();
        pressures.sort_by(f64::total_cmp);
        pressures.dedup_by(|a, b| (*a - *b).abs() <= 1e-9 * b.abs());
        let mut names = vec!["pressure", "length", "inner_diameter", "outer_diameter", "axial_stiffness"];
        let mut units = vec!["Pa", "m", "m", "m", "N"];
        let sources: Vec<&str> = self.stiffness_sources().filter(|source| *source != CALIBRATED).collect();
        let of_sources: Vec<String> =
            sources.iter().map(|source| format!("bending_stiffness_{source}")).collect();
        names.extend(of_sources.iter().map(String::as_str));
        units.extend(sources.iter().map(|_| "N m^2"));
        for column in columns {
            names.push(column.name);
            units.push(match column.name {
                "rayleigh_mass" => "1/s",
                "rayleigh_stiffness" => "s",
                _ => "N m^2",
            });
        }
        let first = self.at(pressures[0], self.any_source(), Extrapolation::Allowed)?;
        let is_kept = |(name, _, of): &&Other| {
            of(&first).is_some() && columns.iter().all(|column| column.name != *name)
        };
        let kept: Vec<&Other> = OTHERS.iter().filter(is_kept).collect();
        names.extend(kept.iter().map(|(name, _, _)| *name));
        units.extend(kept.iter().map(|(_, unit, _)| *unit));

        let mut text = String::from("# A muscle with columns from a calibration; written by efam.\n");
        let quoted = |text: &str| toml::Value::from(text).to_string();
        let _ = writeln!(text, "name = {}", quoted(&format!("{}-calibrated", self.name)));
        let _ = writeln!(text, "source = {}", quoted(&format!("{source}; all else: {}", self.source)));
        let _ = writeln!(text, "gravity = \"{:?} m/s^2\"\n\n[rest]", self.gravity);
        let _ = writeln!(text, "length = \"{:?} m\"", self.rest.length);
        let mass_per_length =
            found.rod_mass.map_or(self.rest.mass_per_length, |mass| mass / self.rest.length);
        let _ = writeln!(text, "mass_per_length = \"{mass_per_length:?} kg/m\"");
        for (key, value, unit) in [
            ("inner_diameter", self.rest.inner_diameter, "m"),
            ("outer_diameter", self.rest.outer_diameter, "m"),
            ("braid_angle", self.rest.braid_angle, "rad"),
        ] {
            if let Some(value) = value {
                let _ = writeln!(text, "{key} = \"{value:?} {unit}\"");
            }
        }
        let fitting = self.end_fitting;
        let mass = found.end_fitting_mass.unwrap_or(fitting.mass);
        let _ = writeln!(text, "\n[end_fitting]\nmass = \"{mass:?} kg\"");
        let _ = writeln!(text, "center_of_mass = \"{:?} m\"", fitting.center_of_mass);
        let _ = writeln!(text, "rotary_inertia = \"{:?} kg m^2\"\n\n[table]", fitting.rotary_inertia);
        let list = |all: &[&str]| all.iter().map(|one| quoted(one)).collect::<Vec<_>>().join(", ");
        let _ = writeln!(text, "columns = [{}]\nunits = [{}]\nrows = [", list(&names), list(&units));
        for pressure in pressures {
            let at = self.at(pressure, self.any_source(), Extrapolation::Allowed)?;
            let mut row = vec![pressure, at.length, at.inner_diameter, at.outer_diameter, at.axial_stiffness];
            for source in &sources {
                row.push(self.at(pressure, source, Extrapolation::Allowed)?.bending_stiffness);
            }
            for column in columns {
                row.push(column.at(pressure, self)?);
            }
            row.extend(kept.iter().filter_map(|(_, _, of)| of(&at)));
            let row: Vec<String> = row.iter().map(|value| format!("{value:?}")).collect();
            let _ = writeln!(text, "  [{}],", row.join(", "));
        }
        text += "]\n";
        if !found.known.parameter.is_empty() {
            let _ = write!(text, "\n{}", found.known.section());
        }
        Ok(text)
    }

    fn any_source(&self) -> &str {
        self.stiffness_sources().next().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::muscle::CalibratedParameter;

    const PSI: f64 = 6_894.757_293_168_361;

    #[test]
    fn a_calibrated_muscle_is_read_back_with_its_columns() {
        let muscle = Muscle::built_in("garbulinski-2022").unwrap();
        let at = |psi: f64, value: f64| (psi * PSI, value);
        let columns = vec![
            CalibratedColumn {
                name: "bending_stiffness_calibrated",
                values: vec![at(12.0, 0.009), at(40.0, 0.011)],
                shape: Some("pder_32".to_owned()),
            },
            CalibratedColumn { name: "rayleigh_mass", values: vec![at(12.0, 0.7)], shape: None },
        ];
        let parameter = CalibratedParameter {
            path: "effects.end_fitting.mass".to_owned(),
            value: 0.056,
            standard_error: Some(1e-4),
            correlations: vec![1.0],
            ..CalibratedParameter::default()
        };
        let known = Known { releases: 2, parameter: vec![parameter], ..Known::default() };
        let one = columns[1].clone();
        let found = Found { columns, end_fitting_mass: Some(0.056), known, ..Found::default() };
        let text = muscle.calibrated("calibration of \"beam\"", &found).unwrap();
        let read = Muscle::from_toml(&text).unwrap();
        assert_eq!((read.known.as_ref(), read.end_fitting.mass), (Some(&found.known), 0.056));
        assert_eq!(read.rest.mass_per_length, muscle.rest.mass_per_length);
        assert!(read.source.starts_with("calibration of \"beam\"; all else: Garbulinski"));
        // All rows of the muscle, and the calibrated pressure between two of them.
        assert_eq!((read.pressure_range(), read.pressures().len()), (muscle.pressure_range(), 21));
        let (new, old) = (
            read.at(15.0 * PSI, CALIBRATED, Extrapolation::Refused).unwrap(),
            muscle.at(15.0 * PSI, "pder_32", Extrapolation::Refused).unwrap(),
        );
        assert!((new.length / old.length - 1.0).abs() < 1e-12);
        assert!((new.axial_stiffness / old.axial_stiffness - 1.0).abs() < 1e-12);
        // The logarithm of the ratio to the published column is a straight line over pressure.
        let published =
            |psi: f64| muscle.at(psi * PSI, "pder_32", Extrapolation::Refused).unwrap().bending_stiffness;
        let [low, high] = [0.009 / published(12.0), 0.011 / published(40.0)].map(f64::ln);
        let expected = published(15.0) * (low + 3.0 / 28.0 * (high - low)).exp();
        assert!((new.bending_stiffness / expected - 1.0).abs() < 1e-12, "{}", new.bending_stiffness);
        assert_eq!((new.rayleigh_mass, new.rayleigh_stiffness), (Some(0.7), None));
        // Beyond the last calibrated pressure the ratio stays, and length and diameters are the muscle's.
        let at = |muscle: &Muscle, source| muscle.at(85.0 * PSI, source, Extrapolation::Refused).unwrap();
        let (new, old) = (at(&read, CALIBRATED), at(&muscle, "pder_32"));
        assert!(
            (new.bending_stiffness / old.bending_stiffness / (0.011 / published(40.0)) - 1.0).abs() < 1e-12
        );
        assert_eq!((new.length, new.outer_diameter), (old.length, old.outer_diameter));
        let found = Found { columns: vec![one], ..Found::default() };
        let alone = muscle.calibrated("one", &found).unwrap();
        assert_eq!(Muscle::from_toml(&alone).unwrap().known, None);
        // All rows of the muscle, and the calibrated pressure.
        assert_eq!(Muscle::from_toml(&alone).unwrap().pressures().len(), 21);
    }
}

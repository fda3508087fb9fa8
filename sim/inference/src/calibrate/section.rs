//! What an experiment file says of its calibration.
//!
//! ```toml
//! [calibrate]                     # all may be left out; then EI and Rayleigh's two losses are found
//! release_instant = true          # unknown of each recording, fitted with it; or false
//! hold_angle = "0.5 deg"          # likewise, its standard deviation; "0 deg" takes it as given
//! clamp_angle = "0.5 deg"         # likewise; taken as given if left out
//! offset = "0.5 mm"               # likewise, of each track
//! repeatability = "0.2 mm"        # root mean square distance of a release from a right model; else from repeats
//! mesh = "removed"                # or "kept": the parameters then belong to the mesh
//! [[calibrate.parameter]]
//! path = "rod.bending_stiffness"  # any parameter of the model
//! scope = "per_pressure"          # shared, per_release
//! start = "0.007 N m^2"
//! bounds = ["0.001 N m^2", "0.1 N m^2"]
//! prior = "0.007 N m^2"           # its mean, with its standard deviation
//! deviation = "0.001 N m^2"
//! scale = "logarithmic"           # linear
//! ```

use std::sync::Arc;

use efam_core::forward::Initial;
use efam_experiments::cleaning::{CleanRelease, Cleaned};
use efam_experiments::experiment::{Experiment, ExperimentError, Start};
use efam_experiments::scenario::document::Keys;
use efam_experiments::scenario::{Case, ScenarioError, ScenarioProblem};

use super::hold::hold;
use super::problem::{FittedParameter, Nuisances, Prior, Problem, Scale, Scope, Trial};
use super::unknowns::ALPHA;
use super::waves::{BETA, damp_waves};
use super::{CalibrateError, CalibrationSettings};

/// Why an experiment could not be made a problem.
#[derive(Debug, thiserror::Error)]
pub enum SectionError {
    /// The experiment.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// What is to be calibrated.
    #[error(transparent)]
    Calibrate(#[from] CalibrateError),
    /// An experiment without a release to fit.
    #[error(
        "{experiment}: every release is held out or dropped, and none is left to fit; take held_out, keep or drop from one [[recording]]"
    )]
    NoRelease {
        /// Its file.
        experiment: String,
    },
    /// A recording of one coordinate alone.
    #[error(
        "{file}: has one coordinate alone, and a fit would take the others, which are 0, for measured; `efam analyse` gives its \
         frequency and damping"
    )]
    OneCoordinate {
        /// Its name.
        file: String,
    },
    /// An experiment without a model.
    #[error(
        "{experiment}: says nothing of the rod, so there is no model to calibrate; add [muscle], or [rod] with its length, mass and stiffness"
    )]
    NoModel {
        /// Its file.
        experiment: String,
    },
}

/// Found unless the experiment says otherwise.
const USUAL: [&str; 3] = ["rod.bending_stiffness", ALPHA, BETA];

/// The problem that an experiment and its cleaned releases make.
/// # Errors
/// [`SectionError`], with the place in the file where there is one.
pub fn problem(
    experiment: &Experiment,
    cleaned: &Cleaned,
) -> Result<(Problem, CalibrationSettings), SectionError> {
    if !experiment.has_model() {
        return Err(SectionError::NoModel { experiment: experiment.path.display().to_string() });
    }
    let mut trials = Vec::new();
    for used in cleaned.used() {
        let of = cleaned.recordings.get(used.recording);
        if let Some(of) = of.filter(|of| of.recording.has_one_coordinate()) {
            return Err(SectionError::OneCoordinate { file: of.name.clone() });
        }
        let case = used.case(experiment)?;
        trials.extend(case.map(|case| trial(experiment, used, case)).transpose()?);
    }
    let Some(first) = trials.iter().find(|trial| !trial.release.held_out) else {
        return Err(SectionError::NoRelease { experiment: experiment.path.display().to_string() });
    };
    let section = experiment.section("calibrate")?;
    let read = || -> Result<_, ScenarioError> {
        section.only(&[
            "parameter",
            "release_instant",
            "hold_angle",
            "clamp_angle",
            "offset",
            "mesh",
            "repeatability",
        ])?;
        let has_pressures = trials.iter().all(|trial| trial.release.pressure.is_some());
        let usual = if has_pressures { Scope::PerPressure } else { Scope::Shared };
        let tables = section.tables("parameter")?;
        let parameters = if tables.is_empty() {
            USUAL.iter().map(|path| FittedParameter::new(path, usual)).collect()
        } else {
            tables.iter().map(|table| parameter(table, first, usual)).collect::<Result<_, _>>()?
        };
        let mesh = section.word("mesh", &[("removed", true), ("kept", false)])?;
        Ok((parameters, nuisances(&section)?, mesh.unwrap_or(true)))
    };
    let (parameters, nuisances, remove_mesh) = read().map_err(ExperimentError::from)?;
    let settings = CalibrationSettings {
        remove_mesh,
        repeatability: repeatability(experiment)?,
        ..CalibrationSettings::default()
    };
    let trials = trials.into_iter().map(Arc::new).collect();
    let mut problem = Problem { trials, parameters, nuisances };
    damp_waves(&mut problem);
    Ok((problem, settings))
}

/// A release with the model of its case; held as the markers show, unless the experiment says that it is straight.
/// # Errors
/// [`CalibrateError::Held`] if the model cannot be held so.
pub(crate) fn trial(experiment: &Experiment, of: &CleanRelease, case: Case) -> Result<Trial, CalibrateError> {
    let mut trial = Trial { release: of.release.clone(), model: case.model, run: case.run };
    match experiment.recordings[of.recording].start_of(of.number) {
        Start::Straight => {}
        Start::Rest => {
            let mut hold = trial.model.clone();
            hold.schedule = None;
            trial.run.initial = Initial::Equilibrium { hold: Box::new(hold), own: Vec::new() };
        }
        Start::Held | Start::InMotion => hold(&mut trial).map_err(|error| CalibrateError::Held {
            release: trial.release.name.clone(),
            error: error.into(),
        })?,
    }
    Ok(trial)
}

/// How well an experiment repeats, where it says so: root mean square distance, m.
/// # Errors
/// [`SectionError`], with the place in the file.
pub fn repeatability(experiment: &Experiment) -> Result<Option<f64>, SectionError> {
    let section = experiment.section("calibrate")?;
    let read = section.quantity_that("repeatability", "m", "be positive", |value| value > 0.0);
    Ok(read.map_err(ExperimentError::from)?)
}

/// Standard deviation of a marker's distance from its assumed place, m: that of the offsets which a
/// calibration fits.
/// # Errors
/// [`SectionError`], with the place in the file.
pub(crate) fn marker_error(experiment: &Experiment) -> Result<f64, SectionError> {
    let own = nuisances(&experiment.section("calibrate")?).map_err(ExperimentError::from)?;
    Ok(own.offset.unwrap_or(0.0))
}

fn nuisances(section: &Keys) -> Result<Nuisances, ScenarioError> {
    let usual = Nuisances::default();
    let must = "not be negative; 0 takes it as given";
    let deviation = |key, unit, usual: Option<f64>| {
        let given = section.quantity_that(key, unit, must, |value| value >= 0.0)?;
        Ok::<_, ScenarioError>(given.map_or(usual, |value| Some(value).filter(|value| *value > 0.0)))
    };
    Ok(Nuisances {
        release_instant: section.flag("release_instant")?.unwrap_or(usual.release_instant),
        hold_angle: deviation("hold_angle", "rad", usual.hold_angle)?,
        clamp_angle: deviation("clamp_angle", "rad", usual.clamp_angle)?,
        offset: deviation("offset", "m", usual.offset)?,
        ..usual
    })
}

fn parameter(table: &Keys, trial: &Trial, usual: Scope) -> Result<FittedParameter, ScenarioError> {
    table.only(&["path", "scope", "start", "bounds", "prior", "deviation", "scale"])?;
    let Some((path, _)) = table.text("path")? else {
        return Err(table.missing("path", "path = \"rod.bending_stiffness\""));
    };
    let known = &trial.model.parameters;
    let Some(of_model) = known.iter().find(|parameter| parameter.path == path) else {
        let paths = known.iter().map(|parameter| parameter.path.as_str());
        return Err(table.wrong(
            "path",
            ScenarioProblem::UnknownWord {
                nearest: models::nearest::nearest(path, paths.clone()).map(str::to_owned),
                known: paths.map(str::to_owned).collect(),
            },
        ));
    };
    let unit = of_model.unit;
    let scopes =
        [("shared", Scope::Shared), ("per_pressure", Scope::PerPressure), ("per_release", Scope::PerRelease)];
    let scales = [("linear", Scale::Linear), ("logarithmic", Scale::Logarithmic)];
    let bounds = match table.quantities("bounds", unit)?.as_deref() {
        None => None,
        Some([low, high]) if low < high => Some((*low, *high)),
        Some(_) => {
            let must = "be two values, the lower one first";
            return Err(table.wrong("bounds", ScenarioProblem::Must { must }));
        }
    };
    let deviation = table.quantity_that("deviation", unit, "be positive", |value| value > 0.0)?;
    let prior = match (table.quantity("prior", unit)?, deviation) {
        (Some(mean), Some(deviation)) => Some(Prior { mean, deviation }),
        (None, None) => None,
        (Some(_), None) => {
            return Err(table.missing("deviation", "deviation = the standard error of the prior"));
        }
        (None, Some(_)) => return Err(table.missing("prior", "prior = the value known beforehand")),
    };
    Ok(FittedParameter {
        path: path.to_owned(),
        scope: table.word("scope", &scopes)?.unwrap_or(usual),
        start: table.quantity("start", unit)?,
        bounds,
        prior,
        scale: table.word("scale", &scales)?,
    })
}

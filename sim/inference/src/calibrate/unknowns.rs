//! From parameters and nuisances to one flat list of unknowns, scaled, and back.

use models::error::ModelError;
use models::model::ModelParameter;
use models::quantity::format_si;

use super::error::CalibrateError;
use super::hold;
use super::problem::{FittedParameter, Prior, Problem, Scale, Scope, Trial, is_same_pressure};

/// Names of what is unknown of a release.
pub const RELEASE_INSTANT: &str = "release instant";
pub(crate) const HOLD_ANGLE: &str = "hold angle";
pub(crate) const CLAMP_ANGLE: &str = "error of the clamp angle";

/// Likewise of a marker, along an axis.
pub(crate) fn offset_of(marker: &str, letter: &str) -> String {
    format!("offset of {marker} in {letter}")
}

/// One number to be found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Unknown {
    pub kind: UnknownKind,
    /// Path of a parameter, or name of a nuisance.
    pub name: String,
    pub unit: &'static str,
    pub group: Group,
    pub scaled: Scaled,
    /// Admissible values of the scaled variable.
    pub bounds: (f64, f64),
    pub prior: Option<Prior>,
    /// Value at which the search starts, SI.
    pub start: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum UnknownKind {
    /// A parameter, by its place in the problem.
    Parameter(usize),
    /// Time by which the rod was let go after time zero of the recording.
    Instant,
    /// Angle at which it was held, over the model's.
    HoldAngle,
    /// Angle of its clamp, over the model's.
    ClampAngle,
    /// A component of the load that sets the start, such as that of a hand before the release.
    Pull,
    /// Offset of a track along an axis.
    Offset { track: usize, axis: usize },
}

/// What has this value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Group {
    All,
    /// Releases at this pressure, Pa.
    Pressure(f64),
    /// One release.
    Release(usize),
}

/// From the variable of the search to the value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scaled {
    Logarithmic,
    /// By a typical size.
    By(f64),
}

/// How an unknown acts in one trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Local {
    /// Its place among the unknowns.
    pub unknown: usize,
    pub acts: Acts,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Acts {
    /// As this parameter of the model.
    Theta(usize),
    /// On top of this parameter, the model's or a fitted one.
    OnTheta(usize),
    Instant,
    Offset {
        track: usize,
        axis: usize,
    },
}

/// All unknowns, and where they act.
#[derive(Clone, Debug)]
pub(crate) struct Unknowns {
    pub list: Vec<Unknown>,
    /// Of each trial; empty for a release that is held out.
    pub of_trial: Vec<Vec<Local>>,
}

impl Unknown {
    /// Its name and what it belongs to, releases by their number.
    pub fn label(&self) -> String {
        match self.group {
            Group::Pressure(pressure) => format!("{} at {}", self.name, format_si(pressure, "Pa")),
            Group::Release(t) => format!("{} of release {}", self.name, t + 1),
            _ => self.name.clone(),
        }
    }

    /// Whether a value of the scaled variable is as far as is admitted.
    pub fn is_at_bound(&self, x: f64) -> bool {
        let (low, high) = self.bounds;
        let nearly = 1e-9 * (1.0 + x.abs());
        x - low <= nearly || high - x <= nearly
    }
}

impl Scaled {
    pub fn value(self, x: f64) -> f64 {
        match self {
            Scaled::Logarithmic => x.exp(),
            Scaled::By(size) => x * size,
        }
    }

    pub fn variable(self, value: f64) -> f64 {
        match self {
            Scaled::Logarithmic => value.ln(),
            Scaled::By(size) => value / size,
        }
    }

    /// Derivative of the value by the variable.
    pub fn slope(self, x: f64) -> f64 {
        match self {
            Scaled::Logarithmic => x.exp(),
            Scaled::By(size) => size,
        }
    }

    /// Logarithm of that up to a constant, and its derivative by the variable.
    #[cfg(feature = "posterior")]
    pub fn logarithm_of_slope(self, x: f64) -> (f64, f64) {
        match self {
            Scaled::Logarithmic => (x, 1.0),
            Scaled::By(_) => (0.0, 0.0),
        }
    }
}

impl Unknown {
    pub fn is_nuisance(&self) -> bool {
        !matches!(self.kind, UnknownKind::Parameter(_))
    }

    /// Longest step of the scaled variable: a factor of three, or as far as it likes.
    pub fn longest_step(&self) -> f64 {
        match self.scaled {
            Scaled::Logarithmic => 3f64.ln(),
            Scaled::By(_) => f64::INFINITY,
        }
    }
}

/// A bound at zero on a logarithmic scale is this far below the typical size.
const NEARLY_ZERO: f64 = 1e-4;
/// Standard deviations by which the setup may be off what is stated of it: one recording in 16 000 is, by chance. Without
/// a limit a model that lacks an effect takes the setup instead, from where a fit with the effect finds no way back. A
/// release instant is limited in a calibration too.
pub(crate) const FARTHEST: f64 = 4.0;
/// Smallest uncertainty of a release instant, s.
const LEAST_INSTANT: f64 = 1e-4;

impl Unknown {
    /// What is unknown of a release beside the model's parameters, about zero and so many deviations off at most.
    pub fn nuisance(
        kind: UnknownKind,
        name: &str,
        unit: &'static str,
        group: Group,
        deviation: f64,
        farthest: f64,
    ) -> Self {
        Self {
            kind,
            name: name.to_owned(),
            unit,
            group,
            scaled: Scaled::By(deviation),
            bounds: (-farthest, farthest),
            prior: Some(Prior { mean: 0.0, deviation }),
            start: 0.0,
        }
    }
}

impl Unknowns {
    pub fn of(problem: &Problem) -> Result<Self, CalibrateError> {
        if problem.trials.iter().all(|trial| trial.release.held_out) {
            return Err(CalibrateError::NoTrials);
        }
        let mut unknowns = Self { list: Vec::new(), of_trial: vec![Vec::new(); problem.trials.len()] };
        for (k, parameter) in problem.parameters.iter().enumerate() {
            if problem.parameters[..k].iter().any(|other| other.path == parameter.path) {
                return Err(CalibrateError::Twice { path: parameter.path.clone() });
            }
            unknowns.add_parameter(problem, k)?;
        }
        for (t, trial) in problem.trials.iter().enumerate() {
            if !trial.release.held_out {
                unknowns.add_nuisances(problem, t, trial)?;
            }
        }
        Ok(unknowns)
    }

    fn add_parameter(&mut self, problem: &Problem, k: usize) -> Result<(), CalibrateError> {
        let parameter = &problem.parameters[k];
        for (t, trial) in problem.trials.iter().enumerate().filter(|(_, trial)| !trial.release.held_out) {
            let index = index(trial, &parameter.path)?;
            let group = group(parameter, t, trial)?;
            let same = |other: &Unknown| other.kind == UnknownKind::Parameter(k) && other.group.is(group);
            let unknown = match self.list.iter().position(same) {
                Some(known) => known,
                None => {
                    let known = &trial.model.parameters[index];
                    let value = trial.model.theta[index];
                    self.list.push(unknown(parameter, k, group, known, value)?);
                    self.list.len() - 1
                }
            };
            self.of_trial[t].push(Local { unknown, acts: Acts::Theta(index) });
        }
        Ok(())
    }

    fn add_nuisances(&mut self, problem: &Problem, t: usize, trial: &Trial) -> Result<(), CalibrateError> {
        let nuisances = &problem.nuisances;
        let mut add = |kind, acts, name: &str, unit, deviation: f64, farthest: f64| {
            self.of_trial[t].push(Local { unknown: self.list.len(), acts });
            let unknown = Unknown::nuisance(kind, name, unit, Group::Release(t), deviation, farthest);
            let start = if let Acts::Theta(k) = acts { trial.model.theta[k] } else { 0.0 };
            self.list.push(Unknown { start, ..unknown });
        };
        if nuisances.release_instant && !trial.is_in_motion() {
            let deviation = trial.release.release_uncertainty.max(LEAST_INSTANT);
            add(UnknownKind::Instant, Acts::Instant, RELEASE_INSTANT, "s", deviation, FARTHEST);
        }
        let angle_is_fitted = problem.parameters.iter().any(|parameter| parameter.path == RELEASE_ANGLE);
        if let Some(deviation) = nuisances.hold_angle.filter(|_| trial.is_straight() && !angle_is_fitted) {
            let acts = Acts::OnTheta(index(trial, RELEASE_ANGLE)?);
            add(UnknownKind::HoldAngle, acts, HOLD_ANGLE, "rad", deviation, nuisances.farthest);
        }
        let clamp_is_fitted = problem.parameters.iter().any(|parameter| parameter.path == BASE_ANGLE);
        if let Some(deviation) = nuisances.clamp_angle.filter(|_| !clamp_is_fitted) {
            let acts = Acts::OnTheta(index(trial, BASE_ANGLE)?);
            add(UnknownKind::ClampAngle, acts, CLAMP_ANGLE, "rad", deviation, nuisances.farthest);
        }
        if trial.is_held() {
            for (path, unit, size) in hold::pulls(trial).map_err(|error| of_model(trial, error))? {
                let acts = Acts::Theta(index(trial, path)?);
                add(UnknownKind::Pull, acts, path, unit, size, f64::INFINITY);
            }
        }
        if let Some(deviation) = nuisances.offset {
            for (track, of) in trial.release.tracks.iter().enumerate() {
                for (axis, letter) in ["x", "z"].into_iter().enumerate() {
                    let name = offset_of(&of.marker, letter);
                    let (kind, acts) = (UnknownKind::Offset { track, axis }, Acts::Offset { track, axis });
                    add(kind, acts, &name, "m", deviation, nuisances.farthest);
                }
            }
        }
        Ok(())
    }
}

/// Gives a trial what was found of its release beside the parameters, by its name: angles and a loss on top of the
/// model's, the load of a hand. What is no part of a model, such as the offset of a marker, changes nothing.
pub(crate) fn pose(trial: &mut Trial, name: &str, value: f64) {
    let (path, is_on_top) = match name {
        HOLD_ANGLE => (RELEASE_ANGLE, true),
        CLAMP_ANGLE => (BASE_ANGLE, true),
        path => (path, false),
    };
    let Ok(k) = trial.model.index(path) else { return };
    let below = if is_on_top { trial.model.theta[k] } else { 0.0 };
    (trial.model, trial.run.initial) = trial.with(&[(k, below + value)]);
}

pub(crate) const RELEASE_ANGLE: &str = "release.angle";
pub(crate) const BASE_ANGLE: &str = "rod.base_angle";
pub(crate) const ALPHA: &str = "effects.rayleigh_mass.alpha";

impl Group {
    /// Whether both are the same, pressures to a thousandth.
    pub fn is(self, other: Group) -> bool {
        match (self, other) {
            (Group::Pressure(a), Group::Pressure(b)) => is_same_pressure(a, b),
            (a, b) => a == b,
        }
    }
}

fn index(trial: &Trial, path: &str) -> Result<usize, CalibrateError> {
    trial.model.index(path).map_err(|error| of_model(trial, error))
}

fn of_model(trial: &Trial, error: ModelError) -> CalibrateError {
    CalibrateError::Model { release: trial.release.name.clone(), error }
}

fn group(parameter: &FittedParameter, t: usize, trial: &Trial) -> Result<Group, CalibrateError> {
    match (parameter.scope, trial.release.pressure) {
        (Scope::Shared, _) => Ok(Group::All),
        (Scope::PerRelease, _) => Ok(Group::Release(t)),
        (Scope::PerPressure, Some(pressure)) => Ok(Group::Pressure(pressure)),
        (Scope::PerPressure, None) => Err(CalibrateError::NoPressure {
            release: trial.release.name.clone(),
            path: parameter.path.clone(),
        }),
    }
}

/// Start, bounds and scale of a parameter, as given or from the registry.
fn unknown(
    parameter: &FittedParameter,
    k: usize,
    group: Group,
    known: &ModelParameter,
    of_model: f64,
) -> Result<Unknown, CalibrateError> {
    let path = || parameter.path.clone();
    let ModelParameter { unit, range: (least, most), scale: size, null_value, .. } = *known;
    let (low, high) = parameter.bounds.unwrap_or((least, most));
    if !(low >= least && high <= most && low < high) {
        return Err(CalibrateError::Bounds { path: path(), low, high, least, most, unit });
    }
    // What may vanish has no logarithm there. Rayleigh's two losses also trade against one another
    // along a straight line, which would be a curved valley in their logarithms.
    let usual = if low >= 0.0 && null_value.is_none() { Scale::Logarithmic } else { Scale::Linear };
    let is_logarithmic = parameter.scale.unwrap_or(usual) == Scale::Logarithmic;
    let start = match parameter.start {
        Some(start) => start,
        None if (is_logarithmic || null_value.is_some()) && of_model <= 0.0 => size.clamp(low, high),
        None => of_model.clamp(low, high),
    };
    if !(low..=high).contains(&start) {
        return Err(CalibrateError::Start { path: path(), start, low, high, unit });
    }
    if let Some(Prior { mean, deviation }) = parameter.prior
        && !(mean.is_finite() && deviation.is_finite() && deviation > 0.0)
    {
        return Err(CalibrateError::Prior { path: path(), mean, deviation });
    }
    if is_logarithmic && (low < 0.0 || start <= 0.0) {
        return Err(CalibrateError::Logarithm { path: path(), low: low.min(start) });
    }
    let scaled = if is_logarithmic { Scaled::Logarithmic } else { Scaled::By(size) };
    // Zero has no logarithm: far below the typical size is near enough.
    let low = if is_logarithmic { low.max(NEARLY_ZERO * size.min(start)) } else { low };
    Ok(Unknown {
        kind: UnknownKind::Parameter(k),
        name: path(),
        unit,
        group,
        scaled,
        bounds: (scaled.variable(low), scaled.variable(high)),
        prior: parameter.prior,
        start,
    })
}

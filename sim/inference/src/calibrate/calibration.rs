//! What a calibration has found, as it is written to `calibration.json`.

use efam_experiments::release::Release;
use models::muscle::Marker;
use models::quantity::format_si;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::marker::marker;
use super::misfit::{FrequencyAndDamping, Misfit};
use super::problem::{Prior, Problem, Scale, Scope, is_of_pressure};
use super::repeats::Repeats;
use super::stage::Stage;
use super::unknowns::pose;

/// A calibration: parameters with their errors, residuals and effort.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Calibration {
    /// The parameters.
    pub parameters: Vec<Calibrated>,
    /// Nuisance parameters, per recording.
    pub nuisances: Vec<Calibrated>,
    /// Correlations of parameters that were found together.
    pub correlations: Vec<Correlations>,
    /// The fit of each release.
    pub releases: Vec<ReleaseFit>,
    /// How well the experiment repeats, where it determines or states it.
    #[serde(default)]
    pub repeats: Option<Repeats>,
    /// The searches, one for all releases that share a parameter.
    pub searches: Vec<SearchReport>,
    /// Caveats of the numbers.
    pub warnings: Vec<String>,
}

/// One number that was found; SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Calibrated {
    /// Path of the parameter, or name of the nuisance.
    pub name: String,
    /// SI unit; empty if dimensionless.
    pub unit: String,
    /// The releases that share it.
    pub scope: Scope,
    /// Pressure of those that share it, Pa, if it is one for each pressure.
    pub pressure_pa: Option<f64>,
    /// The release that it belongs to, if it is one for each.
    pub release: Option<String>,
    /// Its value.
    pub value: f64,
    /// Where the search began.
    pub start: f64,
    /// Standard error; none where the data do not determine it.
    pub standard_error: Option<f64>,
    /// The interval that holds the truth in 95 % of experiments; not symmetric on a logarithmic
    /// scale.
    pub interval_95: Option<[f64; 2]>,
    /// The same from the profile of the likelihood, if it was requested.
    pub profile_95: Option<[f64; 2]>,
    /// How it was scaled.
    pub scale: Scale,
    /// Smallest and largest admissible value.
    pub bounds: [Option<f64>; 2],
    /// Whether it hit one of them.
    pub at_bound: bool,
    /// The prior.
    pub prior: Option<Prior>,
    /// Factor on the standard error, because residuals are correlated and differ from the stated noise.
    #[serde(alias = "widening")]
    pub error_inflation: Option<f64>,
    /// By how many standard errors mesh and step had moved it, before that was removed.
    pub numerical_shift: Option<f64>,
}

/// Correlations of estimates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Correlations {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Shape `[names][names]`.
    pub matrix: Vec<Vec<f64>>,
}

/// The fit of one release.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ReleaseFit {
    /// Its name.
    pub name: String,
    /// Its pressure, Pa.
    pub pressure_pa: Option<f64>,
    /// Payload, kg.
    pub payload_kg: f64,
    /// Largest distance of the tip from where it was seen last, m.
    pub excursion_m: f64,
    /// Whether it was kept out of the fit and only predicted.
    pub held_out: bool,
    /// End of what was fitted, s after release.
    pub duration_s: f64,
    /// Each track.
    pub tracks: Vec<TrackFit>,
    /// How its tip swings in the recording.
    #[serde(default)]
    pub measured: FrequencyAndDamping,
    /// How it swings in the fit, by the same samples.
    #[serde(default)]
    pub fitted: FrequencyAndDamping,
    /// How far the fit is from the recording in the quantities of a prediction.
    #[serde(default)]
    pub misfit: Misfit,
    /// Root mean square error of mesh and step, mm, before it was removed.
    pub numerical_error_mm: f64,
    /// What may be left of it, mm.
    pub numerical_error_left_mm: f64,
}

/// The fit of one track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrackFit {
    /// Name of the marker.
    pub marker: String,
    /// Samples fitted.
    pub samples: usize,
    /// Samples that the robust loss holds back.
    pub held_back: usize,
    /// Root mean square distance of measurement and prediction, mm, what is held back counting less.
    pub rms_mm: f64,
    /// Stated noise of a coordinate, mm.
    pub stated_noise_mm: f64,
    /// Noise of a coordinate as the residuals show it, mm.
    pub noise_mm: f64,
    /// Variance of the residuals over that of the stated noise.
    pub reduced_chi_squared: f64,
    /// Autocorrelation of the residuals at one sample.
    pub autocorrelation: f64,
}

/// One search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SearchReport {
    /// The releases that were fitted together.
    pub releases: Vec<String>,
    /// Stages of the fit.
    pub stages: Vec<Stage>,
    /// Searches begun.
    pub starts: usize,
    /// Whether the last one found its minimum.
    pub converged: bool,
    /// Half the sum of squared residuals over the noise, large ones counting less, and of the priors.
    pub cost: f64,
    /// Simulations of all its releases with their sensitivities.
    pub evaluations: usize,
    /// Steps of the integrator in these, roughly.
    pub steps: usize,
}

impl Calibrated {
    /// Its name and what it belongs to.
    pub fn label(&self) -> String {
        match (&self.release, self.pressure_pa) {
            (Some(release), _) => format!("{} of {release}", self.name),
            (None, Some(pressure)) => format!("{} at {}", self.name, format_si(pressure, "Pa")),
            (None, None) => self.name.clone(),
        }
    }

    /// Standard error over the value; none of a value of zero.
    pub fn relative_error(&self) -> Option<f64> {
        self.standard_error.map(|error| error / self.value.abs()).filter(|error| error.is_finite())
    }
}

impl Calibration {
    /// A problem with what was found in its models.
    pub fn applied(&self, problem: &Problem) -> Problem {
        let mut problem = problem.clone();
        for trial in problem.trials_mut() {
            let release = &trial.release;
            let is_own = |one: &&Calibrated| match (&one.release, one.pressure_pa) {
                (Some(own), _) => *own == release.name,
                (None, pressure) => is_of_pressure(pressure, release.pressure),
            };
            let own = self.parameters.iter().filter(is_own);
            let values: Vec<(usize, f64)> =
                own.filter_map(|one| Some((trial.model.index(&one.name).ok()?, one.value))).collect();
            (trial.model, trial.run.initial) = trial.with(&values);
        }
        problem
    }

    /// The same, each rod clamped, held and let go as it was found to be.
    pub fn as_held(&self, problem: &Problem) -> Problem {
        let mut problem = self.applied(problem);
        for trial in problem.trials_mut() {
            let name = trial.release.name.clone();
            let is_own = |one: &&Calibrated| one.release.as_ref() == Some(&name);
            for found in self.nuisances.iter().filter(is_own) {
                pose(trial, &found.name, found.value);
            }
        }
        problem
    }

    /// What was found of a release beside the parameters; zero where it was taken as given.
    pub fn nuisance(&self, release: &str, name: &str) -> f64 {
        let is_it = |one: &&Calibrated| one.name == name && one.release.as_deref() == Some(release);
        self.nuisances.iter().find(is_it).map_or(0.0, |one| one.value)
    }

    /// Offset of the tip's marker from the tip of the models; none where it was taken as given.
    pub fn marker(&self, problem: &Problem) -> Option<Marker> {
        let found = |release: &Release, name: &str| {
            let is_it = |one: &&Calibrated| one.name == name && one.release.as_ref() == Some(&release.name);
            let one = self.nuisances.iter().find(is_it)?;
            Some((one.value, one.standard_error.or(one.prior.map(|prior| prior.deviation))?))
        };
        let releases = problem.trials.iter().map(|trial| &trial.release);
        marker(releases.filter(|release| !release.held_out), found)
    }

    /// The parameters of a path, in the order of their pressures.
    pub fn of(&self, path: &str) -> Vec<&Calibrated> {
        let mut all: Vec<_> = self.parameters.iter().filter(|found| found.name == path).collect();
        all.sort_by(|a, b| a.pressure_pa.unwrap_or(0.0).total_cmp(&b.pressure_pa.unwrap_or(0.0)));
        all
    }
}

//! What a diagnosis says, as it is written to `diagnosis.json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::mesh_check::Numerics;
use crate::calibrate::repeats::Repeats;

/// The answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// One effect, or several, each told from all others.
    Named,
    /// The same, or a class, and more than noise and repeatability remains: a similar effect may act instead, or another one as
    /// well.
    Incomplete,
    /// Several effects that these recordings cannot separate, or an effect and a stated value that may be wrong instead.
    Class,
    /// A value that is stated of the setup is wrong; with another one nothing is missing.
    Misstated,
    /// Nothing that these recordings could show.
    #[default]
    NothingMissing,
    /// Something that the catalogue does not hold.
    Unknown,
}

/// A diagnosis with its evidence.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Diagnosis {
    /// The answer.
    pub verdict: Verdict,
    /// The answer in words: its first line with the gap before and after, then a line for each piece of evidence.
    pub summary: String,
    /// Effects that were added to the model, in the order in which they were found.
    pub effects: Vec<Added>,
    /// Effects that would do as well as the last one added; empty where it stands alone.
    pub members: Vec<Member>,
    /// Recordings that separate the members.
    pub separating_experiment: Option<Separation>,
    /// Every candidate of every round.
    pub evidence: Vec<Evidence>,
    /// Gap between simulation and recordings, before and after.
    pub gap: Vec<Gap>,
    /// How well the experiment repeats; none where that is not known.
    #[serde(default)]
    pub repeats: Option<Repeats>,
    /// The misfit, and the share that the effects explain.
    #[serde(default)]
    pub shares: Option<Shares>,
    /// Parameters that the fit moved far from the stated setup, the farthest first.
    #[serde(default)]
    pub contradictions: Vec<Contradiction>,
    /// False-alarm level of a round, and the score that it amounts to.
    pub false_alarm: f64,
    /// Score that a candidate has to exceed, by round.
    pub thresholds: Vec<f64>,
    /// Whether the model as it is misses even the first swings, so that candidates were fitted to these first.
    #[serde(default)]
    pub misses_first_swings: bool,
    /// Errors of the simulation before anything is added, the largest first; empty where it misses even the first
    /// swings.
    pub misfits: Vec<Misfit>,
    /// Residual patterns of each round.
    pub shapes: Vec<Shape>,
    /// Mesh and step.
    pub numerics: Numerics,
    /// Held-out releases, by name.
    pub held_out: Vec<String>,
    /// A moment that would explain the residual where no effect does: a description, not a cause.
    pub description: Option<Description>,
    /// Where the search was cut short, and what it left out; none where it ended by itself.
    #[serde(default)]
    pub cut_short: Option<CutShort>,
    /// Most node steps (nodes times steps of the integrator) of the search.
    #[serde(default)]
    pub budget: u64,
    /// Node steps of all its simulations, those of the baseline included.
    #[serde(default)]
    pub node_steps: u64,
    /// Caveats of the answer.
    pub warnings: Vec<String>,
}

/// What a search that was cut short left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CutShort {
    /// The round in which the search was cut short, so that its answer is not final; none where it was completed, and
    /// parts of the answer alone are left out.
    pub round: Option<usize>,
    /// What ended it.
    pub by: CutBy,
    /// Candidates that were not fitted for that, in the order of their scores where they have any.
    pub not_fitted: Vec<String>,
    /// Other parts of the search and of the answer that were left out.
    pub left_out: Vec<String>,
}

/// What ended a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CutBy {
    /// Its budget of work: the answer depends on no clock, load or number of threads.
    Budget,
    /// A time limit or the user: another machine may give another answer.
    Interruption,
}

/// An effect that the repaired model has.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Added {
    /// Its stable name.
    pub effect: String,
    /// Its parameters.
    pub parameters: Vec<ParameterValue>,
}

/// A parameter of an added effect; SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ParameterValue {
    /// Scenario key.
    pub name: String,
    /// SI unit; empty if dimensionless.
    pub unit: String,
    /// The release or pressure that it belongs to, where each has its own.
    pub of: Option<String>,
    /// Its value.
    pub value: f64,
    /// Interval that holds the truth in 95 % of experiments; none for one that was held.
    pub interval_95: Option<[f64; 2]>,
}

/// A parameter that a fit moved far from what is stated of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Contradiction {
    /// Its name.
    pub parameter: String,
    /// Where the fit has it, SI.
    pub value: f64,
    /// SI unit; empty if dimensionless.
    pub unit: String,
    /// Distance from the stated value, in its standard deviations.
    pub deviations: f64,
}

/// An effect with the same trace in these recordings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Member {
    /// Its stable name.
    pub effect: String,
    /// By how much its best fit is worse than that of the best, χ² in units of the noise as it is.
    pub behind: f64,
    /// How far apart its trace and that of the best are when all else is fitted, standard deviations:
    /// below 2 they are one, from 5 on they are separable.
    pub distance: f64,
}

/// An experiment that would tell the members of a class apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Separation {
    /// The recording to make.
    pub what: String,
    /// Distance of the two nearest members with it, found by simulating it.
    pub distance: f64,
    /// The same without it.
    pub distance_now: f64,
}

/// Evidence for and against one candidate in one round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Evidence {
    /// Round, 1 being the search for the first effect.
    pub round: usize,
    /// Its stable name.
    pub effect: String,
    /// Whether it was found before, and this candidate has a strength for each pressure.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub of_each_pressure: bool,
    /// Whether it was fitted to the first swings, because the model misses even those: its score is the root of the
    /// decrease of χ² there.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub of_first_swings: bool,
    /// Values at which parameters were tried.
    pub tried: Vec<(String, f64)>,
    /// Size of its score.
    pub score: f64,
    /// Predicted decrease of χ².
    pub predicted_decrease: f64,
    /// Decrease of χ² when it was fitted, roughly where it came not near the best; none where it was not.
    pub realised_decrease: Option<f64>,
    /// Its strength: the fitted one, or else the predicted one; SI.
    pub strength: f64,
    /// Decrease of χ² on held-out releases.
    pub held_out_decrease: Option<f64>,
    /// Reason for its rejection; none for the answer.
    pub rejected: Option<String>,
}

impl Evidence {
    /// Says why it is not the answer; the first reason stands.
    pub(super) fn reject(&mut self, why: &str) {
        self.rejected.get_or_insert_with(|| why.to_owned());
    }

    /// What was requested, as a row of a table names it.
    pub fn label(&self) -> String {
        if self.of_each_pressure { format!("{}, by pressure", self.effect) } else { self.effect.clone() }
    }
}

/// Gap between simulation and recordings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Gap {
    /// Name of the release.
    pub release: String,
    /// Whether it is held out.
    pub held_out: bool,
    /// Root mean square distance of all samples without the effects, mm, and with them.
    pub before_mm: f64,
    /// With them.
    pub after_mm: f64,
    /// The same over the noise, 1 being noise alone, without samples that the robust loss holds back.
    pub before: f64,
    /// With them.
    pub after: f64,
    /// Standard deviation of the noise of a coordinate, mm: the mean over the tracks.
    pub noise_mm: f64,
}

/// A description, not a cause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Description {
    /// The terms that were needed, as parameters of `latent_moment`.
    pub moment: Added,
    /// Share of what noise does not explain that is gone with it, over what was fitted.
    pub share: f64,
    /// Decrease of χ², in units of the noise as it is.
    pub decrease: f64,
}

/// A pattern that the residual may have.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Shape {
    /// Round; the last one is of the repaired model.
    pub round: usize,
    /// In words.
    pub what: String,
    /// Size of its score.
    pub score: f64,
    /// Score that a shape has to exceed.
    pub threshold: f64,
    /// Amplitude, as a share of the largest of all releases, at which most of it is.
    pub at_amplitude: f64,
    /// Its size there at the tip, mm, when all else is fitted.
    pub size_mm: f64,
}

/// Something that a simulation does wrong.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Misfit {
    /// What it does.
    pub what: Wrong,
    /// Amplitudes, as shares of the largest of all releases, between which it does so.
    pub amplitudes: [f64; 2],
    /// Change of the measured swing against the simulated one from cycle to cycle: a share of the amplitude,
    /// or an angle of the phase, rad.
    pub per_cycle: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Its size between these amplitudes, mm at the marker.
    pub size_mm: f64,
    /// Cycles that a release takes there, and cycles before that: medians.
    pub cycles: [f64; 2],
    /// Pressures at which it can be seen, Pa.
    pub pressures_pa: Vec<f64>,
    /// Pressures that swing at these amplitudes, Pa.
    pub pressures_there_pa: Vec<f64>,
}

/// An error of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Wrong {
    /// It decays more slowly than what was measured.
    LosesEnergyTooSlowly,
    /// It decays faster.
    LosesEnergyTooFast,
    /// Its frequency is too low.
    SwingsTooSlowly,
    /// Its frequency is too high.
    SwingsTooFast,
}

/// What was missing before anything was added, and what of it is left; root mean square over releases and samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Shares {
    /// Distance of simulation and recordings before, mm, of the releases that were fitted.
    pub before_mm: f64,
    /// The same with the effects.
    pub left_mm: f64,
    /// Share of the square of what noise does not explain that is gone; none where there is nothing to explain.
    pub removed: Option<f64>,
    /// The same for held-out releases.
    pub removed_held_out: Option<f64>,
}

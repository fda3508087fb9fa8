//! What a diagnosis says, as it is written to `diagnosis.json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// One effect, or several, each separated from all others.
    Named,
    /// The same, and more than noise and repeatability remains: a similar effect may act instead, or another one as well.
    Incomplete,
    /// Several effects, or an effect and a statement, that these recordings cannot separate.
    Class,
    /// A value that is stated of the rod or the setup is wrong; with another one nothing is missing.
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
    /// A statement that was freed because it explains more than any effect: its word, such as `stiffness`; none where none was.
    pub freed: Option<String>,
    /// Effects and statements that explain the recordings as well as one that was added.
    pub members: Vec<Member>,
    /// Recordings that separate the members.
    pub separating_experiment: Option<Separation>,
    /// Candidates of each round, with their odds.
    pub rounds: Vec<Round>,
    /// What was seen: features that the answer mends, the largest gain first; those that are off most where there is no answer.
    pub seen: Vec<Seen>,
    /// What the fit moved far from the stated rod and setup, the farthest first.
    pub contradictions: Vec<Contradiction>,
    /// Gap between simulation and recordings, before and after.
    pub gap: Vec<Gap>,
    /// The same of all fitted releases together.
    pub total: Total,
    /// Held-out releases, by name.
    pub held_out: Vec<String>,
    /// Probability, given the recordings, that nothing is missing, above which no effect is named.
    pub false_alarm: f64,
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Features of all fitted releases, and unknowns of the model without anything added.
    pub features: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// Where the search was cut short; none where it ended by itself.
    pub cut_short: Option<CutShort>,
    /// Most node steps (nodes times steps of the integrator) of the search.
    pub budget: u64,
    /// Node steps of all its simulations.
    pub node_steps: u64,
    /// Simulated releases.
    pub runs: usize,
    /// Caveats of the answer.
    pub warnings: Vec<String>,
}

/// Where a search was cut short.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CutShort {
    /// The round that was not completed, so that the answer is not final; none where every round was, and parts of the answer
    /// alone are left out.
    pub round: Option<usize>,
    /// What ended it.
    pub by: CutBy,
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
    /// Interval that holds the truth with 95 %, given the model; none for one that was held.
    pub interval_95: Option<[f64; 2]>,
}

/// A value of the rod or the setup that a fit moved far from what is stated of it; SI.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Contradiction {
    /// Its name.
    pub parameter: String,
    /// Where the fit has it; of what is stated as a value itself, of a setup its distance from the statement.
    pub value: f64,
    /// Interval that holds it with 95 %, given the model.
    pub interval_95: [f64; 2],
    /// SI unit; empty if dimensionless.
    pub unit: String,
    /// Distance from the stated value, in its standard deviations as stated.
    pub deviations: f64,
}

/// An effect or statement with the same trace in these recordings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Member {
    /// Its stable name.
    pub effect: String,
    /// Logarithm of the odds of the best over it.
    pub behind: f64,
    /// How far apart its trace and that of the best are when all else is fitted, standard deviations: below 2 they are one,
    /// from 5 on they are separable. None of a statement.
    pub distance: Option<f64>,
}

/// An experiment that would separate the members of a class.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Separation {
    /// The recording to make.
    pub what: String,
    /// Distance of the two nearest members with it, found by simulating it.
    pub distance: f64,
    /// The same without it.
    pub distance_now: f64,
}

/// One round: candidates beside what was found before.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Round {
    /// Logarithm of the odds that an answer must exceed.
    pub bar: f64,
    /// Share of the swing that the model misses or that does not repeat, before.
    pub share: f64,
    /// Candidates that were fitted, the best first.
    pub candidates: Vec<Odds>,
    /// Candidates that were not fitted: a model that is linear about that of before promises less of them.
    pub others: Vec<String>,
}

/// Odds of one candidate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Odds {
    /// Effect or statement.
    pub name: String,
    /// Logarithm of the odds over the model without it, by features.
    pub features: f64,
    /// The same by all samples; none where they were not fitted.
    pub all: Option<f64>,
    /// Share of the swing that is left.
    pub share: f64,
    /// What is left of all samples, mm; none where that was not fitted.
    pub rms_mm: Option<f64>,
    /// Why it is not the answer; none for the answer.
    pub rejected: Option<String>,
}

impl Odds {
    /// By all samples, or else by features.
    pub fn best(&self) -> f64 {
        self.all.unwrap_or(self.features)
    }

    /// That it is in the answer, or why it is not.
    pub fn reason(&self) -> &str {
        self.rejected.as_deref().unwrap_or("in the answer")
    }
}

/// A feature before and after.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Seen {
    /// Release.
    pub release: String,
    /// What it is, in words.
    pub what: String,
    /// Its unit; empty if dimensionless.
    pub unit: String,
    /// As recorded, in that unit.
    pub recorded: f64,
    /// As the model has it before.
    pub before: f64,
    /// With the answer.
    pub after: f64,
    /// Distance from the recording before and after, in standard deviations of what the answer leaves.
    pub deviations: [f64; 2],
}

/// Gap between simulation and recordings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Gap {
    /// Name of the release.
    pub release: String,
    /// Whether it is held out.
    pub held_out: bool,
    /// Root mean square distance of all samples without the answer, mm.
    pub before_mm: f64,
    /// With it.
    pub after_mm: f64,
    /// The same over the noise, 1 being noise alone.
    pub before: f64,
    /// With it.
    pub after: f64,
    /// Standard deviation of the noise of a coordinate, mm: the mean over the tracks.
    pub noise_mm: f64,
}

/// Root mean square distance of simulation and recordings over all fitted releases, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Total {
    /// Of the model as it is.
    pub before_mm: f64,
    /// With the answer.
    pub after_mm: f64,
    /// Of noise alone.
    pub noise_mm: f64,
    /// How well releases repeat, mm: as stated, or as releases of one condition show it, or else 1.7 % of the first swing.
    pub repeats_mm: f64,
}

impl Diagnosis {
    /// The round in which the search was cut short, if its answer is not final.
    pub fn cut_short_in_round(&self) -> Option<usize> {
        self.cut_short.as_ref()?.round
    }
}

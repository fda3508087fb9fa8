//! The answer: odds, values, what was seen, and what is left.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::diagnose::verdict::Verdict;

/// What hypotheses are weighed to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Weighed {
    /// The answer.
    pub verdict: Verdict,
    /// The same in words.
    pub summary: String,
    /// Effects, and a statement that is wrong, in the order in which they were found.
    pub named: Vec<String>,
    /// Others that these recordings cannot separate from the last one.
    pub members: Vec<String>,
    /// Rounds of the search.
    pub rounds: Vec<Round>,
    /// Parameters of what was named, from the fit to all samples.
    pub values: Vec<Value>,
    /// Parts of the setup that the fit moved by more than two prior standard deviations.
    pub moved: Vec<Value>,
    /// What is left, root mean square distance of the markers, mm: of the model as it is, with the answer, and of noise alone.
    pub before_mm: f64,
    /// With the answer.
    pub after_mm: f64,
    /// Of noise alone.
    pub noise_mm: f64,
    /// What was seen: features that the answer mends, the largest gain first.
    pub seen: Vec<Seen>,
    /// Simulated releases.
    pub runs: usize,
    /// Features of all releases, and unknowns of the model without anything added.
    pub features: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// Releases that took part.
    pub releases: usize,
    /// Caveats.
    pub warnings: Vec<String>,
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
}

/// Odds of one candidate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Odds {
    /// Effect or statement.
    pub name: String,
    /// Logarithm of the odds over the model without it, by features.
    pub features: f64,
    /// The same with what the fit to all samples adds; none where that was not made.
    pub all: Option<f64>,
    /// Share that is left.
    pub share: f64,
    /// What is left of all samples, mm; none where that was not fitted.
    pub rms_mm: Option<f64>,
}

/// A value with its interval.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Value {
    /// What has it.
    pub name: String,
    /// SI unit; empty if dimensionless.
    pub unit: String,
    /// Its value, SI.
    pub value: f64,
    /// Interval that holds the truth with 95 %, given the model.
    pub interval_95: [f64; 2],
    /// Prior standard deviations from its prior mean.
    pub deviations: f64,
}

/// A feature before and after.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Seen {
    /// Release.
    pub release: String,
    /// What it is, in words.
    pub what: String,
    /// As recorded, in the unit of the words.
    pub recorded: f64,
    /// As the model has it without the answer.
    pub before: f64,
    /// With the answer.
    pub after: f64,
    /// What it adds to the logarithm of the likelihood.
    pub gain: f64,
}

impl Weighed {
    /// The answer as a table for a terminal.
    pub fn table(&self) -> String {
        let mut text = format!("{}\n", self.summary);
        for (k, round) in self.rounds.iter().enumerate() {
            text += &format!(
                "\nround {}: {:.2} % of the swing is missed; an answer needs log odds of {:.1}\n",
                k + 1,
                100.0 * round.share,
                round.bar
            );
            for own in &round.candidates {
                let all = own.all.map_or(String::new(), |all| format!(", with all samples {all:.1}"));
                let rms = own.rms_mm.map_or(String::new(), |rms| format!(", {rms:.3} mm left"));
                text += &format!(
                    "  {:24} {:8.1}{all}, {:.2} % missed{rms}\n",
                    own.name,
                    own.features,
                    100.0 * own.share
                );
            }
        }
        for own in self.values.iter().chain(&self.moved) {
            let [low, high] = own.interval_95;
            text += &format!("  {} = {:.4e} ({low:.3e} to {high:.3e}) {}\n", own.name, own.value, own.unit);
        }
        for own in &self.seen {
            text += &format!(
                "  {}: {} is {:.4}; {:.4} before, {:.4} after ({:.1})\n",
                own.release, own.what, own.recorded, own.before, own.after, own.gain
            );
        }
        text += &format!(
            "all samples: {:.3} mm before, {:.3} mm after, {:.3} mm of noise; {} features, {} unknowns, {} runs\n",
            self.before_mm, self.after_mm, self.noise_mm, self.features, self.unknowns, self.runs
        );
        for own in &self.warnings {
            text += &format!("caveat: {own}\n");
        }
        text
    }
}

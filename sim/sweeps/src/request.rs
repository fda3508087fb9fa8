//! The request of a sweep, as a TOML file gives it.
//!
//! ```toml
//! [sweep]
//! scenario = "release-15psi.toml"   # relative to this file
//! design = "latin_hypercube"        # grid, sobol, posterior
//! points = 256                      # a grid has as many as its values give
//! seed = 1
//! [[sweep.parameter]]
//! path = "effects.payload.mass"     # any key of a scenario but files, as --set says it
//! range = ["0 g", "200 g"]          # or values = ["0 g", "50 g", "100 g"]
//! steps = 11                        # of a range in a grid
//! scale = "linear"                  # logarithmic
//! ```
//!
//! Instead of `scenario` it may have `experiments` ([`super::experiments`]).

use std::path::{Path, PathBuf};

use efam_experiments::scenario::document::{Document, Keys};
use efam_experiments::scenario::{Scenario, ScenarioError, ScenarioProblem, plan};
use efam_store::input;
use models::nearest::nearest;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::experiments::{self, OfExperiments};
use super::key::{ValueKind, Varying};
use super::point::setting;
use super::row::DesignValue;

/// Points of a sweep, at most.
pub const MOST_POINTS: usize = 10_000_000;
/// Points of a Sobol' design, at most: the sequence has no more.
pub const MOST_SOBOL: usize = 1 << 16;
/// Steps of a range in a grid, at most.
const MOST_STEPS: usize = 1_000_000;
/// Parameters that vary, at most; the sequence of Sobol' has 256 dimensions.
const MOST_PARAMETERS: usize = 64;

/// What a posterior leaves to its reader.
const MESH: &str = "the calibration removed the error of its mesh from its numbers, and these runs have the error of \
                    theirs: for numbers as exact as those of `efam predict` give more rod.nodes";

/// How points are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Design {
    /// Every value of each with every value of all others; the last varies fastest.
    Grid,
    /// Each range in as many layers as there are points, a point in each.
    LatinHypercube,
    /// Points of Sobol', scrambled.
    Sobol,
    /// Draws from the errors of the scenario's calibration; ranges beside them are drawn evenly.
    Posterior,
}

/// Values that a parameter may have.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// One of these.
    List(Vec<DesignValue>),
    /// Any between two.
    Range {
        /// The lower end.
        low: f64,
        /// The upper end.
        high: f64,
        /// Whether their logarithms are evenly spread.
        logarithmic: bool,
    },
}

/// What varies.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignParameter {
    /// Key of the scenario.
    pub path: String,
    /// What its values are.
    pub kind: ValueKind,
    /// Which.
    pub values: Values,
}

/// A sweep, read and checked.
#[derive(Clone, Debug)]
pub struct SweepRequest {
    /// Name: as given, or that of the file.
    pub name: String,
    /// Its file.
    pub path: PathBuf,
    /// The text of the file.
    pub text: String,
    /// What it is about.
    pub subject: Subject,
    /// Caveats of the results.
    pub warnings: Vec<String>,
}

/// What a sweep is about.
#[derive(Clone, Debug)]
pub enum Subject {
    /// A scenario with values that vary.
    Scenario(OfScenario),
    /// Experiments.
    Experiments(OfExperiments),
}

/// A scenario with values that vary.
#[derive(Clone, Debug)]
pub struct OfScenario {
    /// The file of the scenario.
    pub scenario: PathBuf,
    /// Its text.
    pub scenario_text: String,
    /// How points are chosen.
    pub design: Design,
    /// How many.
    pub points: usize,
    /// Of the random numbers.
    pub seed: u64,
    /// What varies.
    pub parameters: Vec<DesignParameter>,
    /// What is set over the scenario at every point: whatever other files say.
    pub set: Vec<String>,
}

impl SweepRequest {
    /// Reads a sweep's file and sets `overrides` over it, each as `path=value`.
    /// # Errors
    /// [`ScenarioError`], of the sweep, of its scenario, or where no experiment can be diagnosed.
    pub fn load(path: &Path, overrides: &[String]) -> Result<SweepRequest, ScenarioError> {
        SweepRequest::of(path, Document::load(path, overrides)?)
    }

    /// The sweep that a text describes; files in it are relative to `path`.
    /// # Errors
    /// As [`SweepRequest::load`].
    pub fn parse(path: &Path, text: &str, overrides: &[String]) -> Result<SweepRequest, ScenarioError> {
        SweepRequest::of(path, Document::parse(path, text, overrides)?)
    }

    fn of(path: &Path, document: Document) -> Result<SweepRequest, ScenarioError> {
        let keys = document.keys();
        keys.only(&["name", "sweep"])?;
        let sweep = keys.table("sweep")?;
        if !sweep.is_given() {
            let example =
                "[sweep] on a line of its own, and scenario = \"…\" or experiments = [\"…\"] under it";
            return Err(keys.missing("sweep", example));
        }
        sweep.only(&[&KEYS[..], &experiments::KEYS].concat())?;
        let of_experiments = ["experiments", "experiment"].into_iter().find(|key| sweep.has(key));
        let others: &[&str] = if of_experiments.is_some() { &KEYS } else { &experiments::KEYS };
        if let Some(key) = others.iter().find(|key| sweep.has(key)) {
            let message = match of_experiments {
                Some(own) => {
                    format!("belongs to a sweep over a scenario, and this one has {own}; keep one of them")
                }
                None => {
                    "belongs to a sweep over experiments; give these instead of scenario, or leave it out"
                        .to_owned()
                }
            };
            return Err(sweep.wrong(key, ScenarioProblem::Other { message }));
        }
        let (subject, warnings) = if of_experiments.is_some() {
            let folder = path.parent().unwrap_or(Path::new(""));
            let (own, warnings) = OfExperiments::read(&sweep, folder)?;
            (Subject::Experiments(own), warnings)
        } else {
            let (own, warnings) = OfScenario::read(&document, &sweep)?;
            (Subject::Scenario(own), warnings)
        };
        let name = plan::name(&document, path, "sweep")?;
        Ok(SweepRequest { name, path: path.to_owned(), text: document.text().to_owned(), subject, warnings })
    }

    /// How many points.
    pub fn points(&self) -> usize {
        match &self.subject {
            Subject::Scenario(own) => own.points,
            Subject::Experiments(own) => own.all.len(),
        }
    }
}

/// Keys of a sweep over a scenario.
const KEYS: [&str; 5] = ["scenario", "design", "points", "seed", "parameter"];

impl OfScenario {
    /// Reads it; says what should be known beforehand, too.
    fn read(document: &Document, sweep: &Keys) -> Result<(OfScenario, Vec<String>), ScenarioError> {
        let Some((scenario, place)) = sweep.text("scenario")? else {
            return Err(sweep.missing("scenario", "scenario = \"release-15psi.toml\", or experiments"));
        };
        let scenario = document.file(place, scenario);
        let scenario_text = input::text(&scenario).map_err(|error| {
            let file = scenario.display().to_string();
            sweep.wrong("scenario", ScenarioProblem::Unreadable { file, reason: error.to_string() })
        })?;
        let designs = [
            ("grid", Design::Grid),
            ("latin_hypercube", Design::LatinHypercube),
            ("sobol", Design::Sobol),
            ("posterior", Design::Posterior),
        ];
        let Some(design) = sweep.word("design", &designs)? else {
            return Err(sweep.missing("design", "design = \"grid\", latin_hypercube, sobol or posterior"));
        };
        let tables = sweep.tables("parameter")?;
        // Before their values are made.
        if tables.len() > MOST_PARAMETERS {
            return Err(sweep.wrong("parameter", ScenarioProblem::Must { must: "be 64 tables at most" }));
        }
        let keys = Varying::of(&scenario, &scenario_text)?;
        let mut parameters = Vec::new();
        for table in &tables {
            parameters.push(parameter(table, design, &keys)?);
            if design == Design::Grid {
                // Before the values of the next are made.
                points(sweep, design, &parameters)?;
            }
        }
        for (k, own) in parameters.iter().enumerate() {
            if parameters[..k].iter().any(|other| other.path == own.path) {
                let message = "is varied already; keep one of the two".to_owned();
                return Err(tables[k].wrong("path", ScenarioProblem::Other { message }));
            }
        }
        if parameters.is_empty() && design != Design::Posterior {
            let example =
                "[[sweep.parameter]] with path = \"muscle.pressure\" and range = [\"10 psi\", \"100 psi\"]";
            return Err(sweep.missing("parameter", example));
        }
        let mut own = OfScenario {
            scenario,
            scenario_text,
            design,
            points: points(sweep, design, &parameters)?,
            seed: sweep.count("seed")?.unwrap_or(1) as u64,
            parameters,
            set: Vec::new(),
        };
        let warnings = own.take_in_files(sweep)?;
        Ok((own, warnings))
    }

    /// What other files say is set over the scenario, so that the plan needs none of them; and the scenario is
    /// tried as it is. Returns what should be known before the results are used.
    fn take_in_files(&mut self, sweep: &Keys) -> Result<Vec<String>, ScenarioError> {
        let mut warnings = Vec::new();
        // The scenario need not contain what varies.
        let first = |own: &DesignParameter| setting(Some(own.kind), &own.path, &own.values.at(0.0, own.kind));
        let varied: Vec<String> = self.parameters.iter().map(first).collect();
        let scenario = Scenario::parse(&self.scenario, &self.scenario_text, &varied)?;
        self.set = scenario.without_files();
        if let Some(nodes) = scenario.known().and_then(|known| known.nodes) {
            self.set.insert(0, format!("rod.nodes={nodes}"));
        }
        if scenario.is_all_rows() {
            let message =
                "asks for all rows of its muscle; give muscle.pressure as a [[sweep.parameter]], or \
                           another scenario"
                    .to_owned();
            return Err(sweep.wrong("scenario", ScenarioProblem::Other { message }));
        }
        if self.design == Design::Posterior {
            let Some(known) = scenario.known() else {
                let message =
                    "has no [calibration] to draw from; give a scenario with the muscle.toml or rod.toml \
                               of a calibration"
                        .to_owned();
                return Err(sweep.wrong("scenario", ScenarioProblem::Other { message }));
            };
            warnings.extend(known.nodes.is_none().then(|| MESH.to_owned()));
        }
        // A point that is refused is a row; that none could be otherwise is said now.
        if let Err(error) = scenario.cases() {
            Scenario::parse(&self.scenario, &self.scenario_text, &[])
                .and_then(|own| own.cases())
                .map_err(|_| error)?;
        }
        Ok(warnings)
    }

    /// Whether a key varies.
    pub fn varies(&self, path: &str) -> bool {
        self.parameters.iter().any(|own| own.path == path)
    }
}

fn points(sweep: &Keys, design: Design, parameters: &[DesignParameter]) -> Result<usize, ScenarioError> {
    let given = sweep.count("points")?;
    if design == Design::Grid {
        if given.is_some() {
            let message = "a grid has as many points as its values give; leave it out".to_owned();
            return Err(sweep.wrong("points", ScenarioProblem::Other { message }));
        }
        let count = |own: &DesignParameter| if let Values::List(all) = &own.values { all.len() } else { 1 };
        let all = parameters.iter().try_fold(1usize, |all, own| all.checked_mul(count(own)));
        return all.filter(|all| *all <= MOST_POINTS).ok_or_else(|| {
            let must = "give ten million points at most; give fewer values or steps";
            sweep.wrong("parameter", ScenarioProblem::Must { must })
        });
    }
    let Some(given) = given else { return Err(sweep.missing("points", "points = 256")) };
    let (most, must) = match design {
        Design::Sobol => (MOST_SOBOL, "lie in 1..=65536, all that the sequence of Sobol' has"),
        _ => (MOST_POINTS, "lie in 1..=10000000"),
    };
    if (1..=most).contains(&given) {
        Ok(given)
    } else {
        Err(sweep.wrong("points", ScenarioProblem::Must { must }))
    }
}

fn parameter(table: &Keys, design: Design, keys: &Varying) -> Result<DesignParameter, ScenarioError> {
    table.only(&["path", "range", "values", "steps", "scale"])?;
    let Some((path, _)) = table.text("path")? else {
        return Err(table.missing("path", "path = \"effects.payload.mass\""));
    };
    let Some(kind) = keys.kind(path) else {
        let known: Vec<String> = keys.all().collect();
        let nearest = nearest(path, known.iter().map(String::as_str)).map(str::to_owned);
        let known = vec!["keys of scenarios but files".to_owned(), "parameters of `efam effects`".to_owned()];
        return Err(table.wrong("path", ScenarioProblem::UnknownWord { nearest, known }));
    };
    let steps = table.count("steps")?;
    let scale = table.word("scale", &[("linear", false), ("logarithmic", true)])?;
    let values = match (table.has("range"), table.has("values")) {
        (true, false) => range(table, kind, scale == Some(true))?,
        (false, true) => list(table, kind)?,
        (true, true) => {
            let message = "values stand here already; keep one of values and range".to_owned();
            return Err(table.wrong("range", ScenarioProblem::Other { message }));
        }
        (false, false) => return Err(table.missing("range", "range = [\"0 g\", \"200 g\"], or values")),
    };
    let is_stepped = design == Design::Grid && matches!(values, Values::Range { .. });
    for (key, is_used) in [("steps", is_stepped), ("scale", table.has("range"))] {
        if table.has(key) && !is_used {
            let message = "belongs to a range".to_owned() + if key == "steps" { " in a grid" } else { "" };
            return Err(table.wrong(key, ScenarioProblem::Other { message: message + "; leave it out" }));
        }
    }
    let values = match (steps, values) {
        (Some(steps), Values::Range { .. }) if !(2..=MOST_STEPS).contains(&steps) => {
            return Err(table.wrong("steps", ScenarioProblem::Must { must: "lie in 2..=1000000" }));
        }
        (Some(steps), range) => stepped(&range, steps, kind),
        (None, Values::Range { .. }) if is_stepped => {
            return Err(table.missing("steps", "steps = 11"));
        }
        (None, values) => values,
    };
    Ok(DesignParameter { path: path.to_owned(), kind, values })
}

fn range(table: &Keys, kind: ValueKind, logarithmic: bool) -> Result<Values, ScenarioError> {
    let ends = match kind {
        ValueKind::Quantity(unit) => table.quantities("range", unit)?,
        ValueKind::Count => table.counts("range")?.map(|all| all.iter().map(|count| *count as f64).collect()),
        ValueKind::Word => {
            let message = "words have no range; write values = [\"…\", \"…\"]".to_owned();
            return Err(table.wrong("range", ScenarioProblem::Other { message }));
        }
    };
    match ends.as_deref() {
        Some([low, high]) if low < high && (*low > 0.0 || !logarithmic) => {
            Ok(Values::Range { low: *low, high: *high, logarithmic })
        }
        _ if logarithmic => {
            let must = "be two positive values, the lower one first; scale = \"linear\" admits zero";
            Err(table.wrong("range", ScenarioProblem::Must { must }))
        }
        _ => Err(table.wrong("range", ScenarioProblem::Must { must: "be two values, the lower one first" })),
    }
}

fn list(table: &Keys, kind: ValueKind) -> Result<Values, ScenarioError> {
    let numbers = |all: Vec<f64>| all.into_iter().map(DesignValue::Number).collect();
    let all: Vec<DesignValue> = match kind {
        ValueKind::Quantity(unit) => table.quantities("values", unit)?.map(numbers),
        ValueKind::Count => {
            table.counts("values")?.map(|all| numbers(all.iter().map(|n| *n as f64).collect()))
        }
        ValueKind::Word => {
            let words = table.texts("values")?;
            let is_word = |word: &&str| word.chars().all(|c| c.is_alphanumeric() || "-_.+".contains(c));
            if words.as_ref().is_some_and(|words| !words.iter().all(is_word)) {
                let must = "be words of letters, digits and - _ + .";
                return Err(table.wrong("values", ScenarioProblem::Must { must }));
            }
            words.map(|words| words.into_iter().map(str::to_owned).map(DesignValue::Word).collect())
        }
    }
    .unwrap_or_default();
    if all.is_empty() {
        return Err(table.wrong("values", ScenarioProblem::Must { must: "be one value at least" }));
    }
    Ok(Values::List(all))
}

/// A range in steps, both ends included.
fn stepped(range: &Values, steps: usize, kind: ValueKind) -> Values {
    let at = |k: usize| range.at(k as f64 / (steps - 1) as f64, kind);
    let mut all: Vec<DesignValue> = Vec::new();
    for value in (0..steps).map(at) {
        // Whole numbers have fewer values than steps.
        if all.last() != Some(&value) {
            all.push(value);
        }
    }
    Values::List(all)
}

impl Values {
    /// The value at a share of the way through them, from 0 to 1.
    pub fn at(&self, share: f64, kind: ValueKind) -> DesignValue {
        match self {
            Values::List(all) => {
                let k = (share * all.len() as f64) as usize;
                all[k.min(all.len() - 1)].clone()
            }
            Values::Range { low, high, logarithmic } => {
                let value = match (logarithmic, share) {
                    // To the last bit.
                    (_, 0.0) => *low,
                    (_, 1.0) => *high,
                    (false, share) => low + share * (high - low),
                    (true, share) => (low.ln() + share * (high.ln() - low.ln())).exp(),
                };
                let value = if kind == ValueKind::Count { value.round() } else { value };
                DesignValue::Number(value.clamp(*low, *high))
            }
        }
    }
}

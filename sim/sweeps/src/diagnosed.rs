//! A point of a sweep over experiments: an experiment as it was planned, and what its diagnosis says.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use efam_experiments::cleaning::clean;
use efam_experiments::experiment::Experiment;
use efam_inference::diagnose::verdict::{Added, Gap};
use efam_inference::diagnose::{Diagnosis, DiagnosisSettings, Verdict, diagnose, problem};
use efam_store::columns::{Cell, Cells, Column, Holds};
use efam_store::input;
use efam_store::sha::sha256;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::row::{DesignValue, Point, Row, fault, joined};

/// Diagnoses of experiments, each with a catalogue of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Diagnose {
    /// The folder in which the experiments are.
    pub folder: String,
    /// Probability that nothing is missing above which no effect is named: as text, which is read back as it is.
    pub false_alarm: String,
    /// Largest number of effects to add.
    pub most: usize,
    /// Node steps after which no further part of the search begins.
    #[serde(default = "usual_budget", skip_serializing_if = "is_usual_budget")]
    pub budget: u64,
}

fn usual_budget() -> u64 {
    DiagnosisSettings::default().budget
}

/// Plans of before have no budget, and keep their hash.
fn is_usual_budget(budget: &u64) -> bool {
    *budget == usual_budget()
}

/// The text between names of a list.
pub(super) const AND: &str = " + ";

/// The columns that a point has before it is diagnosed.
const GIVEN: [&str; 3] = ["experiment", "sha256", "without"];
/// Texts of a diagnosis, then its numbers with unit and meaning.
const TEXTS: [&str; 4] = ["verdict", "effects", "members", "parameters"];
const NUMBERS: [(&str, &str, &str); 6] = [
    ("gap_before", "", "largest gap of fitted releases, before"),
    ("gap_after", "", "largest gap of fitted releases, after"),
    ("held_out_gap_before", "", "largest gap of held-out releases, before"),
    ("held_out_gap_after", "", "largest gap of held-out releases, after"),
    ("noise_m", "m", "largest noise of a release"),
    ("separation", "", "distance of the nearest two with the recording that is proposed"),
];

/// An answer, as a row has it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Answer {
    /// The point.
    pub point: usize,
    /// Its experiment.
    pub experiment: String,
    /// Why there is no answer.
    pub failed: Option<String>,
    /// The answer; none if it failed.
    pub verdict: Option<Verdict>,
    /// Effects that were added to the model, in the order in which they were found.
    pub effects: Vec<Added>,
    /// Effects that would do as well as the last one.
    pub members: Vec<String>,
    /// Gaps of what was fitted, the worst before and after, in units of the noise.
    pub gap: Option<[f64; 2]>,
    /// The same for held-out releases.
    #[serde(alias = "locked_gap")]
    pub held_out_gap: Option<[f64; 2]>,
    /// Distance of the nearest two members with the recording that would separate them.
    pub separation: Option<f64>,
    /// How long it took, s; none where that is not known.
    pub seconds: Option<f64>,
}

/// An answer in a few words: its effects, and those that would do as well as the last one.
pub fn in_short(verdict: Verdict, effects: &[&str], members: &[&str]) -> String {
    let names = effects.join(AND);
    match verdict {
        Verdict::Misstated => "misstated".to_owned(),
        Verdict::NothingMissing => "nothing".to_owned(),
        Verdict::Unknown if names.is_empty() => "unknown".to_owned(),
        Verdict::Unknown => format!("unknown, partly {names}"),
        Verdict::Named => names,
        Verdict::Incomplete if members.is_empty() => format!("{names}, incomplete"),
        Verdict::Incomplete => format!("{names}, or {}, incomplete", members.join(", ")),
        Verdict::Class if members.is_empty() => format!("{names}, or a wrong statement"),
        Verdict::Class => format!("{names}, or {}", members.join(", ")),
    }
}

impl Answer {
    /// What is said, in a few words.
    pub fn said(&self) -> String {
        let effects: Vec<&str> = self.effects.iter().map(|added| added.effect.as_str()).collect();
        let members: Vec<&str> = self.members.iter().map(String::as_str).collect();
        self.verdict.map_or("no answer".to_owned(), |verdict| in_short(verdict, &effects, &members))
    }

    /// The answers in some rows of a table with these columns; none of a table that has others.
    pub fn of_rows(columns: &[Column], cells: &[Cells]) -> Option<Vec<Answer>> {
        let column = |name: &str| columns.iter().position(|own| own.name == name).map(|k| &cells[k]);
        let texts = |name| if let Cells::Texts(all) = column(name)? { Some(all) } else { None };
        let numbers = |name: &str| if let Cells::Numbers(all) = column(name)? { Some(all) } else { None };
        let Cells::Counts(points) = column("point")? else { return None };
        let [experiment, reason] = [texts("experiment")?, texts("reason")?];
        let [verdict, effects, members, parameters] = TEXTS.map(texts);
        let [verdict, effects, members, parameters] = [verdict?, effects?, members?, parameters?];
        // Sweeps of before call the gaps of held-out releases `locked_gap`.
        let found =
            NUMBERS.map(|(name, ..)| numbers(name).or_else(|| numbers(&name.replace("held_out", "locked"))));
        let number = |k: usize, row: usize| found[k].map(|all| all[row]).filter(|number| !number.is_nan());
        let pair = |k, row| Some([number(k, row)?, number(k + 1, row)?]);
        let names = |text: &Option<String>| -> Vec<String> {
            text.iter().flat_map(|text| text.split(AND)).map(str::to_owned).collect()
        };
        // An interval without an end has no JSON.
        let bare = |effect: String| Added { effect, parameters: Vec::new() };
        let answer = |(row, point): (usize, &i64)| Answer {
            point: *point as usize,
            experiment: experiment[row].clone().unwrap_or_default(),
            failed: reason[row].clone(),
            verdict: verdict[row].as_ref().and_then(|word| serde_json::from_value(word.clone().into()).ok()),
            effects: (parameters[row].as_ref())
                .and_then(|text| serde_json::from_str(text).ok())
                .unwrap_or_else(|| names(&effects[row]).into_iter().map(bare).collect()),
            members: names(&members[row]),
            gap: pair(0, row),
            held_out_gap: pair(2, row),
            separation: number(5, row),
            seconds: None,
        };
        Some(points.iter().enumerate().map(answer).collect())
    }
}

/// The columns that a point has before it is diagnosed.
pub(super) fn given() -> Vec<Column> {
    let column = |name: &str, holds| Column { name: name.to_owned(), unit: "", holds };
    let own = GIVEN.map(|name| column(name, Holds::Texts));
    std::iter::once(column("point", Holds::Counts)).chain(own).collect()
}

/// The columns of what a diagnosis says.
pub(super) fn answers() -> Vec<Column> {
    let texts = TEXTS.into_iter().map(|name| (name, "", Holds::Texts));
    let numbers = NUMBERS.into_iter().map(|(name, unit, _)| (name, unit, Holds::NumbersOrNone));
    let all = texts.chain(numbers).chain([("warnings", "", Holds::Texts)]);
    all.map(|(name, unit, holds)| Column { name: name.to_owned(), unit, holds }).collect()
}

/// What a number of a row is, in words.
pub(super) fn meaning(name: &str) -> Option<&'static str> {
    NUMBERS.iter().find(|(own, ..)| *own == name).map(|(.., meaning)| *meaning)
}

/// Diagnoses the experiment of a point. The row gives whatever goes wrong.
pub(super) fn run(work: &Diagnose, point: &Point) -> Row {
    let said = catch_unwind(AssertUnwindSafe(|| said(work, point))).unwrap_or_else(|_| Err(fault()));
    match said {
        Ok(diagnosis) => Row::whole(told(&diagnosis)),
        // On each machine the folder may be another.
        Err(why) => Row::failed(why.replace(&format!("{}/", work.folder), ""), &answers()),
    }
}

fn said(work: &Diagnose, point: &Point) -> Result<Diagnosis, String> {
    let [file, sha256, without] = &point.values[..] else { return Err(fault()) };
    let [file, sha256, without] = [file, sha256, without].map(word);
    let (found, experiment) = look(&Path::new(&work.folder).join(file));
    if found != sha256 {
        return Err(format!(
            "{file}: it, a recording or a muscle that it names was changed since the plan was made; put that back, \
             or make a new plan"
        ));
    }
    let experiment = experiment?;
    let cleaned = clean(&experiment).map_err(|error| error.to_string())?;
    let problem = problem(&experiment, &cleaned).map_err(|error| error.to_string())?;
    let settings = DiagnosisSettings {
        false_alarm: work.false_alarm.parse().unwrap_or(DiagnosisSettings::default().false_alarm),
        most_effects: work.most,
        excluded: without.split(AND).filter(|name| !name.is_empty()).map(str::to_owned).collect(),
        budget: work.budget,
        ..DiagnosisSettings::default()
    };
    let settings = settings.stated(&experiment).map_err(|error| error.to_string())?;
    let outcome = diagnose(&problem, &settings, &|_: &str| ()).map_err(|error| error.to_string())?;
    Ok(outcome.diagnosis)
}

fn word(value: &DesignValue) -> &str {
    if let DesignValue::Word(word) = value { word } else { "" }
}

/// The hash of an experiment with all that it names, and the experiment itself or what is wrong with it.
pub(super) fn look(file: &Path) -> (String, Result<Experiment, String>) {
    let experiment = Experiment::load(file, &[]).map_err(|error| error.to_string());
    // A file that cannot be read has no hash, and is another as soon as it can.
    let hash = |file: &Path| input::sha256(file).unwrap_or_default();
    let mut hashes = vec![hash(file)];
    if let Ok(experiment) = &experiment {
        hashes.push(sha256(experiment.muscle_text().unwrap_or_default().as_bytes()));
        hashes.extend(experiment.recordings.iter().map(|entry| hash(&entry.file)));
    }
    (sha256(hashes.join(",").as_bytes()), experiment)
}

/// The answers of a row, in the order of their columns.
fn told(diagnosis: &Diagnosis) -> Vec<Cell> {
    let verdict = serde_json::to_value(diagnosis.verdict).ok();
    let effects = diagnosis.effects.iter().map(|added| added.effect.clone()).collect();
    let members = diagnosis.members.iter().map(|member| member.effect.clone()).collect();
    let parameters = serde_json::to_string(&diagnosis.effects).ok();
    let texts = [
        verdict.and_then(|word| word.as_str().map(str::to_owned)),
        joined(effects, AND),
        joined(members, AND),
        parameters.filter(|_| !diagnosis.effects.is_empty()),
    ];
    let worst = |held_out: bool, of: fn(&Gap) -> f64| {
        let own = diagnosis.gap.iter().filter(|gap| gap.held_out == held_out).map(of);
        own.fold(f64::NAN, f64::max)
    };
    let numbers = [
        worst(false, |gap| gap.before),
        worst(false, |gap| gap.after),
        worst(true, |gap| gap.before),
        worst(true, |gap| gap.after),
        1e-3 * diagnosis.gap.iter().map(|gap| gap.noise_mm).fold(f64::NAN, f64::max),
        diagnosis.separating_experiment.as_ref().map_or(f64::NAN, |own| own.distance),
    ];
    let warnings = Cell::Text(joined(diagnosis.warnings.clone(), "; "));
    texts.map(Cell::Text).into_iter().chain(numbers.map(Cell::Number)).chain([warnings]).collect()
}

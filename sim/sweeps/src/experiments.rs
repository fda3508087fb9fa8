//! A sweep over experiments, as its file says it.
//!
//! ```toml
//! [sweep]
//! experiments = ["bench/*/experiment.toml"]   # relative to this file
//! diagnose = { false_alarm = 0.01, most = 3, budget = 2e9, without = ["air_drag"] }   # as of `efam diagnose`
//! [[sweep.experiment]]                        # of some experiments: effects that are left out besides
//! file = "bench/0007/experiment.toml"
//! without = ["dahl"]
//! ```

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use efam_experiments::scenario::document::Keys;
use efam_experiments::scenario::{ScenarioError, ScenarioProblem};
use efam_inference::diagnose::{self, DiagnosisSettings};
use efam_store::escape::is_hidden;
use models::effects::Catalogue;
use rayon::prelude::*;

use super::diagnosed::{AND, Diagnose, look};
use super::row::{DesignValue, Point};

/// Keys of a sweep over experiments.
pub(super) const KEYS: [&str; 3] = ["experiments", "diagnose", "experiment"];

/// Experiments to be diagnosed.
#[derive(Clone, Debug)]
pub struct OfExperiments {
    /// How.
    pub work: Diagnose,
    /// Each: its file, the hash of all that it names, effects that are left out.
    pub all: Vec<[String; 3]>,
}

impl OfExperiments {
    /// A point.
    pub(super) fn point(&self, index: usize) -> Point {
        Point { index, seed: 0, values: self.all[index].clone().map(DesignValue::Word).to_vec() }
    }

    /// Reads it from the section of a file that lies in `folder`; says what should be known beforehand, too.
    pub(super) fn read(sweep: &Keys, folder: &Path) -> Result<(OfExperiments, Vec<String>), ScenarioError> {
        let diagnosed = sweep.table("diagnose")?;
        diagnosed.only(&["false_alarm", "most", "budget", "without"])?;
        let usual = DiagnosisSettings::default();
        let must = "lie between 0 and 1, such as 0.01";
        let false_alarm = diagnosed
            .quantity_that("false_alarm", "", must, |share| share > 0.0 && share < 1.0)?
            .unwrap_or(usual.false_alarm);
        let must = "be a number of node steps, 1 to 1e18, such as 2e9";
        let budget = diagnosed
            .quantity_that("budget", "", must, |node_steps| (1.0..=1e18).contains(&node_steps))?
            .map_or(usual.budget, |node_steps| node_steps as u64);
        // Wherever it is run from, by whatever scheduler.
        let folder = std::path::absolute(folder.join(".")).unwrap_or_else(|_| folder.to_owned());
        let catalogue = Catalogue::default();
        let without: BTreeSet<String> = diagnose::without(&diagnosed, &catalogue)?.into_iter().collect();
        let mut files: BTreeMap<String, BTreeSet<String>> = matching(sweep, "experiments", &folder)?
            .into_iter()
            .map(|file| (file, without.clone()))
            .collect();
        for table in sweep.tables("experiment")? {
            table.only(&["file", "without"])?;
            if !table.has("file") {
                return Err(table.missing("file", "file = \"bench/0007/experiment.toml\""));
            }
            let own: BTreeSet<String> =
                without.iter().cloned().chain(diagnose::without(&table, &catalogue)?).collect();
            files.extend(matching(&table, "file", &folder)?.into_iter().map(|file| (file, own.clone())));
        }
        let looked: Vec<_> = files
            .into_par_iter()
            .map(|(file, without)| {
                let (sha256, experiment) = look(&folder.join(&file));
                let wrong = match experiment {
                    Err(wrong) => Some(wrong),
                    Ok(own) if !own.has_model() => Some(format!("{file}: says nothing of the rod")),
                    Ok(own) => own
                        .recordings
                        .iter()
                        .find(|entry| fs::metadata(&entry.file).is_err())
                        .map(|entry| format!("{file}: {}: is not there", entry.file.display())),
                };
                ([file, sha256, without.into_iter().collect::<Vec<_>>().join(AND)], wrong)
            })
            .collect();
        let (all, wrong): (Vec<_>, Vec<_>) = looked.into_iter().unzip();
        let wrong: Vec<String> = wrong.into_iter().flatten().collect();
        let mut warnings = Vec::new();
        if let Some(first) = wrong.first() {
            let (count, of) = (wrong.len(), all.len());
            if count == of {
                let message = format!("none of {of} can be diagnosed, the first because of this: {first}");
                let key = if sweep.has("experiments") { "experiments" } else { "experiment" };
                return Err(sweep.wrong(key, ScenarioProblem::Other { message }));
            }
            warnings.push(format!("{count} of {of} experiments cannot be diagnosed, and will be rows that say so; the first because of this: {first}"));
        }
        let work = Diagnose {
            folder: text(sweep, "experiments", &folder)?.to_owned(),
            false_alarm: format!("{false_alarm:?}"),
            most: diagnosed.count("most")?.unwrap_or(usual.most_effects),
            budget,
        };
        Ok((OfExperiments { work, all }, warnings))
    }
}

/// The path of a folder as a plan holds it.
fn text<'a>(table: &Keys, key: &str, folder: &'a Path) -> Result<&'a str, ScenarioError> {
    folder.to_str().ok_or_else(|| {
        let folder = folder.display();
        let message = format!(
            "the folder {folder} has bytes that are not UTF-8 in its path, so no plan can name it; rename it"
        );
        table.wrong(key, ScenarioProblem::Other { message })
    })
}

/// The files that are like the patterns of a key, relative to a folder.
fn matching(table: &Keys, key: &str, folder: &Path) -> Result<Vec<String>, ScenarioError> {
    let wrong = |message| table.wrong(key, ScenarioProblem::Other { message });
    let base = PathBuf::from(glob::Pattern::escape(text(table, key, folder)?));
    let mut found = Vec::new();
    for pattern in table.texts(key)?.unwrap_or_default() {
        let paths = glob::glob(&base.join(pattern).display().to_string()).map_err(|error| {
            wrong(format!("`{pattern}` is no pattern ({}); write * for any name", error.msg))
        })?;
        let before = found.len();
        for path in paths.flatten().filter(|path| path.is_file()) {
            let own = path.strip_prefix(folder).unwrap_or(&path);
            let is_plain = |file: &&str| !file.contains([',', '"']) && !file.contains(is_hidden);
            let Some(file) = own.to_str().filter(is_plain) else {
                let file = own.display();
                let what = "a comma, a quote, a character that cannot be seen, or bytes that are not UTF-8";
                return Err(wrong(format!("`{file}` has {what} in its name; rename it")));
            };
            let file = if cfg!(windows) { file.replace('\\', "/") } else { file.to_owned() };
            found.push(file);
        }
        if found.len() == before {
            let message =
                format!("no file is like `{pattern}`, seen from {}; look for it with ls", folder.display());
            return Err(wrong(message));
        }
    }
    if found.is_empty() && table.has(key) {
        return Err(
            table.wrong(key, ScenarioProblem::Must { must: "name one file at least, or a pattern of names" })
        );
    }
    Ok(found)
}

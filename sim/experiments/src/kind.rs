//! Which kind of file something is, for messages to those who gave a command another kind than it takes.

use std::fmt::{self, Display};
use std::path::Path;

use efam_recordings::{ReadOptions, read};
use efam_store::MARK;
use efam_store::escape::shell_word;
use efam_store::input;
use toml::{Table, Value};

/// Endings of recordings that can be read.
const RECORDINGS: [&str; 7] = ["csv", "tsv", "txt", "trc", "c3d", "parquet", "pq"];
/// Keys of a scenario alone: how to let go, how long, and the pressure.
const OF_SCENARIOS: [&str; 2] = ["run", "release"];

/// A kind of file, as commands take them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// What is simulated.
    Scenario,
    /// Recordings and facts about them.
    Experiment,
    /// A design of many points.
    Sweep,
    /// Tables of a muscle.
    Muscle,
    /// Effects as text.
    Laws,
    /// Markers over time.
    Recording,
    /// A folder that efam wrote.
    Run,
}

impl FileKind {
    /// The kind of a file; none where it is not plain.
    pub fn of(path: &Path) -> Option<FileKind> {
        if path.is_dir() {
            return path.join(MARK).is_file().then_some(FileKind::Run);
        }
        // What can be read once only, such as a pipe, has been read.
        if !path.is_file() {
            return None;
        }
        if may_be_recording(path) {
            return read(path, &ReadOptions::default()).is_ok().then_some(FileKind::Recording);
        }
        of_text(&input::text(path).ok()?)
    }

    /// Why a file of this kind is of no use where another one is due, and which command takes it.
    pub fn instead_of(self, due: FileKind, path: &Path) -> String {
        let shown = path.display();
        format!("{shown}: is {self}, and {due} is due; {}", self.command(&shell_word(path)))
    }

    fn command(self, file: &str) -> String {
        match self {
            FileKind::Scenario => format!("`efam simulate {file}` takes it"),
            FileKind::Experiment => format!(
                "`efam diagnose {file}` takes it, as calibrate and analyse do; `efam predict` takes the rod.toml or muscle.toml that \
                 `efam calibrate {file}` writes"
            ),
            FileKind::Sweep => format!("`efam sweep {file}` takes it"),
            FileKind::Muscle => format!("`efam predict --muscle {file} --pressure 40psi` takes it"),
            FileKind::Laws => format!("`efam effects --check {file}` takes it"),
            FileKind::Recording => {
                format!(
                    "`efam experiment init {file}` writes an experiment from it, `efam inspect {file}` summarises it"
                )
            }
            FileKind::Run => format!("`efam report {file}` takes it"),
        }
    }
}

impl Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FileKind::Scenario => "a scenario",
            FileKind::Experiment => "an experiment",
            FileKind::Sweep => "a sweep",
            FileKind::Muscle => "a muscle file",
            FileKind::Laws => "a file of laws",
            FileKind::Recording => "a recording",
            FileKind::Run => "the folder of a run",
        })
    }
}

/// Whether a path has the ending of a recording that can be read.
pub fn may_be_recording(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| RECORDINGS.contains(&ending.as_str()))
}

/// The kind of a text of TOML, by keys that only that kind has.
fn of_text(text: &str) -> Option<FileKind> {
    let table: Table = text.parse().ok()?;
    let has = |key: &str| table.contains_key(key);
    let has_pressure =
        table.get("muscle").and_then(Value::as_table).is_some_and(|own| own.contains_key("pressure"));
    Some(if has("recording") {
        FileKind::Experiment
    } else if has("sweep") {
        FileKind::Sweep
    } else if has("rest") && has("table") {
        FileKind::Muscle
    } else if has_pressure || OF_SCENARIOS.into_iter().any(has) {
        FileKind::Scenario
    } else if has("laws") && table.len() == 1 {
        FileKind::Laws
    } else {
        return None;
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_told_apart_by_keys_that_only_their_kind_has() {
        for (text, kind) in [
            ("[muscle]\nname = \"m\"\npressure = \"1 psi\"", Some(FileKind::Scenario)),
            ("[rod]\nlength = \"1 m\"\n[run]\nduration = \"1 s\"", Some(FileKind::Scenario)),
            ("[muscle]\nname = \"m\"\n[[recording]]\nfile = \"a.csv\"", Some(FileKind::Experiment)),
            ("[sweep]\nscenario = \"s.toml\"", Some(FileKind::Sweep)),
            ("[laws.mine]\nplace = \"flow\"", Some(FileKind::Laws)),
            (models::muscle::BUILT_IN[0].1, Some(FileKind::Muscle)),
            // Of either of two kinds, or of none.
            ("[muscle]\nname = \"m\"", None),
            ("[muscle", None),
        ] {
            assert_eq!(of_text(text), kind, "{text}");
        }
    }
}

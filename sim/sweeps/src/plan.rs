//! A plan: what is to be simulated, frozen. Its head is `plan.json`, its points are the lines of `points.csv`; a
//! hash holds both together.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Lines, Take, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use efam_experiments::scenario::ScenarioError;
use efam_store::columns::Column;
use efam_store::input::{self, MOST_JSON};
use efam_store::sha::{Sha, sha256};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SweepError;
use super::design::Sampler;
use super::request::{MOST_POINTS, Subject, SweepRequest};
use super::row::Point;
use super::work::{Simulate, Work};

/// The head of a plan.
pub const PLAN: &str = "plan.json";
/// Its points.
pub const POINTS: &str = "points.csv";
/// Points that are made at a time.
const CHUNK: usize = 4096;

/// What a plan says beside its points. Whole numbers and texts only: these are read back as they are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Head {
    /// SHA-256 of this, with nothing in this place; so that of the points, too.
    pub sha256: String,
    /// Name of the sweep.
    pub name: String,
    /// Version of the program that made the plan.
    pub efam: String,
    /// What is done with each point.
    pub work: Work,
    /// How many points there are.
    pub points: usize,
    /// Points in a shard; the last may have fewer.
    pub points_per_shard: usize,
    /// SHA-256 of the points.
    pub points_sha256: String,
    /// The file of the sweep.
    pub sweep: String,
    /// What it says.
    pub sweep_text: String,
    /// Caveats of the results.
    pub warnings: Vec<String>,
}

impl Head {
    /// How many shards there are.
    pub fn shards(&self) -> usize {
        self.points.div_ceil(self.points_per_shard)
    }

    /// Points of a shard.
    pub fn points_of(&self, shard: usize) -> Range<usize> {
        let first = shard.saturating_mul(self.points_per_shard);
        first.min(self.points)..first.saturating_add(self.points_per_shard).min(self.points)
    }

    /// Files that were read when the plan was made, with their texts.
    pub fn texts(&self) -> Vec<(&Path, &str)> {
        let scenario = match &self.work {
            Work::Simulate(own) => Some((Path::new(&own.scenario), own.scenario_text.as_str())),
            Work::Diagnose(_) => None,
        };
        [(Path::new(&self.sweep), self.sweep_text.as_str())].into_iter().chain(scenario).collect()
    }

    fn hash(&self) -> String {
        let bare = Head { sha256: String::new(), ..self.clone() };
        sha256(serde_json::to_string(&bare).expect("a head has nothing that JSON has not").as_bytes())
    }
}

/// Freezes a request: writes its points, and returns its head.
/// # Errors
/// [`SweepError`].
pub fn freeze(asked: &SweepRequest, points_per_shard: usize, to: &mut dyn Write) -> Result<Head, SweepError> {
    let sampler;
    let (work, point): (Work, Box<Make>) = match &asked.subject {
        Subject::Scenario(own) => {
            sampler = Sampler::new(own)?;
            let work = Work::Simulate(Simulate {
                design: own.design,
                seed: own.seed,
                parameters: sampler.paths.clone(),
                scenario: own.scenario.display().to_string(),
                scenario_text: own.scenario_text.clone(),
                set: own.set.clone(),
            });
            (work, Box::new(|index| sampler.point(index)))
        }
        Subject::Experiments(own) => {
            (Work::Diagnose(own.work.clone()), Box::new(|index| Ok(own.point(index))))
        }
    };
    let mut sha = Sha::default();
    let mut put = |line: String| -> Result<(), SweepError> {
        let both = sha.write_all(line.as_bytes()).and_then(|()| to.write_all(line.as_bytes()));
        both.map_err(|source| SweepError::Unwritten { file: POINTS.into(), source })
    };
    let names: Vec<String> = work.given().into_iter().map(|own| own.name).collect();
    put(names.join(",") + "\n")?;
    for first in (0..asked.points()).step_by(CHUNK) {
        let chunk = first..(first + CHUNK).min(asked.points());
        let lines: Vec<Result<String, ScenarioError>> =
            chunk.into_par_iter().map(|index| point(index).map(|point| work.line(&point))).collect();
        for line in lines {
            put(line?)?;
        }
    }
    let mut head = Head {
        sha256: String::new(),
        name: asked.name.clone(),
        efam: env!("CARGO_PKG_VERSION").to_owned(),
        points: asked.points(),
        points_per_shard,
        points_sha256: sha.hexadecimal(),
        sweep: asked.path.display().to_string(),
        sweep_text: asked.text.clone(),
        warnings: asked.warnings.clone(),
        work,
    };
    head.sha256 = head.hash();
    Ok(head)
}

/// Makes a point of its number.
type Make<'a> = dyn Fn(usize) -> Result<Point, ScenarioError> + Sync + 'a;

/// A plan that was read, and is as it was frozen.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Where it lies, and its shards beside it.
    pub folder: PathBuf,
    /// What it says.
    pub head: Head,
}

impl Plan {
    /// Opens a plan: its folder, or the file of its head.
    /// # Errors
    /// [`SweepError::NoPlan`], [`SweepError::Altered`].
    pub fn open(path: &Path) -> Result<Plan, SweepError> {
        let folder = if path.is_dir() || path.file_name().is_none_or(|name| name != PLAN) {
            path.to_owned()
        } else {
            path.parent().unwrap_or(Path::new("")).to_owned()
        };
        let no_plan = |file: &Path| {
            let file = file.to_owned();
            move |error: io::Error| SweepError::NoPlan { file, reason: error.to_string() }
        };
        let altered = |file: &Path| SweepError::Altered { file: file.to_owned() };
        let (file, points) = (folder.join(PLAN), folder.join(POINTS));
        let text = input::up_to(&file, MOST_JSON).map_err(no_plan(&file))?;
        let head: Head = serde_json::from_str(&text).map_err(|_| altered(&file))?;
        let can_be = (1..=MOST_POINTS).contains(&head.points) && head.points_per_shard > 0;
        if head.hash() != head.sha256 || !can_be {
            return Err(altered(&file));
        }
        let mut sha = Sha::default();
        let hashed =
            input::whole(&points).and_then(|(file, _)| io::copy(&mut BufReader::new(file), &mut sha));
        hashed.map_err(no_plan(&points))?;
        if sha.hexadecimal() != head.points_sha256 {
            return Err(altered(&points));
        }
        Ok(Plan { folder, head })
    }

    /// Its points, to be read from the first on.
    /// # Errors
    /// [`SweepError::NoPlan`].
    pub fn points(&self) -> Result<Points<'_>, SweepError> {
        let file = self.folder.join(POINTS);
        let opened = input::whole(&file);
        let lines =
            opened.map_err(|error| SweepError::NoPlan { file: file.clone(), reason: error.to_string() })?;
        Ok(Points {
            head: &self.head,
            given: self.head.work.given(),
            file,
            lines: BufReader::new(lines.0).lines(),
            next: None,
        })
    }
}

/// The head as a file has it.
pub fn head_text(head: &Head) -> String {
    serde_json::to_string_pretty(head).expect("a head has nothing that JSON has not") + "\n"
}

/// The points of a plan, one after the other: only those that are requested are held.
pub struct Points<'a> {
    head: &'a Head,
    /// The columns of its lines.
    given: Vec<Column>,
    file: PathBuf,
    lines: Lines<BufReader<Take<File>>>,
    /// The point whose line comes next; none before the line of names.
    next: Option<usize>,
}

impl Points<'_> {
    /// Points of a shard that lies beyond those that were requested before.
    /// # Errors
    /// [`SweepError::Altered`] where a line is none of a plan.
    /// # Panics
    /// If the shard lies before another that was requested.
    pub fn of(&mut self, shard: usize) -> Result<Vec<Point>, SweepError> {
        let range = self.head.points_of(shard);
        if self.next.is_none() {
            self.line()?;
            self.next = Some(0);
        }
        let next = self.next.unwrap_or_default();
        assert!(next <= range.start, "shards are read one after the other");
        for _ in next..range.start {
            self.line()?;
        }
        self.next = Some(range.end);
        range.map(|index| self.line().and_then(|line| self.point(index, &line))).collect()
    }

    fn line(&mut self) -> Result<String, SweepError> {
        let line = self.lines.next().and_then(Result::ok);
        line.ok_or_else(|| SweepError::Altered { file: self.file.clone() })
    }

    fn point(&self, index: usize, line: &str) -> Result<Point, SweepError> {
        let point = self.head.work.point(&self.given, line).filter(|point| point.index == index);
        point.ok_or_else(|| SweepError::Altered { file: self.file.clone() })
    }
}

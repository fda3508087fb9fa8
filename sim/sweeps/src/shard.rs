//! One shard: whether it is there, and how it comes to be.

use std::fs;
use std::io::{ErrorKind, Write};
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Instant;

use efam_core::forward::Cancel;
use efam_store::added;
use efam_store::columns::{ParquetFile, about};
use efam_store::input;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

use super::SweepError;
use super::plan::Plan;
use super::row::{Point, Row};
use super::work::Work;

/// The rows of a shard, in a folder that names it.
pub const PART: &str = "part.parquet";
/// Entries of its metadata: the plan's hash, and its own number.
const OF_PLAN: &str = "plan_sha256";
const OF_SHARD: &str = "shard";

/// The file of a shard below the folder of its plan: a partition, as DuckDB, Polars and others read it.
pub fn file(folder: &Path, shard: usize) -> PathBuf {
    self::folder(folder, shard).join(PART)
}

/// That of a shard.
pub fn folder(folder: &Path, shard: usize) -> PathBuf {
    folder.join(format!("shard={shard:05}"))
}

/// What is there of a shard.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// Nothing.
    Missing,
    /// All of it.
    Whole,
    /// A file of another plan, with its hash.
    Foreign(String),
    /// A file that cannot be read, or lacks rows, and why.
    Damaged(String),
}

/// Looks what is there of a shard.
pub fn look(plan: &Plan, shard: usize) -> Found {
    let path = file(&plan.folder, shard);
    match fs::metadata(&path) {
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            return Found::Missing;
        }
        Err(error) => return Found::Damaged(error.to_string()),
        Ok(_) => {}
    }
    let said = match about(&path) {
        Ok(said) => said,
        Err(error) => return Found::Damaged(error.to_string()),
    };
    let hash = said.entries.get(OF_PLAN).cloned().unwrap_or_default();
    let own = said.entries.get(OF_SHARD).and_then(|own| own.parse().ok());
    if hash != plan.head.sha256 || own != Some(shard) {
        return Found::Foreign(hash);
    }
    let due = plan.head.points_of(shard).len();
    if said.rows == due {
        Found::Whole
    } else {
        Found::Damaged(format!("it has {} rows, where {due} are due", said.rows))
    }
}

/// Whether a shard is to be run.
/// # Errors
/// [`SweepError::NoShard`]; [`SweepError::Foreign`], unless it may be overwritten.
pub fn is_due(plan: &Plan, shard: usize, overwrite: bool) -> Result<bool, SweepError> {
    let shards = plan.head.shards();
    if shard >= shards {
        return Err(SweepError::NoShard { shard, shards });
    }
    match look(plan, shard) {
        Found::Whole => Ok(false),
        Found::Foreign(hash) if !overwrite => {
            Err(SweepError::Foreign { file: file(&plan.folder, shard), hash })
        }
        Found::Missing | Found::Damaged(_) | Found::Foreign(_) => Ok(true),
    }
}

/// What is reported of a sweep that runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// One more point is done.
    Point,
    /// This shard is written.
    Shard(usize),
}

/// Runs shards, the first one first, and writes each when it is done; returns how many of their points have no answer.
/// `tell` receives the progress, from any thread. After `stop` no further shard is begun.
///
/// As many shards run at a time as there are threads, each on threads of its own. So none waits for the longest, what
/// is interrupted loses little, and each diagnosis says truly how long it took.
/// # Errors
/// [`SweepError::Results`]; then that shard is not written.
pub fn run_all(
    plan: &Plan,
    due: &[usize],
    stop: &Cancel,
    tell: &(dyn Fn(Told) + Sync),
) -> Result<usize, SweepError> {
    let threads = rayon::current_num_threads();
    let lanes = threads.min(due.len());
    let rest = Mutex::new((plan.points()?, due.iter()));
    let next = || -> Option<Result<(usize, Vec<Point>), SweepError>> {
        let mut rest = rest.lock().unwrap_or_else(PoisonError::into_inner);
        let (points, due) = &mut *rest;
        if stop.is_requested() {
            return None;
        }
        due.next().map(|shard| points.of(*shard).map(|points| (*shard, points)))
    };
    let lane = || {
        let mut failed = 0;
        while let Some(shard) = next() {
            let (shard, points) = shard?;
            failed += run(plan, shard, points, tell)?;
            tell(Told::Shard(shard));
        }
        Ok(failed)
    };
    if lanes <= 1 {
        return lane();
    }
    let own = |k: usize| threads / lanes + usize::from(k < threads % lanes);
    // The thread of a lane is one of its pool's. Where no more can be had, a lane takes the threads of all.
    let work = |k: usize| match ThreadPoolBuilder::new().num_threads(own(k)).use_current_thread().build() {
        Ok(pool) => pool.install(lane),
        Err(_) => lane(),
    };
    thread::scope(|scope| {
        let begin = |k| thread::Builder::new().stack_size(STACK).spawn_scoped(scope, move || work(k));
        // Fewer lanes do all the same.
        let begun: Vec<_> = (0..lanes).map_while(|k| begin(k).ok()).collect();
        if begun.is_empty() {
            return lane();
        }
        let ended = begun.into_iter().map(|lane| lane.join().unwrap_or_else(|panic| resume_unwind(panic)));
        ended.collect::<Vec<_>>().into_iter().sum()
    })
}

/// As a main thread has it.
const STACK: usize = 8 << 20;

/// Runs the points of a shard, and writes it; returns how many have no answer.
fn run(
    plan: &Plan,
    shard: usize,
    points: Vec<Point>,
    tell: &(dyn Fn(Told) + Sync),
) -> Result<usize, SweepError> {
    let head = &plan.head;
    let work = &head.work;
    // In the order of the points, whichever is done first.
    let (rows, seconds): (Vec<(Point, Row)>, Vec<f64>) = points
        .into_par_iter()
        .with_max_len(1)
        .map(|point| {
            let begin = Instant::now();
            let row = work.run(&point);
            tell(Told::Point);
            ((point, row), begin.elapsed().as_secs_f64())
        })
        .unzip();
    let failed = rows.iter().filter(|(_, row)| row.is_failed()).count();
    let about = [
        (OF_PLAN, head.sha256.clone()),
        (OF_SHARD, shard.to_string()),
        ("run", head.name.clone()),
        ("efam", head.efam.clone()),
    ];
    let folder = folder(&plan.folder, shard);
    if let Work::Diagnose(_) = work {
        // Beside the rows, which are the same whoever is how fast.
        let lines = rows.iter().zip(&seconds).map(|((point, _), own)| format!("{},{own:.3}\n", point.index));
        let text = format!("{TIMED}\n{}", lines.collect::<String>());
        added::replace(&folder, SECONDS, |file| file.write_all(text.as_bytes()))?;
    }
    added::replace(&folder, PART, |file| {
        let mut file = ParquetFile::begin(file, &work.columns(), &about)?;
        file.write(work.table(rows))?;
        file.finish()
    })?;
    Ok(failed)
}

/// How long each diagnosis of a shard took.
pub const SECONDS: &str = "seconds.csv";
/// Its first line.
const TIMED: &str = "point,seconds";

/// How long the diagnoses of a shard took, s, by point; of none where that is not known.
pub fn seconds(folder: &Path, shard: usize) -> Vec<(usize, f64)> {
    let text = input::text(&file(folder, shard).with_file_name(SECONDS)).unwrap_or_default();
    let line = |line: &str| {
        let (point, seconds) = line.split_once(',')?;
        Some((point.parse().ok()?, seconds.parse().ok()?))
    };
    text.lines().filter_map(line).collect()
}

//! One shard: whether it is there, and how it comes to be.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::SweepError;
use super::plan::Plan;
use super::point::{Point, Row, cells, columns, run as run_point};
use crate::results::atomic::write_whole;
use crate::results::columns::{ParquetFile, about};

/// The rows of a shard, in a folder that names it.
pub const PART: &str = "part.parquet";
/// Entries of its metadata: the plan's hash, and its own number.
const OF_PLAN: &str = "plan_sha256";
const OF_SHARD: &str = "shard";

/// The file of a shard below the folder of its plan: a partition, as DuckDB, Polars and others read it.
pub fn file(folder: &Path, shard: usize) -> PathBuf {
    folder.join(format!("shard={shard:05}")).join(PART)
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
    match said.rows == due {
        true => Found::Whole,
        false => Found::Damaged(format!("it has {} rows, where {due} are due", said.rows)),
    }
}

/// What was done about a shard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Done {
    /// It was there already.
    Skipped,
    /// It was run; so many points of it could not be simulated.
    Run {
        /// How many.
        failed: usize,
    },
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

/// Simulates the points of a shard on all threads, and writes it; `tell` hears of each point, from any thread.
/// # Errors
/// [`SweepError::Results`]; then nothing is written.
pub fn run(
    plan: &Plan,
    shard: usize,
    points: Vec<Point>,
    tell: &(dyn Fn() + Sync),
) -> Result<Done, SweepError> {
    let head = &plan.head;
    // In the order of the points, whichever is done first.
    let rows: Vec<Row> = points
        .into_par_iter()
        .with_max_len(1)
        .map(|point| {
            let row = run_point(|point| head.case(point), point);
            tell();
            row
        })
        .collect();
    let about = [
        (OF_PLAN, head.sha256.clone()),
        (OF_SHARD, shard.to_string()),
        ("run", head.name.clone()),
        ("efam", head.efam.clone()),
    ];
    write_whole(&file(&plan.folder, shard), |file| {
        let mut file = ParquetFile::begin(file, &columns(&head.parameters), &about)?;
        file.write(cells(&head.parameters, &rows))?;
        file.finish()
    })?;
    Ok(Done::Run { failed: rows.iter().filter(|row| row.failed.is_some()).count() })
}

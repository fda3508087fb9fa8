//! The folder of a sweep from its plan on.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use efam_store::folder::Folder;
use efam_store::{MARK, StoreError};
use efam_sweeps::SweepError;
use efam_sweeps::estimate::points_per_shard;
use efam_sweeps::plan::{self, Head, Plan, freeze, head_text};
use efam_sweeps::request::{Subject, SweepRequest};

use crate::Request;
use crate::swept::{ADDED, swept_mark};

/// Freezes the points of a sweep into an open folder; without a number of points in a shard there are a thousand
/// shards at most.
/// # Errors
/// [`SweepError`] for a point that the scenario refuses, and what cannot be written.
pub fn write_plan(
    folder: &mut Folder,
    sweep: &SweepRequest,
    in_shard: Option<usize>,
    argv: Vec<String>,
) -> Result<Head, SweepError> {
    let request = Request {
        name: sweep.name.clone(),
        input_hashes: hashes(texts(sweep)),
        warnings: sweep.warnings.clone(),
        argv,
        ..Request::default()
    };
    folder.may_have(&ADDED);
    let own = in_shard.unwrap_or_else(|| points_per_shard(sweep.points()));
    let mut head = None;
    let written = folder.write_with(plan::POINTS, |file| {
        let mut to = BufWriter::new(file);
        let frozen = freeze(sweep, own, &mut to);
        let is_frozen = frozen.is_ok();
        head = Some(frozen);
        if is_frozen { to.flush() } else { Err(io::Error::other("no plan")) }
    });
    let head = match head {
        Some(Err(error)) if !matches!(error, SweepError::Unwritten { .. }) => return Err(error),
        Some(Ok(head)) => written.map(|()| head)?,
        Some(Err(error)) => return Err(written.err().map_or(error, StoreError::into)),
        // Nothing was tried, because its file cannot be made.
        None => return Err(written.expect_err("the file was not made").into()),
    };
    folder.write(plan::PLAN, head_text(&head).as_bytes())?;
    folder.write(MARK, swept_mark(&request).as_bytes())?;
    Ok(head)
}

/// The plan in a folder, if it is the requested one.
/// # Errors
/// [`SweepError::OtherPlan`] if it is not.
pub fn again(sweep: &SweepRequest, in_shard: Option<usize>, folder: &Path) -> Result<Plan, SweepError> {
    let there = Plan::open(folder)?;
    let own = in_shard.unwrap_or(there.head.points_per_shard);
    if freeze(sweep, own, &mut io::sink())?.sha256 != there.head.sha256 {
        return Err(SweepError::OtherPlan { folder: folder.to_owned() });
    }
    Ok(there)
}

/// What the page of a merged sweep says of its making, but for the time that it took.
pub fn request_of(plan: &Plan) -> Request {
    let head = &plan.head;
    Request { name: head.name.clone(), input_hashes: hashes(head.texts()), ..Request::default() }
}

/// Files that are read at planning, and need not be there later, with their texts.
fn texts(sweep: &SweepRequest) -> Vec<(&Path, &str)> {
    let scenario = match &sweep.subject {
        Subject::Scenario(own) => Some((own.scenario.as_path(), own.scenario_text.as_str())),
        Subject::Experiments(_) => None,
    };
    [(sweep.path.as_path(), sweep.text.as_str())].into_iter().chain(scenario).collect()
}

/// What was read, by name.
fn hashes(texts: Vec<(&Path, &str)>) -> BTreeMap<String, String> {
    let hash =
        |(path, text): (&Path, &str)| (path.display().to_string(), efam_store::sha::sha256(text.as_bytes()));
    texts.into_iter().map(hash).collect()
}

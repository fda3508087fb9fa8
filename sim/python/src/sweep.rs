//! Sweeps: many simulations of one design, or many diagnoses, in one table.

use std::path::PathBuf;
use std::time::Instant;

use efam::failure::Failure;
use efam_core::forward::Cancel;
use efam_report::Request;
use efam_report::swept::{again, request_of, swept_table, write_plan, write_swept};
use efam_store::columns::{Found, table};
use efam_sweeps::merge::merge;
use efam_sweeps::plan::{PLAN, Plan};
use efam_sweeps::request::SweepRequest;
use efam_sweeps::shard::{Told, is_due, run_all};
use efam_sweeps::status::SWEEP;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::to_string;

use crate::failure::exception;
use crate::overrides::{Laws, tables};
use crate::source::read;
use crate::stored::arrays;
use crate::watch::{Progress, followed};

/// What is printed as JSON and for people, where it is, and all columns.
type Swept<'py> = (String, String, PathBuf, Bound<'py, PyDict>);

/// Runs a sweep into a folder, or goes on with it; returns all of its columns.
#[pyfunction]
#[pyo3(signature = (of, out, overwrite, csv, points_per_shard, tell, options))]
#[allow(clippy::too_many_arguments)]
pub fn sweep<'py>(
    py: Python<'py>,
    of: &Bound<'_, PyAny>,
    out: PathBuf,
    overwrite: bool,
    csv: bool,
    points_per_shard: Option<usize>,
    tell: Option<Py<PyAny>>,
    options: &Bound<'_, PyDict>,
) -> PyResult<Swept<'py>> {
    if points_per_shard == Some(0) {
        return Err(exception(Failure::Usage("points_per_shard = 0: must be 1 at least".to_owned())));
    }
    let (path, text) = match of.cast::<PyDict>() {
        // Tables are what is set over nothing.
        Ok(_) => (PathBuf::from("sweep"), String::new()),
        Err(_) => read(of, "sweep")?,
    };
    let tables = |of: &Bound<'_, PyDict>| self::tables(of, &Laws::default());
    let of_tables = of.cast::<PyDict>().map(&tables).unwrap_or_else(|_| Ok(Vec::new()))?;
    let set = [of_tables, tables(options)?].concat();
    let work =
        |cancel: Cancel, progress: &Progress| -> Result<(String, String, PathBuf, Vec<Found>), Failure> {
            let begin = Instant::now();
            let asked = SweepRequest::parse(&path, &text, &set)?;
            let plan = if out.join(PLAN).is_file() && !overwrite {
                again(&asked, points_per_shard, &out)?
            } else {
                let mut folder = efam_store::folder::open(Some(&out), overwrite, &asked.name, &asked.text)?;
                let head = write_plan(&mut folder, &asked, points_per_shard, Vec::new())?;
                Plan { folder: folder.finish()?, head }
            };
            let mut due = Vec::new();
            for shard in 0..plan.head.shards() {
                if is_due(&plan, shard, overwrite)? {
                    due.push(shard);
                }
            }
            progress.expect(due.iter().map(|shard| plan.head.points_of(*shard).len()).sum());
            let told = |told| {
                if told == Told::Point {
                    progress.step();
                }
            };
            run_all(&plan, &due, &cancel, &told)?;
            if cancel.is_requested() {
                return Err(Failure::Interrupted);
            }
            let (merged, kept) = merge(&plan, csv, &|| ())?;
            let wall_time_s = begin.elapsed().as_secs_f64();
            let request = Request { warnings: merged.warnings.clone(), wall_time_s, ..request_of(&plan) };
            write_swept(&plan, &request, &merged, &kept)?;
            let file = plan.folder.join(SWEEP);
            let columns = table(&file)
                .map_err(|error| Failure::Output(format!("{}: cannot be read ({error})", file.display())))?;
            let json = to_string(&merged).expect("a sweep has nothing that JSON has not");
            Ok((json, swept_table(&merged), plan.folder, columns))
        };
    let (json, text, folder, columns) = followed(py, tell, work)?.map_err(exception)?;
    let all = arrays(py, columns)?;
    Ok((json, text, folder, all))
}

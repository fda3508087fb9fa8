//! What is there of a sweep, and what is missing: read from its files alone.

use efam_store::columns::about;
use schemars::JsonSchema;
use serde::Serialize;

use super::plan::Plan;
use super::shard::{Found, file, look};

/// The table of all points.
pub const SWEEP: &str = "sweep.parquet";

/// State of a sweep.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Status {
    /// Points of the plan.
    pub points: usize,
    /// Its shards.
    pub shards: usize,
    /// Points that were run, those included that could not be simulated.
    pub points_done: usize,
    /// Shards that are whole.
    pub shards_done: usize,
    /// Shards that are to be run, as `sbatch --array=` takes them; empty if none is.
    pub missing_array: String,
    /// The same, one by one.
    pub missing: Vec<usize>,
    /// Faults that block it, or files that cannot be used.
    pub faults: Vec<String>,
    /// Whether the sweep is merged.
    pub is_merged: bool,
}

/// Looks at every shard of a plan.
pub fn status(plan: &Plan) -> Status {
    let head = &plan.head;
    let mut status = Status { points: head.points, shards: head.shards(), ..Status::default() };
    for shard in 0..status.shards {
        let file = file(&plan.folder, shard).display().to_string();
        match look(plan, shard) {
            Found::Whole => {
                status.shards_done += 1;
                status.points_done += head.points_of(shard).len();
                continue;
            }
            Found::Missing => {}
            Found::Damaged(why) => {
                status.faults.push(format!("{file}: cannot be read ({why}); it is run anew"))
            }
            Found::Foreign(_) => {
                status
                    .faults
                    .push(format!("{file}: belongs to another plan; run gets --overwrite to replace it"));
            }
        }
        status.missing.push(shard);
    }
    status.missing_array = array(&status.missing);
    status.is_merged = is_merged(plan);
    status
}

/// Whether the table of a plan is there.
pub(super) fn is_merged(plan: &Plan) -> bool {
    about(&plan.folder.join(SWEEP))
        .is_ok_and(|said| said.entries.get("plan_sha256") == Some(&plan.head.sha256))
}

/// Numbers in ascending order as Slurm writes them: `3,7-9`.
pub fn array(numbers: &[usize]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    let text = |run: &[usize]| match run {
        [] => String::new(),
        [one] => one.to_string(),
        [first, .., last] => format!("{first}-{last}"),
    };
    runs.map(text).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::array;

    #[test]
    fn numbers_stand_as_slurm_takes_them() {
        assert_eq!(array(&[3, 7, 8, 9]), "3,7-9");
        assert_eq!(array(&[0, 1]), "0-1");
        assert_eq!((array(&[]), array(&[4])), (String::new(), "4".to_owned()));
    }
}

//! Sweeps: many simulations or diagnoses from one plan, on one machine or on many.
//!
//! A file says what varies, or which experiments are diagnosed ([`request`]); [`plan::freeze`] writes down every
//! point, and a hash of all. A shard is some points that follow one another: whoever runs it, wherever, writes the
//! same file `shard=00003/part.parquet`, or none ([`shard`]). What is there and what is missing can be seen from the
//! files alone ([`status`]), and [`merge`] puts them together. So a shard is a function of the plan and its number,
//! and nothing has to be kept in order between those who run them.

pub mod answers;
pub mod cluster;
mod design;
pub mod diagnosed;
pub mod estimate;
pub mod experiments;
pub mod key;
pub mod merge;
pub mod plan;
pub mod point;
pub mod request;
pub mod row;
pub mod shard;
pub mod status;
pub mod work;

use std::io;
use std::path::PathBuf;

use efam_experiments::scenario::ScenarioError;
use efam_store::StoreError;

/// Why a sweep cannot go on. A point that has no answer is none of these: it is a row.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// What the sweep's file or its scenario says.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// There is no plan.
    #[error("{}: cannot be read ({reason}); give the folder that `efam sweep plan` wrote", file.display())]
    NoPlan {
        /// The file.
        file: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// A plan that is not as it was frozen.
    #[error(
        "{}: was altered since the plan was made, or was not copied whole; copy it again, or make a new plan from \
         the sweep's file", file.display()
    )]
    Altered {
        /// The file.
        file: PathBuf,
    },
    /// A shard that the plan has not.
    #[error("shard {shard}: the plan has {shards}, 0 to {}; ask for one of these", shards.saturating_sub(1))]
    NoShard {
        /// What was requested.
        shard: usize,
        /// How many there are.
        shards: usize,
    },
    /// The shard of another plan.
    #[error(
        "{}: belongs to another plan ({}…), and is kept; run this plan in a folder of its own, or replace it with \
         --overwrite", file.display(), hash.chars().take(8).collect::<String>()
    )]
    Foreign {
        /// The file.
        file: PathBuf,
        /// Hash of its plan.
        hash: String,
    },
    /// The folder has the plan of something else.
    #[error(
        "{}: holds the sweep of another plan; choose another --out, or replace it with --overwrite", folder.display()
    )]
    OtherPlan {
        /// The folder.
        folder: PathBuf,
    },
    /// Shards are missing.
    #[error("{missing} of {shards} shards are missing: --array={array}; run them first: {how}")]
    Incomplete {
        /// How many.
        missing: usize,
        /// Of how many.
        shards: usize,
        /// Which.
        array: String,
        /// The command that runs them.
        how: String,
    },
    /// A shard that cannot be read.
    #[error("{}: cannot be read ({reason}); remove it, and run shard {shard} again", file.display())]
    Damaged {
        /// The file.
        file: PathBuf,
        /// Its shard.
        shard: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// The points could not be written.
    #[error("{}: cannot be written: {source}; free it, or choose another --out", file.display())]
    Unwritten {
        /// The file.
        file: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Results that could not be written.
    #[error(transparent)]
    Results(#[from] StoreError),
}

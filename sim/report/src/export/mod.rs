//! A finished run in the formats of other programs: MATLAB, and tools for robots.
//!
//! One exporter serves all commands, for it knows tables only: whatever Parquet and CSV a run folder holds, with
//! names, units and numbers. The run itself stays as it is.

mod mat;
mod mat5;
mod mcap;
mod stored;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use efam_store::StoreError;
use efam_store::atomic::{write_new, write_whole};
use schemars::JsonSchema;
use serde::Serialize;

use crate::reread::RereadError;

pub use stored::{Cells, Series, Stored, Table, read};

/// Formats that a run can be written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// MAT of version 7.3, which is HDF5: MATLAB, Octave, h5py.
    Mat,
    /// MAT of version 5: scipy, MATLAB, Octave.
    Mat5,
    /// MCAP with JSON messages: Foxglove, ROS 2, Rerun.
    Mcap,
}

impl Format {
    /// Ending of its files.
    pub fn ending(self) -> &'static str {
        match self {
            Format::Mat | Format::Mat5 => "mat",
            Format::Mcap => "mcap",
        }
    }
}

/// Why a run was not exported; nothing half-written stays.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The folder.
    #[error(transparent)]
    Run(#[from] RereadError),
    /// A run whose numbers stand elsewhere.
    #[error("{}: holds no table, neither Parquet nor CSV; its numbers are in its JSON files", folder.display())]
    NoTable {
        /// The folder.
        folder: PathBuf,
    },
    /// Messages need an instant.
    #[error("{}: no table of it has a column time_s or t_s, which MCAP needs; take --to mat", folder.display())]
    NoTime {
        /// The folder.
        folder: PathBuf,
    },
    /// There is such a file.
    #[error("{}: exists already; choose another --out, or replace it with --overwrite", file.display())]
    Exists {
        /// The file.
        file: PathBuf,
    },
    /// A path that is no file's.
    #[error("{}: is no place for a file; give --out the name of one, such as release.{ending}", file.display())]
    NoFile {
        /// What was given.
        file: PathBuf,
        /// Ending of the format.
        ending: &'static str,
    },
    /// The file system refused.
    #[error(transparent)]
    Results(#[from] StoreError),
}

/// Writes a run as one file.
/// # Errors
/// [`ExportError`]; what was there before then still is.
pub fn export(run: &Stored, format: Format, to: &Path, overwrite: bool) -> Result<(), ExportError> {
    let file = || to.to_path_buf();
    if to.file_name().is_none() || to.is_dir() {
        return Err(ExportError::NoFile { file: file(), ending: format.ending() });
    }
    // Said before the tables are written; what comes meanwhile is not replaced either.
    if to.exists() && !overwrite {
        return Err(ExportError::Exists { file: file() });
    }
    if run.tables.is_empty() {
        return Err(ExportError::NoTable { folder: run.folder.clone() });
    }
    if format == Format::Mcap && run.tables.iter().all(|table| table.time().is_none()) {
        return Err(ExportError::NoTime { folder: run.folder.clone() });
    }
    let write = |file: &mut File| {
        let mut buffer = BufWriter::new(file);
        match format {
            Format::Mat => mat::write(run, &mut buffer)?,
            Format::Mat5 => mat5::write(run, &mut buffer)?,
            Format::Mcap => mcap::write(run, &mut buffer)?,
        }
        buffer.flush()
    };
    Ok(if overwrite { write_whole(to, write) } else { write_new(to, write) }?)
}

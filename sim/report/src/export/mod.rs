//! A finished run in the formats of other programs: MATLAB, tools for robots, slides.
//!
//! One exporter serves all commands, for it knows tables only: whatever Parquet and CSV a run folder holds, with
//! names, units and numbers. GIF and PNG are of a simulation. The run itself stays as it is.

mod animated;
mod font;
mod mat;
mod mat5;
mod mcap;
mod raster;
mod still;
mod stored;

use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use efam_store::StoreError;
use efam_store::atomic::{write_new, write_whole};
use efam_store::disk::File;
use efam_store::input::{MOST_JSON, up_to};
use schemars::JsonSchema;
use serde::Serialize;

use crate::PICTURE;
use crate::reread::RereadError;

use animated::Motion;
use font::Font;
pub(crate) use mat5::linear_mat;
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
    /// GIF: the rod in motion.
    Gif,
    /// PNG: the picture of the run.
    Png,
}

impl Format {
    /// Ending of its files.
    pub fn ending(self) -> &'static str {
        match self {
            Format::Mat | Format::Mat5 => "mat",
            Format::Mcap => "mcap",
            Format::Gif => "gif",
            Format::Png => "png",
        }
    }
}

/// Why a run was not exported; nothing half-written stays.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The folder.
    #[error(transparent)]
    Run(#[from] RereadError),
    /// A run whose numbers are elsewhere.
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
    /// A GIF shows a rod that moves.
    #[error(
        "{}: holds no trajectory of a rod, which GIF needs; give the folder of `efam simulate`, of one run",
        folder.display()
    )]
    NoMotion {
        /// The folder.
        folder: PathBuf,
    },
    /// A PNG is made of the picture of a run.
    #[error("{}: is no picture that efam drew ({reason}); give the folder of `efam simulate`, of one run", picture.display())]
    NoPicture {
        /// The picture.
        picture: PathBuf,
        /// What is wrong with it.
        reason: String,
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
    if run.tables.is_empty() && format != Format::Png {
        return Err(ExportError::NoTable { folder: run.folder.clone() });
    }
    if format == Format::Mcap && run.tables.iter().all(|table| table.time().is_none()) {
        return Err(ExportError::NoTime { folder: run.folder.clone() });
    }
    type Content<'a> = Box<dyn Fn(&mut BufWriter<Remembering>) -> io::Result<()> + 'a>;
    let content: Content = match format {
        Format::Mat => Box::new(|to| mat::write(run, to)),
        Format::Mat5 => Box::new(|to| mat5::write(run, to)),
        Format::Mcap => Box::new(|to| mcap::write(run, to)),
        Format::Gif => {
            let none = || ExportError::NoMotion { folder: run.folder.clone() };
            let motion = Motion::of(run).ok_or_else(none)?;
            Box::new(move |to| animated::write(&motion, Font::of_system(), to))
        }
        Format::Png => {
            let still = picture(run)?;
            Box::new(move |to| to.write_all(&still))
        }
    };
    let write = |file: &mut File| {
        let mut buffer = BufWriter::new(Remembering { file, failed: None });
        let done = content(&mut buffer).and_then(|()| buffer.flush());
        done.map_err(|error| buffer.get_mut().failed.take().unwrap_or(error))
    };
    Ok(if overwrite { write_whole(to, write) } else { write_new(to, write) }?)
}

/// A file that keeps why it could not be written: the writer of MCAP says `Record parse failed` of a full disk.
struct Remembering<'a> {
    file: &'a mut File,
    failed: Option<io::Error>,
}

impl Write for Remembering<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes).map_err(|error| {
            let copy = io::Error::new(error.kind(), error.to_string());
            self.failed.get_or_insert(error);
            copy
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Remembering<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// The picture of a run as PNG.
fn picture(run: &Stored) -> Result<Vec<u8>, ExportError> {
    let picture = run.folder.join(PICTURE);
    let wrong = |reason: String| ExportError::NoPicture { picture: picture.clone(), reason };
    let text = up_to(&picture, MOST_JSON).map_err(|error| wrong(error.to_string()))?;
    still::png(&text, Font::of_system()).ok_or_else(|| wrong("its size cannot be read".to_owned()))
}

/// Whether this system has a font for pictures of pixels; without one they have no letters.
pub fn has_letters() -> bool {
    Font::of_system().is_some()
}

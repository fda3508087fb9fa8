//! What can keep results from being written.

use std::io;
use std::path::PathBuf;

use crate::manifest::MANIFEST;

/// Why no run folder was written; nothing half-written stays.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// There is a run folder already.
    #[error("{}: exists already; choose another --out, or replace it with --overwrite", folder.display())]
    Exists {
        /// The folder.
        folder: PathBuf,
    },
    /// There is a folder that a run did not write, so it is not ours to remove.
    #[error(
        "{}: holds other files than those of a run (it has no {MANIFEST}), and --overwrite replaces run folders only; \
         choose another --out", folder.display()
    )]
    NotARun {
        /// The folder.
        folder: PathBuf,
    },
    /// A run folder in which there is something else.
    #[error(
        "{}: holds {}, which efam did not write; it stays: move it elsewhere, or choose another --out",
        folder.display(), entry.display()
    )]
    Foreign {
        /// The folder.
        folder: PathBuf,
        /// What is in it, below the folder.
        entry: PathBuf,
    },
    /// A run folder of which a file was edited.
    #[error(
        "{}: holds {}, which was changed since efam wrote it; it stays: move it elsewhere, or choose another --out",
        folder.display(), entry.display()
    )]
    Changed {
        /// The folder.
        folder: PathBuf,
        /// The file, below the folder.
        entry: PathBuf,
    },
    /// A folder that was free, or a run's, when the work began, and is not any more.
    #[error("{why}; the results are in {}", kept.display())]
    Kept {
        /// Why the folder could not be taken.
        why: Box<StoreError>,
        /// Where the results are.
        kept: PathBuf,
    },
    /// Something came into a run folder in the instant in which it was replaced.
    #[error("{}: is written; what is left of the folder that it replaced is in {}", folder.display(), kept.display())]
    Late {
        /// The folder.
        folder: PathBuf,
        /// Where the rest of the old one is.
        kept: PathBuf,
    },
    /// A file is where a folder is due.
    #[error("{}: is a file where a folder is due; choose another --out, or move the file away", path.display())]
    NotAFolder {
        /// The file.
        path: PathBuf,
    },
    /// A path that names no folder of its own, such as `.` or `/`.
    #[error("{}: names no folder of its own; give --out a name, such as outputs/release", path.display())]
    Unnamed {
        /// The path.
        path: PathBuf,
    },
    /// A further file whose name is none, or is taken.
    #[error("{name:?}: cannot be a file of the run folder; choose a plain file name that no result has")]
    FileName {
        /// The name.
        name: String,
    },
    /// The file system refused.
    #[error("{}: cannot be written: {source}; free it, or choose another --out", path.display())]
    Write {
        /// What was to be written.
        path: PathBuf,
        /// Why it was not.
        source: io::Error,
    },
}

impl StoreError {
    pub(super) fn write(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        move |source| match source.kind() {
            io::ErrorKind::NotADirectory => Self::NotAFolder { path: file_in_the_way(path) },
            _ => Self::Write { path, source },
        }
    }
}

/// The part of a path that is a file though the path goes on.
fn file_in_the_way(path: PathBuf) -> PathBuf {
    let file = path.ancestors().find(|part| part.is_file()).map(PathBuf::from);
    file.unwrap_or(path)
}

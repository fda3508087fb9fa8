//! A run folder: complete under its name, or not there at all.
//!
//! Files go into a hidden folder beside the target, hence on the same file system, are flushed to
//! the disk, and the whole is renamed. A run that fails, or is dropped, removes what it wrote; what one
//! that is killed leaves is hidden, and removed by the next that comes (`partial.rs`).

use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock};
use std::time::SystemTime;

use crate::StoreError;
use crate::disk::{self, File, sync_folder};
use crate::manifest::{self, Foreign, MANIFEST, Manifest, foreign};
use crate::names::{begins, beside, plain_name};
use crate::partial::{Partial, exchange, remove_left, tidy, tidy_within, wait_to_hold};
use crate::sha::sha256;
pub use crate::utc::utc;

/// Where runs go that are given no folder.
pub const OUTPUTS: &str = "outputs";
/// The file that says what a run folder holds, written into each.
pub const MARK: &str = "summary.json";
/// The manifest until it is whole.
const UNNAMED: &str = ".efam-files.json";
/// What steps aside for another run.
const REPLACED: &str = "replaced";
/// Others that may come and go while a run takes its place.
const MOST_RIVALS: usize = 100;

/// Where a run goes.
#[derive(Clone, Copy, Debug)]
pub enum Target<'a> {
    /// `<root>/<UTC>_<name>_<hash8>`; a number follows where that is taken.
    Dated {
        /// Folder of all runs.
        root: &'a Path,
        /// Name of the run, as the user wrote it.
        name: &'a str,
        /// SHA-256 of its scenario, in hexadecimal.
        hash: &'a str,
        /// When.
        at: SystemTime,
    },
    /// This folder.
    Given {
        /// The folder.
        folder: &'a Path,
        /// Whether it may replace a run that is there.
        overwrite: bool,
    },
}

/// Opens the folder `out` or, without it, a new one under [`OUTPUTS`] that is named after the hour, after
/// `name` and after the text that requests the results.
/// # Errors
/// [`StoreError`].
pub fn open(out: Option<&Path>, overwrite: bool, name: &str, asks: &str) -> Result<Folder, StoreError> {
    let hash = sha256(asks.as_bytes());
    Folder::begin(match out {
        Some(folder) => Target::Given { folder, overwrite },
        None => Target::Dated { root: Path::new(OUTPUTS), name, hash: &hash, at: SystemTime::now() },
    })
}

/// A run folder in the making.
#[derive(Debug)]
pub struct Folder {
    target: PathBuf,
    partial: Partial,
    dated: bool,
    replaces: bool,
    added: &'static [&'static str],
    finished: bool,
    /// Whether nothing is written any more. Whoever writes reads it.
    given_up: RwLock<bool>,
}

/// Whether a given folder can take a run: to be checked before a long simulation.
/// # Errors
/// [`StoreError::Exists`], [`StoreError::NotARun`], [`StoreError::Foreign`], [`StoreError::Changed`],
/// [`StoreError::NotAFolder`] or [`StoreError::Unnamed`].
pub fn admit(folder: &Path, overwrite: bool) -> Result<(), StoreError> {
    let here = || folder.to_path_buf();
    if folder.file_name().is_none() {
        return Err(StoreError::Unnamed { path: here() });
    }
    match fs::read_dir(folder).map(Iterator::count) {
        Ok(0) => Ok(()),
        Ok(_) if !folder.join(MANIFEST).is_file() => Err(StoreError::NotARun { folder: here() }),
        Ok(_) if !overwrite => Err(StoreError::Exists { folder: here() }),
        // A link to a run is followed.
        Ok(_) => match fs::canonicalize(folder).and_then(|run| foreign_in_one(&run)) {
            Ok(None) => Ok(()),
            Ok(Some(foreign)) => Err(foreign.refuses(folder)),
            Err(error) => Err(StoreError::write(folder)(error)),
        },
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(StoreError::write(folder)(error)),
    }
}

/// [`foreign`], of one folder: repeated if another run took the name meanwhile, for then its answer mixes the two.
fn foreign_in_one(run: &Path) -> io::Result<Option<Foreign>> {
    let mut answer = Ok(None);
    for _ in 0..MOST_RIVALS {
        let opened = identity(run);
        answer = foreign(run);
        if matches!(answer, Ok(None)) || identity(run).ok() == opened.ok() {
            break;
        }
    }
    answer
}

/// Distinguishes a folder from another that gets its name: an inode alone is soon used again.
#[cfg(unix)]
fn identity(folder: &Path) -> io::Result<(u64, u64, SystemTime)> {
    use std::os::unix::fs::MetadataExt;
    let folder = fs::metadata(folder)?;
    Ok((folder.dev(), folder.ino(), folder.modified()?))
}

/// Elsewhere names are not exchanged.
#[cfg(not(unix))]
fn identity(_: &Path) -> io::Result<()> {
    Ok(())
}

impl Folder {
    /// Makes room beside the target.
    /// # Errors
    /// As [`admit`]; [`StoreError::Write`].
    pub fn begin(target: Target) -> Result<Self, StoreError> {
        let (target, dated, replaces) = match target {
            Target::Dated { root, name, hash, at } => {
                let short = &hash[..hash.len().min(8)];
                (root.join(format!("{}_{}_{short}", utc(at), plain_name(name))), true, false)
            }
            Target::Given { folder, overwrite } => {
                restore(folder);
                if overwrite {
                    tidy_within(folder);
                }
                admit(folder, overwrite)?;
                // A link to a folder is followed: the folder is replaced, not the link.
                (fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf()), false, overwrite)
            }
        };
        let parent = parent(&target);
        disk::create_dir_all(&parent).map_err(|error| {
            if parent.is_file() {
                StoreError::NotAFolder { path: parent.clone() }
            } else {
                StoreError::write(&parent)(error)
            }
        })?;
        tidy(&parent);
        let made = Partial::begin(&target, disk::create_dir);
        let (partial, ()) = made.map_err(StoreError::write(&target))?;
        Ok(Self {
            target,
            partial,
            dated,
            replaces,
            added: &[],
            finished: false,
            given_up: RwLock::new(false),
        })
    }

    /// Names folders that commands may add when it is finished; see [`Manifest`].
    pub fn may_have(&mut self, folders: &'static [&'static str]) {
        self.added = folders;
    }

    /// Where files go until the folder is finished.
    pub fn path(&self) -> &Path {
        &self.partial.path
    }

    /// Removes what was written, while another thread may write: of that nothing is left, and its next file is an error.
    /// For the end of a program.
    pub fn give_up(&self) {
        // Waits for a file that is being written.
        let mut given_up = self.given_up.write().unwrap_or_else(PoisonError::into_inner);
        *given_up = true;
        let _ = remove_left(&self.partial.path);
    }

    /// Writes one file, down to the disk.
    /// # Errors
    /// [`StoreError::Write`]; its path is that which the file would have had.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StoreError> {
        self.write_with(name, |file| file.write_all(bytes))
    }

    /// Lets a function write one file, `name` or `folder/name`, then sees it down to the disk.
    /// # Errors
    /// As [`Self::write`].
    pub fn write_with(
        &self,
        name: &str,
        write: impl FnOnce(&mut File) -> io::Result<()>,
    ) -> Result<(), StoreError> {
        let path = self.partial.path.join(name);
        let given_up = self.given_up.read().unwrap_or_else(PoisonError::into_inner);
        let written = || {
            if *given_up {
                return Err(io::Error::other("the results are given up"));
            }
            disk::create_dir_all(&parent(&path))?;
            let mut file = File::create_new(&path)?;
            write(&mut file)?;
            file.sync_all()
        };
        written().map_err(StoreError::write(self.target.join(name)))
    }

    /// Gives the folder its name, and returns it.
    ///
    /// If the name was taken meanwhile, or somebody put a file into the folder to be replaced, the run gets a free name
    /// beside it: what was computed is not lost for a name.
    /// # Errors
    /// [`StoreError::Kept`] in that case; [`StoreError::Late`]; [`StoreError::Write`].
    pub fn finish(mut self) -> Result<PathBuf, StoreError> {
        let manifest =
            Manifest::of(&self.partial.path, self.added).map_err(StoreError::write(&self.target))?;
        // Half a manifest would be taken for that of a run which had its name, and stay hidden for ever.
        self.write(UNNAMED, manifest.text().as_bytes())?;
        let [unnamed, named] = [UNNAMED, MANIFEST].map(|name| self.partial.path.join(name));
        disk::rename(&unnamed, &named).map_err(StoreError::write(self.target.join(MANIFEST)))?;
        sync_folder(&self.partial.path).map_err(StoreError::write(&self.target))?;
        let named = match (self.replaces, self.dated) {
            (true, _) => self.replace().map(|()| self.target.clone()),
            (false, true) => self.take_free_name(&self.partial.path),
            (false, false) => match self.rename_to(&self.target) {
                Ok(()) => Ok(self.target.clone()),
                Err(error) => Err(self.refused(error)),
            },
        };
        let folder = match named {
            Ok(folder) => folder,
            Err(late @ StoreError::Late { .. }) => {
                self.finished = true;
                return Err(late);
            }
            Err(why) => {
                let Ok(kept) = self.take_free_name(&self.partial.path) else { return Err(why) };
                if kept != self.target {
                    self.finished = true;
                    return Err(StoreError::Kept { why: why.into(), kept });
                }
                // The name was free after all.
                kept
            }
        };
        self.finished = true;
        // The rename is done. Surviving a power cut as well is attempted, not required.
        let _ = sync_folder(&parent(&folder));
        Ok(folder)
    }

    /// A folder that is not empty, or a file, refuses the rename, so nothing is lost in a race.
    fn rename_to(&self, target: &Path) -> io::Result<()> {
        disk::rename(&self.partial.path, target)
    }

    fn refused(&self, error: io::Error) -> StoreError {
        if self.target.exists() {
            StoreError::Exists { folder: self.target.clone() }
        } else {
            StoreError::write(&self.target)(error)
        }
    }

    /// Gives a folder the name of the target, followed by a number where that is taken.
    fn take_free_name(&self, folder: &Path) -> Result<PathBuf, StoreError> {
        let mut name = self.target.clone();
        for number in 2.. {
            match disk::rename(folder, &name) {
                Ok(()) => break,
                Err(_) if fs::symlink_metadata(&name).is_ok() => {
                    name = self.target.as_os_str().to_owned().into();
                    name.as_mut_os_string().push(format!("_{number}"));
                }
                Err(error) => return Err(StoreError::write(&name)(error)),
            }
        }
        Ok(name)
    }

    /// The old run and the new one change places, and the old one is removed.
    fn replace(&self) -> Result<(), StoreError> {
        let failed = || StoreError::write(&self.target);
        let new = &self.partial.path;
        for _ in 0..MOST_RIVALS {
            match exchange(new, &self.target) {
                Ok(()) => return self.remove(new, || exchange(new, &self.target)),
                // Nothing is there, unless another was faster.
                Err(_) if !self.target.exists() => match self.rename_to(&self.target) {
                    Ok(()) => return Ok(()),
                    Err(_) if self.target.exists() => {}
                    Err(error) => return Err(failed()(error)),
                },
                Err(_) => break,
            }
        }
        self.step_aside()
    }

    /// Where names cannot be exchanged, the old run steps aside, and comes back if the new one cannot take its
    /// place; if this is killed between the two, by [`restore`].
    fn step_aside(&self) -> Result<(), StoreError> {
        let failed = || StoreError::write(&self.target);
        let aside = beside(&self.target, REPLACED);
        disk::rename(&self.target, &aside).map_err(failed())?;
        if let Err(error) = self.rename_to(&self.target) {
            let _ = disk::rename(&aside, &self.target);
            return Err(failed()(error));
        }
        self.remove(&aside, || {
            disk::rename(&self.target, &self.partial.path)?;
            disk::rename(&aside, &self.target)
        })
    }

    /// Removes the run that was replaced, which now has another name; if it holds what efam did not write, `undo` puts
    /// it back. A check before the exchange would miss what is written between the check and the exchange.
    fn remove(&self, old: &Path, undo: impl FnOnce() -> io::Result<()>) -> Result<(), StoreError> {
        // Under its hidden name the old run would be taken for left. Whoever holds it made it, and waits for nothing but
        // a run still older; or tidies, and waits for nothing.
        let _old = wait_to_hold(old);
        let why = match foreign(old) {
            Ok(None) => None,
            Ok(Some(foreign)) => Some(foreign.refuses(&self.target)),
            // Tidied by another process of this machine.
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
            Err(error) => Some(StoreError::write(&self.target)(error)),
        };
        match why {
            Some(why) if undo().is_ok() => Err(why),
            None if manifest::remove(old).is_ok() => Ok(()),
            _ => {
                let kept = self.take_free_name(old)?;
                Err(StoreError::Late { folder: self.target.clone(), kept })
            }
        }
    }
}

/// A run that was moved aside for another, whose process was killed before that took its place, gets its name back.
fn restore(folder: &Path) {
    let begins = begins(folder, REPLACED);
    for entry in fs::read_dir(parent(folder)).into_iter().flatten().flatten() {
        if entry.file_name().to_string_lossy().starts_with(&begins) && !folder.exists() {
            let _ = disk::rename(&entry.path(), folder);
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !self.finished {
            let _ = remove_left(&self.partial.path);
        }
    }
}

fn parent(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

#[cfg(test)]
mod tests;

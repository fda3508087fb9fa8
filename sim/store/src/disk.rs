//! The calls by which this crate changes a disk, each of which a test can make fail.
//!
//! A debug build fails the call whose number `EFAM_FAULT` states, such as `17 fail /tmp/log`, or ends there with `kill`
//! for `fail`; a write that fails has written half. The file says which call it was. A release build has nothing of
//! this.

use std::fs;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file that is written.
#[derive(Debug)]
pub struct File {
    file: fs::File,
    path: PathBuf,
}

impl File {
    /// Creates a file under a name that is free.
    /// # Errors
    /// What the system said.
    pub fn create_new(path: &Path) -> io::Result<Self> {
        strike("create", path)?;
        Ok(Self { file: fs::File::create_new(path)?, path: path.to_owned() })
    }

    /// Waits until all of it is on the disk.
    /// # Errors
    /// What the system said.
    pub fn sync_all(&self) -> io::Result<()> {
        strike("fsync", &self.path)?;
        self.file.sync_all()
    }
}

impl Write for File {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        strike_with("write", &self.path, || drop(self.file.write(&bytes[..bytes.len() / 2])))?;
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for File {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// Creates a folder.
pub(super) fn create_dir(path: &Path) -> io::Result<()> {
    strike("create", path)?;
    fs::create_dir(path)
}

/// Creates a folder and those above it, where they are not there.
/// # Errors
/// What the system said.
pub fn create_dir_all(path: &Path) -> io::Result<()> {
    if !path.is_dir() {
        strike("create", path)?;
    }
    fs::create_dir_all(path)
}

/// Gives a file or folder another name.
pub(super) fn rename(from: &Path, to: &Path) -> io::Result<()> {
    strike("rename", to)?;
    fs::rename(from, to)
}

/// Removes a file.
pub(super) fn remove_file(path: &Path) -> io::Result<()> {
    strike("remove", path)?;
    fs::remove_file(path)
}

/// Removes a folder that is empty.
pub(super) fn remove_dir(path: &Path) -> io::Result<()> {
    strike("remove", path)?;
    fs::remove_dir(path)
}

/// Removes a folder with all that is in it.
pub(super) fn remove_dir_all(path: &Path) -> io::Result<()> {
    strike("remove", path)?;
    fs::remove_dir_all(path)
}

/// Waits until the names in a folder are on the disk.
#[cfg(unix)]
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    strike("fsync", folder)?;
    fs::File::open(folder)?.sync_all()
}

/// Elsewhere a folder cannot be opened as a file.
#[cfg(not(unix))]
pub(super) fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Fails where a test wants it.
pub(super) fn strike(call: &str, path: &Path) -> io::Result<()> {
    strike_with(call, path, || ())
}

#[cfg(not(debug_assertions))]
fn strike_with(_: &str, _: &Path, _: impl FnOnce()) -> io::Result<()> {
    Ok(())
}

#[cfg(debug_assertions)]
fn strike_with(call: &str, path: &Path, before: impl FnOnce()) -> io::Result<()> {
    if !fault::is_due(call, path) {
        return Ok(());
    }
    before();
    if fault::kills() {
        std::process::abort();
    }
    Err(io::Error::other(fault::REASON))
}

/// Where the fault comes.
#[cfg(debug_assertions)]
pub(super) mod fault {
    #[cfg(test)]
    use std::path::Path;

    /// What the disk says then.
    pub const REASON: &str = "the disk failed, as a test wanted";

    #[cfg(not(test))]
    mod of_program {
        use std::io::Write;
        use std::path::Path;
        use std::sync::LazyLock;
        use std::sync::atomic::{AtomicU64, Ordering};

        /// Number of the call, whether the program ends there, and the file that records it.
        static PLAN: LazyLock<Option<(u64, bool, String)>> = LazyLock::new(|| {
            let plan = std::env::var("EFAM_FAULT").ok()?;
            let mut words = plan.splitn(3, ' ');
            Some((words.next()?.parse().ok()?, words.next()? == "kill", words.next()?.to_owned()))
        });
        static CALLS: AtomicU64 = AtomicU64::new(0);

        pub fn is_due(call: &str, path: &Path) -> bool {
            let Some((number, _, log)) = &*PLAN else { return false };
            let is_due = CALLS.fetch_add(1, Ordering::SeqCst) + 1 == *number;
            if is_due && let Ok(mut log) = std::fs::File::create(log) {
                let _ = write!(log, "{call} {}", path.display());
            }
            is_due
        }

        pub fn kills() -> bool {
            PLAN.as_ref().is_some_and(|plan| plan.1)
        }
    }
    #[cfg(not(test))]
    pub use of_program::{is_due, kills};

    #[cfg(test)]
    thread_local! {
        /// Calls until the one that fails, on this thread.
        pub static LEFT: std::cell::Cell<Option<u64>> = const { std::cell::Cell::new(None) };
    }

    #[cfg(test)]
    pub fn is_due(_: &str, _: &Path) -> bool {
        let left = LEFT.get();
        LEFT.set(left.and_then(|left| left.checked_sub(1)));
        left == Some(0)
    }

    #[cfg(test)]
    pub fn kills() -> bool {
        false
    }
}

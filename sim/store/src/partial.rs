//! What is in the making: a hidden neighbour of its place, on the same file system, until it is whole.
//!
//! Who makes it holds a lock on it, which ends with
//! the process however that ends; so whoever comes later knows what was left by the dead, and removes it. A
//! lock may be unknown to other machines that share a folder: each tidies after itself only. Where there are
//! no locks at all, on some network file systems, it is called `unheld` and nobody tidies it.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use crate::disk;
use crate::manifest::{self, MANIFEST, Manifest, foreign};
use crate::names::{PARTIAL, UNHELD, beside, is_named, is_partial};

/// A hundred times as long as the removal of a run takes; a process that was stopped may hold a run for ever.
const PATIENCE: Duration = Duration::from_secs(2);
const PAUSE: Duration = Duration::from_millis(1);

/// A file or folder in the making; held until dropped, and not removed by that.
#[derive(Debug)]
pub struct Partial {
    /// Where it is made.
    pub path: PathBuf,
    _lock: Option<File>,
}

/// What came of an attempt to hold a path.
enum Held {
    Lock(File),
    /// Somebody took it for left, and removes it or has.
    Lost,
    /// There are no locks here.
    Unknown,
}

impl Partial {
    /// Makes room for `target` by `make`, which creates a new file or folder at a path and nothing else.
    /// # Errors
    /// Those of `make`.
    pub fn begin<T>(target: &Path, make: impl Fn(&Path) -> io::Result<T>) -> io::Result<(Self, T)> {
        loop {
            let path = beside(target, PARTIAL);
            let made = match make(&path) {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                made => made?,
            };
            match hold(&path) {
                Held::Lock(lock) => return Ok((Self { path, _lock: Some(lock) }, made)),
                Held::Lost => {}
                Held::Unknown => {
                    let unheld = beside(target, UNHELD);
                    disk::rename(&path, &unheld)?;
                    return Ok((Self { path: unheld, _lock: None }, made));
                }
            }
        }
    }
}

/// Removes what was left in a folder by processes of this machine that are no more.
pub fn tidy(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        let Ok(kind) = entry.file_type() else { continue };
        if kind.is_symlink() {
            continue;
        }
        // The lock is kept until it is gone, so that nobody begins in it.
        if is_named(&name.to_string_lossy(), PARTIAL)
            && let Held::Lock(_lock) = hold(&path)
        {
            let _ = if kind.is_dir() { remove_left(&path) } else { disk::remove_file(&path) };
        }
    }
}

/// Removes what dead processes of this machine left in a run folder, and in folders that were added to it.
pub(super) fn tidy_within(folder: &Path) {
    let Some(manifest) = Manifest::read(folder) else { return };
    tidy(folder);
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        if is_folder && manifest.may_have(&entry.file_name().to_string_lossy()) {
            tidy(&entry.path());
        }
    }
}

/// Removes a folder that was given up, or that a dead process left. One with a manifest had its name already and was replaced: of that only
/// what the manifest lists goes.
pub fn remove_left(folder: &Path) -> io::Result<()> {
    match folder.join(MANIFEST).exists() {
        false => disk::remove_dir_all(folder),
        true if foreign(folder)?.is_none() => manifest::remove(folder),
        true => Ok(()),
    }
}

/// Removes what was left of these files in a folder in which nobody has anything to write any more, by whatever machine.
pub fn clear(folder: &Path, names: &[&str]) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        let hidden = entry.file_name().to_string_lossy().into_owned();
        let is_of = |name: &&str| hidden.starts_with(&format!(".{name}."));
        if is_file && is_partial(&hidden) && names.iter().any(is_of) {
            let _ = disk::remove_file(&entry.path());
        }
    }
}

#[cfg(unix)]
fn hold(path: &Path) -> Held {
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == ErrorKind::NotFound => return Held::Lost,
        Err(_) => return Held::Unknown,
    };
    match file.try_lock() {
        Ok(()) if path.exists() => Held::Lock(file),
        Ok(()) | Err(fs::TryLockError::WouldBlock) => Held::Lost,
        Err(fs::TryLockError::Error(_)) => Held::Unknown,
    }
}

/// Elsewhere a folder cannot be opened as a file, and a lock keeps its own process out.
#[cfg(not(unix))]
fn hold(_: &Path) -> Held {
    Held::Unknown
}

/// Holds a path until what is returned is dropped, so that [`tidy`] leaves it. Waits for another who holds it; returns
/// nothing if the path is gone, cannot be held, or is held too long.
pub fn wait_to_hold(path: &Path) -> Option<File> {
    let began = Instant::now();
    loop {
        match hold(path) {
            Held::Lock(lock) => return Some(lock),
            Held::Lost if path.exists() && began.elapsed() < PATIENCE => thread::sleep(PAUSE),
            Held::Lost | Held::Unknown => return None,
        }
    }
}

/// Gives a path another name that is free.
/// # Errors
/// [`ErrorKind::AlreadyExists`] if something has that name.
#[cfg(any(target_os = "linux", target_vendor = "apple"))]
pub fn rename_new(from: &Path, to: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    use rustix::io::Errno;
    disk::strike("rename", to)?;
    match renameat_with(CWD, from, CWD, to, RenameFlags::NOREPLACE) {
        // The file system has no such call.
        Err(Errno::INVAL | Errno::NOSYS | Errno::NOTSUP) => link_new(from, to),
        renamed => Ok(renamed?),
    }
}

/// Gives a path another name that is free.
/// # Errors
/// [`ErrorKind::AlreadyExists`] if something has that name.
#[cfg(not(any(target_os = "linux", target_vendor = "apple")))]
pub fn rename_new(from: &Path, to: &Path) -> io::Result<()> {
    link_new(from, to)
}

/// A second name for a file is refused where that name is taken, unlike a new one.
fn link_new(from: &Path, to: &Path) -> io::Result<()> {
    disk::strike("rename", to)?;
    fs::hard_link(from, to)?;
    disk::remove_file(from)
}

/// Two paths change places, so that neither is ever without content.
/// # Errors
/// One of them is not there, or the file system cannot do it.
#[cfg(any(target_os = "linux", target_vendor = "apple"))]
pub fn exchange(a: &Path, b: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    disk::strike("rename", b)?;
    Ok(renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE)?)
}

/// Elsewhere nobody can.
/// # Errors
/// Always.
#[cfg(not(any(target_os = "linux", target_vendor = "apple")))]
pub fn exchange(_: &Path, b: &Path) -> io::Result<()> {
    fs::symlink_metadata(b)?;
    Err(ErrorKind::Unsupported.into())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::names::host;

    #[test]
    fn what_the_dead_left_is_tidied_and_nothing_else() {
        let root = std::env::temp_dir().join(format!("efam-partial-{}", std::process::id()));
        fs::create_dir_all(&root).unwrap();
        let target = root.join("run");
        let begin = || Partial::begin(&target, |path| fs::create_dir(path)).unwrap().0;
        let (live, dead) = (begin(), begin().path);
        fs::write(dead.join("half"), "a run").unwrap();
        let (file, _) = Partial::begin(&root.join("a.mat"), |path| File::create_new(path)).unwrap();
        let dead_file = root.join(format!(".b.mat.partial-{}-1-2", host()));
        fs::write(&dead_file, "half").unwrap();
        let others =
            [".run.partial-elsewhere.example-1-2", ".run.unheld-1-2", ".partial-notes", "run.partial-1-2"];
        others.iter().for_each(|name| fs::create_dir(root.join(name)).unwrap());
        // A link is not what this module makes: what it leads to is somebody's.
        fs::create_dir(root.join("photos")).unwrap();
        fs::write(root.join("photos/sea.jpg"), "sea").unwrap();
        let link = root.join(format!(".photos.partial-{}-1-2", host()));
        std::os::unix::fs::symlink(root.join("photos"), &link).unwrap();
        tidy(&root);
        assert!(live.path.exists() && file.path.exists(), "they are being made");
        assert!(!dead.exists() && !dead_file.exists());
        assert!(others.iter().all(|name| root.join(name).exists()));
        assert!(root.join("photos/sea.jpg").exists());
        drop((live, file));
        tidy(&root);
        assert_eq!(fs::read_dir(&root).unwrap().count(), others.len() + 2);
        fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn a_name_that_is_taken_is_not_given_again() {
        let root = std::env::temp_dir().join(format!("efam-rename-{}", std::process::id()));
        fs::create_dir_all(&root).unwrap();
        let (from, to) = (root.join("new"), root.join("old"));
        for rename in [rename_new, link_new] {
            fs::write(&from, "new").unwrap();
            fs::write(&to, "old").unwrap();
            assert_eq!(rename(&from, &to).unwrap_err().kind(), ErrorKind::AlreadyExists);
            assert_eq!(fs::read(&to).unwrap(), b"old");
            fs::remove_file(&to).unwrap();
            rename(&from, &to).unwrap();
            assert_eq!(fs::read(&to).unwrap(), b"new");
            assert!(!from.exists());
            fs::remove_file(&to).unwrap();
        }
        fs::remove_dir_all(&root).unwrap();
    }
}

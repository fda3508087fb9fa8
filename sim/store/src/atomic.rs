//! A file: complete under its name, or not there at all.

use std::cell::Cell;
use std::fs;
use std::io;
use std::path::Path;

use crate::StoreError;
use crate::disk::{self, File};
use crate::partial::{self, Partial, rename_new};

/// Lets a function write a file beside its place, sees it down to the disk, and gives it its name. Who reads the name
/// finds the old file or the new one, whenever this is killed; what is then left is hidden, and tidied by the next that
/// writes here.
/// # Errors
/// [`StoreError`]; what was there before is there still.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), StoreError> {
    written(path, write, disk::rename)
}

/// The same, for a name that is free.
/// # Errors
/// [`StoreError::Exists`] if something has that name, also if it came while this wrote; else [`StoreError`].
pub fn write_new(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), StoreError> {
    if fs::symlink_metadata(path).is_ok() {
        return Err(StoreError::Exists { folder: path.to_owned() });
    }
    let is_taken = Cell::new(false);
    let rename = |from: &Path, to: &Path| {
        let renamed = rename_new(from, to);
        is_taken.set(renamed.as_ref().is_err_and(|error| error.kind() == io::ErrorKind::AlreadyExists));
        renamed
    };
    let written = written(path, write, rename);
    if is_taken.get() { Err(StoreError::Exists { folder: path.to_owned() }) } else { written }
}

/// The same, with how the file gets its name.
pub(super) fn written(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
    rename: impl Fn(&Path, &Path) -> io::Result<()>,
) -> Result<(), StoreError> {
    replaced(path, write, rename).map_err(StoreError::write(path))
}

/// The same, with the bare error.
pub(super) fn replaced(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
    rename: impl Fn(&Path, &Path) -> io::Result<()>,
) -> io::Result<()> {
    let folder = path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    disk::create_dir_all(folder)?;
    partial::tidy(folder);
    let (partial, mut file) = Partial::begin(path, File::create_new)?;
    let named = || rename(&partial.path, path);
    let done = write(&mut file).and_then(|()| file.sync_all()).and_then(|()| named());
    if done.is_err() {
        let _ = disk::remove_file(&partial.path);
    }
    done?;
    // The rename is done. Surviving a power cut as well is attempted, not required.
    let _ = disk::sync_folder(folder);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_file_that_comes_while_another_is_written_stays() {
        let folder = std::env::temp_dir().join(format!("efam-atomic-new-{}", std::process::id()));
        let path = folder.join("run.mat");
        let taken = write_new(&path, |file| {
            fs::write(&path, "mine")?;
            file.write_all(b"exported")
        });
        assert!(matches!(taken, Err(StoreError::Exists { .. })), "{taken:?}");
        assert_eq!(fs::read(&path).unwrap(), b"mine");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_file_that_fails_leaves_the_old_one_and_nothing_else() {
        let folder = std::env::temp_dir().join(format!("efam-atomic-{}", std::process::id()));
        let path = folder.join("shard=00001/part");
        write_whole(&path, |file| file.write_all(b"old")).unwrap();
        let broken = write_whole(&path, |file| {
            file.write_all(b"half of the")?;
            Err(io::Error::other("no space"))
        });
        assert!(broken.unwrap_err().to_string().contains("part: cannot be written: no space"));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
        write_whole(&path, |file| file.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        fs::write(folder.join(".part.partial-a-1-2"), "left").unwrap();
        let mine = [".my.partial-notes", ".thesis.partial-host-1-1"].map(|name| folder.join(name));
        mine.iter().for_each(|file| fs::write(file, "mine").unwrap());
        partial::clear(&folder, &["part"]);
        for file in mine {
            fs::remove_file(file).expect("it stays");
        }
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }
}

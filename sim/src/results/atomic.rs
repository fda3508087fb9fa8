//! A file: complete under its name, or not there at all.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use super::ResultsError;

/// What the names of files in the making begin with.
const PARTIAL: &str = ".partial-";

/// Lets a function write a file beside its place, sees it down to the disk, and gives it its name. Who reads the name
/// finds the old file or the new one, whenever this is killed; then a file `.partial-…` is left.
/// # Errors
/// [`ResultsError`]; what was there before is there still.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), ResultsError> {
    let folder = path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    let written = || {
        fs::create_dir_all(folder)?;
        let (partial, mut file) = begin(folder)?;
        let done = write(&mut file).and_then(|()| file.sync_all()).and_then(|()| fs::rename(&partial, path));
        if done.is_err() {
            let _ = fs::remove_file(&partial);
        }
        done
    };
    written().map_err(ResultsError::write(path))?;
    // The rename stands; that it also outlives a power cut is asked for, not insisted on.
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Removes what was left in a folder by those who were killed while they wrote.
pub fn tidy(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_name().to_string_lossy().starts_with(PARTIAL) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// A file that nobody else writes, on this machine or on another that shares the folder.
fn begin(folder: &Path) -> io::Result<(PathBuf, File)> {
    loop {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos());
        let partial = folder.join(format!("{PARTIAL}{}-{since:x}", std::process::id()));
        match File::create_new(&partial) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            file => return Ok((partial, file?)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

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
        fs::write(folder.join(".partial-1-2"), "left").unwrap();
        tidy(&folder);
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }
}

//! A run folder: complete under its name, or not there at all.
//!
//! Files go into a hidden folder beside the target, hence on the same file system, are flushed to
//! the disk, and the whole is renamed. A run that fails, or is dropped, removes what it wrote; one
//! that is killed leaves a hidden folder `.<name>.partial-<process>`, which may be deleted.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use super::ResultsError;

/// Where runs go that are given no folder.
pub const OUTPUTS: &str = "outputs";
/// The file by which a run folder is known, written into each.
pub const MARK: &str = "summary.json";
const MOST_NAME_LENGTH: usize = 60;

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

/// A run folder in the making.
#[derive(Debug)]
pub struct Folder {
    target: PathBuf,
    partial: PathBuf,
    dated: bool,
    replaces: bool,
    finished: bool,
}

/// Whether a given folder can take a run: to be asked before a long simulation.
/// # Errors
/// [`ResultsError::Exists`], [`ResultsError::NotARun`], [`ResultsError::NotAFolder`] or
/// [`ResultsError::Unnamed`].
pub fn admit(folder: &Path, overwrite: bool) -> Result<(), ResultsError> {
    let here = || folder.to_path_buf();
    if folder.file_name().is_none() {
        return Err(ResultsError::Unnamed { path: here() });
    }
    match fs::read_dir(folder).map(Iterator::count) {
        Ok(0) => Ok(()),
        Ok(_) if !folder.join(MARK).is_file() => Err(ResultsError::NotARun { folder: here() }),
        Ok(_) if !overwrite => Err(ResultsError::Exists { folder: here() }),
        Ok(_) => Ok(()),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(ResultsError::write(folder)(error)),
    }
}

impl Folder {
    /// Makes room beside the target.
    /// # Errors
    /// As [`admit`]; [`ResultsError::Write`].
    pub fn begin(target: Target) -> Result<Self, ResultsError> {
        let (target, dated, replaces) = match target {
            Target::Dated { root, name, hash, at } => {
                let short = &hash[..hash.len().min(8)];
                (root.join(format!("{}_{}_{short}", utc(at), plain_name(name))), true, false)
            }
            Target::Given { folder, overwrite } => {
                admit(folder, overwrite)?;
                // A link to a folder is followed: the folder is replaced, not the link.
                (fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf()), false, overwrite)
            }
        };
        let parent = parent(&target);
        fs::create_dir_all(&parent).map_err(|error| match parent.is_file() {
            true => ResultsError::NotAFolder { path: parent.clone() },
            false => ResultsError::write(&parent)(error),
        })?;
        let partial = beside(&target, "partial");
        fs::create_dir(&partial).map_err(ResultsError::write(&partial))?;
        Ok(Self { target, partial, dated, replaces, finished: false })
    }

    /// Where files go until the folder is finished.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Writes one file, down to the disk.
    /// # Errors
    /// [`ResultsError::Write`]; its path is that which the file would have had.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), ResultsError> {
        self.write_with(name, |file| file.write_all(bytes))
    }

    /// Lets a function write one file, `name` or `folder/name`, then sees it down to the disk.
    /// # Errors
    /// As [`Self::write`].
    pub fn write_with(
        &self,
        name: &str,
        write: impl FnOnce(&mut File) -> std::io::Result<()>,
    ) -> Result<(), ResultsError> {
        let path = self.partial.join(name);
        let written = || {
            fs::create_dir_all(parent(&path))?;
            let mut file = File::create_new(&path)?;
            write(&mut file)?;
            file.sync_all()
        };
        written().map_err(ResultsError::write(self.target.join(name)))
    }

    /// Gives the folder its name, and returns it.
    /// # Errors
    /// [`ResultsError::Exists`] if another run was faster; [`ResultsError::Write`].
    pub fn finish(mut self) -> Result<PathBuf, ResultsError> {
        sync_folder(&self.partial).map_err(ResultsError::write(&self.target))?;
        let folder = match (self.replaces, self.dated) {
            (true, _) => self.replace()?,
            (false, true) => self.take_free_name()?,
            (false, false) => {
                self.rename_to(&self.target).map_err(|error| self.refused(error))?;
                self.target.clone()
            }
        };
        self.finished = true;
        // The rename stands; that it also outlives a power cut is asked for, not insisted on.
        let _ = sync_folder(&parent(&folder));
        Ok(folder)
    }

    /// A folder that is not empty, or a file, refuses the rename, so nothing is lost in a race.
    fn rename_to(&self, target: &Path) -> std::io::Result<()> {
        fs::rename(&self.partial, target)
    }

    fn refused(&self, error: std::io::Error) -> ResultsError {
        match self.target.exists() {
            true => ResultsError::Exists { folder: self.target.clone() },
            false => ResultsError::write(&self.target)(error),
        }
    }

    fn take_free_name(&self) -> Result<PathBuf, ResultsError> {
        let mut name = self.target.clone();
        for number in 2.. {
            match self.rename_to(&name) {
                Ok(()) => break,
                Err(_) if name.exists() => {
                    name = self.target.as_os_str().to_owned().into();
                    name.as_mut_os_string().push(format!("_{number}"));
                }
                Err(error) => return Err(ResultsError::write(&name)(error)),
            }
        }
        Ok(name)
    }

    /// The old run steps aside, and comes back if the new one cannot take its place.
    fn replace(&self) -> Result<PathBuf, ResultsError> {
        let failed = || ResultsError::write(&self.target);
        let aside = beside(&self.target, "replaced");
        let had_one = match fs::rename(&self.target, &aside) {
            Ok(()) => true,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => false,
            Err(error) => return Err(failed()(error)),
        };
        if let Err(error) = self.rename_to(&self.target) {
            if had_one {
                let _ = fs::rename(&aside, &self.target);
            }
            return Err(failed()(error));
        }
        if had_one {
            fs::remove_dir_all(&aside).map_err(ResultsError::write(&aside))?;
        }
        Ok(self.target.clone())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !self.finished {
            let _ = fs::remove_dir_all(&self.partial);
        }
    }
}

/// A hidden neighbour of the target that no other process uses.
fn beside(target: &Path, what: &str) -> PathBuf {
    use std::sync::atomic::{AtomicU32, Ordering};
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    parent(target).join(format!(".{name}.{what}-{}-{count}", std::process::id()))
}

fn parent(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

#[cfg(unix)]
fn sync_folder(folder: &Path) -> std::io::Result<()> {
    File::open(folder)?.sync_all()
}

/// Elsewhere a folder cannot be opened as a file.
#[cfg(not(unix))]
fn sync_folder(_: &Path) -> std::io::Result<()> {
    Ok(())
}

/// A name that any file system takes and that leads nowhere: letters, digits, `.`, `_` and `-`.
pub fn plain_name(name: &str) -> String {
    let admitted = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-');
    let words = name.split(|c| !admitted(c)).filter(|word| !word.is_empty());
    let joined: String = words.collect::<Vec<_>>().join("-").chars().take(MOST_NAME_LENGTH).collect();
    match joined.trim_matches(['.', '-', '_']) {
        "" => "run".to_owned(),
        name => name.to_owned(),
    }
}

/// Time as `20260131T235959Z`, which sorts as it reads.
pub fn utc(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    let [year, month, day] = calendar(days);
    let [hour, minute, second] = [second / 3600, second / 60 % 60, second % 60];
    format!("{year:04}{month:02}{day:02}T{hour:02}{minute:02}{second:02}Z")
}

/// Year, month and day of a number of days after 1 January 1970.
///
/// The year begins in March, so that the leap day is its last.
/// Source: Hinnant, chrono-compatible low-level date algorithms, `civil_from_days`.
fn calendar(days: u64) -> [u64; 3] {
    let days = days + 719_468;
    let (era, of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let march_month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * march_month + 2) / 5 + 1;
    let month = if march_month < 10 { march_month + 3 } else { march_month - 9 };
    [era * 400 + year_of_era + u64::from(month <= 2), month, day]
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    /// A folder of its own for each test, removed at its end.
    struct Scratch(PathBuf);

    impl Scratch {
        fn new(test: &str) -> Self {
            let path = std::env::temp_dir().join(format!("efam-folder-{test}-{}", std::process::id()));
            let _ = fs::remove_dir_all(&path);
            fs::create_dir_all(&path).unwrap();
            Self(path)
        }

        fn entries(&self) -> Vec<String> {
            let mut names: Vec<_> = fs::read_dir(&self.0)
                .unwrap()
                .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
                .collect();
            names.sort();
            names
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    fn put(folder: &Path, overwrite: bool, text: &str) -> Result<PathBuf, ResultsError> {
        let made = Folder::begin(Target::Given { folder, overwrite })?;
        made.write(MARK, text.as_bytes())?;
        made.finish()
    }

    #[test]
    fn a_run_is_replaced_only_when_asked() {
        let scratch = Scratch::new("overwrite");
        let out = scratch.0.join("run");
        put(&out, false, "first").unwrap();
        assert!(admit(&out, false).is_err() && admit(&out, true).is_ok());
        let error = put(&out, false, "second").unwrap_err();
        assert!(matches!(&error, ResultsError::Exists { folder } if *folder == out), "{error}");
        assert!(
            error
                .to_string()
                .ends_with("run: exists already; choose another --out, or replace it with --overwrite")
        );
        assert_eq!(fs::read_to_string(out.join(MARK)).unwrap(), "first");
        put(&out, true, "third").unwrap();
        assert_eq!(fs::read_to_string(out.join(MARK)).unwrap(), "third");
        assert_eq!(scratch.entries(), ["run"]);
    }

    #[test]
    fn a_folder_of_other_things_is_never_replaced_but_an_empty_one_is_filled() {
        let scratch = Scratch::new("foreign");
        let photos = scratch.0.join("photos");
        fs::create_dir(&photos).unwrap();
        put(&photos, false, "into an empty folder").unwrap();
        fs::remove_file(photos.join(MARK)).unwrap();
        fs::write(photos.join("holiday.jpg"), "sea").unwrap();
        for overwrite in [false, true] {
            let error = put(&photos, overwrite, "run").unwrap_err();
            assert!(matches!(error, ResultsError::NotARun { .. }), "{error}");
        }
        assert_eq!(fs::read_to_string(photos.join("holiday.jpg")).unwrap(), "sea");
    }

    #[test]
    fn a_folder_that_is_given_up_leaves_nothing() {
        let scratch = Scratch::new("dropped");
        let out = scratch.0.join("run");
        let made = Folder::begin(Target::Given { folder: &out, overwrite: false }).unwrap();
        made.write("trajectory.csv", b"half of").unwrap();
        assert!(!out.exists());
        assert_eq!(scratch.entries().len(), 1);
        drop(made);
        assert!(scratch.entries().is_empty(), "{:?}", scratch.entries());
    }

    #[test]
    fn a_file_in_place_of_the_folder_is_named() {
        let scratch = Scratch::new("file");
        let file = scratch.0.join("run");
        fs::write(&file, "a file").unwrap();
        for out in [file.clone(), file.join("below"), file.join("further/below")] {
            let error = put(&out, true, "run").unwrap_err();
            let ResultsError::NotAFolder { path } = &error else { panic!("{error}") };
            assert_eq!(*path, file);
        }
        let root = scratch.0.join("run");
        let at = UNIX_EPOCH;
        let error = Folder::begin(Target::Dated { root: &root, name: "a", hash: "b", at }).unwrap_err();
        assert!(matches!(error, ResultsError::NotAFolder { .. }), "{error}");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_names_file_and_cause() {
        let scratch = Scratch::new("full");
        let out = scratch.0.join("run");
        let made = Folder::begin(Target::Given { folder: &out, overwrite: false }).unwrap();
        let full = |_: &mut File| File::options().write(true).open("/dev/full")?.write_all(b"much");
        let error = made.write_with("trajectory.parquet", full).unwrap_err().to_string();
        assert!(error.contains("run/trajectory.parquet: cannot be written: No space left"), "{error}");
        drop(made);
        assert!(scratch.entries().is_empty());
    }

    #[test]
    fn two_runs_of_one_second_both_find_a_name() {
        let scratch = Scratch::new("dated");
        let at = UNIX_EPOCH + Duration::from_secs(1_709_164_799 + 86_400);
        let target = Target::Dated { root: &scratch.0, name: "15 psi", hash: "0123456789abcdef", at };
        for _ in 0..3 {
            let made = Folder::begin(target).unwrap();
            made.write(MARK, b"{}").unwrap();
            made.finish().unwrap();
        }
        let name = "20240229T235959Z_15-psi_01234567";
        assert_eq!(scratch.entries(), [name.to_owned(), format!("{name}_2"), format!("{name}_3")]);
    }

    #[test]
    fn names_cannot_leave_the_folder_of_runs() {
        for (name, expected) in [
            ("../../etc/passwd", "etc-passwd"),
            ("/root", "root"),
            ("..", "run"),
            ("", "run"),
            ("a\\b:c\0d\n", "a-b-c-d"),
            ("15 psi, 50 g", "15-psi-50-g"),
            ("Größe", "Gr-e"),
        ] {
            assert_eq!(plain_name(name), expected, "{name:?}");
        }
        assert_eq!(plain_name(&"x".repeat(500)).len(), MOST_NAME_LENGTH);
        for path in ["/", "..", "."] {
            let error = admit(Path::new(path), true).unwrap_err();
            assert!(!matches!(error, ResultsError::Exists { .. }), "{path}: {error}");
        }
    }

    #[test]
    fn the_calendar_knows_its_leap_days() {
        for (days, date) in [
            (0, [1970, 1, 1]),
            (58, [1970, 2, 28]),
            (59, [1970, 3, 1]),
            (11_016, [2000, 2, 29]),
            (20_454, [2026, 1, 1]),
        ] {
            assert_eq!(calendar(days), date, "{days}");
        }
    }
}

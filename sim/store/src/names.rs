//! Names of files and folders that efam makes: plain ones, and hidden ones of what is in the making.
//!
//! A hidden name is `.<name>.partial-<host>-<process>-<number>`, or `unheld` instead of `partial` where there are no
//! locks.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// Of what is in the making.
pub const PARTIAL: &str = "partial";
/// The same where there are no locks.
pub const UNHELD: &str = "unheld";
/// Of the name that it will have.
const MOST_BYTES: usize = 100;
/// Of a plain name.
const MOST_NAME_LENGTH: usize = 60;

/// A name that any file system takes and that leads nowhere: letters, digits, `.`, `_` and `-`.
pub fn plain_name(name: &str) -> String {
    let admitted = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-');
    let words = name.split(|c| !admitted(c)).filter(|word| !word.is_empty());
    let joined: String = words.collect::<Vec<_>>().join("-").chars().take(MOST_NAME_LENGTH).collect();
    match joined.trim_matches(['.', '-', '_']) {
        "" => "run".to_owned(),
        name if is_device(name) => format!("run-{name}"),
        name => name.to_owned(),
    }
}

/// Whether Windows takes a name for one of its devices, whatever its ending.
fn is_device(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default().to_ascii_lowercase();
    let numbered = |device: &str| {
        stem.strip_prefix(device).is_some_and(|rest| rest.len() == 1 && rest > "0" && rest <= "9")
    };
    matches!(&*stem, "con" | "prn" | "aux" | "nul") || numbered("com") || numbered("lpt")
}

/// Whether a name is one that a process gives on some machine.
pub fn is_partial(name: &str) -> bool {
    let is_of = |what: &str| {
        let after = name.rsplit_once(&format!(".{what}-")).filter(|(before, _)| before.starts_with('.'));
        let ends = after.and_then(|(_, after)| {
            let (before, count) = after.rsplit_once('-')?;
            let (host, process) = before.rsplit_once('-')?;
            Some([host, process, count])
        });
        ends.is_some_and(|[host, process, count]| !host.is_empty() && is_number(process) && is_number(count))
    };
    is_of(PARTIAL) || is_of(UNHELD)
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// A hidden neighbour of a path that nobody else uses, nor has: a machine counts its processes anew.
pub fn beside(target: &Path, what: &str) -> PathBuf {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    loop {
        let (process, count) = (std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = target.with_file_name(format!("{}{process}-{count}", begins(target, what)));
        if fs::symlink_metadata(&path).is_err() {
            return path;
        }
    }
}

/// What the names begin with that [`beside`] gives on this machine. Of a long name they contain only the
/// beginning, for a file system takes 255 bytes.
pub fn begins(target: &Path, what: &str) -> String {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    format!(".{}.{what}-{}-", &name[..name.floor_char_boundary(MOST_BYTES)], host())
}

/// Whether a name is one that [`beside`] gives on this machine.
pub fn is_named(name: &str, what: &str) -> bool {
    if !name.starts_with('.') {
        return false;
    }
    let after = name.rsplit_once(&format!(".{what}-{}-", host()));
    let ends = after.and_then(|(_, after)| after.split_once('-'));
    ends.is_some_and(|(process, count)| is_number(process) && is_number(count))
}

/// This machine, as others that share a folder know it.
#[cfg(unix)]
pub fn host() -> String {
    plain_name(&rustix::system::uname().nodename().to_string_lossy())
}

#[cfg(not(unix))]
pub fn host() -> String {
    "here".to_owned()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn names_are_known_again_whatever_stands_in_them() {
        for name in ["run", "a.partial-b-1-2", "-", "…", &"ö".repeat(120)] {
            let path = beside(Path::new(name), PARTIAL);
            let own = path.file_name().unwrap().to_string_lossy();
            assert!(is_named(&own, PARTIAL) && !is_named(&own, UNHELD) && own.len() < 255, "{own}");
        }
        for name in ["run", ".run.partial-1-2", ".partial-", ".run.partial-x-1-2-3"] {
            assert!(!is_named(name, PARTIAL), "{name}");
        }
        for name in [".run.partial-lab-1-2", ".part.parquet.unheld-node-7.example-123-0"] {
            assert!(is_partial(name), "{name}");
        }
        for name in [".my.partial-notes", "run.partial-lab-1-2", ".partial-lab-1-2", ".run.partial-1-2"] {
            assert!(!is_partial(name), "{name}");
        }
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
            ("-rf *", "rf"),
            (".bashrc", "bashrc"),
            ("CON", "run-CON"),
            ("com7.csv", "run-com7.csv"),
            ("console", "console"),
        ] {
            assert_eq!(plain_name(name), expected, "{name:?}");
        }
        assert_eq!(plain_name(&"x".repeat(500)).len(), MOST_NAME_LENGTH);
    }
}

//! The manifest of a run folder: which files efam wrote there.
//!
//! Only a folder in which every entry is listed, with the content that was written, is ever replaced or removed; and
//! what is removed is removed entry by entry. So a file that somebody else put there, or changed, always stays.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::StoreError;
use crate::names::is_partial;
use crate::sha::Sha;

/// The file of the manifest, written into each run folder.
pub const MANIFEST: &str = "efam-files.json";
/// The longest manifest that is read, bytes: a hundred thousand files.
const MOST_BYTES: u64 = 16 << 20;

/// What efam wrote into a folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Always `efam`.
    program: String,
    /// The version that wrote the folder.
    version: String,
    /// SHA-256 of each file but this one, by its path below the folder, with `/` between its parts.
    files: BTreeMap<String, String>,
    /// Paths that commands may add or rewrite later, each part with at most one `*` for any text.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    later: Vec<String>,
}

/// An entry that keeps a folder from being replaced.
#[derive(Clone, Debug, PartialEq)]
pub enum Foreign {
    /// There is no manifest, so nothing in the folder is known to be efam's.
    NoManifest,
    /// The manifest does not list this entry.
    Unknown(PathBuf),
    /// This file is listed, and its content is another.
    Changed(PathBuf),
}

impl Manifest {
    /// The manifest of all that lies in a folder.
    /// # Errors
    /// What the file system said.
    pub(super) fn of(folder: &Path, later: &[&str]) -> io::Result<Self> {
        let mut files = BTreeMap::new();
        for entry in entries(folder)?.into_iter().filter(|entry| !entry.is_folder) {
            files.insert(entry.name, hash(&entry.path)?);
        }
        files.remove(MANIFEST);
        let later = later.iter().map(|own| (*own).to_owned()).collect();
        Ok(Self { program: "efam".to_owned(), version: env!("CARGO_PKG_VERSION").to_owned(), files, later })
    }

    /// The manifest as its file has it.
    pub(super) fn text(&self) -> String {
        serde_json::to_string_pretty(self).expect("texts and lists have JSON") + "\n"
    }

    /// Reads the manifest of a folder; nothing where there is none, or another program's.
    fn read(folder: &Path) -> Option<Self> {
        let path = folder.join(MANIFEST);
        let length = fs::symlink_metadata(&path).ok().filter(fs::Metadata::is_file)?.len();
        let text = if length <= MOST_BYTES { fs::read_to_string(&path).ok()? } else { return None };
        serde_json::from_str(&text).ok().filter(|manifest: &Self| manifest.program == "efam")
    }

    /// Whether efam may have written an entry, going by its name alone.
    fn lists(&self, entry: &Entry) -> bool {
        let is_later = |pattern: &String| is_like(pattern, &entry.name);
        if entry.is_folder {
            let below = format!("{}/", entry.name);
            let is_above = |pattern: &String| {
                let depth = entry.name.split('/').count();
                let head: Vec<&str> = pattern.split('/').take(depth).collect();
                pattern.split('/').count() > depth && is_like(&head.join("/"), &entry.name)
            };
            return self.files.keys().any(|file| file.starts_with(&below)) || self.later.iter().any(is_above);
        }
        let last = entry.name.rsplit('/').next().unwrap_or_default();
        entry.is_file
            && (entry.name == MANIFEST
                || self.files.contains_key(&entry.name)
                || self.later.iter().any(is_later)
                || (!self.later.is_empty() && is_partial(last)))
    }
}

/// Finds what in a folder efam did not write; an empty folder holds nothing of that kind.
/// # Errors
/// What the file system said.
pub(super) fn foreign(folder: &Path) -> io::Result<Option<Foreign>> {
    let all = entries(folder)?;
    if all.is_empty() {
        return Ok(None);
    }
    let Some(manifest) = Manifest::read(folder) else { return Ok(Some(Foreign::NoManifest)) };
    if let Some(entry) = all.iter().find(|entry| !manifest.lists(entry)) {
        return Ok(Some(Foreign::Unknown(entry.name.clone().into())));
    }
    for entry in all.iter().filter(|entry| !entry.is_folder) {
        let is_later = manifest.later.iter().any(|pattern| is_like(pattern, &entry.name));
        if let Some(written) = manifest.files.get(&entry.name).filter(|_| !is_later)
            && hash(&entry.path)? != *written
        {
            return Ok(Some(Foreign::Changed(entry.name.clone().into())));
        }
    }
    Ok(None)
}

/// Removes what the manifest of a folder lists, and the folder if nothing else is in it. What came into it since
/// [`foreign`] was asked stays, and the folder with it.
/// # Errors
/// What the file system said; [`ErrorKind::DirectoryNotEmpty`] where something stays.
pub(super) fn remove(folder: &Path) -> io::Result<()> {
    let all = match entries(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        all => all?,
    };
    if let Some(manifest) = Manifest::read(folder) {
        let (own, last): (Vec<_>, Vec<_>) =
            all.iter().filter(|entry| manifest.lists(entry)).partition(|entry| entry.name != MANIFEST);
        // The deepest first. Without the manifest the rest would belong to nobody: it goes last.
        for entry in own.iter().rev().chain(&last) {
            gone(if entry.is_folder { fs::remove_dir(&entry.path) } else { fs::remove_file(&entry.path) })?;
        }
    }
    gone(fs::remove_dir(folder))
}

/// Somebody else may have removed it at the same time.
fn gone(removed: io::Result<()>) -> io::Result<()> {
    match removed {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        removed => removed,
    }
}

/// Something below a folder; a link is neither folder nor file.
struct Entry {
    path: PathBuf,
    /// Its path below the folder, with `/` between its parts.
    name: String,
    is_folder: bool,
    is_file: bool,
}

/// All that lies below a folder, each folder before what is in it.
fn entries(folder: &Path) -> io::Result<Vec<Entry>> {
    if !fs::symlink_metadata(folder)?.is_dir() {
        return Err(ErrorKind::NotADirectory.into());
    }
    let mut all = Vec::new();
    let mut open = vec![(folder.to_path_buf(), String::new())];
    while let Some((folder, above)) = open.pop() {
        for entry in fs::read_dir(&folder)? {
            let entry = entry?;
            let (path, kind) = (entry.path(), entry.file_type()?);
            let name = format!("{above}{}", entry.file_name().to_string_lossy());
            if kind.is_dir() {
                open.push((path.clone(), format!("{name}/")));
            }
            all.push(Entry { path, name, is_folder: kind.is_dir(), is_file: kind.is_file() });
        }
    }
    all.sort_by(|a, b| a.name.split('/').cmp(b.name.split('/')));
    Ok(all)
}

fn hash(file: &Path) -> io::Result<String> {
    let mut sha = Sha::default();
    io::copy(&mut File::open(file)?, &mut sha)?;
    Ok(sha.hexadecimal())
}

/// Whether a path is like a pattern, part by part; a `*` in a part stands for any text without `/`.
fn is_like(pattern: &str, path: &str) -> bool {
    let is_like = |(pattern, part): (&str, &str)| match pattern.split_once('*') {
        None => pattern == part,
        Some((head, tail)) => {
            part.len() >= head.len() + tail.len() && part.starts_with(head) && part.ends_with(tail)
        }
    };
    let parts = |text: &str| text.split('/').count();
    parts(pattern) == parts(path) && pattern.split('/').zip(path.split('/')).all(is_like)
}

impl Foreign {
    /// The error that a folder cannot be replaced because of this.
    pub(super) fn refuses(self, folder: &Path) -> StoreError {
        let folder = folder.to_path_buf();
        match self {
            Foreign::NoManifest => StoreError::NotARun { folder },
            Foreign::Unknown(entry) => StoreError::Foreign { folder, entry },
            Foreign::Changed(entry) => StoreError::Changed { folder, entry },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_stands_for_one_part_of_a_path() {
        for (pattern, path, expected) in [
            ("shard=*/part.parquet", "shard=00003/part.parquet", true),
            ("shard=*/part.parquet", "shard=/part.parquet", true),
            ("shard=*/part.parquet", "shard=1/2/part.parquet", false),
            ("shard=*/part.parquet", "thesis/part.parquet", false),
            ("log/*.txt", "log/4_1.txt", true),
            ("log/*.txt", "log/4_1.tex", false),
            ("a*a", "a", false),
            ("sweep.json", "sweep.json", true),
            ("sweep.json", "sweep.json.bak", false),
        ] {
            assert_eq!(is_like(pattern, path), expected, "{pattern} {path}");
        }
    }

    #[test]
    fn what_efam_did_not_write_is_found_and_never_removed() {
        let folder = std::env::temp_dir().join(format!("efam-manifest-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        let made = || {
            fs::create_dir_all(folder.join("pictures")).unwrap();
            fs::write(folder.join("summary.json"), "{}").unwrap();
            fs::write(folder.join("pictures/a.svg"), "<svg/>").unwrap();
            let manifest = Manifest::of(&folder, &["shard=*/part.parquet"]).unwrap();
            fs::write(folder.join(MANIFEST), manifest.text()).unwrap();
        };
        made();
        assert_eq!(foreign(&folder).unwrap(), None);
        fs::create_dir(folder.join("shard=00001")).unwrap();
        fs::write(folder.join("shard=00001/part.parquet"), "rows").unwrap();
        fs::write(folder.join("shard=00001/.part.parquet.partial-lab-12-3"), "half").unwrap();
        assert_eq!(foreign(&folder).unwrap(), None, "a shard was added, another is in the making");
        remove(&folder).unwrap();
        assert!(!folder.exists());

        for name in ["notes.txt", "pictures/thesis.tex", ".git/", "shard=00001", ".a.partial-of-my-own"] {
            made();
            let put = folder.join(name);
            if name.ends_with('/') {
                fs::create_dir(put).unwrap()
            } else {
                fs::write(put, "mine").unwrap()
            }
            let name = name.trim_end_matches('/');
            assert_eq!(foreign(&folder).unwrap(), Some(Foreign::Unknown(name.into())));
            assert_eq!(remove(&folder).unwrap_err().kind(), ErrorKind::DirectoryNotEmpty, "{name}");
            assert!(fs::symlink_metadata(folder.join(name)).is_ok(), "{name} stays");
            assert!(!folder.join("summary.json").exists());
            fs::remove_dir_all(&folder).unwrap();
        }
        made();
        fs::write(folder.join("pictures/a.svg"), "<svg />").unwrap();
        assert_eq!(foreign(&folder).unwrap(), Some(Foreign::Changed("pictures/a.svg".into())));
        fs::remove_file(folder.join(MANIFEST)).unwrap();
        assert_eq!(foreign(&folder).unwrap(), Some(Foreign::NoManifest));
        fs::remove_dir_all(&folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_not_followed() {
        let root = std::env::temp_dir().join(format!("efam-manifest-link-{}", std::process::id()));
        let (folder, photos) = (root.join("run"), root.join("photos"));
        fs::create_dir_all(&folder).unwrap();
        fs::create_dir_all(&photos).unwrap();
        fs::write(photos.join("sea.jpg"), "sea").unwrap();
        std::os::unix::fs::symlink(&photos, folder.join("pictures")).unwrap();
        fs::write(folder.join("pictures/a.svg"), "<svg/>").unwrap();
        let files = BTreeMap::from([("pictures/a.svg".to_owned(), String::new())]);
        let manifest =
            Manifest { program: "efam".to_owned(), version: "0".to_owned(), files, later: Vec::new() };
        fs::write(folder.join(MANIFEST), manifest.text()).unwrap();
        assert_eq!(foreign(&folder).unwrap(), Some(Foreign::Unknown("pictures".into())));
        assert!(remove(&folder).is_err());
        assert!(photos.join("sea.jpg").exists() && photos.join("a.svg").exists());
        fs::remove_dir_all(&root).unwrap();
    }
}

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
use crate::disk;
use crate::sha::Sha;

/// The file of the manifest, written into each run folder.
pub const MANIFEST: &str = "efam-files.json";
/// The longest manifest that is read, bytes: a hundred thousand files.
const MOST_BYTES: u64 = 16 << 20;
/// Earlier contents of a file that are known again: one for each write that was killed before its rename, and one more.
const MOST_EARLIER: usize = 8;

/// What efam wrote into a folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Always `efam`.
    program: String,
    /// The version that wrote the folder.
    version: String,
    /// SHA-256 of each file but this one, by its path below the folder, with `/` between its parts.
    files: BTreeMap<String, String>,
    /// SHA-256 of what a name held before: a program that is killed between manifest and rename leaves that.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    earlier: BTreeMap<String, Vec<String>>,
    /// Folders that commands may add later, each with a manifest of its own; `*` is any text.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    folders: Vec<String>,
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
    pub(super) fn of(folder: &Path, folders: &[&str]) -> io::Result<Self> {
        let mut files = BTreeMap::new();
        for entry in entries(folder)?.into_iter().filter(|entry| !entry.is_folder) {
            files.insert(entry.name, hash(&entry.path)?);
        }
        files.remove(MANIFEST);
        let folders = folders.iter().map(|own| (*own).to_owned()).collect();
        Ok(Self { files, folders, ..Self::empty() })
    }

    pub(super) fn empty() -> Self {
        Self {
            program: "efam".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            files: BTreeMap::new(),
            earlier: BTreeMap::new(),
            folders: Vec::new(),
        }
    }

    /// The manifest as its file has it.
    pub(super) fn text(&self) -> String {
        serde_json::to_string_pretty(self).expect("texts and lists have JSON") + "\n"
    }

    /// Reads the manifest of a folder; nothing where there is none, or another program's.
    pub(super) fn read(folder: &Path) -> Option<Self> {
        let path = folder.join(MANIFEST);
        let length = fs::symlink_metadata(&path).ok().filter(fs::Metadata::is_file)?.len();
        let text = if length <= MOST_BYTES { fs::read_to_string(&path).ok()? } else { return None };
        serde_json::from_str(&text).ok().filter(|manifest: &Self| manifest.program == "efam")
    }

    /// Whether a folder may be added later.
    pub(super) fn may_have(&self, folder: &str) -> bool {
        self.folders.iter().any(|pattern| is_like(pattern, folder))
    }

    /// Whether it states a content of a file.
    pub(super) fn has(&self, name: &str, sha256: &str) -> bool {
        let earlier = self.earlier.get(name).into_iter().flatten();
        self.files.get(name).into_iter().chain(earlier).any(|own| own == sha256)
    }

    /// Whether it states a file.
    pub(super) fn states(&self, name: &str) -> bool {
        self.files.contains_key(name)
    }

    /// States another content of a file, beside that which it has had.
    pub(super) fn put(&mut self, name: &str, sha256: String) {
        let Some(before) = self.files.insert(name.to_owned(), sha256.clone()) else { return };
        let earlier = self.earlier.entry(name.to_owned()).or_default();
        earlier.retain(|own| *own != sha256 && *own != before);
        if before != sha256 {
            earlier.push(before);
        }
        earlier.drain(..earlier.len().saturating_sub(MOST_EARLIER));
        self.earlier.retain(|_, earlier| !earlier.is_empty());
    }
}

/// The manifests of a folder, and of the folders in it that were added later.
struct Manifests {
    top: Manifest,
    below: BTreeMap<String, Manifest>,
}

impl Manifests {
    /// Reads them; nothing where the folder itself has none.
    fn read(folder: &Path, all: &[Entry]) -> Option<Self> {
        let top = Manifest::read(folder)?;
        let added = all.iter().filter(|entry| entry.is_folder && top.may_have(&entry.name));
        let below = added.filter_map(|entry| Some((entry.name.clone(), Manifest::read(&entry.path)?)));
        Some(Self { below: below.collect(), top })
    }

    /// The manifest that is due to state an entry, and its name there.
    fn of<'a>(&self, entry: &'a Entry) -> (&Manifest, &'a str) {
        let split = entry.name.split_once('/');
        let below = split.and_then(|(folder, name)| Some((self.below.get(folder)?, name)));
        below.unwrap_or((&self.top, &entry.name))
    }

    /// Whether efam may have written an entry, going by its name alone. A folder is nothing without what is in it.
    fn lists(&self, entry: &Entry) -> bool {
        let (manifest, name) = self.of(entry);
        if entry.is_folder {
            let below = format!("{name}/");
            return manifest.files.keys().any(|file| file.starts_with(&below)) || manifest.may_have(name);
        }
        entry.is_file && (name == MANIFEST || manifest.files.contains_key(name))
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
    let Some(manifests) = Manifests::read(folder, &all) else { return Ok(Some(Foreign::NoManifest)) };
    if let Some(entry) = all.iter().find(|entry| !manifests.lists(entry)) {
        return Ok(Some(Foreign::Unknown(entry.name.clone().into())));
    }
    for entry in all.iter().filter(|entry| !entry.is_folder) {
        let (manifest, name) = manifests.of(entry);
        if name != MANIFEST && !manifest.has(name, &hash(&entry.path)?) {
            return Ok(Some(Foreign::Changed(entry.name.clone().into())));
        }
    }
    Ok(None)
}

/// Removes what the manifest of a folder lists, and the folder if nothing else is in it. What came into it since
/// [`foreign`] looked stays, and the folder with it.
/// # Errors
/// What the file system said; [`ErrorKind::DirectoryNotEmpty`] where something stays.
pub(super) fn remove(folder: &Path) -> io::Result<()> {
    let all = match entries(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        all => all?,
    };
    if let Some(manifests) = Manifests::read(folder, &all) {
        let (own, last): (Vec<_>, Vec<_>) =
            all.iter().filter(|entry| manifests.lists(entry)).partition(|entry| entry.name != MANIFEST);
        // The deepest first. Without the manifest the rest would belong to nobody: it goes last.
        for entry in own.iter().rev().chain(&last) {
            gone(if entry.is_folder {
                disk::remove_dir(&entry.path)
            } else {
                disk::remove_file(&entry.path)
            })?;
        }
    }
    gone(disk::remove_dir(folder))
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

pub(super) fn hash(file: &Path) -> io::Result<String> {
    let mut sha = Sha::default();
    io::copy(&mut File::open(file)?, &mut sha)?;
    Ok(sha.hexadecimal())
}

/// Whether a path is like a pattern, part by part; a `*` in a part matches any text without `/`.
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
    use std::io::Write;

    use super::*;

    #[test]
    fn a_pattern_stands_for_one_part_of_a_path() {
        for (pattern, path, expected) in [
            ("shard=*", "shard=00003", true),
            ("shard=*", "shard=", true),
            ("shard=*", "shard=1/2", false),
            ("shard=*", "thesis", false),
            ("a*a", "a", false),
            ("log", "log", true),
            ("log", "log.bak", false),
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
            let manifest = Manifest::of(&folder, &["shard=*", "log"]).unwrap();
            fs::write(folder.join(MANIFEST), manifest.text()).unwrap();
        };
        let add = |name: &str, text: &str| {
            let (below, name) = name.rsplit_once('/').unwrap_or(("", name));
            crate::added::add(&folder.join(below), name, |file| file.write_all(text.as_bytes()))
        };
        made();
        assert_eq!(foreign(&folder).unwrap(), None);
        fs::create_dir(folder.join("log")).unwrap();
        add("shard=00001/part.parquet", "rows").unwrap();
        add("summary.json", "{1}").unwrap();
        add("sweep.json", "{}").unwrap();
        assert_eq!(foreign(&folder).unwrap(), None, "a shard was added, and results");
        // Killed before the rename, the old content is there under the new hash.
        fs::write(folder.join("summary.json"), "{}").unwrap();
        assert_eq!(foreign(&folder).unwrap(), None);
        add("summary.json", "{2}").unwrap();
        remove(&folder).unwrap();
        assert!(!folder.exists());

        for name in [
            "notes.txt",
            "pictures/thesis.tex",
            ".git/",
            "shard=00001",
            ".a.partial-of-my-own",
            ".thesis.partial-host-1-1",
            "log/notes.txt",
            "shard=mine/part.parquet",
            "sweep.csv",
        ] {
            made();
            let put = folder.join(name);
            if let Some(parent) = put.parent() {
                fs::create_dir_all(parent).unwrap();
            }
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
        // Nor does what comes later replace it.
        made();
        for (name, text) in [("sweep.csv", "mine"), ("summary.json", "{mine}")] {
            fs::write(folder.join(name), text).unwrap();
            let refused = add(name, "of efam").unwrap_err().to_string();
            assert!(refused.contains(&format!("holds {name}, which ")), "{refused}");
            assert_eq!(fs::read_to_string(folder.join(name)).unwrap(), text);
            assert!(foreign(&folder).unwrap().is_some());
            add(name, text).unwrap();
            assert_eq!(foreign(&folder).unwrap(), None, "the same bytes are efam's");
        }
        fs::remove_dir_all(&folder).unwrap();
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
        let manifest = Manifest { files, ..Manifest::empty() };
        fs::write(folder.join(MANIFEST), manifest.text()).unwrap();
        assert_eq!(foreign(&folder).unwrap(), Some(Foreign::Unknown("pictures".into())));
        assert!(remove(&folder).is_err());
        assert!(photos.join("sea.jpg").exists() && photos.join("a.svg").exists());
        fs::remove_dir_all(&root).unwrap();
    }
}

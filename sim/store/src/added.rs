//! Files that come into a finished folder, or are written anew there, each stated in the manifest.

use std::cell::RefCell;
use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::Path;

use crate::StoreError;
use crate::atomic::{replaced, written};
use crate::disk::{self, File};
use crate::manifest::{Foreign, MANIFEST, Manifest, hash};
use crate::partial::wait_to_hold;

/// Writes a file into a folder that is finished, whole, and states it in the manifest there: before the file has its name,
/// so that none is ever without.
/// # Errors
/// [`StoreError::Foreign`] or [`StoreError::Changed`] if something is under that name that efam did not write; else
/// [`StoreError`]. What was there before is there still.
pub fn add(
    folder: &Path,
    name: &str,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<(), StoreError> {
    added(folder, name, write, true)
}

/// The same; what is under that name is replaced, whoever wrote it.
/// # Errors
/// [`StoreError`]; what was there before is there still.
pub fn replace(
    folder: &Path,
    name: &str,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<(), StoreError> {
    added(folder, name, write, false)
}

fn added(
    folder: &Path,
    name: &str,
    write: impl FnOnce(&mut File) -> io::Result<()>,
    keeps: bool,
) -> Result<(), StoreError> {
    let folder = if folder == Path::new("") { Path::new(".") } else { folder };
    let refused = RefCell::new(None);
    let written = written(&folder.join(name), write, |from, to| {
        let sha256 = hash(from)?;
        // Of two who add, the second states what the first has added.
        let _held = wait_to_hold(folder);
        if keeps && let Some(foreign) = known(folder, name, &sha256)? {
            *refused.borrow_mut() = Some(foreign);
            return Err(ErrorKind::AlreadyExists.into());
        }
        let mut manifest = Manifest::read(folder).unwrap_or_else(Manifest::empty);
        manifest.put(name, sha256);
        let text = manifest.text();
        replaced(&folder.join(MANIFEST), |file| file.write_all(text.as_bytes()), disk::rename)?;
        disk::rename(from, to)
    });
    match refused.into_inner() {
        Some(foreign) => Err(foreign.refuses(folder)),
        None => written,
    }
}

/// Why a file may not be replaced; nothing where efam wrote it, or none is there.
/// # Errors
/// [`Foreign`] if efam did not write what is there, and it is not the same; what the file system said.
fn known(folder: &Path, name: &str, sha256: &str) -> io::Result<Option<Foreign>> {
    let file = folder.join(name);
    let there = match fs::symlink_metadata(&file) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        // A link is not what efam wrote, and may lead to a device that never ends.
        Ok(there) if !there.is_file() => return Ok(Some(Foreign::Unknown(name.into()))),
        _ => hash(&file)?,
    };
    let manifest = Manifest::read(folder);
    let is_known = there == sha256 || manifest.as_ref().is_some_and(|own| own.has(name, &there));
    let is_listed = manifest.is_some_and(|own| own.states(name));
    let foreign = if is_listed { Foreign::Changed } else { Foreign::Unknown };
    Ok((!is_known).then(|| foreign(name.into())))
}

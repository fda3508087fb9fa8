//! Files that somebody named, read up to a bound: memory follows from the bound, whatever the file's length.

use std::fs::{self, File};
use std::io::{self, Read, Take};
use std::path::Path;

use crate::memory;
use crate::sha::Sha;

/// The longest scenario, experiment or muscle that is read, bytes.
pub const MOST_TEXT: u64 = 16 << 20;
/// The longest JSON of a run folder that is read, bytes: ten thousand releases with their cycles. In memory it takes
/// some ten times as much.
pub const MOST_JSON: u64 = 64 << 20;
/// Bytes of memory that a byte of a table takes until it is exported: as text, as cells, and as columns that are joined.
const TABLE: u64 = 8;

/// The text of a scenario, an experiment or a muscle. It may come through a pipe of the shell, as `/dev/stdin`.
/// # Errors
/// What the system said, or that the file is too long, or a named pipe.
pub fn text(path: &Path) -> io::Result<String> {
    up_to(path, MOST_TEXT)
}

/// The text of a file that has at most so many bytes.
/// # Errors
/// As [`text`].
pub fn up_to(path: &Path, most: u64) -> io::Result<String> {
    let mut text = String::new();
    open(path)?.take(most + 1).read_to_string(&mut text)?;
    if text.len() as u64 > most {
        Err(io::Error::other(format!("it has more than {most} bytes, the most that is read")))
    } else {
        Ok(text)
    }
}

/// The bytes of a table of results, where memory holds what becomes of them.
/// # Errors
/// What the system said, or that memory does not hold it.
pub fn table(path: &Path) -> io::Result<Vec<u8>> {
    let (mut file, length) = whole(path)?;
    match memory::available() {
        Some(free) if length.saturating_mul(TABLE) > free => {
            let [needed, free] = [TABLE * length, free].map(|bytes| bytes as f64 / 1e9);
            Err(io::Error::other(format!(
                "it takes some {needed:.1} GB of memory, and {free:.1} GB are free"
            )))
        }
        _ => {
            let mut bytes = Vec::with_capacity(length as usize);
            file.read_to_end(&mut bytes)?;
            Ok(bytes)
        }
    }
}

/// Opens a file that ends, and returns its length; no more is read if it grows. A link may lead to a device that never ends.
/// # Errors
/// What the system said, or that it is no file.
pub fn whole(path: &Path) -> io::Result<(Take<File>, u64)> {
    refuse_pipe(path)?;
    let there = fs::metadata(path)?;
    if !there.is_file() {
        return Err(io::Error::other("it is no file"));
    }
    Ok((File::open(path)?.take(there.len()), there.len()))
}

/// Opens a file to be read up to a bound.
/// # Errors
/// What the system said, or that it is a named pipe.
pub fn open(path: &Path) -> io::Result<File> {
    refuse_pipe(path)?;
    File::open(path)
}

/// SHA-256 of a file in hexadecimal, however long it is.
/// # Errors
/// As [`whole`].
pub fn sha256(path: &Path) -> io::Result<String> {
    let mut sha = Sha::default();
    io::copy(&mut whole(path)?.0, &mut sha)?;
    Ok(sha.hexadecimal())
}

/// A named pipe would be waited for until somebody writes to it. One of the shell has no name in the file system, and
/// its other end is there already.
#[cfg(unix)]
fn refuse_pipe(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::FileTypeExt;
    let is_pipe = fs::metadata(path).is_ok_and(|file| file.file_type().is_fifo());
    if is_pipe && fs::canonicalize(path).is_ok() {
        Err(io::Error::other("it is a named pipe; give a file, or the pipe as /dev/stdin"))
    } else {
        Ok(())
    }
}

#[cfg(not(unix))]
fn refuse_pipe(_: &Path) -> io::Result<()> {
    Ok(())
}

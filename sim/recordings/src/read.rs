//! From a file to a recording: its bytes, its format, its reader.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use efam_store::memory;

use super::cells::{Rows, decode, without_blanks};
use super::draft::{Draft, ReadOptions};
use super::error::{RecordingError, RecordingProblem};
use super::format::{self, Format};
use super::{Recording, c3d, columnar, motive, qualisys, tidy, trc, vicon};

/// The longest file that is read, bytes: three days of one marker at 100 Hz, or an hour of sixty.
const MOST_BYTES: u64 = 2 << 30;
/// Bytes of memory that a byte of a file takes until its releases are cut out. A sample of a marker takes 32 bytes,
/// 72 with an orientation, and some copies of those that are used; each has 20 bytes or so of a text. (A text that
/// is made to deceive takes 100, and [`columnar::MOST_EXPANSION`] is what Parquet may take.)
const MEMORY: u64 = 8;

/// Reads a recording; its format is told from what stands in it, not from its name.
/// # Errors
/// The file cannot be read, is in no known format, or does not hold together.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Recording, RecordingError> {
    let bytes = load(path).map_err(|problem| RecordingError { file: path.to_owned(), problem })?;
    parse(bytes, path, options)
}

/// Reads a recording from the bytes of a file; `source` is only its name.
/// # Errors
/// As for [`read`].
pub fn parse(bytes: Vec<u8>, source: &Path, options: &ReadOptions) -> Result<Recording, RecordingError> {
    let extension = source.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let draft = if bytes.is_empty() {
        Err(RecordingProblem::Empty)
    } else if bytes.starts_with(columnar::MAGIC) || matches!(&*extension, "parquet" | "pq") {
        columnar::read(bytes)
    } else if c3d::is_c3d(&bytes) || extension == "c3d" {
        c3d::read(&bytes)
    } else if let Some(problem) = another(&bytes, &extension) {
        Err(problem)
    } else {
        text(bytes, options)
    };
    let recording = draft.and_then(|draft| draft.finish(source, options));
    recording.map_err(|problem| RecordingError { file: source.to_owned(), problem })
}

fn load(path: &Path) -> Result<Vec<u8>, RecordingProblem> {
    let metadata = std::fs::metadata(path).map_err(RecordingProblem::Unreadable)?;
    if !metadata.is_file() {
        return Err(RecordingProblem::NotAFile);
    }
    admit(metadata.len(), memory::available())?;
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    // A file that still grows is read up to where it was.
    let file = File::open(path).map_err(RecordingProblem::Unreadable)?;
    file.take(metadata.len()).read_to_end(&mut bytes).map_err(RecordingProblem::Unreadable)?;
    Ok(bytes)
}

/// Whether a file of a length is read where so much memory is free, if that is known.
fn admit(bytes: u64, free: Option<u64>) -> Result<(), RecordingProblem> {
    let needed = MEMORY * bytes;
    match free {
        _ if bytes > MOST_BYTES => Err(RecordingProblem::TooLarge { bytes, most: MOST_BYTES }),
        Some(free) if needed > free => Err(RecordingProblem::NoMemory { bytes, needed, free }),
        _ => Ok(()),
    }
}

/// What other programs write that is no table, by its first bytes: what it is, and what to save instead.
const OTHERS: [(&[u8], &str, &str); 8] = [
    (b"PK\x03\x04", "an archive (zip)", "unpack it, and give the recording itself"),
    (
        b"\xd0\xcf\x11\xe0",
        "a spreadsheet of an old program (.xls)",
        "save it as CSV from the spreadsheet program",
    ),
    (b"\x89HDF", "HDF5", "save it as CSV, as DeepLabCut does beside it"),
    (b"MATLAB 5.0", "variables of MATLAB", "save them with writetable as CSV, or take Parquet"),
    (b"\x1f\x8b", "a compressed file (gzip)", "unpack it first"),
    (b"\x93NUMPY", "an array of numpy", "save it with savetxt, or give it to efam.Recording in Python"),
    (
        b"<?xml",
        "XML",
        "export a table of t, x and y: a project of Tracker or Kinovea has the points of its picture alone",
    ),
    (b"{", "JSON", "save it as a table, such as CSV"),
];

fn another(bytes: &[u8], extension: &str) -> Option<RecordingProblem> {
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let (_, what, remedy) = OTHERS.iter().find(|(first, ..)| start.starts_with(first))?;
    let is_of = |name: &[u8]| start.starts_with(b"PK") && bytes.windows(name.len()).any(|part| part == name);
    let (what, remedy) = match extension {
        "xlsx" | "xlsm" | "ods" => ("a spreadsheet", "save it as CSV from the spreadsheet program"),
        _ if is_of(b"xl/workbook") => ("a spreadsheet", "save it as CSV from the spreadsheet program"),
        "trk" | "trz" => {
            ("a project of Tracker", "in Tracker, export t, x and y by File > Export > Data File")
        }
        "kva" => ("a project of Kinovea", "in Kinovea, export its trajectories as a table"),
        _ => (*what, *remedy),
    };
    Some(RecordingProblem::NotRead { what: what.to_owned(), remedy })
}

fn text(bytes: Vec<u8>, options: &ReadOptions) -> Result<Draft, RecordingProblem> {
    let (mut text, finding) = decode(bytes)?;
    let tabs = without_blanks(&text);
    let is_strict = tabs.is_some();
    text = tabs.unwrap_or(text);
    let columns = options.columns.as_deref();
    let format = if columns.is_some() { Format::Tidy } else { format::of_text(&text)? };
    let rows = &mut Rows::new(&text);
    rows.is_strict = is_strict;
    let mut draft = match format {
        Format::ViconNexus => vicon::nexus(rows),
        Format::ViconLegacy => vicon::legacy(rows),
        Format::Motive => motive::read(rows),
        Format::Qualisys => qualisys::read(rows),
        Format::Trc => trc::read(rows),
        _ => tidy::read(rows, columns),
    }?;
    draft.findings.extend(finding);
    draft.findings.extend(is_strict.then(|| "cells are separated by blanks".to_owned()));
    Ok(draft)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_before_it_is_read() {
        assert!(admit(1 << 20, Some(8 << 20)).is_ok() && admit(MOST_BYTES, None).is_ok());
        let message = admit(1 << 30, Some(2 << 30)).unwrap_err().to_string();
        assert_eq!(
            message,
            "has 1.07 GB, which takes some 8.59 GB of memory, and 2.15 GB are free; cut it into shorter pieces, \
             or record it anew at a lower rate"
        );
        assert!(matches!(admit(MOST_BYTES + 1, None), Err(RecordingProblem::TooLarge { .. })));
    }
}

//! From a file to a recording: its bytes, its format, its reader.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use efam_store::memory;

use super::cells::{Rows, decode};
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
    } else {
        text(bytes)
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

fn text(bytes: Vec<u8>) -> Result<Draft, RecordingProblem> {
    let (text, finding) = decode(bytes)?;
    let format = format::of_text(&mut Rows::new(&text))?;
    let rows = &mut Rows::new(&text);
    let mut draft = match format {
        Format::ViconNexus => vicon::nexus(rows),
        Format::ViconLegacy => vicon::legacy(rows),
        Format::Motive => motive::read(rows),
        Format::Qualisys => qualisys::read(rows),
        Format::Trc => trc::read(rows),
        _ => tidy::read(rows),
    }?;
    draft.findings.extend(finding);
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

//! From a file to a recording: its bytes, its format, its reader.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::cells::{Rows, decode};
use super::error::{Problem, RecordingError};
use super::format::{self, Format};
use super::length::Length;
use super::{Recording, c3d, columnar, motive, qualisys, tidy, trc, vicon};

/// The longest file that is read, bytes. A sample of a marker takes 32 bytes, 72 with an orientation,
/// and each has a byte or more of the file. So reading takes at most some 100 bytes a byte (5 to 8 as a
/// rule, 2 to 4 of C3D), and [`columnar::MOST_EXPANSION`] of Parquet.
const MOST_BYTES: u64 = 2 << 30;

/// What the person knows better than the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Unit of the positions, whatever the file states.
    pub unit: Option<Length>,
    /// Samples a second, whatever the file states. Times then come from frame numbers or, where
    /// there are none, from counting.
    pub rate_hz: Option<f64>,
}

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
        Err(Problem::Empty)
    } else if bytes.starts_with(columnar::MAGIC) || matches!(&*extension, "parquet" | "pq") {
        columnar::read(bytes)
    } else if c3d::is_c3d(&bytes) || extension == "c3d" {
        c3d::read(&bytes)
    } else {
        text(&bytes)
    };
    let recording = draft.and_then(|draft| draft.finish(source, options));
    recording.map_err(|problem| RecordingError { file: source.to_owned(), problem })
}

fn load(path: &Path) -> Result<Vec<u8>, Problem> {
    let metadata = std::fs::metadata(path).map_err(Problem::Unreadable)?;
    if !metadata.is_file() {
        return Err(Problem::NotAFile);
    }
    if metadata.len() > MOST_BYTES {
        return Err(Problem::TooLarge { bytes: metadata.len(), most: MOST_BYTES });
    }
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    // A file that still grows is read up to where it was.
    let file = File::open(path).map_err(Problem::Unreadable)?;
    file.take(metadata.len()).read_to_end(&mut bytes).map_err(Problem::Unreadable)?;
    Ok(bytes)
}

fn text(bytes: &[u8]) -> Result<super::draft::Draft, Problem> {
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

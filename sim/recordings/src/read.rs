//! From a file to a recording: its bytes, its format, its reader.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use efam_store::memory;

use super::cells::{Rows, decode, is_wide, no_letter, without_blanks};
use super::draft::{Draft, ReadOptions};
use super::error::{RecordingError, RecordingProblem};
use super::format::{self, Format};
use super::kinovea::Trajectory;
use super::{Recording, c3d, columnar, kinovea, long, motive, qualisys, tidy, trc, vicon};

/// The longest file that is read, bytes: three days of one marker at 100 Hz, or an hour of sixty.
const MOST_BYTES: u64 = 2 << 30;
/// Bytes of memory that a byte of a file takes until its releases are cut out. A sample of a marker takes 32 bytes,
/// 72 with an orientation, and some copies of those that are used; each has 20 bytes or so of a text. (A text that
/// is made to deceive takes 100, and [`columnar::MOST_EXPANSION`] is what Parquet may take.)
const MEMORY: u64 = 8;
/// Bytes that are read before a file can be refused by them. All that shows a format is in the first.
const PIECE: u64 = 1 << 20;

/// Reads a recording; its format is detected from its content, not from its name.
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
    let extension = extension(source);
    let draft = if bytes.is_empty() {
        Err(RecordingProblem::Empty)
    } else if is_parquet(&bytes, &extension) {
        columnar::read(bytes)
    } else if is_c3d(&bytes, &extension) {
        c3d::read(&bytes)
    } else if let Some(problem) = another(&bytes, &extension) {
        Err(problem)
    } else {
        text(bytes, options)
    };
    let recording = draft.and_then(|draft| draft.finish(source, options));
    recording.map_err(|problem| RecordingError { file: source.to_owned(), problem })
}

pub(super) fn load(path: &Path) -> Result<Vec<u8>, RecordingProblem> {
    let metadata = std::fs::metadata(path).map_err(RecordingProblem::Unreadable)?;
    if !metadata.is_file() {
        return Err(RecordingProblem::NotAFile);
    }
    admit(metadata.len(), memory::available())?;
    let file = File::open(path).map_err(RecordingProblem::Unreadable)?;
    // A file that still grows is read up to where it was.
    until_refused(file.take(metadata.len()), &extension(path)).map_err(RecordingProblem::Unreadable)
}

/// All bytes of a file; of one that cannot be a recording those that show it.
fn until_refused(mut file: impl Read, extension: &str) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut is_text = true;
    loop {
        let begin = bytes.len();
        file.by_ref().take(PIECE).read_to_end(&mut bytes)?;
        if begin == bytes.len() {
            return Ok(bytes);
        }
        if begin == 0 {
            let is_other = is_parquet(&bytes, extension) || is_c3d(&bytes, extension);
            is_text = !is_other && !is_wide(&bytes);
            let is_refused = if is_other {
                !bytes.starts_with(columnar::MAGIC) && !c3d::is_c3d(&bytes)
            } else {
                another(&bytes, extension).is_some()
            };
            if is_refused {
                return Ok(bytes);
            }
        }
        if is_text && no_letter(&bytes[begin..]).is_some() {
            return Ok(bytes);
        }
    }
}

fn extension(source: &Path) -> String {
    source.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

fn is_parquet(bytes: &[u8], extension: &str) -> bool {
    bytes.starts_with(columnar::MAGIC) || matches!(extension, "parquet" | "pq")
}

fn is_c3d(bytes: &[u8], extension: &str) -> bool {
    c3d::is_c3d(bytes) || extension == "c3d"
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
    let (text, finding) = decode(bytes)?;
    let read = |own: Trajectory| -> Result<Draft, RecordingProblem> {
        let mut draft = one_text(own.text, finding.clone(), options)?;
        if let ([marker], Some(name)) = (&mut draft.markers[..], own.name) {
            marker.name = name;
        }
        Ok(draft)
    };
    let of_markers = options.columns.is_none().then(|| long::trajectories(&text)).into_iter().flatten();
    let mut drafts =
        kinovea::trajectories(&text).chain(of_markers).map(read).collect::<Result<Vec<Draft>, _>>()?;
    if drafts.len() < 2 {
        return drafts.pop().map_or_else(|| one_text(text, finding, options), Ok);
    }
    kinovea::merged(drafts, text.len()).ok_or_else(|| RecordingProblem::NotRead {
        what: "too many trajectories in the same columns, or some whose times do not ascend".to_owned(),
        remedy: "export each into a file of its own, or all as one table with columns for each",
    })
}

fn one_text(
    mut text: String,
    finding: Option<String>,
    options: &ReadOptions,
) -> Result<Draft, RecordingProblem> {
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

    #[test]
    fn several_trajectories_are_a_marker_each() {
        let rows = |from: usize, count: usize, x: usize| {
            (from..from + count).map(|k| format!("0.{k:02} {} 0\n", x + k)).collect::<String>()
        };
        let head = "#Kinovea Trajectory data export\n#T X Y\n";
        let read = |text: String, rate_hz: Option<f64>| {
            let options = ReadOptions { unit: Some(crate::Length::Metre), rate_hz, ..ReadOptions::default() };
            parse(text.into_bytes(), Path::new("a.txt"), &options)
        };
        for between in ["\n", "\r\n", "\n\n#T X Y\n"] {
            // The second one begins later, and ends earlier.
            let text = format!("{head}{}{between}{}", rows(0, 20, 0), rows(3, 9, 100));
            let read = read(text, None).unwrap();
            assert_eq!((read.time.len(), read.rate_hz, read.markers.len()), (20, 100.0, 2), "{between:?}");
            for k in 0..20usize {
                let at = [0, 1].map(|marker: usize| read.markers[marker].position[k].map(|at| at[0]));
                let second = (3..12).contains(&k).then_some(100.0 + k as f64);
                assert_eq!(at, [Some(k as f64), second], "{k}");
            }
            assert_ne!(read.markers[0].name, read.markers[1].name);
        }
        // Since 2023 each has its name above it, and numbers have the decimal sign of the program.
        let named = format!(
            "#Kinovea Trajectory data export\n#T X Y\n\n# Tip 1\n{}\n# base\n{}\n",
            rows(0, 20, 0),
            rows(3, 9, 100)
        );
        for text in [named.clone(), named.replace('.', ",")] {
            let read = read(text, None).unwrap();
            let names: Vec<&str> = read.markers.iter().map(|marker| marker.name.as_str()).collect();
            assert_eq!((names, read.rate_hz), (vec!["Tip 1", "base"], 100.0));
        }
        let alone =
            read(format!("#Kinovea Trajectory data export\n#T X Y\n\n# Tip 1\n{}", rows(0, 20, 0)), None);
        assert_eq!(alone.unwrap().markers[0].name, "Tip 1");
        let error = read(format!("{head}{}\n{}{}", rows(0, 9, 0), rows(5, 9, 0), rows(0, 9, 0)), None);
        assert!(error.unwrap_err().to_string().contains("whose times do not ascend"));
        // One of them, and a blank line at the end or in another program's table.
        let block = rows(0, 20, 0);
        for text in [format!("{head}{block}\n \n"), format!("t_s x y\n{block}\n0.21 1 1\n")] {
            assert_eq!(read(text, None).unwrap().markers.len(), 1);
        }
    }

    /// A file that never ends, as far as it is read.
    struct Endless(Vec<u8>, u64);

    impl Read for Endless {
        fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
            for place in to.iter_mut() {
                *place = *self.0.get(self.1 as usize).unwrap_or(&0);
                self.1 += 1;
            }
            Ok(to.len())
        }
    }

    #[test]
    fn a_file_that_is_refused_is_read_no_further() {
        let text = b"t_s,tip_x_mm,tip_z_mm\n0,1,2\n".to_vec();
        let long = text.iter().copied().cycle().take(5 << 20).collect::<Vec<u8>>();
        for (begin, extension, due) in [
            (text.clone(), "csv", PIECE),
            (long, "csv", 6 << 20),
            (b"PK\x03\x04".to_vec(), "csv", PIECE),
            (text.clone(), "parquet", PIECE),
            (text.clone(), "c3d", PIECE),
        ] {
            let mut file = Endless(begin, 0);
            let bytes = until_refused(file.by_ref(), extension).unwrap();
            assert_eq!((bytes.len() as u64, file.1), (due, due), "{extension}");
            let refused = parse(bytes, &Path::new("a").with_extension(extension), &ReadOptions::default());
            assert!(refused.is_err());
        }
        // What can be a recording is read to its end.
        let wide: Vec<u8> = [0xff, 0xfe].into_iter().chain(text.iter().flat_map(|byte| [*byte, 0])).collect();
        let parquet = [columnar::MAGIC, &[0; 3 << 20]].concat();
        for (bytes, extension) in [(text, "csv"), (wide, "csv"), (parquet, "csv")] {
            assert!(until_refused(&bytes[..], extension).unwrap() == bytes);
        }
    }
}

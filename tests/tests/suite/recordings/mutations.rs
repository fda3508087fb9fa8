//! Goal: no bytes make a reader panic or hang, or take memory beyond all measure.
//! Setup: small recordings of each format, with bytes changed, put in, taken out and cut off; and
//! bytes without any sense behind the first bytes of each format.
//! Expected: a recording that holds together, or an error with a message. What was found on the way
//! is kept below by name.

use std::path::Path;
use std::sync::LazyLock;

use efam_recordings::{Length, ReadOptions, parse};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;
use tests::recordings::{C3d, legacy, millimetres, motive, nexus, parquet, qualisys, tidy, trc};

use super::super::drawn;

/// One file of each format, with its extension.
static FILES: LazyLock<Vec<(&str, Vec<u8>)>> = LazyLock::new(|| {
    let mut files: Vec<(&str, Vec<u8>)> = vec![
        ("csv", tidy().into()),
        ("csv", tidy().replace(',', ";").replace('.', ",").into()),
        ("csv", nexus().into()),
        ("csv", legacy().into()),
        ("csv", motive().into()),
        ("tsv", qualisys().into()),
        ("trc", trc().into()),
        ("parquet", parquet()),
    ];
    for processor in [84, 85, 86] {
        files.extend([false, true].map(|floats| ("c3d", C3d::small(processor, floats).bytes(millimetres))));
    }
    files
});

/// Reads, and checks that what was read holds together.
fn holds(bytes: Vec<u8>, extension: &str) -> Result<(), TestCaseError> {
    let source = format!("a.{extension}");
    let length = bytes.len();
    let options = [
        ReadOptions::default(),
        ReadOptions { unit: Some(Length::Millimetre), rate_hz: Some(100.0), columns: None },
    ];
    for options in options {
        match parse(bytes.clone(), Path::new(&source), &options) {
            Err(error) => prop_assert!(error.to_string().len() > source.len() + 10),
            Ok(recording) => {
                prop_assert!(recording.rate_hz > 0.0 && recording.rate_hz.is_finite());
                prop_assert!(recording.time.len() >= 2);
                prop_assert!(recording.time.windows(2).all(|pair| pair[1] > pair[0]));
                for marker in &recording.markers {
                    prop_assert_eq!(marker.position.len(), recording.time.len());
                    marker.quality();
                }
                let numbers = recording.markers.len() * recording.time.len();
                prop_assert!(numbers <= 1000 * length, "{} numbers from {} bytes", numbers, length);
            }
        }
    }
    Ok(())
}

/// One change of a file.
#[derive(Clone, Debug)]
enum Change {
    Set(Index, u8),
    Insert(Index, Vec<u8>),
    Remove(Index, usize),
    Repeat(Index, usize),
    Cut(Index),
}

fn change() -> impl Strategy<Value = Change> {
    let of_text = prop::sample::select(b"0123456789-+.,;\t\n\r \"eExXnN\0\xff#".to_vec());
    let byte = prop_oneof![any::<u8>(), of_text];
    let at = any::<Index>;
    prop_oneof![
        6 => (at(), byte.clone()).prop_map(|(at, byte)| Change::Set(at, byte)),
        2 => (at(), vec(byte, 1..6)).prop_map(|(at, bytes)| Change::Insert(at, bytes)),
        2 => (at(), 1_usize..40).prop_map(|(at, count)| Change::Remove(at, count)),
        1 => (at(), 1_usize..200).prop_map(|(at, count)| Change::Repeat(at, count)),
        1 => at().prop_map(Change::Cut),
    ]
}

fn changed(mut bytes: Vec<u8>, changes: &[Change]) -> Vec<u8> {
    for change in changes {
        if bytes.is_empty() {
            break;
        }
        match change {
            Change::Set(at, byte) => {
                let at = at.index(bytes.len());
                bytes[at] = *byte;
            }
            Change::Insert(at, more) => {
                let at = at.index(bytes.len());
                bytes.splice(at..at, more.iter().copied());
            }
            Change::Remove(at, count) => {
                let at = at.index(bytes.len());
                bytes.drain(at..(at + count).min(bytes.len()));
            }
            Change::Repeat(at, count) => {
                let at = at.index(bytes.len());
                let again = bytes[at..(at + count).min(bytes.len())].to_vec();
                bytes.splice(at..at, again);
            }
            Change::Cut(at) => bytes.truncate(at.index(bytes.len())),
        }
    }
    bytes
}

/// Cases of each test; `PROPTEST_CASES=1000000` for a night.
fn cases() -> ProptestConfig {
    drawn(3000)
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn changed_files(file in any::<Index>(), changes in vec(change(), 1..8)) {
        let (extension, bytes) = &FILES[file.index(FILES.len())];
        holds(changed(bytes.clone(), &changes), extension)?;
    }

    /// Most bytes of a small C3D or Parquet file are data: these changes go to what is before or after.
    #[test]
    fn changed_headers(file in any::<Index>(), changes in vec((any::<Index>(), any::<u8>()), 1..6)) {
        let binary: Vec<_> = FILES.iter().filter(|(extension, _)| matches!(*extension, "c3d" | "parquet")).collect();
        let (extension, bytes) = binary[file.index(binary.len())];
        let mut bytes = bytes.clone();
        let header = if *extension == "c3d" { 0..24 } else { bytes.len().saturating_sub(400)..bytes.len() };
        for (at, byte) in changes {
            let at = header.start + at.index(header.len());
            bytes[at] = byte;
        }
        holds(bytes, extension)?;
    }

    #[test]
    fn bytes_without_sense(
        start in prop::sample::select(&[
            "", "\x02P", "PAR1", "Trajectories\n100\n", "TRAJECTORIES\n100,Hz\n", "Format Version,1\n", "NO_OF_FRAMES\t1\n",
            "PathFileType\t4\n", "t_s,tip_x_m,tip_z_m\n", "\u{feff}",
        ][..]),
        bytes in vec(any::<u8>(), 0..600),
        is_text in any::<bool>(),
    ) {
        let letters = b"0123456789.,,,;\t\t\n\n\rXYZeabFrame \"-";
        let rest = bytes.iter().map(|byte| if is_text { letters[usize::from(*byte) % letters.len()] } else { *byte });
        holds(start.bytes().chain(rest).collect(), "csv")?;
    }
}

/// Found: the parquet package panics where the place of a column is negative, anywhere in its footer.
#[test]
fn a_broken_footer_of_parquet() {
    let whole = parquet();
    let footer = u32::from_le_bytes(whole[whole.len() - 8..whole.len() - 4].try_into().unwrap()) as usize;
    for at in (whole.len() - 8 - footer..whole.len()).step_by(5) {
        let mut file = whole.clone();
        file[at] = 0xd7;
        holds(file, "parquet").unwrap();
    }
}

/// Found: arrow-ipc panics at a broken schema of Arrow, which is before the end of a Parquet file.
#[test]
fn a_broken_schema_of_arrow() {
    let whole = parquet();
    for from_end in 1..400 {
        let mut file = whole.clone();
        let at = file.len() - from_end;
        file[at] = b'E';
        holds(file, "parquet").unwrap();
    }
}

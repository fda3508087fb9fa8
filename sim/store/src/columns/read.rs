//! What [`crate::columns::ParquetFile`] wrote, read back.

use std::collections::BTreeMap;
use std::io::{self, Read, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use arrow_array::{Array, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_schema::{DataType, FieldRef};
use bytes::Bytes;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader};

use crate::columns::{Cells, Column, Holds, cause};
use crate::footer::{footer_of, look_through, look_through_footer};
use crate::input;

/// Nothing takes no room in a file: so much memory may cells take that its bytes do not show, and so many times its
/// length.
const MOST_CELLS: [usize; 2] = [64 << 20, 100];
/// Bytes at the end of a file that are read for its footer; one that is longer is read again.
const END: u64 = 64 << 10;

/// What a file says of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct About {
    /// Its key-value metadata.
    pub entries: BTreeMap<String, String>,
    /// Rows that it has.
    pub rows: usize,
}

/// What a file says of itself, without its rows.
/// # Errors
/// A file that cannot be read or is no Parquet.
pub fn about(path: &Path) -> io::Result<About> {
    guarded(|| {
        let end = end(path)?;
        let footer = footer_of(&end).map_err(io::Error::other)?;
        look_through_footer(footer).map_err(io::Error::other)?;
        let metadata = ParquetMetaDataReader::decode_metadata(footer).map_err(cause)?;
        let of_file = metadata.file_metadata();
        let entries = of_file.key_value_metadata().into_iter().flatten();
        let entries = entries.map(|entry| (entry.key.clone(), entry.value.clone().unwrap_or_default()));
        Ok(About { entries: entries.collect(), rows: rows(&metadata)? })
    })
}

/// All cells of a file that was written with these columns.
/// # Errors
/// A file that cannot be read, is no Parquet, or has other columns.
pub fn read(path: &Path, columns: &[Column]) -> io::Result<Vec<Cells>> {
    let found = table(path)?;
    if !found.iter().map(|found| &found.name).eq(columns.iter().map(|column| &column.name)) {
        return Err(io::Error::other("it has other columns"));
    }
    let kind = |cells: &Cells| std::mem::discriminant(cells);
    if found.iter().zip(columns).any(|(found, column)| kind(&found.cells) != kind(&column.holds.none())) {
        return Err(io::Error::other("its columns hold something else"));
    }
    Ok(found.into_iter().map(|found| found.cells).collect())
}

/// A column of a table as it was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Its name.
    pub name: String,
    /// Its unit, or nothing where there is none.
    pub unit: String,
    /// Its cells.
    pub cells: Cells,
}

/// All columns of a file, whatever they are.
/// # Errors
/// A file that cannot be read, is no Parquet, or has columns that [`crate::columns::ParquetFile`] does not write.
pub fn table(path: &Path) -> io::Result<Vec<Found>> {
    guarded(|| {
        // The schema of Arrow contains the units.
        let (reader, rows) = open(path)?;
        let kind = |field: &FieldRef| match field.data_type() {
            DataType::Int64 => Some(Holds::Counts),
            DataType::Utf8 => Some(Holds::Texts),
            DataType::Float64 => Some(Holds::NumbersOrNone),
            _ => None,
        };
        let begun = |field: &FieldRef| {
            let unknown = || io::Error::other(format!("its column {} holds something else", field.name()));
            let unit = field.metadata().get("unit").cloned().unwrap_or_default();
            let holds = kind(field).ok_or_else(unknown)?;
            Ok((Found { name: field.name().clone(), unit, cells: holds.none() }, holds))
        };
        let mut all = reader.schema().fields().iter().map(begun).collect::<io::Result<Vec<_>>>()?;
        for batch in reader.build().map_err(cause)? {
            let batch = batch.map_err(io::Error::other)?;
            for (k, (found, holds)) in all.iter_mut().enumerate() {
                let cells = cells(&batch, k, *holds);
                found.cells.append(cells.ok_or_else(|| io::Error::other("its columns hold something else"))?);
            }
        }
        if all.iter().all(|(found, _)| found.cells.len() == rows) {
            Ok(all.into_iter().map(|(found, _)| found).collect())
        } else {
            Err(io::Error::other(format!("it does not hold the {rows} rows that it states")))
        }
    })
}

/// Rows that a footer states, if it says the same of the whole file and of its groups.
fn rows(metadata: &ParquetMetaData) -> io::Result<usize> {
    let stated = metadata.file_metadata().num_rows();
    let of_groups: i128 = metadata.row_groups().iter().map(|group| i128::from(group.num_rows())).sum();
    match usize::try_from(stated) {
        Ok(rows) if i128::from(stated) == of_groups => Ok(rows),
        _ => Err(io::Error::other(format!("it states {stated} rows, and {of_groups} in its groups"))),
    }
}

/// The reader of pages panics where these do not hold together.
fn guarded<T>(read: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
    let read = catch_unwind(AssertUnwindSafe(read));
    read.unwrap_or_else(|_| Err(io::Error::other("its pages do not hold together")))
}

/// A file that holds what [`crate::columns::ParquetFile`] writes, and no more than its length allows; and its rows.
fn open(path: &Path) -> io::Result<(ParquetRecordBatchReaderBuilder<Bytes>, usize)> {
    let bytes = Bytes::from(input::table(path)?);
    look_through(&bytes, true).map_err(io::Error::other)?;
    let most = MOST_CELLS[0].saturating_add(bytes.len().saturating_mul(MOST_CELLS[1]));
    let opened = ParquetRecordBatchReaderBuilder::try_new(bytes).map_err(cause)?;
    let rows = rows(opened.metadata())?;
    let columns = opened.metadata().file_metadata().schema_descr().num_columns();
    if rows.saturating_mul(columns).saturating_mul(size_of::<Option<String>>()) > most {
        return Err(io::Error::other(format!(
            "it states {rows} rows of {columns} columns, which it cannot hold"
        )));
    }
    Ok((opened, rows))
}

/// The end of a file, with the whole footer in it if the file has one.
fn end(path: &Path) -> io::Result<Vec<u8>> {
    let (file, length) = input::whole(path)?;
    let mut file = file.into_inner();
    let mut last = |count: u64| {
        let mut bytes = Vec::new();
        file.seek(SeekFrom::Start(length - count.min(length)))?;
        file.by_ref().take(count).read_to_end(&mut bytes)?;
        io::Result::Ok(bytes)
    };
    let bytes = last(END)?;
    match bytes.last_chunk::<8>() {
        Some([a, b, c, d, ..]) if footer_of(&bytes).is_err() => {
            last(u64::from(u32::from_le_bytes([*a, *b, *c, *d])) + 8)
        }
        _ => Ok(bytes),
    }
}

fn cells(batch: &RecordBatch, column: usize, holds: Holds) -> Option<Cells> {
    let array = batch.column(column).as_any();
    Some(match holds {
        Holds::Numbers | Holds::NumbersOrNone | Holds::Nothing => {
            let numbers = array.downcast_ref::<Float64Array>()?;
            Cells::Numbers(numbers.iter().map(|number| number.unwrap_or(f64::NAN)).collect())
        }
        Holds::Counts => Cells::Counts(array.downcast_ref::<Int64Array>()?.values().to_vec()),
        Holds::Texts => {
            let texts = array.downcast_ref::<StringArray>()?;
            Cells::Texts(texts.iter().map(|text| text.map(str::to_owned)).collect())
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    use crate::columns::{CsvFile, ParquetFile};

    fn columns() -> Vec<Column> {
        let column = |name: &str, unit, holds| Column { name: name.to_owned(), unit, holds };
        vec![
            column("point", "", Holds::Counts),
            column("z_m", "m", Holds::NumbersOrNone),
            column("reason", "", Holds::Texts),
        ]
    }

    fn rows() -> Vec<Cells> {
        vec![
            Cells::Counts(vec![0, (1 << 53) - 1]),
            Cells::Numbers(vec![0.1 + 0.2, -1e-300]),
            Cells::Texts(vec![None, Some("a, \"b\"\nc".to_owned())]),
        ]
    }

    #[test]
    fn what_was_written_is_read_to_the_same_bits() {
        let path = std::env::temp_dir().join(format!("efam-columns-{}.parquet", std::process::id()));
        let mut file =
            ParquetFile::begin(File::create(&path).unwrap(), &columns(), &[("plan", "abc".to_owned())])
                .unwrap();
        file.write(rows()).unwrap();
        file.write(rows()).unwrap();
        file.finish().unwrap();
        let mut twice = rows();
        twice.iter_mut().zip(rows()).for_each(|(own, more)| own.append(more));
        assert_eq!(read(&path, &columns()).unwrap(), twice);
        let found = table(&path).unwrap();
        assert_eq!(found.iter().map(|column| column.cells.clone()).collect::<Vec<_>>(), twice);
        assert_eq!((found[1].name.as_str(), found[1].unit.as_str()), ("z_m", "m"));
        let said = about(&path).unwrap();
        assert_eq!((said.rows, said.entries["plan"].as_str()), (4, "abc"));
        assert!(read(&path, &columns()[..2]).unwrap_err().to_string().contains("other columns"));
        // Cut short, it is refused.
        let bytes = std::fs::read(&path).unwrap();
        for length in [0, 3, bytes.len() / 2, bytes.len() - 1] {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert!(about(&path).is_err() && read(&path, &columns()).is_err(), "{length}");
            assert!(table(&path).is_err(), "{length}");
        }
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn texts_stand_in_csv_as_they_should() {
        let mut text = Vec::new();
        let mut file = CsvFile::begin(&mut text, &columns()).unwrap();
        file.write(&rows()).unwrap();
        file.finish().unwrap();
        let expected =
            "point,z_m,reason\n0,0.30000000000000004,\n9007199254740991,-1e-300,\"a, \"\"b\"\"\nc\"\n";
        assert_eq!(String::from_utf8(text).unwrap(), expected);
    }
}

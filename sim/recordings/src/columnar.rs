//! Tidy tables in Parquet, such as a run's own `trajectory.parquet`.

use std::collections::{BTreeMap, BTreeSet};

use arrow_array::{Array, Float32Array, Float64Array, Int32Array, Int64Array, RecordBatch};
use arrow_schema::{DataType, Schema};
use bytes::Bytes;
use efam_store::footer::look_through;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ArrowReaderOptions, ParquetRecordBatchReaderBuilder};
use parquet::file::metadata::ParquetMetaData;

use super::draft::Draft;
use super::error::RecordingProblem;
use super::format::Format;
use super::layout::Layout;
use super::tidy;

/// First bytes of a file.
pub(super) use efam_store::footer::MAGIC;

/// Numbers in a column that repeat themselves take next to no room in a file; so many times its
/// length is read, in bytes.
pub(super) const MOST_EXPANSION: usize = 1000;

/// Reads a file.
pub(super) fn read(bytes: Vec<u8>) -> Result<Draft, RecordingProblem> {
    // What is known to make the reader of pages panic is refused before; this is for the rest.
    let read = std::panic::catch_unwind(|| read_checked(bytes));
    read.unwrap_or_else(|_| Err(RecordingProblem::Parquet("its pages do not hold together".to_owned())))
}

fn read_checked(bytes: Vec<u8>) -> Result<Draft, RecordingProblem> {
    if !bytes.starts_with(MAGIC) {
        let start: Vec<String> = bytes.iter().take(4).map(|byte| format!("{byte:#04x}")).collect();
        return Err(RecordingProblem::Parquet(format!("it begins with {}, not with PAR1", start.join(" "))));
    }
    let broken = |error: &dyn std::fmt::Display| RecordingProblem::Parquet(error.to_string());
    look_through(&bytes, false).map_err(RecordingProblem::Parquet)?;
    let length = bytes.len();
    let most = length.saturating_mul(MOST_EXPANSION);
    // The schema of Arrow that may be beside that of Parquet adds nothing here, and its reader
    // panics where it is broken.
    let options = ArrowReaderOptions::new().with_skip_arrow_metadata(true);
    let builder = ParquetRecordBatchReaderBuilder::try_new_with_options(Bytes::from(bytes), options)
        .map_err(|error| broken(&error))?;
    let names: Vec<String> = builder.schema().fields().iter().map(|field| field.name().clone()).collect();
    let mut layout = tidy::layout(&names, Format::Parquet)?;
    let wanted: BTreeSet<usize> = layout.columns().collect();
    check(builder.schema(), &wanted)?;
    let rows = rows(builder.metadata(), length)?;
    if rows.saturating_mul(8 * wanted.len()) > most {
        let columns = wanted.len();
        return Err(RecordingProblem::Parquet(format!(
            "it states {rows} rows of {columns} columns, which it cannot hold"
        )));
    }
    let mask = ProjectionMask::roots(builder.parquet_schema(), wanted.iter().copied());
    let reader = builder.with_projection(mask).build().map_err(|error| broken(&error))?;

    // Columns that are read are in the order of the file, without the others.
    let places: BTreeMap<usize, usize> =
        wanted.iter().enumerate().map(|(place, column)| (*column, place)).collect();
    let place = |column: usize| places[&column];
    layout.frame = layout.frame.map(place);
    layout.time = layout.time.map(|(column, second)| (place(column), second));
    for point in &mut layout.points {
        point.position = point.position.map(|column| column.map(place));
        point.orientation = point.orientation.map(|columns| columns.map(place));
    }
    let mut draft = layout.draft("row");
    for batch in reader {
        let batch = batch.map_err(|error| broken(&error))?;
        add(&layout, &batch, &mut draft)?;
        if draft.places.len() > rows {
            return Err(RecordingProblem::Parquet(format!(
                "it has more rows than the {rows} that it states"
            )));
        }
    }
    if draft.places.is_empty() {
        return Err(RecordingProblem::Parquet("it has no rows".to_owned()));
    }
    Ok(draft)
}

/// Rows that are stated, with all places of columns checked against the length of the file.
fn rows(metadata: &ParquetMetaData, length: usize) -> Result<usize, RecordingProblem> {
    let broken = |what: &str| RecordingProblem::Parquet(format!("its {what} is beyond its end"));
    let within = |value: i64| usize::try_from(value).ok().filter(|value| *value <= length);
    let mut rows = 0_usize;
    for group in metadata.row_groups() {
        let more = usize::try_from(group.num_rows()).map_err(|_| broken("count of rows"))?;
        rows = rows.saturating_add(more);
        for column in group.columns() {
            let first = column.dictionary_page_offset().unwrap_or(column.data_page_offset());
            let end = within(first).zip(within(column.compressed_size())).map(|(first, size)| first + size);
            if end.is_none_or(|end| end > length) || within(column.data_page_offset()).is_none() {
                return Err(broken(&format!("column {}", column.column_path().string())));
            }
            if column.num_values() < 0 {
                return Err(broken("count of values"));
            }
        }
    }
    let stated = usize::try_from(metadata.file_metadata().num_rows()).unwrap_or(usize::MAX);
    Ok(rows.max(stated))
}

/// Whether columns hold numbers.
fn check(schema: &Schema, wanted: &BTreeSet<usize>) -> Result<(), RecordingProblem> {
    for column in wanted {
        let field = schema.field(*column);
        let is_number = matches!(
            field.data_type(),
            DataType::Float64 | DataType::Float32 | DataType::Int64 | DataType::Int32
        );
        if !is_number {
            let (column, kind) = (field.name().clone(), field.data_type().to_string());
            return Err(RecordingProblem::ColumnType { column, kind });
        }
    }
    Ok(())
}

fn add(layout: &Layout, batch: &RecordBatch, draft: &mut Draft) -> Result<(), RecordingProblem> {
    let columns: Vec<Vec<Option<f64>>> = batch.columns().iter().map(|column| numbers(column)).collect();
    let schema = batch.schema();
    layout.rows(&|column| schema.field(column).name().clone(), &columns, draft)
}

/// The numbers of a column; nothing where one is null or not finite.
fn numbers(column: &dyn Array) -> Vec<Option<f64>> {
    let any = column.as_any();
    let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
    if let Some(array) = any.downcast_ref::<Float64Array>() {
        return array.iter().map(finite).collect();
    }
    if let Some(array) = any.downcast_ref::<Float32Array>() {
        return array.iter().map(|value| finite(value.map(f64::from))).collect();
    }
    if let Some(array) = any.downcast_ref::<Int64Array>() {
        return array.iter().map(|value| value.map(|value| value as f64)).collect();
    }
    match any.downcast_ref::<Int32Array>() {
        Some(array) => array.iter().map(|value| value.map(f64::from)).collect(),
        None => vec![None; column.len()],
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use arrow_array::{ArrayRef, StringArray};
    use parquet::arrow::ArrowWriter;

    use super::*;
    use crate::{ReadOptions, Recording, RecordingError, parse};

    fn table(columns: Vec<(&str, ArrayRef)>) -> Result<Recording, RecordingError> {
        let batch = RecordBatch::try_from_iter(columns).unwrap();
        let mut file = Vec::new();
        let mut writer = ArrowWriter::try_new(&mut file, batch.schema(), None).unwrap();
        writer.write(&batch).unwrap();
        writer.close().unwrap();
        parse(file, Path::new("a.parquet"), &ReadOptions::default())
    }

    #[test]
    fn other_kinds_of_numbers_and_nulls() {
        let recording = table(vec![
            ("note", Arc::new(StringArray::from(vec!["a", "b", "c"]))),
            ("t_ms", Arc::new(Int64Array::from(vec![0, 10, 20]))),
            ("tip_z_mm", Arc::new(Float32Array::from(vec![Some(1.5), None, Some(f32::NAN)]))),
            ("tip_x_mm", Arc::new(Int32Array::from(vec![100, 101, 102]))),
        ]);
        let recording = recording.unwrap();
        assert_eq!(recording.time, [0.0, 0.01, 0.02]);
        assert_eq!(recording.markers[0].position, [Some([0.1, 0.0, 0.0015]), None, None]);
    }

    /// Eight times as many columns take 8 times as long if all is linear, and 64 times if all are compared with all.
    #[test]
    #[ignore = "long; .ci/thorough runs it"]
    fn time_grows_with_the_number_of_columns_and_no_faster() {
        let file = |markers: usize| {
            let names = (0..markers).flat_map(|k| ["x", "y", "z"].map(|axis| format!("m{k}_{axis}_m")));
            let values: ArrayRef = Arc::new(Float64Array::from(vec![0.25, 0.5]));
            let time: ArrayRef = Arc::new(Float64Array::from(vec![0.0, 1.0]));
            let columns =
                [("t_s".to_owned(), time)].into_iter().chain(names.map(|name| (name, values.clone())));
            let batch = RecordBatch::try_from_iter(columns).unwrap();
            let mut file = Vec::new();
            let mut writer = ArrowWriter::try_new(&mut file, batch.schema(), None).unwrap();
            writer.write(&batch).unwrap();
            writer.close().unwrap();
            file
        };
        let time = |file: &Vec<u8>| {
            let (bytes, begin) = (file.clone(), std::time::Instant::now());
            parse(bytes, Path::new("a.parquet"), &ReadOptions::default()).unwrap();
            begin.elapsed().as_secs_f64()
        };
        let files = [2_000, 16_000].map(file);
        // The machine has other work at times: the shortest of each, measured in turns.
        let [few, many] = (0..4)
            .fold([f64::INFINITY; 2], |least, _| std::array::from_fn(|k| least[k].min(time(&files[k]))));
        assert!(many / few < 22.0, "{:.1} times as long for 8 times as many columns", many / few);
    }

    #[test]
    fn columns_without_numbers_are_named() {
        let error = table(vec![
            ("t_s", Arc::new(Float64Array::from(vec![0.0, 1.0]))),
            ("tip_x_m", Arc::new(StringArray::from(vec!["0.1", "0.2"]))),
            ("tip_z_m", Arc::new(Float64Array::from(vec![0.0, 1.0]))),
        ]);
        let expected =
            "a.parquet: column tip_x_m is of type Utf8; it must hold numbers; convert it before saving";
        assert_eq!(error.unwrap_err().to_string(), expected);
    }

    #[test]
    fn rows_that_the_file_cannot_hold_are_refused() {
        // A million times the same number takes some hundred bytes.
        let zeros: ArrayRef = Arc::new(Float64Array::from(vec![0.0; 1_000_000]));
        let error = table(vec![("t_s", zeros.clone()), ("tip_x_m", zeros.clone()), ("tip_z_m", zeros)]);
        let message = error.unwrap_err().to_string();
        assert!(message.contains("it states 1000000 rows of 3 columns, which it cannot hold"), "{message}");
    }
}

//! Numbers in columns, each with its unit, as Parquet and as CSV.

use std::io::{self, BufWriter, Write};
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name with unit, such as `tip_z_m`.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// What it holds.
    pub holds: Holds,
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// A number in each row.
    Numbers,
    /// A number, or none where it is not a number.
    NumbersOrNone,
    /// Nothing, whatever is written.
    Nothing,
}

/// A file in Parquet, compressed by Snappy, with the unit of each column in its metadata under `unit`.
pub struct ParquetFile<W: Write + Send> {
    writer: ArrowWriter<W>,
    schema: Arc<Schema>,
    holds: Vec<Holds>,
}

impl<W: Write + Send> ParquetFile<W> {
    /// Begins it; `about` becomes its key-value metadata.
    /// # Errors
    /// What the writer met.
    pub fn begin(to: W, columns: &[Column], about: &[(&str, String)]) -> io::Result<Self> {
        let schema = Arc::new(Schema::new(columns.iter().map(field).collect::<Vec<_>>()));
        let entries = about.iter().map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone()));
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_dictionary_enabled(false) // hardly any number comes twice
            .set_key_value_metadata(Some(entries.collect()))
            .build();
        let writer = ArrowWriter::try_new(to, schema.clone(), Some(properties)).map_err(cause)?;
        Ok(Self { writer, schema, holds: columns.iter().map(|column| column.holds).collect() })
    }

    /// Writes some rows, column by column.
    /// # Errors
    /// What the writer met.
    pub fn write(&mut self, columns: Vec<Vec<f64>>) -> io::Result<()> {
        let arrays = self.holds.iter().zip(columns).map(|(holds, values)| -> ArrayRef {
            Arc::new(match holds {
                Holds::Numbers => Float64Array::from(values),
                Holds::NumbersOrNone => values.into_iter().map(number).collect(),
                Holds::Nothing => Float64Array::new_null(values.len()),
            })
        });
        let batch =
            RecordBatch::try_new(self.schema.clone(), arrays.collect()).expect("columns of one length");
        self.writer.write(&batch).and_then(|()| self.writer.flush()).map_err(cause)
    }

    /// Ends it.
    /// # Errors
    /// What the writer met.
    pub fn finish(self) -> io::Result<()> {
        self.writer.close().map(|_| ()).map_err(cause)
    }
}

/// The same as text; numbers read back to the same bits.
pub struct CsvFile<W: Write> {
    to: BufWriter<W>,
    holds: Vec<Holds>,
}

impl<W: Write> CsvFile<W> {
    /// Begins it with a line of names.
    /// # Errors
    /// What the writer met.
    pub fn begin(to: W, columns: &[Column]) -> io::Result<Self> {
        let mut to = BufWriter::new(to);
        let names: Vec<_> = columns.iter().map(|column| column.name.as_str()).collect();
        writeln!(to, "{}", names.join(","))?;
        Ok(Self { to, holds: columns.iter().map(|column| column.holds).collect() })
    }

    /// Writes some rows, column by column.
    /// # Errors
    /// What the writer met.
    pub fn write(&mut self, columns: &[Vec<f64>]) -> io::Result<()> {
        for row in 0..columns[0].len() {
            for (k, (holds, values)) in self.holds.iter().zip(columns).enumerate() {
                let comma = if k > 0 { "," } else { "" };
                match (holds, number(values[row])) {
                    (Holds::Nothing, _) | (Holds::NumbersOrNone, None) => write!(self.to, "{comma}")?,
                    _ => write!(self.to, "{comma}{:?}", values[row])?,
                }
            }
            writeln!(self.to)?;
        }
        Ok(())
    }

    /// Ends it.
    /// # Errors
    /// What the writer met.
    pub fn finish(mut self) -> io::Result<()> {
        self.to.flush()
    }
}

fn number(value: f64) -> Option<f64> {
    Some(value).filter(|value| !value.is_nan())
}

fn field(column: &Column) -> Field {
    let unit = [("unit".to_owned(), column.unit.to_owned())].into();
    Field::new(&column.name, DataType::Float64, column.holds != Holds::Numbers).with_metadata(unit)
}

/// What the file system said, where it was that.
fn cause(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(inner) => match inner.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(inner) => io::Error::other(inner),
        },
        error => io::Error::other(error),
    }
}

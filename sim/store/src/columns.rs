//! Columns, each with its unit, as Parquet and as CSV: numbers, counts, texts.

mod read;

use std::fmt::Write as _;
use std::io::{self, Write};
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;

use crate::escape::cell;

pub use read::{About, Found, about, read, table};

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name with unit, such as `tip_z_m`.
    pub name: String,
    /// SI unit; empty if dimensionless.
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
    /// A whole number in each row.
    Counts,
    /// A text in each row, or none.
    Texts,
}

/// The cells of a column in some rows.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// Numbers; not a number where there is none.
    Numbers(Vec<f64>),
    /// Whole numbers.
    Counts(Vec<i64>),
    /// Texts.
    Texts(Vec<Option<String>>),
}

/// One cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A number; not a number where there is none.
    Number(f64),
    /// A whole number.
    Count(i64),
    /// A text, or none.
    Text(Option<String>),
}

impl From<Vec<f64>> for Cells {
    fn from(numbers: Vec<f64>) -> Self {
        Cells::Numbers(numbers)
    }
}

impl Holds {
    /// No cell of it yet.
    pub fn none(self) -> Cells {
        match self {
            Holds::Numbers | Holds::NumbersOrNone | Holds::Nothing => Cells::Numbers(Vec::new()),
            Holds::Counts => Cells::Counts(Vec::new()),
            Holds::Texts => Cells::Texts(Vec::new()),
        }
    }
}

impl Cells {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Cells::Numbers(all) => all.len(),
            Cells::Counts(all) => all.len(),
            Cells::Texts(all) => all.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Puts one more of the same kind behind them.
    /// # Panics
    /// If it is of another kind.
    pub fn push(&mut self, cell: Cell) {
        match (self, cell) {
            (Cells::Numbers(own), Cell::Number(number)) => own.push(number),
            (Cells::Counts(own), Cell::Count(count)) => own.push(count),
            (Cells::Texts(own), Cell::Text(text)) => own.push(text),
            _ => panic!("cells of one column are of one kind"),
        }
    }

    /// Puts others of the same kind behind them.
    /// # Panics
    /// If they are of another kind.
    pub fn append(&mut self, others: Cells) {
        match (self, others) {
            (Cells::Numbers(own), Cells::Numbers(others)) => own.extend(others),
            (Cells::Counts(own), Cells::Counts(others)) => own.extend(others),
            (Cells::Texts(own), Cells::Texts(others)) => own.extend(others),
            _ => panic!("cells of one column are of one kind"),
        }
    }

    /// Takes away the first of them.
    pub fn take(&mut self, count: usize) -> Cells {
        fn first<T>(all: &mut Vec<T>, count: usize) -> Vec<T> {
            let rest = all.split_off(count.min(all.len()));
            std::mem::replace(all, rest)
        }
        match self {
            Cells::Numbers(all) => Cells::Numbers(first(all, count)),
            Cells::Counts(all) => Cells::Counts(first(all, count)),
            Cells::Texts(all) => Cells::Texts(first(all, count)),
        }
    }

    /// Those of some rows.
    pub fn some(&self, rows: &[usize]) -> Cells {
        match self {
            Cells::Numbers(all) => Cells::Numbers(rows.iter().map(|row| all[*row]).collect()),
            Cells::Counts(all) => Cells::Counts(rows.iter().map(|row| all[*row]).collect()),
            Cells::Texts(all) => Cells::Texts(rows.iter().map(|row| all[*row].clone()).collect()),
        }
    }

    /// As numbers; none of texts.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        let (numbers, counts): (&[f64], &[i64]) = match self {
            Cells::Numbers(all) => (all, &[]),
            Cells::Counts(all) => (&[], all),
            Cells::Texts(_) => (&[], &[]),
        };
        numbers.iter().copied().chain(counts.iter().map(|count| *count as f64))
    }

    fn array(self, holds: Holds) -> ArrayRef {
        match (self, holds) {
            (cells, Holds::Nothing) => Arc::new(Float64Array::new_null(cells.len())),
            (Cells::Numbers(all), Holds::NumbersOrNone) => {
                Arc::new(all.into_iter().map(number).collect::<Float64Array>())
            }
            (Cells::Numbers(all), _) => Arc::new(Float64Array::from(all)),
            (Cells::Counts(all), _) => Arc::new(Int64Array::from(all)),
            (Cells::Texts(all), _) => Arc::new(StringArray::from(all)),
        }
    }

    /// Writes a cell as CSV has it, unquoted; nothing where there is none.
    fn tell(&self, holds: Holds, row: usize, to: &mut String) {
        let _ = match self {
            Cells::Numbers(_) if holds == Holds::Nothing => Ok(()),
            Cells::Numbers(all) if holds == Holds::NumbersOrNone && all[row].is_nan() => Ok(()),
            Cells::Numbers(all) => write!(to, "{:?}", all[row]),
            Cells::Counts(all) => write!(to, "{}", all[row]),
            Cells::Texts(all) => to.write_str(&cell(all[row].as_deref().unwrap_or_default())),
        };
    }
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
    /// An error of the writer.
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
    /// An error of the writer.
    pub fn write(&mut self, columns: Vec<Cells>) -> io::Result<()> {
        let arrays = self.holds.iter().zip(columns).map(|(holds, cells)| cells.array(*holds));
        let batch = RecordBatch::try_new(self.schema.clone(), arrays.collect())
            .expect("columns of one length and of what they hold");
        self.writer.write(&batch).and_then(|()| self.writer.flush()).map_err(cause)
    }

    /// Ends it.
    /// # Errors
    /// An error of the writer.
    pub fn finish(self) -> io::Result<()> {
        self.writer.close().map(|_| ()).map_err(cause)
    }
}

/// The same as text; numbers read back to the same bits.
pub struct CsvFile<W: Write> {
    to: csv::Writer<W>,
    holds: Vec<Holds>,
    cell: String,
}

impl<W: Write> CsvFile<W> {
    /// Begins it with a line of names.
    /// # Errors
    /// An error of the writer.
    pub fn begin(to: W, columns: &[Column]) -> io::Result<Self> {
        let mut to = csv::Writer::from_writer(to);
        to.write_record(columns.iter().map(|column| cell(&column.name).into_owned()))?;
        Ok(Self { to, holds: columns.iter().map(|column| column.holds).collect(), cell: String::new() })
    }

    /// Writes some rows, column by column.
    /// # Errors
    /// An error of the writer.
    pub fn write(&mut self, columns: &[Cells]) -> io::Result<()> {
        for row in 0..columns[0].len() {
            for (holds, cells) in self.holds.iter().zip(columns) {
                self.cell.clear();
                cells.tell(*holds, row, &mut self.cell);
                self.to.write_field(&self.cell)?;
            }
            self.to.write_record(None::<&[u8]>)?;
        }
        Ok(())
    }

    /// Ends it.
    /// # Errors
    /// An error of the writer.
    pub fn finish(mut self) -> io::Result<()> {
        self.to.flush()
    }
}

fn number(value: f64) -> Option<f64> {
    Some(value).filter(|value| !value.is_nan())
}

fn field(column: &Column) -> Field {
    let unit = [("unit".to_owned(), column.unit.to_owned())].into();
    let (kind, may_lack) = match column.holds {
        Holds::Numbers => (DataType::Float64, false),
        Holds::NumbersOrNone | Holds::Nothing => (DataType::Float64, true),
        Holds::Counts => (DataType::Int64, false),
        Holds::Texts => (DataType::Utf8, true),
    };
    Field::new(&column.name, kind, may_lack).with_metadata(unit)
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

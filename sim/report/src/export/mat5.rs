//! MAT of version 5, which scipy reads: the same structs as in the version 7.3 of [`crate::export::mat`].
//!
//! An element is a tag of its type and its length, and bytes up to a multiple of eight. A matrix has its class, its
//! shape and its name before its numbers; a struct has the names of its fields, and a matrix for each.
//!
//! Source: MathWorks, MAT-File Format, chapter 1, Level 5 MAT-Files.

use std::io::{self, Write};

use crate::export::mat::{MOST_LETTERS, columns, words};
use crate::export::stored::{Cells, Series, Stored, Table};
use crate::linear::{LinearAnswer, Matrices, SignalAnswer};

/// Types of elements.
const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
/// Classes of matrices.
const OF_FIELDS: u32 = 2;
const OF_LETTERS: u32 = 4;
const OF_DOUBLES: u32 = 6;

/// A value of MATLAB.
#[derive(Clone)]
enum Value {
    /// Column by column.
    Matrix {
        rows: usize,
        width: usize,
        numbers: Vec<f64>,
    },
    Text(String),
    Struct(Vec<(String, Value)>),
}

/// Writes the file.
/// # Errors
/// What the file system says, and a table of more than 4 GB, which this format has no place for.
pub(super) fn write(run: &Stored, to: impl Write) -> io::Result<()> {
    file(variables(run), to)
}

/// Writes a linear model: `m = load("linear.mat"); sys = ss(m.A, m.B, m.C, m.D);`, and as much in the structs `discrete`,
/// `reduced` and `reduced_discrete`, as far as there are such. `inputs`, `outputs` and `states` have a name a line.
/// # Errors
/// What the file system says.
pub(crate) fn linear_mat(answer: &LinearAnswer, to: impl Write) -> io::Result<()> {
    let matrix = |rows: &[Vec<f64>]| {
        let width = rows.first().map_or(0, Vec::len);
        let numbers = (0..width).flat_map(|k| rows.iter().map(move |row| row[k])).collect();
        Value::Matrix { rows: rows.len(), width, numbers }
    };
    let matrices = |of: &Matrices| {
        let all = [("A", &of.a), ("B", &of.b), ("C", &of.c), ("D", &of.d)];
        all.map(|(name, rows)| (name.to_owned(), matrix(rows))).to_vec()
    };
    let names = |all: &[SignalAnswer]| {
        let names: Vec<&str> = all.iter().map(|own| own.name.as_str()).collect();
        Value::Text(names.join("\n"))
    };
    let sampled = |of: &Matrices| {
        let sample = answer.sample_s.map(|sample| ("sample_s".to_owned(), matrix(&[vec![sample]])));
        Value::Struct(matrices(of).into_iter().chain(sample).collect())
    };
    let mut variables = matrices(&answer.continuous);
    for (name, all) in [("inputs", &answer.inputs), ("outputs", &answer.outputs), ("states", &answer.states)]
    {
        variables.push((name.to_owned(), names(all)));
        let at_rest: Vec<Vec<f64>> = all.iter().map(|own| vec![own.at_rest]).collect();
        variables.push((format!("{name}_at_rest"), matrix(&at_rest)));
    }
    variables.push(("static_gain".to_owned(), matrix(&answer.static_gain)));
    variables.extend(answer.discrete.as_ref().map(|own| ("discrete".to_owned(), sampled(own))));
    if let Some(reduced) = &answer.reduced {
        variables.push(("reduced".to_owned(), Value::Struct(matrices(&reduced.continuous))));
        let discrete = reduced.discrete.as_ref();
        variables.extend(discrete.map(|own| ("reduced_discrete".to_owned(), sampled(own))));
    }
    file(variables, to)
}

fn file(variables: Vec<(String, Value)>, mut to: impl Write) -> io::Result<()> {
    let mut head = [b' '; 124];
    let title = b"MATLAB 5.0 MAT-file, by efam";
    head[..title.len()].copy_from_slice(title);
    // No place for the data of other subsystems.
    head[116..].fill(0);
    to.write_all(&head)?;
    to.write_all(&[0x00, 0x01, b'I', b'M'])?;
    for (name, value) in variables {
        let mut bytes = Vec::new();
        matrix(&variable(&name), &value, &mut bytes)?;
        to.write_all(&bytes)?;
    }
    Ok(())
}

fn variables(run: &Stored) -> Vec<(String, Value)> {
    let each = |table: &Table, of: &dyn Fn(&Series) -> Option<Value>| -> Value {
        let fields = table.series.iter().filter_map(|series| Some((series.name.clone(), of(series)?)));
        Value::Struct(fields.collect())
    };
    let all = |of: &dyn Fn(&Series) -> Option<Value>| -> Value {
        Value::Struct(run.tables.iter().map(|table| (table.name.clone(), each(table, of))).collect())
    };
    let numbers = |series: &Series| {
        let (width, numbers) = columns(series);
        Some(Value::Matrix { rows: numbers.len() / width, width, numbers })
    };
    let mut variables: Vec<_> =
        run.tables.iter().map(|table| (table.name.clone(), each(table, &numbers))).collect();
    variables.push(("unit".to_owned(), all(&|series| Some(Value::Text(series.unit.clone())))));
    let has_words = |table: &Table| table.series.iter().any(|own| matches!(own.cells, Cells::Words(_)));
    if run.tables.iter().any(has_words) {
        variables.push(("words".to_owned(), all(&|series| words(series).map(Value::Text))));
    }
    let facts = run.facts.iter().chain(&run.files);
    let facts = facts.map(|(name, text)| (name.to_string(), Value::Text(text.to_string())));
    variables.push(("about".to_owned(), Value::Struct(facts.collect())));
    variables
}

fn matrix(name: &str, value: &Value, to: &mut Vec<u8>) -> io::Result<()> {
    let mut own = Vec::new();
    let (class, shape) = match value {
        Value::Matrix { rows, width, .. } => (OF_DOUBLES, [*rows, *width]),
        Value::Text(text) => (OF_LETTERS, [1, text.encode_utf16().count()]),
        Value::Struct(_) => (OF_FIELDS, [1, 1]),
    };
    element(UINT32, &[class, 0].map(u32::to_le_bytes).concat(), &mut own)?;
    element(INT32, &shape.map(|side| (side as u32).to_le_bytes()).concat(), &mut own)?;
    element(INT8, name.as_bytes(), &mut own)?;
    match value {
        Value::Matrix { numbers, .. } => {
            element(DOUBLE, &numbers.iter().flat_map(|one| one.to_le_bytes()).collect::<Vec<_>>(), &mut own)?;
        }
        Value::Text(text) => {
            element(UINT16, &text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<_>>(), &mut own)?;
        }
        Value::Struct(fields) => {
            let names: Vec<String> = fields.iter().map(|(name, _)| variable(name)).collect();
            let room = MOST_LETTERS + 1;
            // A short element: length and type in one word, and its four bytes.
            own.extend((4u32 << 16 | INT32).to_le_bytes());
            own.extend((room as u32).to_le_bytes());
            let padded = |name: &String| {
                let mut bytes = name.clone().into_bytes();
                bytes.resize(room, 0);
                bytes
            };
            element(INT8, &names.iter().flat_map(padded).collect::<Vec<_>>(), &mut own)?;
            for (_, value) in fields {
                matrix("", value, &mut own)?;
            }
        }
    }
    element(MATRIX, &own, to)
}

fn element(kind: u32, bytes: &[u8], to: &mut Vec<u8>) -> io::Result<()> {
    let length = u32::try_from(bytes.len())
        .map_err(|_| io::Error::other("more than 4 GB, which MAT of version 5 cannot hold; take --to mat"))?;
    to.extend(kind.to_le_bytes());
    to.extend(length.to_le_bytes());
    to.extend(bytes);
    to.resize(to.len().next_multiple_of(8), 0);
    Ok(())
}

/// A name as MATLAB admits it: letters, digits and `_`, a letter first.
fn variable(name: &str) -> String {
    let fit = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(fit).collect();
    let is_led = name.starts_with(|c: char| c.is_ascii_alphabetic());
    let name = if is_led { name } else { format!("x{name}") };
    name.chars().take(MOST_LETTERS).collect()
}

//! MCAP: a channel for each body or quantity, messages in JSON with a schema, at their simulated times.
//!
//! `/trajectory/tip` has `tip_x_m`, `tip_z_m` and their rates, `/trajectory/nodes` arrays with a number for each node,
//! `/trajectory/energy` all energies; each message has the time of its row, too. Columns of words become parts of the
//! topic, with `/` as `%2F`. Instants of MCAP are whole nanoseconds from 0 on: where a table begins before its zero, as a
//! release does in its hold, all instants of the file are later by the whole seconds that `time_zero_s` of the metadata `run` says.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::io::{self, Seek, Write};
use std::ops::Range;

use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, McapError, WriteOptions, Writer};
use serde_json::{Map, Value, json};

use crate::export::stored::{Cells, Series, Stored, Table};

const NANOSECONDS: f64 = 1e9;
/// Parts of a name before which that of its body ends.
const COORDINATES: [&str; 8] = ["x", "y", "z", "vx", "vy", "vz", "angle", "rate"];

/// What is said of one body.
struct Channel<'a> {
    topic: String,
    time: &'a [f64],
    series: Vec<&'a Series>,
    rows: Vec<usize>,
}

/// Writes the file.
/// # Errors
/// An error of the writer.
pub(super) fn write(run: &Stored, to: impl Write + Seek) -> io::Result<()> {
    filled(run, to).map_err(|error| match error {
        McapError::Io(error) => error,
        error => io::Error::other(error),
    })
}

fn filled(run: &Stored, to: impl Write + Seek) -> Result<(), McapError> {
    let program = format!("efam {}", env!("CARGO_PKG_VERSION"));
    let mut file = Writer::with_options(to, WriteOptions::new().compression(None).library(program))?;
    let channels: Vec<Channel> = run.tables.iter().flat_map(channels).collect();
    let first = channels.iter().flat_map(|of| of.rows.iter().map(|row| of.time[*row]));
    let zero = first.fold(0.0, f64::min).floor().abs();
    let mut facts: BTreeMap<String, String> =
        run.facts.iter().map(|(name, fact)| ((*name).to_owned(), fact.clone())).collect();
    facts.insert("time_zero_s".to_owned(), zero.to_string());
    file.write_metadata(&Metadata { name: "run".to_owned(), metadata: facts })?;
    for (name, text) in &run.files {
        file.attach(&Attachment {
            log_time: 0,
            create_time: 0,
            name: (*name).to_owned(),
            media_type: if name.ends_with("json") { "application/json" } else { "application/toml" }
                .to_owned(),
            data: Cow::Borrowed(text.as_bytes()),
        })?;
    }
    let mut messages = Vec::new();
    for (k, of) in channels.iter().enumerate() {
        let instant = |row: &usize| ((of.time[*row] + zero) * NANOSECONDS).round() as u64;
        messages.extend(of.rows.iter().map(|row| (instant(row), k, *row)));
    }
    messages.sort_unstable();
    let ids = channels.iter().map(|of| announced(&mut file, of)).collect::<Result<Vec<u16>, _>>()?;
    let mut sequence = vec![0; channels.len()];
    for (instant, k, row) in messages {
        sequence[k] += 1;
        let header = MessageHeader {
            channel_id: ids[k],
            sequence: sequence[k],
            log_time: instant,
            publish_time: instant,
        };
        file.write_to_known_channel(&header, message(&channels[k], row).to_string().as_bytes())?;
    }
    file.finish().map(drop)
}

/// The channels of a table; none where it has no time.
fn channels(table: &Table) -> Vec<Channel<'_>> {
    let Some(time) = table.time() else {
        return Vec::new();
    };
    let bodies = bodies(table);
    let mut found: Vec<Channel> = Vec::new();
    // The channels of the bodies below a topic.
    let mut below: HashMap<String, Range<usize>> = HashMap::new();
    for row in (0..table.rows).filter(|row| time[*row].is_finite()) {
        let words = table.series.iter().filter_map(|series| match &series.cells {
            Cells::Words(words) => Some(words[row].as_str()),
            Cells::Numbers { .. } => None,
        });
        let above = words.fold(format!("/{}", table.name), |topic, word| format!("{topic}/{}", part(word)));
        let own = below.entry(above).or_insert_with_key(|above| {
            let first = found.len();
            found.extend(bodies.iter().map(|(body, series)| {
                let topic = if body.is_empty() { above.clone() } else { format!("{above}/{}", part(body)) };
                Channel { topic, time, series: series.clone(), rows: Vec::new() }
            }));
            first..found.len()
        });
        found[own.clone()].iter_mut().for_each(|of| of.rows.push(row));
    }
    found
}

/// A word as one part of a topic, different for different words: what would end it, and what nobody can type, is
/// written as in addresses of the web.
fn part(word: &str) -> String {
    let written = |c: char| match c {
        '/' | '%' => format!("%{:02X}", c as u32),
        c if c.is_control() => format!("%{:02X}", c as u32),
        c => c.to_string(),
    };
    if word.is_empty() { "%".to_owned() } else { word.chars().map(written).collect() }
}

/// Columns by the body that they are of.
fn bodies(table: &Table) -> Vec<(String, Vec<&Series>)> {
    let mut bodies: Vec<(String, Vec<&Series>)> = Vec::new();
    let mut known: HashMap<String, usize> = HashMap::new();
    for series in table.series.iter().filter(|series| !series.is_time()) {
        let Some(body) = body(series) else { continue };
        let place = *known.entry(body.clone()).or_insert(bodies.len());
        match bodies.get_mut(place) {
            Some((_, all)) => all.push(series),
            None => bodies.push((body, vec![series])),
        }
    }
    bodies
}

fn body(series: &Series) -> Option<String> {
    let Cells::Numbers { width, .. } = series.cells else { return None };
    if width > 1 {
        return Some("nodes".to_owned());
    }
    if series.unit == "J" {
        return Some("energy".to_owned());
    }
    let parts: Vec<&str> = series.name.split('_').collect();
    let end = parts.iter().position(|part| COORDINATES.contains(part)).unwrap_or(parts.len());
    Some(parts[..end].join("_"))
}

fn announced<W: Write + Seek>(file: &mut Writer<W>, of: &Channel) -> Result<u16, McapError> {
    let mut properties = Map::from_iter([("time_s".to_owned(), number("s"))]);
    for series in &of.series {
        let own = match series.cells {
            Cells::Numbers { width: 1, .. } => number(&series.unit),
            _ => json!({ "type": "array", "items": number(&series.unit) }),
        };
        properties.insert(series.name.clone(), own);
    }
    let schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "type": "object",
        "properties": properties,
        "required": ["time_s"],
    });
    let name = format!("efam{}", of.topic.replace('/', "."));
    let schema = file.add_schema(&name, "jsonschema", schema.to_string().as_bytes())?;
    file.add_channel(schema, &of.topic, "json", &BTreeMap::new())
}

fn number(unit: &str) -> Value {
    json!({ "type": "number", "description": format!("in {unit}"), "unit": unit })
}

/// What a row says of a body; what has no value there is left out.
fn message(of: &Channel, row: usize) -> Value {
    let mut message = Map::from_iter([("time_s".to_owned(), json!(of.time[row]))]);
    for series in &of.series {
        let Cells::Numbers { width, values } = &series.cells else { continue };
        let own = &values[row * width..(row + 1) * width];
        if own.iter().all(|value| value.is_finite()) {
            let value = if *width == 1 { json!(own[0]) } else { json!(own) };
            message.insert(series.name.clone(), value);
        }
    }
    Value::Object(message)
}

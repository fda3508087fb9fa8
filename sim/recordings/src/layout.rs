//! What a header says about the rows below it, and the reading of those rows: the same for all text.

use super::Marker;
use super::cells::{NotANumber, Numbers, Rows, in_header, is_word, short};
use super::draft::{Draft, Unit};
use super::error::RecordingProblem;
use super::format::Format;
use super::length::Length;

/// The columns of each row below a header. Columns count from 0.
pub(super) struct Layout {
    pub format: Format,
    /// Columns that the header names, beyond which no cell may be filled; nothing where that is not known.
    pub width: Option<usize>,
    pub unit: Unit,
    /// Samples a second, if stated.
    pub rate: Option<f64>,
    /// What is wrong with the clock, which matters unless the person states a rate.
    pub wrong_clock: Option<RecordingProblem>,
    /// Column of frame numbers.
    pub frame: Option<usize>,
    /// Column of times, and the length of their unit, s.
    pub time: Option<(usize, f64)>,
    /// The name of that column, if it states no unit.
    pub assumed_second: Option<String>,
    pub points: Vec<Columns>,
    /// Whether the format writes three zeros for a lost point.
    pub zero_is_lost: bool,
    /// Whether z counts downwards, as the rows of a picture do.
    pub is_picture: bool,
    /// Whether another section may follow below the rows.
    pub sections: bool,
    /// Samples that the header states.
    pub samples: Option<f64>,
    pub findings: Vec<String>,
}

/// Columns of a marker.
#[derive(Debug)]
pub(super) struct Columns {
    pub name: String,
    /// x, y, z; without one the coordinate is 0.
    pub position: [Option<usize>; 3],
    /// w, x, y, z.
    pub orientation: Option<[usize; 4]>,
    /// How likely the place is right, from 0 to 1, as programs state it that find points in pictures.
    pub likelihood: Option<usize>,
}

/// Likelihood below which a place counts as lost; DeepLabCut plots nothing below it.
const LEAST_LIKELY: f64 = 0.6;

/// What is counted while rows are read.
#[derive(Default)]
struct Tally {
    partial: usize,
    zero: usize,
    short: usize,
    first_short: u64,
    /// Cells of the longest row that is too short.
    most: usize,
    off_unit: usize,
    unlikely: usize,
    words: usize,
    /// The first of them, and its line.
    first_word: Option<(String, u64)>,
    /// Rows that are no samples, the first of them, and its line.
    passed_over: usize,
    first_passed_over: Option<(String, u64)>,
}

impl Layout {
    /// A layout of points, with nothing more known.
    pub(super) fn new(format: Format, unit: Unit, points: Vec<Columns>, findings: Vec<String>) -> Self {
        Self {
            format,
            width: None,
            unit,
            rate: None,
            wrong_clock: None,
            frame: None,
            time: None,
            assumed_second: None,
            points,
            zero_is_lost: false,
            is_picture: false,
            sections: false,
            samples: None,
            findings,
        }
    }

    /// A draft without samples, whose places are counted in lines or rows.
    pub(super) fn draft(&self, place: &'static str) -> Draft {
        let mut draft = Draft::new(self.format, self.unit.clone(), place);
        draft.rate = self.rate;
        draft.assumed_second.clone_from(&self.assumed_second);
        draft.findings.clone_from(&self.findings);
        draft.markers = self.points.iter().map(Columns::marker).collect();
        draft
    }

    /// Reads all rows that follow.
    pub(super) fn read(self, rows: &mut Rows) -> Result<Draft, RecordingProblem> {
        let header_line = rows.line();
        self.read_from(header_line, rows)
    }

    /// The same, with the line of the header.
    pub(super) fn read_from(mut self, header_line: u64, rows: &mut Rows) -> Result<Draft, RecordingProblem> {
        let mut numbers = Numbers::default();
        let mut tally = Tally::default();
        let mut draft = self.draft("line");
        draft.wrong_clock = self.wrong_clock.take();
        let width = 1 + self.columns().max().unwrap_or(0);
        // Cells of the row before, and the fewest decimals of a last cell.
        let mut last: Option<(usize, usize)> = None;
        let mut has_clock = None;
        while rows.read_filled()? {
            let line = rows.line();
            if let Some(title) = rows.title().filter(|_| self.sections) {
                draft.findings.push(format!("section `{title}` from line {line} on was passed over"));
                break;
            }
            let is_word = self.has_word_for_time(rows);
            let has_clock = *has_clock.get_or_insert(!is_word);
            if rows.cell(0).starts_with('#') || has_clock && is_word {
                tally.passed_over += 1;
                tally.first_passed_over.get_or_insert_with(|| (rows.start(), line));
                continue;
            }
            let decimals = decimals(rows);
            if rows.is_open() && last.is_some_and(|(width, least)| rows.width() < width || decimals < least) {
                draft.findings.push(format!(
                    "line {line}, the last, is cut off in `{}`; it was left out",
                    rows.start()
                ));
                break;
            }
            last = Some((rows.width(), last.map_or(decimals, |(_, least)| least.min(decimals))));
            let (cells, names) = (rows.filled(), self.width.unwrap_or(usize::MAX));
            if cells > names || rows.is_strict && cells < names {
                return Err(RecordingProblem::Cells { line, cells, header: header_line, names });
            }
            if rows.width() < width {
                tally.short += 1;
                tally.first_short = if tally.short == 1 { line } else { tally.first_short };
                tally.most = tally.most.max(rows.width());
            }
            self.row(rows, line, &mut numbers, &mut draft, &mut tally)?;
            // A whole row has a byte or more for each point; so memory follows from the file's length.
            let samples = draft.places.len();
            if samples * self.points.len() > rows.length() {
                let (markers, bytes) = (self.points.len(), rows.length());
                return Err(RecordingProblem::ShortRows { markers, samples, bytes });
            }
        }
        if draft.places.is_empty() {
            return Err(RecordingProblem::HeaderOnly { line: header_line });
        }
        let is_table = self.format == Format::Tidy;
        if let Some(names) = self.width.filter(|_| is_table && tally.short == draft.places.len()) {
            // No row has a cell for the last name, so any name may be over another's cells.
            let (line, cells) = (tally.first_short, tally.most);
            return Err(RecordingProblem::Cells { line, cells, header: header_line, names });
        }
        draft.findings.extend(numbers.finding()?);
        self.say(&tally, &mut draft);
        Ok(draft)
    }

    /// Takes rows from columns of numbers, as this layout counts them; nothing where a number is missing.
    pub(super) fn rows(
        &self,
        name: &dyn Fn(usize) -> String,
        columns: &[Vec<Option<f64>>],
        draft: &mut Draft,
    ) -> Result<(), RecordingProblem> {
        for row in 0..columns.first().map_or(0, Vec::len) {
            let place = draft.places.len() as u64 + 1;
            draft.places.push(place);
            let clock = |column: usize| {
                let wrong = || RecordingProblem::NotANumber {
                    line: place,
                    column: column + 1,
                    name: name(column),
                    value: "null".to_owned(),
                };
                columns[column][row].ok_or_else(wrong)
            };
            if let Some(column) = self.frame {
                draft.frames.push(clock(column)?);
            }
            if let Some((column, second)) = self.time {
                draft.times.push(second * clock(column)?);
            }
            for (point, marker) in self.points.iter().zip(&mut draft.markers) {
                // Without a column the coordinate is 0.
                let at = |column: Option<usize>| column.map_or(Some(0.0), |column| columns[column][row]);
                let [x, y, z] = point.position;
                let position = (|| Some([at(x)?, at(y)?, at(z)?]))();
                let likely = point.likelihood.and_then(|column| columns[column][row]);
                marker.position.push(self.place(position, likely));
                if let (Some([w, x, y, z]), Some(orientation)) = (point.orientation, &mut marker.orientation)
                {
                    let q =
                        (|| Some([columns[w][row]?, columns[x][row]?, columns[y][row]?, columns[z][row]?]))();
                    orientation.push(q.and_then(unit_quaternion));
                }
            }
        }
        Ok(())
    }

    /// Frame and time of a row.
    fn clock(&self, rows: &Rows, line: u64, numbers: &mut Numbers, draft: &mut Draft) {
        let Draft { frames, times, wrong_clock, .. } = draft;
        let mut or_wrong = |value: Option<f64>, column: usize, name: &str| {
            value.unwrap_or_else(|| {
                wrong_clock.get_or_insert_with(|| {
                    let (name, value) = (name.to_owned(), short(rows.cell(column)));
                    RecordingProblem::NotANumber { line, column: column + 1, name, value }
                });
                f64::NAN
            })
        };
        if let Some(column) = self.frame {
            let frame = numbers.read(rows.cell(column), line).ok().flatten();
            let frame = frame.filter(|frame| frame.abs() < 1e15 && frame.fract() == 0.0);
            frames.push(or_wrong(frame, column, "frame"));
        }
        if let Some((column, second)) = self.time {
            times.push(or_wrong(second_of(rows.cell(column), second, numbers, line), column, "time"));
        }
    }

    fn row(
        &self,
        rows: &Rows,
        line: u64,
        numbers: &mut Numbers,
        draft: &mut Draft,
        tally: &mut Tally,
    ) -> Result<(), RecordingProblem> {
        draft.places.push(line);
        self.clock(rows, line, numbers, draft);
        let (words, first_word) = (&mut tally.words, &mut tally.first_word);
        let mut number = |column: usize, name: &dyn Fn() -> String| {
            let cell = rows.cell(column);
            match numbers.read(cell, line) {
                Ok(number) => Ok(number),
                Err(NotANumber) if is_word(cell) => {
                    *words += 1;
                    first_word.get_or_insert_with(|| (short(cell), line));
                    Ok(None)
                }
                Err(NotANumber) => Err(RecordingProblem::NotANumber {
                    line,
                    column: column + 1,
                    name: name(),
                    value: short(cell),
                }),
            }
        };
        for (columns, marker) in self.points.iter().zip(&mut draft.markers) {
            let mut position = [0.0; 3];
            let (mut there, mut wanted) = (0, 0);
            for axis in 0..3 {
                let Some(column) = columns.position[axis] else { continue };
                wanted += 1;
                if let Some(value) =
                    number(column, &|| format!("{} {}", columns.name, ["x", "y", "z"][axis]))?
                {
                    position[axis] = value;
                    there += 1;
                }
            }
            let is_zero = self.zero_is_lost && there == wanted && position == [0.0; 3];
            tally.zero += usize::from(is_zero);
            tally.partial += usize::from(there > 0 && there < wanted);
            let seen = (there == wanted && !is_zero).then_some(position);
            let likely = match columns.likelihood {
                Some(column) => number(column, &|| format!("{} likelihood", columns.name))?,
                None => None,
            };
            let place = self.place(seen, likely);
            tally.unlikely += usize::from(seen.is_some() && place.is_none());
            marker.position.push(place);
            if let (Some(columns_of_q), Some(orientation)) = (columns.orientation, &mut marker.orientation) {
                let mut q = [0.0; 4];
                let mut there = 0;
                for (value, column) in q.iter_mut().zip(columns_of_q) {
                    if let Some(read) = number(column, &|| format!("{} orientation", columns.name))? {
                        *value = read;
                        there += 1;
                    }
                }
                let rotation = (there == 4).then_some(q).and_then(unit_quaternion);
                tally.off_unit += usize::from(there == 4 && rotation.is_none());
                orientation.push(rotation);
            }
        }
        Ok(())
    }

    /// Whether a row has a word where its time is due, as names that come once more, or a mean at the foot.
    fn has_word_for_time(&self, rows: &Rows) -> bool {
        self.time.map(|time| time.0).or(self.frame).is_some_and(|column| is_word(rows.cell(column)))
    }

    /// A place as it is kept: with z upwards, and nothing where it is unlikely.
    fn place(&self, seen: Option<[f64; 3]>, likely: Option<f64>) -> Option<[f64; 3]> {
        let [x, y, z] = seen.filter(|_| likely.is_none_or(|likely| likely >= LEAST_LIKELY))?;
        Some([x, y, if self.is_picture { -z } else { z }])
    }

    /// All columns that are read.
    pub(super) fn columns(&self) -> impl Iterator<Item = usize> {
        let points = self.points.iter().flat_map(|point| {
            let orientation = point.orientation.into_iter().flatten();
            point.position.into_iter().flatten().chain(orientation).chain(point.likelihood)
        });
        points.chain(self.frame).chain(self.time.map(|time| time.0))
    }

    fn say(&self, tally: &Tally, draft: &mut Draft) {
        let samples = draft.places.len();
        let findings = &mut draft.findings;
        if let Some(stated) = self.samples.filter(|stated| *stated != samples as f64) {
            findings.push(format!("the header states {stated} samples, the file has {samples}: an excerpt?"));
        }
        let at = |first: &Option<(String, u64)>| {
            first.as_ref().map_or(String::new(), |(text, line)| format!("`{text}` in line {line}"))
        };
        let counted = [
            (
                tally.words,
                format!(
                    "cells have a word in place of a number, the first {}; they count as lost",
                    at(&tally.first_word)
                ),
            ),
            (
                tally.passed_over,
                format!(
                    "rows are no samples and were passed over, the first {}",
                    at(&tally.first_passed_over)
                ),
            ),
            (
                tally.short,
                format!(
                    "rows have fewer cells than the header, the first in line {}; what is missing counts as lost",
                    tally.first_short
                ),
            ),
            (
                tally.partial,
                "times only some of a marker's coordinates were there; it counts as lost".to_owned(),
            ),
            (
                tally.zero,
                format!(
                    "times a marker stood at exactly 0, 0, 0, which {} writes for a lost point; it counts as lost",
                    self.format
                ),
            ),
            (
                tally.off_unit,
                "quaternions are no rotations (their norm is not 1 within a tenth); they count as lost"
                    .to_owned(),
            ),
            (
                tally.unlikely,
                format!("times a place had a likelihood below {LEAST_LIKELY}; it counts as lost"),
            ),
        ];
        let met = counted.into_iter().filter(|(count, _)| *count > 0);
        findings.extend(met.map(|(count, what)| format!("{count} {what}")));
    }
}

impl Columns {
    /// A marker whose x, y and z are in columns.
    pub(super) fn at((name, position): (String, [usize; 3])) -> Self {
        Self { name, position: position.map(Some), orientation: None, likelihood: None }
    }

    /// The marker, still without samples.
    pub(super) fn marker(&self) -> Marker {
        let orientation = self.orientation.map(|_| Vec::new());
        Marker { name: self.name.clone(), position: Vec::new(), orientation }
    }
}

/// A quaternion scaled to the norm 1, from which it may be off by a tenth; nothing beyond.
pub(super) fn unit_quaternion(q: [f64; 4]) -> Option<[f64; 4]> {
    let norm = q.iter().map(|value| value * value).sum::<f64>().sqrt();
    ((norm - 1.0).abs() < 0.1).then(|| q.map(|value| value / norm))
}

/// Digits after the decimal sign of the last cell of a row.
fn decimals(rows: &Rows) -> usize {
    let last = rows.cell(rows.width().saturating_sub(1));
    last.rsplit_once(['.', ',']).map_or(0, |(_, decimals)| decimals.len())
}

/// A time, s: a number of a unit, or hours, minutes and seconds between colons, with hundredths after a third one as
/// Kinovea writes them; a date before it is passed over, and so is a time zone after it. Half of the day may be AM or PM.
pub(super) fn second_of(cell: &str, second: f64, numbers: &mut Numbers, line: u64) -> Option<f64> {
    if !cell.contains(':') {
        return Some(second * numbers.read(cell, line).ok().flatten()?);
    }
    let cell = cell.to_ascii_uppercase();
    let half = |half: &str| cell.strip_suffix(half).map(str::trim_end);
    let (whole, noon) = match (half("AM"), half("PM")) {
        (Some(before), _) => (before, Some(0.0)),
        (_, Some(before)) => (before, Some(12.0)),
        _ => (cell.as_str(), None),
    };
    let clock = whole.rsplit([' ', 'T']).next()?;
    let clock = clock.split(['Z', '+', '-']).next()?;
    let parts = clock.split(':').map(in_header).collect::<Option<Vec<f64>>>()?;
    match parts[..] {
        [minutes, seconds] => Some(60.0 * minutes + seconds),
        [hours, minutes, seconds] => {
            let hours = noon.map_or(hours, |noon| noon + hours % 12.0);
            Some(3600.0 * hours + 60.0 * minutes + seconds)
        }
        [hours, minutes, seconds, hundredths] => {
            Some(3600.0 * hours + 60.0 * minutes + seconds + 0.01 * hundredths)
        }
        _ => None,
    }
}

/// The one unit of positions whose columns state their own; nothing if none does.
pub(super) fn one_unit<'a>(stated: impl IntoIterator<Item = (&'a str, Length)>, place: &str) -> Option<Unit> {
    let mut first: Option<(&str, Length)> = None;
    for (name, unit) in stated {
        match first {
            None => first = Some((name, unit)),
            Some((before, length)) if length != unit => {
                return Some(Unit::Mixed([(before.to_owned(), length), (name.to_owned(), unit)]));
            }
            Some(_) => {}
        }
    }
    first.map(|(_, length)| Unit::Stated(length, place.to_owned()))
}

//! Trajectories of Kinovea: as text, one below the other, a blank line between them, each with times of its own.
//!
//! ```text
//! #Kinovea Trajectory data export
//! #T X Y
//!
//! # tip
//! 0:00:00:00 0.00 0.00
//!
//! # base
//! 0:00:00:12 3.10 0.20
//! ```
//! Versions before 2023 write no names.

use std::collections::BTreeMap;

use super::Marker;
use super::draft::Draft;
use super::names::{distinct, some};

/// Trajectories that are read at most.
pub(super) const MOST: usize = 50;

/// One of them: its name, if the export has names, and a text of the lines above the first one and its own, each in its place.
pub(super) struct Trajectory {
    pub name: Option<String>,
    pub text: String,
}

/// The trajectories of an export; none of another text.
pub(super) fn trajectories(text: &str) -> impl Iterator<Item = Trajectory> {
    let note = |line: &str| line.strip_prefix('#').map(|note| note.trim().to_owned());
    let is_of_kinovea =
        |line: &str| line.to_lowercase().trim_start_matches(['#', ' ']).starts_with("kinovea");
    let is_row = |line: &str| line.starts_with(|c: char| c.is_ascii_digit() || c == '-');
    let first = text.lines().position(is_row).filter(|_| text.lines().next().is_some_and(is_of_kinovea));
    let (mut starts, mut name, mut was_row) = (Vec::new(), None, false);
    for (at, line) in text.lines().enumerate().filter(|_| first.is_some()) {
        if is_row(line) && !was_row {
            starts.push((at, name.take()));
        }
        was_row = is_row(line);
        name = note(line).filter(|note| !note.is_empty() && note != "T X Y" && !is_of_kinovea(note)).or(name);
    }
    starts.into_iter().take(MOST + 1).map(move |(start, name)| {
        let first = first.unwrap_or_default();
        let above = text.lines().take(first).chain(std::iter::repeat_n("", start - first));
        let own = text.lines().skip(start).take_while(move |line| is_row(line));
        Trajectory { name, text: above.chain(own).flat_map(|line| [line, "\n"]).collect() }
    })
}

/// Trajectories of a text of so many bytes as one draft, over all times that one of them has; nothing if there are too many,
/// or the times of one do not ascend.
pub(super) fn merged(drafts: Vec<Draft>, bytes: usize) -> Option<Draft> {
    let has_times = drafts.iter().all(|draft| !draft.times.is_empty());
    let clock = |draft: &Draft| if has_times { draft.times.clone() } else { draft.frames.clone() };
    let clocks: Vec<Vec<f64>> = drafts.iter().map(clock).collect();
    let is_clear = |(draft, clock): (&Draft, &Vec<f64>)| {
        let ascends = clock.windows(2).all(|pair| pair[0] < pair[1]);
        let first = clock.first().is_some_and(|time| *time >= 0.0);
        draft.wrong_clock.is_none() && ascends && first
    };
    // The bits of numbers that are not negative ascend as they do.
    let bits = |time: &f64| (time + 0.0).to_bits();
    let mut places: BTreeMap<u64, u64> = BTreeMap::new();
    for (draft, clock) in drafts.iter().zip(&clocks) {
        clock.iter().zip(&draft.places).for_each(|(time, place)| {
            places.entry(bits(time)).or_insert(*place);
        });
    }
    let count = drafts.len();
    // A whole row has a byte or more for each point; so memory follows from the file's length.
    if count > MOST || count * places.len() > bytes || !drafts.iter().zip(&clocks).all(is_clear) {
        return None;
    }
    let of_one = |draft: &Draft| draft.markers.iter().map(|own| own.name.clone()).collect::<Vec<_>>();
    let names = distinct(drafts.iter().flat_map(of_one), &mut Vec::new());
    let marker = |(name, (clock, own)): (String, (&Vec<f64>, &Marker))| {
        let mut seen = clock.iter().zip(&own.position).peekable();
        let at = |time: &u64| seen.next_if(|(own, _)| bits(own) == *time).and_then(|(_, at)| *at);
        Marker { name, position: places.keys().map(at).collect(), orientation: None }
    };
    let all = drafts.iter().zip(&clocks);
    let all = all.flat_map(|(draft, clock)| draft.markers.iter().map(move |own| (clock, own)));
    let markers: Vec<Marker> = names.into_iter().zip(all).map(marker).collect();
    let names: Vec<String> = markers.iter().map(|own| own.name.clone()).collect();
    let clock: Vec<f64> = places.keys().map(|time| f64::from_bits(*time)).collect();
    let (times, frames) = if has_times { (clock, Vec::new()) } else { (Vec::new(), clock) };
    let mut merged = drafts.into_iter().next()?;
    merged.findings.push(format!(
        "{count} trajectories in the same columns, a marker each: {}; one that is not seen at a time counts as lost there",
        some(&names)
    ));
    Some(Draft { times, frames, places: places.into_values().collect(), markers, ..merged })
}

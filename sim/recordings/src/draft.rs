//! A file as it was parsed, and what makes a recording of it: unit, clock, checks, findings.

use std::path::Path;

use efam_store::escape::{escaped, is_hidden};

use super::cells::short;
use super::clock::{self, Clock};
use super::error::RecordingProblem;
use super::format::Format;
use super::length::{Length, TOO_FAR, UnknownUnit};
use super::names::distinct;
use super::quality;
use super::{Marker, Recording};

/// What the person knows better than the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Unit of the positions, whatever the file states.
    pub unit: Option<Length>,
    /// Samples a second, whatever the file states. Times then come from frame numbers or, where
    /// there are none, from counting.
    pub rate_hz: Option<f64>,
}

/// A file's numbers in its own units.
pub(super) struct Draft {
    pub format: Format,
    pub unit: Unit,
    /// Samples a second, if stated.
    pub rate: Option<f64>,
    /// Frame number of each sample, whole numbers; empty if the file has none.
    pub frames: Vec<f64>,
    /// Time of each sample, s; empty if the file has none.
    pub times: Vec<f64>,
    /// Where each sample stands, for messages.
    pub places: Vec<u64>,
    /// What `places` count: lines, rows.
    pub place: &'static str,
    /// Positions in the file's unit.
    pub markers: Vec<Marker>,
    pub findings: Vec<String>,
}

/// Unit of the positions.
#[derive(Clone)]
pub(super) enum Unit {
    /// Stated, and where.
    Stated(Length, String),
    /// Not stated, but the format has a fixed one; with its reason.
    Assumed(Length, &'static str),
    /// Not stated, and the format has none; with what is silent.
    Silent(String),
}

/// Extents beyond which a unit is doubtful, m.
const DOUBTFUL_EXTENT: (f64, f64) = (1e-3, 30.0);

impl Draft {
    pub(super) fn new(format: Format, unit: Unit, place: &'static str) -> Self {
        let (frames, times, places) = Default::default();
        Self { format, unit, rate: None, frames, times, places, place, markers: vec![], findings: vec![] }
    }

    /// Makes the recording.
    pub(super) fn finish(self, source: &Path, options: &ReadOptions) -> Result<Recording, RecordingProblem> {
        let Draft { format, unit, mut rate, frames, times, places, place, mut markers, findings: met } = self;
        if places.len() < 2 {
            return Err(RecordingProblem::OneSample);
        }
        let mut findings = Vec::new();
        let unit = unit.settle(options.unit, &mut findings)?;
        if let Some(none) = rate.filter(|rate| !(rate.is_finite() && *rate > 0.0)) {
            findings.push(format!(
                "rate: the file states {} Hz, which is none; it was passed over",
                clock::plain(none)
            ));
            rate = None;
        }
        let place = |sample: usize| format!("{place} {}", places[sample]);
        let stated = clock::Stated { frames: &frames, times: &times, rate, samples: places.len() };
        let Clock { rate_hz, time } = stated.clock(options.rate_hz, &place, &mut findings)?;
        findings.extend(met);

        if markers.iter().all(|marker| marker.position.iter().all(Option::is_none)) {
            return Err(RecordingProblem::AllLost { markers: markers.len(), samples: time.len() });
        }
        if unit != Length::Metre {
            let positions = markers.iter_mut().flat_map(|marker| marker.position.iter_mut().flatten());
            positions.for_each(|position| *position = position.map(|value| unit.to_metres(value)));
        }
        name_visibly(&mut markers, &mut findings);
        findings.extend(quality::losses(&markers, &time));
        let extents = markers.iter().filter_map(|marker| quality::extent(&marker.position));
        let extent = extents.flatten().map(|[low, high]| high - low).fold(0.0, f64::max);
        if extent > DOUBTFUL_EXTENT.1 {
            let doubt = match unit {
                Length::Metre => TOO_FAR.to_owned(),
                unit => format!("is the unit {} right?", unit.symbol()),
            };
            findings.push(format!("a marker moves by {} m along an axis: {doubt}", clock::plain(extent)));
        }
        if extent < DOUBTFUL_EXTENT.0 {
            findings.push(format!(
                "no marker moves by more than {extent:.3e} m along any axis: is the unit {} right?",
                unit.symbol()
            ));
        }
        // They quote the file.
        let findings = findings.iter().map(|finding| escaped(finding).into_owned()).collect();
        Ok(Recording { source: source.to_owned(), format, rate_hz, time, markers, findings })
    }
}

/// Names without hidden characters, for they go into tables, files and commands; different ones stay different.
fn name_visibly(markers: &mut [Marker], findings: &mut Vec<String>) {
    if !markers.iter().any(|marker| marker.name.contains(is_hidden)) {
        return;
    }
    let names = markers.iter().map(|marker| escaped(&marker.name).into_owned());
    let names = distinct(names.collect::<Vec<_>>(), findings);
    markers.iter_mut().zip(names).for_each(|(marker, name)| marker.name = name);
}

impl Unit {
    /// As a file states it: its word, if there is one, and where that stands; else `silent`.
    pub(super) fn stated(word: Option<&str>, place: &str, silent: Unit) -> Result<Unit, RecordingProblem> {
        let Some(word) = word.filter(|word| !word.is_empty()) else { return Ok(silent) };
        let unknown = || UnknownUnit { place: place.to_owned(), value: short(word) };
        let length = Length::named(word).ok_or_else(unknown)?;
        Ok(Unit::Stated(length, place.to_owned()))
    }

    fn settle(self, wanted: Option<Length>, findings: &mut Vec<String>) -> Result<Length, RecordingProblem> {
        let (length, finding) = match (wanted, self) {
            (None, Unit::Silent(place)) => return Err(RecordingProblem::NoUnit { place }),
            (None, Unit::Stated(length, place)) => {
                (length, format!("{}, as {place} states", length.symbol()))
            }
            (None, Unit::Assumed(length, why)) => {
                (length, format!("{} is assumed, for the file states none: {why}", length.symbol()))
            }
            (Some(wanted), Unit::Stated(length, place)) if wanted != length => {
                let stated = length.symbol();
                (wanted, format!("{}, as requested, though {place} states {stated}", wanted.symbol()))
            }
            (Some(wanted), _) => (wanted, format!("{}, as requested", wanted.symbol())),
        };
        findings.push(format!("unit: {finding}"));
        Ok(length)
    }
}

//! A file as it was parsed, and what makes a recording of it: unit, clock, checks, findings.

use std::ops::Range;
use std::path::Path;

use efam_store::escape::{escaped, is_hidden};

use super::cells::short;
use super::clock::{self, Clock};
use super::error::RecordingProblem;
use super::format::Format;
use super::length::{Length, TOO_FAR, UnknownUnit};
use super::names::distinct;
use super::{Marker, Recording, lost, order, quality, repeats};

/// What the person knows better than the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Unit of the positions, whatever the file states.
    pub unit: Option<Length>,
    /// Samples a second, whatever the file states. Times then come from frame numbers or, where
    /// there are none, from counting.
    pub rate_hz: Option<f64>,
    /// What the columns of a table hold, as its line of names would say it: for one without such a line, or with a
    /// wrong one. `-` is a column that is passed over.
    pub columns: Option<Vec<String>>,
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
    /// The column of times, if it states no unit and seconds are assumed.
    pub assumed_second: Option<String>,
    /// The first thing that is wrong with frames, times or rate; it does not matter if the person states a rate.
    pub wrong_clock: Option<RecordingProblem>,
    /// The place of each sample, for messages.
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
    /// No unit of length.
    Wrong(UnknownUnit),
    /// Different ones, with the columns that state them.
    Mixed([(String, Length); 2]),
}

/// Extents beyond which a unit is doubtful, m.
const DOUBTFUL_EXTENT: (f64, f64) = (1e-3, 30.0);

/// Steps of a time without a unit that may be seconds. Milliseconds and frames are whole numbers; spreadsheets count days, of
/// which a hundredth of a second is 1e-7, and no camera takes a hundred thousand pictures a second.
const SECONDS: Range<f64> = 1e-5..1.0;

impl Draft {
    pub(super) fn new(format: Format, unit: Unit, place: &'static str) -> Self {
        let (frames, times, places) = Default::default();
        let (assumed_second, markers, findings, wrong_clock) = Default::default();
        Self {
            format,
            unit,
            rate: None,
            frames,
            times,
            assumed_second,
            wrong_clock,
            places,
            place,
            markers,
            findings,
        }
    }

    /// Makes the recording.
    pub(super) fn finish(self, source: &Path, options: &ReadOptions) -> Result<Recording, RecordingProblem> {
        let Draft { format, unit, mut rate, mut places, place, mut markers, findings: met, .. } = self;
        let (mut frames, mut times) = (self.frames, self.times);
        let met = if options.rate_hz.is_none() {
            let done = order::put(&mut times, &mut frames, &mut markers, &mut places, place);
            [done, met].concat()
        } else {
            met
        };
        clock::over_midnight(&mut times);
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
        match self.wrong_clock {
            Some(problem) if options.rate_hz.is_none() => return Err(problem),
            Some(problem) => findings.push(format!("the file's own clock is set aside: {problem}")),
            None => {}
        }
        if let Some(column) = self.assumed_second.filter(|_| options.rate_hz.is_none()) {
            let assumed = || format!("time: s is assumed, for column `{column}` states no unit");
            findings.push(clock::since_1970(&mut times, &column).unwrap_or_else(assumed));
            let step = (times[places.len() - 1] - times[0]) / (places.len() - 1) as f64;
            if !SECONDS.contains(&step.abs()) {
                let is = if step.abs() < SECONDS.start { "short" } else { "long" };
                return Err(RecordingProblem::TimeUnit { column, step: clock::plain(step), is });
            }
        }
        if options.rate_hz.is_some() && !clock::ascends(&frames) {
            findings.push("frame numbers do not ascend; samples are counted instead".to_owned());
            frames.clear();
        }
        let stated = clock::Stated { frames: &frames, times: &times, rate, samples: places.len() };
        let Clock { mut rate_hz, mut time } = stated.clock(options.rate_hz, &place, &mut findings)?;
        findings.extend(met);

        findings.extend(lost::mask_codes(&mut markers));
        if let Some((fresh, others)) = repeats::find(&markers, &mut findings) {
            findings.push(repeats::leave_out(&fresh, others, &mut time, &mut markers));
            rate_hz = clock::rate_of(&time);
        }
        findings.extend(lost::mask_repeated(&mut markers));
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
                unit => format!("is the unit {unit} right?"),
            };
            findings.push(format!("a marker moves by {} m along an axis: {doubt}", clock::plain(extent)));
        }
        if extent < DOUBTFUL_EXTENT.0 {
            findings.push(format!(
                "no marker moves by more than {extent:.3e} m along any axis: is the unit {unit} right?"
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
    /// As a file states it: its word, if there is one, and where that is; else `silent`.
    pub(super) fn stated(word: Option<&str>, place: &str, silent: Unit) -> Unit {
        let Some(word) = word.filter(|word| !word.is_empty()) else { return silent };
        match (Length::named(word), Length::cut_off(word)) {
            (Some(length), _) => Unit::Stated(length, place.to_owned()),
            (None, Some(length)) => Unit::Stated(length, format!("{place}, `{}`, cut off,", short(word))),
            (None, None) => Unit::Wrong(UnknownUnit { place: place.to_owned(), value: short(word) }),
        }
    }

    fn settle(self, wanted: Option<Length>, findings: &mut Vec<String>) -> Result<Length, RecordingProblem> {
        let (length, finding) = match (wanted, self) {
            (None, Unit::Silent(place)) => return Err(RecordingProblem::NoUnit { place }),
            (None, Unit::Stated(Length::Pixel, place)) => return Err(RecordingProblem::Pixels { place }),
            (None, Unit::Wrong(unknown)) => return Err(unknown.into()),
            (None, Unit::Mixed([(first, one), (other, two)])) => {
                return Err(RecordingProblem::MixedUnits { first, other, units: [one, two] });
            }
            (None, Unit::Stated(length, place)) => (length, format!("{length}, as {place} states")),
            (None, Unit::Assumed(length, why)) => {
                (length, format!("{length} is assumed, for the file states none: {why}"))
            }
            (Some(wanted), Unit::Stated(length, place)) if wanted != length => {
                (wanted, format!("{wanted}, as requested, though {place} states {length}"))
            }
            (Some(wanted), Unit::Wrong(unknown)) => (
                wanted,
                format!("{wanted}, as requested, though {} states `{}`", unknown.place, unknown.value),
            ),
            (Some(wanted), Unit::Mixed([(first, one), (other, two)])) => {
                (wanted, format!("{wanted}, as requested, though {first} is in {one} and {other} in {two}"))
            }
            (Some(wanted), _) => (wanted, format!("{wanted}, as requested")),
        };
        findings.push(format!("unit: {finding}"));
        Ok(length)
    }
}

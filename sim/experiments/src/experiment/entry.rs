//! One `[[recording]]` of an experiment file.

use std::collections::BTreeSet;
use std::path::PathBuf;

use efam_recordings::Length;
use efam_store::escape::escaped;

use super::direction::{AXES, Direction};
use super::payload::{Payload, payload};
use super::pressure::{Pressures, pressure};
use crate::scenario::document::{Document, Keys};
use crate::scenario::plan::Plan;
use crate::scenario::{ScenarioError, ScenarioProblem};

/// A recording, and what is known of it beside its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its key in the experiment file, such as `recording[1]`; members count from one.
    pub key: String,
    /// Name of its file without folders.
    pub name: String,
    /// Its file.
    pub file: PathBuf,
    /// Gauge pressure, Pa, if it is known; the mean of one that changes.
    pub pressure: Option<f64>,
    /// The same over time, if that was recorded.
    pub pressures: Option<Pressures>,
    /// What hung on the tip.
    pub payload: Payload,
    /// Markers whose centroid is the tip.
    pub tip: Vec<String>,
    /// Markers along the rod.
    pub body: Vec<BodyMarker>,
    /// Markers that do not move with the rod, or a rigid body.
    pub base: Vec<String>,
    /// Unit of the file's lengths, where it is silent or wrong.
    pub unit: Option<Length>,
    /// Samples a second, likewise.
    pub rate: Option<f64>,
    /// What the columns of a table hold, likewise.
    pub columns: Option<Vec<String>>,
    /// Against gravity, in the file's frame.
    pub up: Option<Direction>,
    /// From the clamp along the rod, in the file's frame.
    pub along: Option<Direction>,
    /// Where the rod leaves the clamp, m, in the file's frame.
    pub clamp: Option<[f64; 3]>,
    /// Angle of the clamp above the horizontal, rad, instead of the model's.
    pub base_angle: Option<f64>,
    /// Angle above the horizontal of the straight rod while it is held, rad.
    pub angle: Option<f64>,
    /// How the rod is held before the release, if it is given.
    pub start: Option<Start>,
    /// Offset of the tip marker from the rod's end.
    pub offset: Option<Offset>,
    /// Instants of release on the recording's clock, s, instead of those that are found.
    pub instants: Option<Vec<f64>>,
    /// Their standard error, s, instead of half a sampling step.
    pub instant_error: Option<f64>,
    /// Releases that alone are used, from one.
    pub keep: Option<Vec<usize>>,
    /// Releases that are not used, from one.
    pub drop: Vec<usize>,
    /// Releases that are held out from every fit.
    pub held_out: HeldOut,
    /// Standard deviation of the noise of each coordinate, m, instead of what is found.
    pub noise: Option<f64>,
    /// Whether spurious points are looked for.
    pub find_spurious: bool,
    /// Intervals on the recording's clock that are not to be used, s.
    pub mask: Vec<[f64; 2]>,
    /// Releases for which something else holds.
    pub overrides: Vec<Override>,
}

/// A marker along the rod.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMarker {
    /// Its name.
    pub marker: String,
    /// Where it sits.
    pub at: At,
}

/// A place along the rod.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum At {
    /// Arc length from the clamp at rest, m.
    Length(f64),
    /// Share of the active length, in 0..=1.
    Share(f64),
}

/// Releases that are held out from every fit.
#[derive(Clone, Debug, PartialEq)]
pub enum HeldOut {
    /// All of the recording.
    All,
    /// These, from one.
    Only(Vec<usize>),
}

/// How a rod is held before its release.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Straight, at the given angle.
    Straight,
    /// Bent, by a hand at its end: force and moment follow from the markers.
    Held,
    /// Not held: at rest by itself, until its pressure changes.
    Rest,
    /// Not held: the recording begins in mid-swing. Posture and velocity follow from the markers.
    InMotion,
}

/// Where the tip marker is beside the rod's end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Offset {
    /// Nowhere else: the marker is the tip.
    None,
    /// As it is seen while the rod is held straight at the given angle.
    Hold,
    /// Along and across the straight rod, m; positive outwards and up.
    Given([f64; 2]),
}

/// What holds for one release of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Override {
    /// Which, from one.
    pub number: usize,
    /// Angle above the horizontal of the straight rod while it is held, rad.
    pub angle: Option<f64>,
    /// Instant of release on the recording's clock, s.
    pub instant: Option<f64>,
}

const KEYS: [&str; 26] = [
    "file",
    "pressure",
    "payload",
    "tip",
    "body",
    "base",
    "unit",
    "rate",
    "columns",
    "up",
    "along",
    "clamp",
    "base_angle",
    "angle",
    "start",
    "offset",
    "instants",
    "instant_error",
    "keep",
    "drop",
    "held_out",
    "noise",
    "spurious",
    "mask",
    "release",
    "note",
];

impl Entry {
    pub(super) fn read(
        document: &Document,
        keys: &Keys,
        plan: Option<&Plan>,
    ) -> Result<Entry, ScenarioError> {
        keys.only(&KEYS)?;
        let Some((file, place)) = keys.text("file")? else {
            return Err(keys.missing("file", "file = \"15psi.csv\", relative to this file"));
        };
        let file = document.file(place, file);
        // It goes into tables, files and commands.
        let name =
            file.file_name().map_or(String::new(), |name| escaped(&name.to_string_lossy()).into_owned());
        if plan.is_some_and(|plan| plan.muscle.is_some()) && !keys.has("pressure") {
            return Err(keys.missing("pressure", "pressure = \"15 psi\", which the muscle needs"));
        }
        keys.text("note")?;
        let (pressure, pressures) = pressure(document, keys, &file, plan)?;
        let (start, overrides) = (start(keys)?, overrides(keys)?);
        let is_bent = start.is_some_and(|start| start != Start::Straight);
        if let (true, Some(own)) = (is_bent, overrides.iter().find(|own| own.angle.is_some())) {
            let message = format!("{NO_ANGLE}, and release {} has one; {ONE_START}", own.number);
            return Err(keys.wrong("start", ScenarioProblem::Other { message }));
        }
        let whole = |key| keys.counts(key).and_then(|counts| from_one(keys, key, counts));
        Ok(Entry {
            key: keys.path.clone(),
            name,
            file,
            pressure,
            pressures,
            payload: payload(keys)?,
            tip: markers(keys, "tip")?
                .ok_or_else(|| keys.missing("tip", "tip = with the name of a marker"))?,
            body: body(keys)?,
            base: markers(keys, "base")?.unwrap_or_default(),
            unit: unit(keys)?,
            columns: keys.texts("columns")?.map(|names| names.into_iter().map(str::to_owned).collect()),
            rate: keys.quantity_that("rate", "Hz", "be positive", |rate| rate > 0.0)?,
            up: direction(keys, "up")?,
            along: direction(keys, "along")?,
            clamp: vector(keys, "clamp", "m")?,
            base_angle: angle(keys, "base_angle")?,
            angle: angle(keys, "angle")?,
            start,
            offset: offset(keys)?,
            instants: match keys.quantities("instants", "s")? {
                Some(list) if list.is_empty() || list.windows(2).any(|pair| pair[0] >= pair[1]) => {
                    let must = "have one instant at least, and each later than the one before";
                    return Err(keys.wrong("instants", ScenarioProblem::Must { must }));
                }
                list => list,
            },
            instant_error: instant_error(keys, start == Some(Start::Rest))?,
            keep: whole("keep")?,
            drop: whole("drop")?.unwrap_or_default(),
            held_out: match keys.is_list("held_out") {
                true => HeldOut::Only(whole("held_out")?.unwrap_or_default()),
                false if keys.flag("held_out")? == Some(true) => HeldOut::All,
                false => HeldOut::Only(Vec::new()),
            },
            noise: keys.quantity_that("noise", "m", "be positive", |noise| noise > 0.0)?,
            find_spurious: keys.word("spurious", &[("mask", true), ("keep", false)])?.unwrap_or(true),
            mask: mask(keys)?,
            overrides,
        })
    }

    /// Angle of a release, from one, if it is given.
    pub fn angle_of(&self, number: usize) -> Option<f64> {
        let own = self.overrides.iter().find(|other| other.number == number).and_then(|other| other.angle);
        own.or(self.angle)
    }

    /// How the rod is held before a release, from one: bent, unless something says that it is straight.
    pub fn start_of(&self, number: usize) -> Start {
        match (self.start, self.angle_of(number)) {
            (Some(start), _) => start,
            (None, Some(_)) => Start::Straight,
            (None, None) => Start::Held,
        }
    }

    /// The pressure whose steps are the releases, unless their instants are given: that of a rod which starts at rest.
    pub fn steps(&self) -> Option<&Pressures> {
        let is_found = self.start == Some(Start::Rest) && self.instants.is_none();
        self.pressures.as_ref().filter(|_| is_found)
    }

    /// Instant of a release, from one, if it is given.
    pub fn instant_of(&self, number: usize) -> Option<f64> {
        let own = self.overrides.iter().find(|other| other.number == number).and_then(|other| other.instant);
        own.or_else(|| self.instants.as_ref()?.get(number.checked_sub(1)?).copied())
    }

    /// Whether a release, from one, is held out from fits.
    pub fn is_held_out(&self, number: usize) -> bool {
        match &self.held_out {
            HeldOut::All => true,
            HeldOut::Only(list) => list.contains(&number),
        }
    }
}

fn markers(keys: &Keys, key: &str) -> Result<Option<Vec<String>>, ScenarioError> {
    let Some(names) = keys.texts(key)? else { return Ok(None) };
    let twice = names.iter().collect::<BTreeSet<_>>().len() < names.len();
    if twice || (names.is_empty() && key == "tip") {
        let must = "name at least one marker, and none twice";
        return Err(keys.wrong(key, ScenarioProblem::Must { must }));
    }
    Ok(Some(names.into_iter().map(str::to_owned).collect()))
}

fn body(keys: &Keys) -> Result<Vec<BodyMarker>, ScenarioError> {
    let one = |table: &Keys| {
        table.only(&["marker", "at"])?;
        let missing = || table.missing("marker", "marker = with its name");
        let marker = table.text("marker")?.ok_or_else(missing)?.0.to_owned();
        let share = table.quantity("at", "");
        let at = match share {
            Ok(None) => return Err(table.missing("at", "at = \"120 mm\", or a share such as 0.6")),
            Ok(Some(share)) => At::Share(share),
            // What is no share is a length; the message is then that of a length.
            Err(_) => At::Length(table.quantity("at", "m")?.unwrap_or_default()),
        };
        match at {
            At::Share(share) if !(0.0..=1.0).contains(&share) => {
                Err(table.wrong("at", ScenarioProblem::Must { must: "be a length, or lie in 0..=1" }))
            }
            At::Length(length) if length < 0.0 => {
                Err(table.wrong("at", ScenarioProblem::Must { must: "not be negative" }))
            }
            at => Ok(BodyMarker { marker, at }),
        }
    };
    keys.tables("body")?.iter().map(one).collect()
}

fn direction(keys: &Keys, key: &str) -> Result<Option<Direction>, ScenarioError> {
    if !keys.is_list(key) {
        return keys.word(key, &AXES);
    }
    let Some(vector) = vector(keys, key, "")? else { return Ok(None) };
    let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() {
        Ok(Some(Direction::Vector(vector.map(|x| x / length))))
    } else {
        Err(keys.wrong(key, ScenarioProblem::Must { must: "not be zero, nor beyond all numbers" }))
    }
}

/// A unit by its symbol, or the length of a pixel.
fn unit(keys: &Keys) -> Result<Option<Length>, ScenarioError> {
    match keys.text("unit")?.and_then(|(text, _)| text.parse::<Length>().ok()) {
        Some(length) => Ok(Some(length)),
        None => keys.word("unit", &Length::by_symbol()),
    }
}

fn vector(keys: &Keys, key: &str, unit: &str) -> Result<Option<[f64; 3]>, ScenarioError> {
    match keys.quantities(key, unit)? {
        None => Ok(None),
        Some(list) => match list[..] {
            [x, y, z] => Ok(Some([x, y, z])),
            _ => Err(keys.wrong(
                key,
                ScenarioProblem::Must { must: "have three numbers: x, y, z of the file's frame" },
            )),
        },
    }
}

fn angle(keys: &Keys, key: &str) -> Result<Option<f64>, ScenarioError> {
    keys.quantity_that(key, "rad", "lie in -6.3..=6.3 rad (-361..=361 deg)", |a| a.abs() <= 6.3)
}

/// What to do about two starts.
const ONE_START: &str = "its posture follows from the markers; leave one of the two out";
const NO_ANGLE: &str = "a rod that is held bent, at rest or in motion has no angle";

fn start(keys: &Keys) -> Result<Option<Start>, ScenarioError> {
    let starts = [
        ("straight", Start::Straight),
        ("held", Start::Held),
        ("rest", Start::Rest),
        ("in motion", Start::InMotion),
    ];
    let start = keys.word("start", &starts)?;
    if start.is_some_and(|start| start != Start::Straight) && keys.has("angle") {
        return Err(
            keys.wrong("start", ScenarioProblem::Other { message: format!("{NO_ANGLE}; {ONE_START}") })
        );
    }
    if start == Some(Start::InMotion) && keys.quantities("instants", "s")?.is_some_and(|list| list.len() > 1)
    {
        let must = "have one instant at most if the recording begins in motion";
        return Err(keys.wrong("instants", ScenarioProblem::Must { must }));
    }
    Ok(start)
}

/// Nobody knows beforehand how well an instant will be found, so that only a given one has an error, and that of a step of pressure.
fn instant_error(keys: &Keys, is_at_rest: bool) -> Result<Option<f64>, ScenarioError> {
    let is_free = !keys.has("instants") && !keys.has("release") && !is_at_rest;
    if keys.has("instant_error") && is_free {
        let message = "belongs to instants that are given; give them too, or leave it out".to_owned();
        return Err(keys.wrong("instant_error", ScenarioProblem::Other { message }));
    }
    keys.quantity_that("instant_error", "s", "be positive", |error| error > 0.0)
}

fn offset(keys: &Keys) -> Result<Option<Offset>, ScenarioError> {
    if !keys.is_list("offset") {
        return keys.word("offset", &[("none", Offset::None), ("hold", Offset::Hold)]);
    }
    match keys.quantities("offset", "m")?.as_deref() {
        Some([along, across]) => Ok(Some(Offset::Given([*along, *across]))),
        _ => Err(keys
            .wrong("offset", ScenarioProblem::Must { must: "have two lengths: along and across the rod" })),
    }
}

fn mask(keys: &Keys) -> Result<Vec<[f64; 2]>, ScenarioError> {
    let form = "a row of two times, such as [\"1.2 s\", \"1.3 s\"],";
    let rows = keys.rows("mask", &["s", "s"], form)?;
    let rows = match rows {
        Some(rows) => rows,
        None if keys.has("mask") => {
            return Err(keys.wrong("mask", ScenarioProblem::WrongType { due: "rows of two times" }));
        }
        None => Vec::new(),
    };
    let rows: Vec<[f64; 2]> = rows.iter().map(|row| [row[0], row[1]]).collect();
    if rows.iter().any(|[from, to]| from > to) {
        Err(keys.wrong("mask", ScenarioProblem::Must { must: "have in each row the earlier time first" }))
    } else {
        Ok(rows)
    }
}

fn overrides(keys: &Keys) -> Result<Vec<Override>, ScenarioError> {
    let one = |table: &Keys| {
        table.only(&["number", "angle", "instant"])?;
        let number = from_one(table, "number", table.count("number")?.map(|number| vec![number]))?;
        let number = number.ok_or_else(|| table.missing("number", "number = 1, for the first release"))?[0];
        Ok(Override { number, angle: angle(table, "angle")?, instant: table.quantity("instant", "s")? })
    };
    keys.tables("release")?.iter().map(one).collect()
}

fn from_one(keys: &Keys, key: &str, counts: Option<Vec<usize>>) -> Result<Option<Vec<usize>>, ScenarioError> {
    if counts.as_ref().is_some_and(|counts| counts.contains(&0)) {
        Err(keys.wrong(key, ScenarioProblem::Must { must: "count releases from 1" }))
    } else {
        Ok(counts)
    }
}

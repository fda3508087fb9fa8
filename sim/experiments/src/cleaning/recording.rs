//! One recording: its markers, its releases, its frame; then each release.

use efam_core::quantile::usual_step;
use efam_recordings::{Length, Recording};
use models::quantity::format_si;

use super::base::{self, Moving};
use super::cycles::{self, Cut};
use super::decision::{Log, mm};
use super::points::{ByName, Seen, see};
use super::release::{Context, LEAST_NOISE, Rod};
use super::{
    BasePose, CleanRecording, CleanRelease, CleaningError, Decision, distance, frame, noise, release, steps,
};
use crate::experiment::{At, Entry, Experiment, ExperimentError, HeldOut, Offset, Start};
use crate::scenario::ScenarioProblem;

/// Samples that a release needs.
const LEAST_SAMPLES: usize = 20;

/// Cleans a recording of an experiment, counted from 0.
/// # Errors
/// [`ExperimentError`]: a marker that is not there, no release, no vertical.
pub fn clean_recording(
    experiment: &Experiment,
    k: usize,
    recording: Recording,
    decisions: &mut Vec<Decision>,
) -> Result<(CleanRecording, Vec<CleanRelease>), ExperimentError> {
    let entry = &experiment.recordings[k];
    let mut log = Log::new(&entry.name, decisions);
    for finding in &recording.findings {
        log.say("file", finding.clone());
    }
    let of = |key: &str| format!("{}.{key}", entry.key);
    let markers = ByName::new(&recording);
    let tip_markers = markers.find(experiment, &of("tip"), &entry.tip)?;
    let time = recording.time.clone();
    if time.len() < LEAST_SAMPLES {
        let (file, samples) = (entry.name.clone(), time.len());
        return Err(CleaningError::TooShort { file, samples, least: LEAST_SAMPLES }.into());
    }
    let step = usual_step(&time).expect("there are samples enough");
    let mut tip = see(entry, &time, step, &tip_markers, &mut log);
    let seen = tip.path.iter().flatten().count();
    if seen < LEAST_SAMPLES {
        let (file, marker, samples) = (entry.name.clone(), tip.name, time.len());
        let key = entry.key.clone();
        return Err(CleaningError::TipLost { file, marker, seen, samples, least: LEAST_SAMPLES, key }.into());
    }
    let mut body = Vec::new();
    for (number, marker) in entry.body.iter().enumerate() {
        let key = of(&format!("body[{}].marker", number + 1));
        let found = markers.find(experiment, &key, std::slice::from_ref(&marker.marker))?;
        body.push((see(entry, &time, step, &found, &mut log), marker.at));
    }
    let base = base_pose(experiment, entry, &markers, (&time, &tip.path), step, &mut log)?;
    if let Some(base) = base.as_ref().filter(|base| base.is_followed()) {
        for seen in [&mut tip].into_iter().chain(body.iter_mut().map(|(seen, _)| seen)) {
            base.take_off(&mut seen.raw);
            base.take_off(&mut seen.path);
        }
    }
    let cuts = cut(entry, &time, &tip, step, &mut log)?;
    let base_angle = entry.base_angle.or(experiment.base_angle());
    let frame = frame::find(entry, base.as_ref(), base_angle, (&time, &tip.path), &cuts, &mut log)?;
    let rod = match experiment.case(k, None)? {
        Some(case) => {
            let length = case.model.rod().length;
            Some(Rod { length, reach: length + case.model.tip_distance })
        }
        None => None,
    };
    check_numbers(entry, cuts.len())?;
    if let Some(rod) = rod {
        check_geometry(experiment, entry, rod, &frame, &cuts)?;
    }
    // Once for all releases: it is that of the whole recording.
    let noise_of = |seen: &Seen| {
        let noise = || release::noise_of(seen, &time, step, &frame, &cuts);
        entry.noise.unwrap_or_else(noise)
    };
    let noise: Vec<f64> = [&tip].into_iter().chain(body.iter().map(|(seen, _)| seen)).map(noise_of).collect();
    let context = Context {
        entry,
        time: &time,
        step,
        tip: &tip,
        body: &body,
        noise: &noise,
        frame: &frame,
        rod,
        recording: k,
    };
    let releases = (cuts.iter().enumerate())
        .map(|(number, cut)| context.release(cut, number + 1, &mut log.release(number + 1)))
        .collect();
    let masked = tip.raw.iter().zip(&tip.path).map(|(raw, used)| raw.is_some() && used.is_none()).collect();
    let clean =
        CleanRecording { name: entry.name.clone(), recording, tip: tip.raw, masked, frame, base, cuts };
    Ok((clean, releases))
}

/// Share of the rod's reach by which a tip that is held straight may be seen nearer or farther: a marker
/// may be off, a rod of another length may not.
const FARTHEST_OFF: f64 = 0.25;

/// The same of its distance from the end of the straight rod: on a thick rod a marker on top is a third of its reach
/// off, and a rod that is held in another direction is half of it off from 29 degrees on.
const FARTHEST_BESIDE: f64 = 0.5;

/// Whether markers can be where they are said to be.
fn check_geometry(
    experiment: &Experiment,
    entry: &Entry,
    rod: Rod,
    frame: &frame::Frame,
    cuts: &[Cut],
) -> Result<(), ExperimentError> {
    for (k, marker) in entry.body.iter().enumerate() {
        if matches!(marker.at, At::Length(at) if at > rod.length) {
            let range = format!("0..={}, the rod's length", format_si(rod.length, "m"));
            let key = format!("{}.body[{}].at", entry.key, k + 1);
            return Err(experiment.wrong(&key, ScenarioProblem::OutOfRange { range }));
        }
    }
    for (k, cut) in cuts.iter().enumerate() {
        let [x, _, z] = frame.place(cut.held);
        let seen = x.hypot(z);
        let is_straight = entry.angle_of(k + 1).is_some() && !matches!(entry.offset, Some(Offset::Given(_)));
        // Bent or straight, no rod reaches a thousand times its length.
        let is_of_another_unit = seen > rod.reach && Length::doubt(seen, rod.reach).is_some();
        if is_of_another_unit || is_straight && (seen - rod.reach).abs() > FARTHEST_OFF * rod.reach {
            let (file, key) = (entry.name.clone(), entry.key.clone());
            let (number, reach) = (k + 1, rod.reach);
            return Err(CleaningError::OffReach { file, key, number, seen, reach }.into());
        }
        if let Some(angle) = entry.angle_of(k + 1).filter(|_| is_straight) {
            let off = (x - rod.reach * angle.cos()).hypot(z - rod.reach * angle.sin());
            if off > FARTHEST_BESIDE * rod.reach {
                let (file, key, reach) = (entry.name.clone(), entry.key.clone(), rod.reach);
                return Err(CleaningError::OffPlace { file, key, number: k + 1, angle, off, reach }.into());
            }
        }
    }
    Ok(())
}

fn base_pose(
    experiment: &Experiment,
    entry: &Entry,
    markers: &ByName,
    (time, tip): (&[f64], &[Option<[f64; 3]>]),
    step: f64,
    log: &mut Log,
) -> Result<Option<BasePose>, ExperimentError> {
    if entry.base.is_empty() {
        log.say("base", "no base is given: one at rest is assumed");
        return Ok(None);
    }
    let found = markers.find(experiment, &format!("{}.base", entry.key), &entry.base)?;
    let body = found.iter().find_map(|marker| Some((marker, marker.orientation.as_ref()?)));
    let (mut pose, moving) = match (body, found.len()) {
        (Some((marker, orientation)), 1) => {
            let seen = &marker.position;
            (base::of_body(seen, orientation), Moving::of_body(seen, orientation))
        }
        _ => {
            let paths: Vec<_> =
                found.iter().map(|marker| see(entry, time, step, &[marker], log).path).collect();
            (base::of_markers(&paths), Moving::of_markers(&paths))
        }
    };
    if let (Some(pose), Some(tip)) = (&mut pose, cycles::mean(tip, 0..tip.len())) {
        pose.follow(time, &moving, step, distance(tip, pose.position));
    }
    match &pose {
        None => {
            log.say("base", "the base is never seen whole: it is left out, and a base at rest is assumed")
        }
        Some(pose) => {
            let turn = match found.len() {
                1 if pose.orientation.is_none() => "; its turns are not seen with one marker".to_owned(),
                _ => format!(
                    " and turns by at most {:.2} deg, standard deviation {:.3} deg",
                    pose.turned.to_degrees(),
                    pose.turn_deviation.to_degrees()
                ),
            };
            log.say(
                "base",
                format!(
                    "the base moves by at most {}, standard deviation {} along an axis{turn}, over {} frames; {}",
                    mm(pose.moved),
                    mm(pose.deviation.into_iter().fold(0.0, f64::max)),
                    pose.frames,
                    if pose.is_followed() {
                        "that is taken off all markers sample by sample"
                    } else {
                        "its mean pose is used"
                    }
                ),
            );
        }
    }
    Ok(pose)
}

fn cut(
    entry: &Entry,
    time: &[f64],
    tip: &Seen,
    step: f64,
    log: &mut Log,
) -> Result<Vec<Cut>, ExperimentError> {
    if let Some(&instant) =
        entry.instants.iter().flatten().find(|at| **at < time[0] || **at >= time[time.len() - 2])
    {
        let (file, key) = (entry.name.clone(), entry.key.clone());
        return Err(CleaningError::InstantOutside {
            file,
            key,
            instant,
            from: time[0],
            to: time[time.len() - 1],
        }
        .into());
    }
    let sigma = entry.noise.or_else(|| noise::of_path(time, &tip.path, step)).unwrap_or(LEAST_NOISE);
    let cuts = match (entry.start, entry.steps()) {
        (Some(Start::InMotion), _) => {
            cycles::cut_in_motion(time, &tip.path, step, sigma, entry.instant_of(1))
        }
        (_, Some(pressures)) => steps::cut(time, &tip.path, step, sigma, pressures),
        _ => cycles::cut(time, &tip.path, step, sigma, entry.instants.as_deref()),
    };
    let no_release = |why| CleaningError::NoRelease { file: entry.name.clone(), why, key: entry.key.clone() };
    let cuts = cuts.map_err(no_release)?;
    let spans: Vec<_> = cuts.iter().map(|cut| format!("{:.2}", time[cut.swing.start])).collect();
    log.say(
        "instants",
        format!(
            "{} release{}, near {} s",
            cuts.len(),
            if cuts.len() == 1 { "" } else { "s" },
            spans.join(", ")
        ),
    );
    Ok(cuts)
}

/// Numbers of releases that the experiment names must be there.
fn check_numbers(entry: &Entry, found: usize) -> Result<(), CleaningError> {
    let of_overrides: Vec<usize> = entry.overrides.iter().map(|other| other.number).collect();
    let held_out = match &entry.held_out {
        HeldOut::Only(list) => list.as_slice(),
        HeldOut::All => &[],
    };
    let named = [
        ("keep", entry.keep.as_deref().unwrap_or_default()),
        ("drop", &entry.drop),
        ("held_out", held_out),
        ("release.number", &of_overrides),
    ];
    for (key, numbers) in named {
        if let Some(&number) = numbers.iter().find(|number| **number > found) {
            let key = format!("{}.{key}", entry.key);
            return Err(CleaningError::NoSuchRelease { file: entry.name.clone(), key, number, found });
        }
    }
    Ok(())
}

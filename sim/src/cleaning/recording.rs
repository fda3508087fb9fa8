//! One recording: its markers, its releases, its frame; then each release.

use models::quantity::format_si;

use super::cycles::{self, Cut};
use super::decision::{Log, mm};
use super::onset::{self, Onset};
use super::points::{Seen, markers, see};
use super::{
    BasePose, CleanRecording, CleanRelease, CleaningError, Decision, Frame, Statistics, base, frame, noise,
    spurious,
};
use crate::experiment::release::{Point, Release, Track};
use crate::experiment::{At, Entry, Experiment, ExperimentError, Offset};
use crate::recording::Recording;

/// Samples that a release needs.
const LEAST_SAMPLES: usize = 20;
/// Time before the release that belongs to it, s.
const LEAD: f64 = 0.5;
/// Share of lost and masked samples from which on a release is dropped.
const MOST_MASKED: f64 = 0.5;
/// Noise of data that have none, m: a tenth of a micrometre.
const LEAST_NOISE: f64 = 1e-7;

/// What the model says of a recording: active length and distance of the tip from the clamp, m.
#[derive(Clone, Copy)]
struct Rod {
    length: f64,
    reach: f64,
}

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
    let tip_markers = markers(experiment, &recording, &of("tip"), &entry.tip)?;
    let time = recording.time.clone();
    if time.len() < LEAST_SAMPLES {
        let (file, samples) = (entry.name.clone(), time.len());
        return Err(CleaningError::TooShort { file, samples, least: LEAST_SAMPLES }.into());
    }
    let step = usual_step(&time);
    let tip = see(entry, &time, step, &tip_markers, &mut log);
    let seen = tip.path.iter().flatten().count();
    if seen < LEAST_SAMPLES {
        let (file, marker, samples) = (entry.name.clone(), tip.name, time.len());
        let key = entry.key.clone();
        return Err(CleaningError::TipLost { file, marker, seen, samples, least: LEAST_SAMPLES, key }.into());
    }
    let mut body = Vec::new();
    for (number, marker) in entry.body.iter().enumerate() {
        let key = of(&format!("body[{}].marker", number + 1));
        let found = markers(experiment, &recording, &key, std::slice::from_ref(&marker.marker))?;
        body.push((see(entry, &time, step, &found, &mut log), marker.at));
    }
    let base = base_pose(experiment, entry, &recording, step, &mut log)?;
    let cuts = cut(entry, &time, &tip, step, &mut log)?;
    let frame = frame::find(entry, base.as_ref(), &tip.path, &cuts, &mut log)?;
    let rod = match experiment.case(k, None)? {
        Some(case) => {
            let length = case.model.rod().length;
            Some(Rod { length, reach: length + case.model.tip_distance })
        }
        None => None,
    };
    check_numbers(entry, cuts.len())?;
    let context =
        Context { entry, time: &time, step, tip: &tip, body: &body, frame: &frame, rod, recording: k };
    let releases = (cuts.iter().enumerate())
        .map(|(number, cut)| context.release(cut, number + 1, &mut log.release(number + 1)))
        .collect();
    let masked = tip.raw.iter().zip(&tip.path).map(|(raw, used)| raw.is_some() && used.is_none()).collect();
    let clean =
        CleanRecording { name: entry.name.clone(), recording, tip: tip.raw, masked, frame, base, cuts };
    Ok((clean, releases))
}

/// Median time between samples, s.
fn usual_step(time: &[f64]) -> f64 {
    spurious::quantile(time.windows(2).map(|pair| pair[1] - pair[0]).collect(), 0.5).unwrap_or(1.0)
}

fn base_pose(
    experiment: &Experiment,
    entry: &Entry,
    recording: &Recording,
    step: f64,
    log: &mut Log,
) -> Result<Option<BasePose>, ExperimentError> {
    if entry.base.is_empty() {
        log.say("base", "no base is given: that it stands still is assumed");
        return Ok(None);
    }
    let found = markers(experiment, recording, &format!("{}.base", entry.key), &entry.base)?;
    let body = found.iter().find_map(|marker| Some((marker, marker.orientation.as_ref()?)));
    let pose = match (body, found.len()) {
        (Some((marker, orientation)), 1) => base::of_body(&marker.position, orientation),
        _ => {
            let paths: Vec<_> =
                found.iter().map(|marker| see(entry, &recording.time, step, &[marker], log).path).collect();
            base::of_markers(&paths)
        }
    };
    match &pose {
        None => log
            .say("base", "the base is never seen whole: it is left out, and that it stands still is assumed"),
        Some(pose) => {
            let turn = match pose.orientation {
                Some(_) => format!("and turns by at most {:.2} deg", pose.turned.to_degrees()),
                None => "; its turns are not seen with fewer than three markers".to_owned(),
            };
            log.say(
                "base",
                format!(
                    "the base moves by at most {} {turn}, over {} frames; its mean pose is used",
                    mm(pose.moved),
                    pose.frames
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
        entry.instants.iter().flatten().find(|at| **at <= time[1] || **at >= time[time.len() - 2])
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
    let cuts = cycles::cut(time, &tip.path, step, sigma, entry.instants.as_deref());
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
        crate::experiment::HeldOut::Only(list) => list.clone(),
        crate::experiment::HeldOut::All => Vec::new(),
    };
    let named = [
        ("keep", entry.keep.clone().unwrap_or_default()),
        ("drop", entry.drop.clone()),
        ("held_out", held_out),
        ("release.number", of_overrides),
    ];
    for (key, numbers) in named {
        if let Some(&number) = numbers.iter().find(|number| **number > found) {
            let key = format!("{}.{key}", entry.key);
            return Err(CleaningError::NoSuchRelease { file: entry.name.clone(), key, number, found });
        }
    }
    Ok(())
}

struct Context<'a> {
    entry: &'a Entry,
    time: &'a [f64],
    step: f64,
    tip: &'a Seen,
    body: &'a [(Seen, At)],
    frame: &'a Frame,
    rod: Option<Rod>,
    recording: usize,
}

impl Context<'_> {
    fn release(&self, cut: &Cut, number: usize, log: &mut Log) -> CleanRelease {
        let (entry, time) = (self.entry, self.time);
        let onset = self.onset(cut, number, log);
        let first = time.partition_point(|t| *t < onset.instant - LEAD).max(cut.hold.start);
        let samples = first..cut.swing.end;
        let angle = entry.angle_of(number);
        let held = self.in_plane(cut.held);
        let rest = self.in_plane(cut.rest);
        let far = held[0].hypot(held[1]);
        let length = self.rod.map_or(far, |rod| rod.length);
        let offset = self.offset(angle, held, log);
        let noise = |seen: &Seen| self.noise(seen, cut);
        let mut tracks = vec![self.track(
            &self.tip.name,
            Point::Tip,
            &self.tip.path[samples.clone()],
            offset,
            noise(self.tip),
        )];
        for (seen, at) in self.body {
            let share = match at {
                At::Share(share) => *share,
                At::Length(at) => (at / length).min(1.0),
            };
            let off = self.body_offset(seen, cut, share, angle, log);
            let path = &seen.path[samples.clone()];
            tracks.push(self.track(&seen.name, Point::Along(share), path, off, noise(seen)));
        }
        let lost = tracks[0].position.iter().filter(|at| at.is_none()).count();
        let masked_samples =
            samples.clone().filter(|&i| self.tip.raw[i].is_some() && self.tip.path[i].is_none()).count();
        let out_of_plane = frame::out_of_plane(self.frame, &self.tip.path, cut.swing.clone());
        let off = |at: [f64; 2]| [at[0] - offset[0], at[1] - offset[1]];
        let statistics = Statistics {
            samples: samples.len(),
            masked_share: lost as f64 / samples.len().max(1) as f64,
            masked_samples,
            hold_angle: held[1].atan2(held[0]),
            hold: off(held),
            rest: off(rest),
            static_drop: held[1] - rest[1],
            offset,
            hold_drift_share: self.hold_drift(cut),
            out_of_plane,
            out_of_plane_share: out_of_plane / length,
            instant_error_steps: onset.uncertainty / self.step,
            noise: tracks[0].noise,
        };
        log.say(
            "along",
            format!(
                "the tip leaves the plane of its swing by {} at most, {:.1} % of {}",
                mm(out_of_plane),
                1e2 * statistics.out_of_plane_share,
                mm(length)
            ),
        );
        let dropped = self.dropped(number, &statistics);
        if let Some(why) = &dropped {
            log.say("keep", format!("dropped: {why}"));
        }
        let release = Release {
            name: format!("{}#{number}", entry.name),
            time: time[samples].iter().map(|t| t - onset.instant).collect(),
            release_uncertainty: onset.uncertainty,
            tracks,
            pressure: entry.pressure,
            payload: entry.payload.mass,
            held_out: entry.is_held_out(number),
        };
        let (recording, instant) = (self.recording, onset.instant);
        CleanRelease {
            release,
            recording,
            number,
            instant,
            angle,
            dropped,
            representative: false,
            statistics,
        }
    }

    fn onset(&self, cut: &Cut, number: usize, log: &mut Log) -> Onset {
        if let Some(instant) = self.entry.instant_of(number) {
            log.say("instants", format!("released at {instant} s, as the experiment says"));
            return Onset { instant, uncertainty: 0.5 * self.step, acceleration: None };
        }
        match onset::estimate(self.time, &self.tip.path, cut, self.step) {
            Some(onset) => {
                let (instant, error) = (onset.instant, 1e3 * onset.uncertainty);
                let a = onset
                    .acceleration
                    .map_or(String::new(), |a| format!(", which falls at {}", format_si(a, "m/s^2")));
                log.say(
                    "instants",
                    format!(
                        "released at {instant:.4} s ± {error:.1} ms, where a parabola{a} leaves the hold"
                    ),
                );
                onset
            }
            None => {
                let instant = self.time[cut.hold.end];
                log.say(
                    "instants",
                    format!("released near {instant:.3} s: too little of the fall is seen for more"),
                );
                Onset { instant, uncertainty: 3.0 * self.step, acceleration: None }
            }
        }
    }

    fn in_plane(&self, at: [f64; 3]) -> [f64; 2] {
        let [x, _, z] = self.frame.place(at);
        [x, z]
    }

    /// What is taken off the tip's place, in W, m.
    fn offset(&self, angle: Option<f64>, held: [f64; 2], log: &mut Log) -> [f64; 2] {
        let reach = self.rod.map(|rod| rod.reach);
        let default = if angle.is_some() && reach.is_some() { Offset::Hold } else { Offset::None };
        let direction = angle.unwrap_or_else(|| held[1].atan2(held[0]));
        let (sin, cos) = direction.sin_cos();
        match (self.entry.offset.unwrap_or(default), reach) {
            (Offset::Given([along, across]), _) => [along * cos - across * sin, along * sin + across * cos],
            (Offset::Hold, Some(reach)) => {
                let off = [held[0] - reach * cos, held[1] - reach * sin];
                let share = 1e2 * off[0].hypot(off[1]) / reach;
                log.say("offset", format!(
                    "while the rod is held straight at {:.1} deg the tip marker stands {} ahead of and {} above its end \
                     ({share:.1} % of the reach): taken off as static bias",
                    direction.to_degrees(), mm(off[0]), mm(off[1])
                ));
                off
            }
            (Offset::Hold, None) => {
                log.say("offset", "without a [rod] or [muscle] it is not known where the held tip must be: nothing is taken off");
                [0.0; 2]
            }
            (Offset::None, _) => {
                log.say(
                    "offset",
                    "no static bias is taken off: the angle of the straight rod at the hold is not given",
                );
                [0.0; 2]
            }
        }
    }

    /// The same of a marker along the rod: only while the rod is held straight its place is known.
    fn body_offset(&self, seen: &Seen, cut: &Cut, share: f64, angle: Option<f64>, log: &mut Log) -> [f64; 2] {
        let (Some(rod), Some(angle)) = (self.rod, angle) else { return [0.0; 2] };
        let held = cycles::mean(&seen.path, cut.late_hold(self.time)).map(|at| self.in_plane(at));
        let (Some(held), false) = (held, self.entry.offset == Some(Offset::None)) else { return [0.0; 2] };
        let off = [held[0] - share * rod.length * angle.cos(), held[1] - share * rod.length * angle.sin()];
        log.say(
            "offset",
            format!(
                "{}: {} ahead and {} above its place while held: taken off",
                seen.name,
                mm(off[0]),
                mm(off[1])
            ),
        );
        off
    }

    fn track(&self, name: &str, at: Point, path: &[Option<[f64; 3]>], offset: [f64; 2], noise: f64) -> Track {
        let place = |at: [f64; 3]| {
            let [x, z] = self.in_plane(at);
            [x - offset[0], z - offset[1]]
        };
        let position = path.iter().map(|at| at.map(place)).collect();
        Track { marker: name.to_owned(), at, position, noise }
    }

    /// Noise of a point: where it rests, else over the release.
    fn noise(&self, seen: &Seen, cut: &Cut) -> f64 {
        if let Some(noise) = self.entry.noise {
            return noise;
        }
        let path: Vec<Option<[f64; 2]>> = seen.path.iter().map(|at| at.map(|at| self.in_plane(at))).collect();
        let late = cut.swing.start + 2 * cut.swing.len() / 3;
        let still = |i: usize| cut.hold.contains(&i) || (late..cut.swing.end).contains(&i);
        let found = noise::of_samples(self.time, &path, self.step, still)
            .or_else(|| noise::of_samples(self.time, &path, self.step, |_| true));
        found.unwrap_or(LEAST_NOISE).max(LEAST_NOISE)
    }

    /// Way of the tip over the end of the hold in that from hold to rest.
    fn hold_drift(&self, cut: &Cut) -> f64 {
        let late = cut.late_hold(self.time);
        let middle = late.start + late.len() / 2;
        let halves = (
            cycles::mean(&self.tip.path, late.start..middle),
            cycles::mean(&self.tip.path, middle..late.end),
        );
        match halves {
            (Some(a), Some(b)) => 2.0 * super::distance(a, b) / super::distance(cut.held, cut.rest),
            _ => 0.0,
        }
    }

    fn dropped(&self, number: usize, statistics: &Statistics) -> Option<String> {
        if let Some(keep) = &self.entry.keep {
            return (!keep.contains(&number)).then(|| "it is not in keep".to_owned());
        }
        if self.entry.drop.contains(&number) {
            return Some("the experiment says so".to_owned());
        }
        (statistics.masked_share > MOST_MASKED)
            .then(|| format!("{:.0} % of its samples are lost or masked", 1e2 * statistics.masked_share))
    }
}

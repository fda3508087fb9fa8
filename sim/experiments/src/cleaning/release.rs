//! One release of a recording: its instant, its tracks in W, its numbers.

use models::quantity::format_si;

use super::cycles::{self, Cut};
use super::decision::{Log, mm};
use super::onset::{self, Onset};
use super::points::Seen;
use super::{CleanRelease, Frame, Statistics, distance, frame, noise};
use crate::experiment::{At, Entry, Offset, Start};
use crate::release::{OutOfPlane, Point, Release, Track};

/// What the model says of a recording: active length and distance of the tip from the clamp, m.
#[derive(Clone, Copy)]
pub(super) struct Rod {
    pub length: f64,
    pub reach: f64,
}

/// Time before the release that belongs to it, s.
const LEAD: f64 = 0.5;
/// Share of lost and masked samples from which on a release is dropped.
const MOST_MASKED: f64 = 0.5;
/// Noise of data that have none, m: a tenth of a micrometre.
pub(super) const LEAST_NOISE: f64 = 1e-7;

/// A recording as its releases see it.
pub(super) struct Context<'a> {
    pub entry: &'a Entry,
    pub time: &'a [f64],
    pub step: f64,
    pub tip: &'a Seen,
    pub body: &'a [(Seen, At)],
    /// Noise of the tip, then of each point of the body, m.
    pub noise: &'a [f64],
    pub frame: &'a Frame,
    pub rod: Option<Rod>,
    pub recording: usize,
}

impl Context<'_> {
    /// The release after a hold, counted from 1.
    pub fn release(&self, cut: &Cut, number: usize, log: &mut Log) -> CleanRelease {
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
        let mut tracks = vec![self.track(
            &self.tip.name,
            Point::Tip,
            &self.tip.path[samples.clone()],
            offset,
            self.noise[0],
        )];
        for ((seen, at), noise) in self.body.iter().zip(&self.noise[1..]) {
            let share = match at {
                At::Share(share) => *share,
                At::Length(at) => (at / length).min(1.0),
            };
            let off = self.body_offset(seen, cut, share, angle, log);
            let path = &seen.path[samples.clone()];
            tracks.push(self.track(&seen.name, Point::Along(share), path, off, *noise));
        }
        let lost = tracks[0].position.iter().filter(|at| at.is_none()).count();
        let masked_samples =
            samples.clone().filter(|&i| self.tip.raw[i].is_some() && self.tip.path[i].is_none()).count();
        let [out_of_plane, sway] = frame::across(self.frame, &self.tip.path, cut.swing.clone());
        let off = |at: [f64; 2]| [at[0] - offset[0], at[1] - offset[1]];
        let statistics = Statistics {
            samples: samples.len(),
            masked_share: lost as f64 / samples.len().max(1) as f64,
            masked_samples,
            hold_angle: held[1].atan2(held[0]),
            hold: off(held),
            rest: off(rest),
            static_drop: (entry.start_of(number) != Start::InMotion).then_some(held[1] - rest[1]),
            offset,
            hold_drift_share: self.hold_drift(cut),
            out_of_plane,
            out_of_plane_share: out_of_plane / length,
            sway_share: sway / length,
            instant_error_steps: onset.uncertainty / self.step,
            noise: tracks[0].noise,
        };
        log.say(
            "along",
            format!(
                "the tip is {} at most from the vertical plane through the clamp's axis, {:.1} % of {}, and sways by {} about \
                 a plane beside it",
                mm(out_of_plane),
                1e2 * statistics.out_of_plane_share,
                mm(length),
                mm(sway)
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
            pressure: entry.pressures.as_ref().map(|all| all.at(onset.instant)).or(entry.pressure),
            payload: entry.payload.mass,
            held_out: entry.is_held_out(number),
            out_of_plane: OutOfPlane { distance: out_of_plane, share: out_of_plane / length },
        };
        let (recording, instant) = (self.recording, onset.instant);
        CleanRelease {
            release,
            recording,
            number,
            instant,
            swings_until: time[cut.rest_end - 1] - onset.instant,
            angle,
            dropped,
            representative: false,
            statistics,
        }
    }

    fn onset(&self, cut: &Cut, number: usize, log: &mut Log) -> Onset {
        if self.entry.start_of(number) == Start::InMotion {
            let instant = self.time[cut.hold.start];
            log.say("start", format!("in motion at {instant:.4} s: posture and velocity there are fitted"));
            return Onset { instant, uncertainty: 0.0, acceleration: None, push: None };
        }
        if let Some(instant) = self.entry.instant_of(number) {
            log.say("instants", format!("released at {instant} s, as the experiment says"));
            let uncertainty = self.entry.instant_error.unwrap_or(0.5 * self.step);
            return Onset { instant, uncertainty, acceleration: None, push: None };
        }
        if self.entry.steps().is_some() {
            let instant = self.time[cut.hold.end - 1];
            log.say("instants", format!("at rest until {instant:.4} s, where its pressure steps"));
            let uncertainty = self.entry.instant_error.unwrap_or(0.5 * self.step);
            return Onset { instant, uncertainty, acceleration: None, push: None };
        }
        match onset::estimate(self.time, &self.tip.path, cut, self.step) {
            Some(onset) => {
                let (instant, error) = (onset.instant, 1e3 * onset.uncertainty);
                let a = onset
                    .acceleration
                    .map_or(String::new(), |a| format!(", which falls at {}", format_si(a, "m/s^2")));
                let push = onset.push.map_or(String::new(), |push| {
                    format!(
                        ", after a push of the hand, which gave it {} along its fall",
                        format_si(push, "m/s")
                    )
                });
                log.say(
                    "instants",
                    format!(
                        "released at {instant:.4} s ± {error:.1} ms, where a parabola{a} leaves the hold{push}"
                    ),
                );
                onset
            }
            None => {
                let instant = self.time[cut.hold.end];
                // Where the tip is lost after the hold, it may have been let go at any time of that.
                let seen = cut.swing.clone().find(|&i| self.tip.path[i].is_some());
                let unseen = seen.map_or(0.0, |i| self.time[i] - instant);
                log.say(
                    "instants",
                    format!("released near {instant:.3} s: too little of the fall is seen for more"),
                );
                Onset { instant, uncertainty: unseen.max(3.0 * self.step), acceleration: None, push: None }
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
                let why = match (self.entry.offset, reach) {
                    (Some(_), _) => "as the experiment says",
                    (None, None) => "without a [rod] or [muscle] it is not known where the tip must be",
                    (None, Some(_)) => "the angle of the straight rod at the hold is not given",
                };
                log.say("offset", format!("no static bias is taken off the tip: {why}"));
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
        Track { marker: name.to_owned(), at, position, noise, discrepancy: 0.0 }
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
            (Some(a), Some(b)) => 2.0 * distance(a, b) / distance(cut.held, cut.rest),
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

/// Noise of a point: while it is held and late in every swing, else over the whole recording.
pub(super) fn noise_of(seen: &Seen, time: &[f64], step: f64, frame: &Frame, cuts: &[Cut]) -> f64 {
    let in_plane = |at| {
        let [x, _, z] = frame.place(at);
        [x, z]
    };
    let path: Vec<Option<[f64; 2]>> = seen.path.iter().map(|at| at.map(in_plane)).collect();
    let mut still = vec![false; time.len()];
    for cut in cuts {
        still[cut.hold.clone()].fill(true);
        still[cut.swing.start + 2 * cut.swing.len() / 3..cut.swing.end].fill(true);
    }
    let found = noise::of_samples(time, &path, step, |i| still[i])
        .or_else(|| noise::of_samples(time, &path, step, |_| true));
    found.unwrap_or(LEAST_NOISE).max(LEAST_NOISE)
}

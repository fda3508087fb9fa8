//! Which markers are what, and which of their samples are used.

use std::collections::HashMap;

use efam_recordings::{Marker, Recording};
use efam_store::escape::escaped;
use models::nearest::{nearest, offer};

use super::decision::{Log, mm};
use super::{bursts, noise, spurious};
use crate::experiment::{Entry, Experiment, ExperimentError};
use crate::scenario::ScenarioProblem;

/// A point of the rod: a marker, or the centroid of several.
#[derive(Clone, Debug)]
pub struct Seen {
    /// Its name.
    pub name: String,
    /// Where it was seen, m, in the recording's frame, shape `[samples]`.
    pub raw: Vec<Option<[f64; 3]>>,
    /// The same without what is masked.
    pub path: Vec<Option<[f64; 3]>>,
}

/// The markers of a recording by their names.
pub struct ByName<'a> {
    recording: &'a Recording,
    places: HashMap<&'a str, usize>,
}

impl<'a> ByName<'a> {
    /// All markers of a recording; of two with one name, the first.
    pub fn new(recording: &'a Recording) -> Self {
        let places = recording.markers.iter().enumerate().rev();
        Self { recording, places: places.map(|(place, marker)| (marker.name.as_str(), place)).collect() }
    }

    /// The markers of some names under a key of the experiment.
    pub fn find(
        &self,
        experiment: &Experiment,
        key: &str,
        names: &[String],
    ) -> Result<Vec<&'a Marker>, ExperimentError> {
        let find = |name: &String| {
            // A recording names its markers visibly.
            let name = escaped(name);
            let place = self.places.get(name.as_ref()).ok_or_else(|| self.missing(experiment, key, &name))?;
            Ok(&self.recording.markers[*place])
        };
        names.iter().map(find).collect()
    }

    fn missing(&self, experiment: &Experiment, key: &str, name: &str) -> ExperimentError {
        let known = || self.recording.markers.iter().map(|marker| marker.name.as_str());
        let file = self.recording.source.file_name().unwrap_or_default().to_string_lossy();
        let meant = offer(nearest(name, known()));
        let mut list: Vec<&str> = known().take(MOST_NAMES).collect();
        if self.recording.markers.len() > MOST_NAMES {
            list.push("…");
        }
        let message = format!("{file} has no marker `{name}`{meant}; it has {}", list.join(", "));
        experiment.wrong(key, ScenarioProblem::Other { message })
    }
}

/// Names that a message lists.
const MOST_NAMES: usize = 20;

/// The point that some markers make: their centroid where all are seen, because the centroid of fewer
/// jumps.
pub fn see(entry: &Entry, time: &[f64], step: f64, markers: &[&Marker], log: &mut Log) -> Seen {
    let name = markers.iter().map(|marker| marker.name.as_str()).collect::<Vec<_>>().join(" + ");
    let raw: Vec<_> = markers.iter().map(|marker| marker.position.clone()).collect();
    let mut used = raw.clone();
    if entry.find_spurious {
        for (marker, path) in markers.iter().zip(&mut used) {
            mask_and_tell(marker, time, step, path, log);
        }
    }
    let mut path = centroid(&used);
    let mut masked = 0;
    for (at, point) in time.iter().zip(&mut path) {
        if entry.mask.iter().any(|[from, to]| (*from..=*to).contains(at)) && point.take().is_some() {
            masked += 1;
        }
    }
    if masked > 0 {
        log.say("mask", format!("{name}: {masked} samples are masked as the experiment says"));
    }
    Seen { name, raw: centroid(&raw), path }
}

/// Empties samples that do not belong to the path of a marker; says how many single ones, and how many in bursts. `step` is
/// the usual time between samples, s.
pub fn mask_spurious(time: &[f64], step: f64, path: &mut [Option<[f64; 3]>]) -> [usize; 2] {
    let empty = |path: &mut [Option<[f64; 3]>], found: &[bool]| {
        path.iter_mut()
            .zip(found)
            .map(|(point, found)| usize::from(*found && point.take().is_some()))
            .sum::<usize>()
    };
    let mut single = empty(path, &spurious::find(time, path, step));
    let sigma = noise::of_path(time, path, step).unwrap_or(0.0);
    let in_bursts = empty(path, &bursts::find(time, path, step, sigma));
    if in_bursts > 0 {
        single += empty(path, &spurious::find(time, path, step));
    }
    [single, in_bursts]
}

/// Empties samples that do not belong to a marker's path, and says so.
fn mask_and_tell(marker: &Marker, time: &[f64], step: f64, path: &mut [Option<[f64; 3]>], log: &mut Log) {
    let [single, in_bursts] = mask_spurious(time, step, path);
    if single + in_bursts > 0 {
        let seen = marker.position.iter().flatten().count();
        let left = |i: usize| spurious::from_neighbours(time, path, i, marker.position[i]);
        let farthest = (0..path.len()).filter(|&i| path[i].is_none()).filter_map(left).fold(0.0, f64::max);
        let percent = 1e2 * (single + in_bursts) as f64 / seen.max(1) as f64;
        log.say(
            "spurious",
            format!(
                "{}: {single} single samples and {in_bursts} in bursts lie where the marker cannot have been, up \
                 to {} away, and are masked ({percent:.2} %)",
                marker.name,
                mm(farthest)
            ),
        );
    }
}

/// Mean of paths where all are seen.
pub(super) fn centroid(paths: &[Vec<Option<[f64; 3]>>]) -> Vec<Option<[f64; 3]>> {
    let samples = paths.first().map_or(0, Vec::len);
    let at = |i: usize| {
        let mut sum = [0.0; 3];
        for path in paths {
            let point = path[i]?;
            (0..3).for_each(|k| sum[k] += point[k] / paths.len() as f64);
        }
        Some(sum)
    };
    (0..samples).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cleaning::tests::{Noise, falling_swing};

    /// Four samples say where a fifth should be; beside a long gap and at the ends there are fewer.
    #[test]
    fn a_ghost_beside_a_gap_or_at_an_end_is_masked() {
        let mut noise = Noise::new(5);
        let (time, mut path) = falling_swing(1.23, 6.0, 0.2, 8.0, 0.01);
        noise.disturb(&mut path, 3e-4);
        path[300..312].fill(None);
        path[400..415].fill(None);
        let ghosts = [0, 299, 416, path.len() - 1];
        ghosts.iter().for_each(|i| path[*i].as_mut().unwrap()[2] += 0.1);
        let lost = |path: &[Option<[f64; 3]>]| path.iter().filter(|point| point.is_none()).count();
        let before = lost(&path);
        let masked = mask_spurious(&time, 0.01, &mut path);
        assert!(ghosts.iter().all(|i| path[*i].is_none()), "{masked:?}");
        // Of two at an end that do not agree, either may be the marker.
        assert!(lost(&path) - before <= 2 * ghosts.len(), "{masked:?}");
    }
}

//! Samples in the order of their times: rows that come twice, and files that begin with the last sample.
//!
//! A row with the time and the places of the one before says nothing new. Times that descend from the first to the last
//! leave one order. Any other order may be that of two recordings, and is refused.

use super::Marker;

/// Puts samples in order; what was done, in plain words. `places` say where each is from, in so many of `place`.
pub(super) fn put(
    times: &mut Vec<f64>,
    frames: &mut Vec<f64>,
    markers: &mut [Marker],
    places: &mut Vec<u64>,
    place: &str,
) -> Vec<String> {
    let mut done = Vec::new();
    if times.is_empty() && frames.is_empty() {
        return done;
    }
    let is_same = |all: &[f64], k: usize| all.is_empty() || all[k] == all[k - 1];
    let is_again = |k: usize| {
        let is_still = |own: &Marker| own.position[k] == own.position[k - 1];
        is_same(times, k) && is_same(frames, k) && markers.iter().all(is_still)
    };
    let keep: Vec<bool> = (0..places.len()).map(|k| k == 0 || !is_again(k)).collect();
    let again = keep.iter().filter(|keep| !**keep).count();
    if again > 0 {
        retain(&keep, times);
        retain(&keep, frames);
        retain(&keep, places);
        markers.iter_mut().for_each(|own| own.retain(&keep));
        done.push(format!(
            "{again} {place}s have the time and the places of the one before; they were left out"
        ));
    }
    let descends = |all: &[f64]| all.len() > 1 && all.windows(2).all(|pair| pair[1] < pair[0]);
    if descends(times) || times.is_empty() && descends(frames) {
        times.reverse();
        frames.reverse();
        places.reverse();
        for marker in markers {
            marker.position.reverse();
            marker.orientation.iter_mut().for_each(|turns| turns.reverse());
        }
        done.push("the last sample comes first; the order was reversed".to_owned());
    }
    done
}

/// Leaves those for which there is `true`; a list of another length stays as it is.
pub(super) fn retain<T>(keep: &[bool], list: &mut Vec<T>) {
    let mut kept = keep.iter();
    if list.len() == keep.len() {
        list.retain(|_| kept.next().is_some_and(|keep| *keep));
    }
}

impl Marker {
    /// Leaves the samples for which there is `true`.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        retain(keep, &mut self.position);
        self.orientation.iter_mut().for_each(|turns| retain(keep, turns));
    }
}

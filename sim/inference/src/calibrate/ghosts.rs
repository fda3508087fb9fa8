//! Samples that jump and come back: another thing that was taken for the marker.

use efam_core::loss::spread;
use efam_experiments::release::Release;

/// Distance of a sample from the middle of its two neighbours, in that of most samples, beyond which another thing was
/// taken for the marker. One of a hundred million samples is as far by chance.
const GHOST: f64 = 6.0;

/// Samples of the tip that are there, with their times, but for ghosts.
pub(super) fn known(release: &Release) -> Vec<(f64, [f64; 2])> {
    let path = &release.tracks[release.leading_track()].position;
    let (time, ghosts) = (&release.time, ghosts(path));
    (0..path.len()).filter(|k| !ghosts[*k]).filter_map(|k| Some((time[k], path[k]?))).collect()
}

/// Which samples jump and come back at once: another thing that was taken for the marker, whatever a model says.
pub(crate) fn ghosts(path: &[Option<[f64; 2]>]) -> Vec<bool> {
    let all: Vec<(usize, [f64; 2])> =
        path.iter().enumerate().filter_map(|(k, at)| Some((k, (*at)?))).collect();
    let jump = |three: &[(usize, [f64; 2])]| {
        let off = |axis: usize| three[1].1[axis] - 0.5 * (three[0].1[axis] + three[2].1[axis]);
        off(0).hypot(off(1))
    };
    let jumps: Vec<f64> = all.windows(3).map(jump).collect();
    let usual = spread(jumps.clone());
    let at = |k: usize| jumps.get(k.wrapping_sub(1)).copied().unwrap_or(0.0);
    let mut ghosts = vec![false; path.len()];
    for (k, (place, _)) in all.iter().enumerate() {
        // The neighbours of a ghost jump half as far as it, those of a turn as far.
        ghosts[*place] = at(k) > GHOST * usual && at(k) > 1.5 * at(k + 1).max(at(k.wrapping_sub(1)));
    }
    ghosts
}

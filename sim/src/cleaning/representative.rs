//! The release that stands for several of the same pressure and payload, as the paper chose one by eye.

use super::CleanRelease;

/// Marks in each group the release with the least of: masked share, out-of-plane share, drift of the hold
/// in its length of swing, uncertainty of its instant in sampling steps, each with weight one.
pub(super) fn choose(releases: &mut [CleanRelease]) {
    let mut done: Vec<(Option<u64>, u64)> = Vec::new();
    for k in 0..releases.len() {
        let group = group(&releases[k]);
        if done.contains(&group) {
            continue;
        }
        done.push(group);
        let best = (0..releases.len())
            .filter(|&i| self::group(&releases[i]) == group && releases[i].dropped.is_none())
            .min_by(|&a, &b| score(&releases[a]).total_cmp(&score(&releases[b])));
        if let Some(best) = best {
            releases[best].representative = true;
        }
    }
}

fn group(of: &CleanRelease) -> (Option<u64>, u64) {
    (of.release.pressure.map(f64::to_bits), of.release.payload.to_bits())
}

fn score(of: &CleanRelease) -> f64 {
    let s = &of.statistics;
    s.masked_share + s.out_of_plane_share + s.hold_drift_share + s.instant_error_steps
}

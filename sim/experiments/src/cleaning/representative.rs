//! The release that represents several of the same pressure and payload, as the paper chose one by eye.

use std::collections::HashMap;

use super::CleanRelease;

/// Marks in each group the release with the least of: masked share, sway across its plane, drift of the hold
/// in its length of swing, uncertainty of its instant in sampling steps, each with weight one.
pub(super) fn choose(releases: &mut [CleanRelease]) {
    let mut best: HashMap<(Option<u64>, u64), usize> = HashMap::new();
    for (k, release) in releases.iter().enumerate().filter(|(_, release)| release.dropped.is_none()) {
        let best = best.entry(group(release)).or_insert(k);
        // The first of equals stays.
        if score(release).total_cmp(&score(&releases[*best])).is_lt() {
            *best = k;
        }
    }
    best.into_values().for_each(|k| releases[k].representative = true);
}

fn group(of: &CleanRelease) -> (Option<u64>, u64) {
    (of.release.pressure.map(f64::to_bits), of.release.payload.to_bits())
}

fn score(of: &CleanRelease) -> f64 {
    let s = &of.statistics;
    s.masked_share + s.sway_share + s.hold_drift_share + s.instant_error_steps
}

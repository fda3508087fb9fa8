//! Where the marker of the tip was seen beside the tip of the model, as the fits of its releases found it.

use efam_core::point::Point;
use efam_experiments::release::Release;
use models::muscle::Marker;

use super::unknowns::offset_of;

/// That of the marker of the first release, over all releases that have it; `found` gives a nuisance of a release, with
/// its standard error. None where the offset was taken as given.
pub(crate) fn marker<'a>(
    releases: impl Iterator<Item = &'a Release>,
    found: impl Fn(&Release, &str) -> Option<(f64, f64)>,
) -> Option<Marker> {
    let of = |release: &'a Release| {
        let tip = release.tracks.iter().find(|track| track.at == Point::Tip)?;
        let offset = |letter| found(release, &offset_of(&tip.marker, letter));
        Some((tip.marker.as_str(), [offset("x")?, offset("z")?]))
    };
    let all: Vec<_> = releases.filter_map(of).collect();
    let (name, _) = all.first()?;
    let own: Vec<_> = all.iter().filter(|(other, _)| other == name).map(|(_, offset)| *offset).collect();
    Marker::of(name, &own)
}

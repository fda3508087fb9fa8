//! Offset of the tip's marker from the tip of the model, over the releases of a fit.

use efam_core::point::Point;
use efam_experiments::release::Release;
use models::muscle::Marker;

use super::unknowns::offset_of;

/// The offset of the first release's marker, over all releases that have this marker. `found` gives a nuisance parameter of a
/// release with its standard error. None where the offset was taken as given.
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

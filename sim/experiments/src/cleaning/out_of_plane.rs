//! How far a tip hangs beside the plane of the model: the paper's statistic.
//!
//! The plane is the vertical one through the clamp's axis. The model's rod stays in it. A tip at the distance `y` beside it,
//! on a rod of the length `L`, is seen in the plane some `y² / 2L` nearer to the clamp: the side of a right triangle.
//!
//! Source: Garbulinski and Wereley (2022), Bending Properties of an Extensile Fluidic Artificial Muscle, section Data: the
//! largest distance of each pressure, its mean and standard deviation over the pressures.

use schemars::JsonSchema;
use serde::Serialize;

use crate::release::{OutOfPlane, Release};

use super::mm;

/// The largest distances over the pressures of an experiment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct OverPressures {
    /// Pressures that count; one where none is stated.
    pub pressures: usize,
    /// Distance.
    pub distance_m: Spread,
    /// Distance over the active length or, without a model, over the distance of the held tip.
    pub share: Spread,
}

/// How numbers of several pressures are spread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Spread {
    /// The largest.
    pub largest: f64,
    /// Their mean.
    pub mean: f64,
    /// Their standard deviation; none of one pressure.
    pub deviation: Option<f64>,
}

impl Spread {
    fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        let deviation = (values.len() > 1).then(|| (square / (count - 1.0)).sqrt());
        Self { largest: values.iter().copied().fold(0.0, f64::max), mean, deviation }
    }
}

/// Of each pressure the largest distance of its releases, then their spread; none without releases.
pub fn over_pressures<'a>(releases: impl Iterator<Item = &'a Release>) -> Option<OverPressures> {
    let mut cases: Vec<(Option<f64>, OutOfPlane)> = Vec::new();
    for release in releases {
        let own = release.out_of_plane;
        match cases.iter_mut().find(|(pressure, _)| *pressure == release.pressure) {
            Some((_, most)) => {
                most.distance = most.distance.max(own.distance);
                most.share = most.share.max(own.share);
            }
            None => cases.push((release.pressure, own)),
        }
    }
    let spread =
        |of: fn(&OutOfPlane) -> f64| Spread::of(&cases.iter().map(|(_, own)| of(own)).collect::<Vec<_>>());
    (!cases.is_empty()).then(|| OverPressures {
        pressures: cases.len(),
        distance_m: spread(|own| own.distance),
        share: spread(|own| own.share),
    })
}

impl OverPressures {
    /// In words, for a table.
    pub fn words(&self) -> String {
        let Self { pressures, distance_m, share } = self;
        let largest = format!("{} at most ({:.1} %)", mm(distance_m.largest), 1e2 * share.largest);
        match (distance_m.deviation, share.deviation) {
            (Some(distance), Some(of_share)) => format!(
                "{largest}; {:.2} ± {:.2} mm ({:.1} ± {:.1} %) over {pressures} pressures",
                1e3 * distance_m.mean,
                1e3 * distance,
                1e2 * share.mean,
                1e2 * of_share
            ),
            _ => largest,
        }
    }
}

/// What the planar model leaves out of these releases, where that is more than the noise of one sample; one sentence for
/// all of them.
pub fn warning<'a>(releases: impl Iterator<Item = &'a Release>) -> Option<String> {
    let noise = |release: &Release| release.tracks.get(release.leading_track()).map_or(0.0, |tip| tip.noise);
    let matters = |release: &&Release| release.out_of_plane.shortening() > noise(release);
    let all: Vec<&Release> = releases.collect();
    let own: Vec<&Release> = all.iter().copied().filter(matters).collect();
    let worst = own.iter().max_by(|a, b| a.out_of_plane.share.total_cmp(&b.out_of_plane.share))?;
    Some(format!(
        "{} of {} releases leave the plane of the model: {} by {} ({:.1} % of the length) from the vertical plane through \
         the clamp's axis, so that the rod is seen {} too short, where the noise is {}; check clamp and along in \
         [[recording]]; if they are right, the answer leaves this deflection out",
        own.len(),
        all.len(),
        worst.name,
        mm(worst.out_of_plane.distance),
        1e2 * worst.out_of_plane.share,
        mm(worst.out_of_plane.shortening()),
        mm(noise(worst)),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::release::{Point, Track};

    fn release(name: &str, pressure: f64, distance: f64, noise: f64) -> Release {
        let tip = Track {
            marker: "tip".to_owned(),
            at: Point::Tip,
            position: vec![Some([0.2, 0.0])],
            noise,
            discrepancy: 0.0,
        };
        Release {
            name: name.to_owned(),
            time: vec![0.0],
            release_uncertainty: 1e-3,
            tracks: vec![tip],
            pressure: Some(pressure),
            payload: 0.0,
            held_out: false,
            out_of_plane: OutOfPlane { distance, share: distance / 0.2 },
        }
    }

    /// Of each pressure the farthest release counts, then mean and standard deviation of these: 10, 20 and 30 mm.
    #[test]
    fn the_statistic_is_that_of_the_farthest_release_of_each_pressure() {
        let all = [(1e5, 4e-3), (1e5, 10e-3), (2e5, 20e-3), (3e5, 30e-3), (3e5, 1e-3)];
        let all = all.map(|(pressure, distance)| release("one", pressure, distance, 1e-4));
        let found = over_pressures(all.iter()).unwrap();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        let Spread { largest, mean, deviation } = found.distance_m;
        assert!(near(largest, 0.03) && near(mean, 0.02) && near(deviation.unwrap(), 0.01), "{found:?}");
        assert!(near(found.share.largest, 0.15) && near(found.share.deviation.unwrap(), 0.05), "{found:?}");
        assert_eq!(found.pressures, 3);
        let one = over_pressures(all[..2].iter()).unwrap();
        assert_eq!((one.pressures, one.distance_m.deviation), (1, None));
        assert_eq!(over_pressures([].iter()), None);
    }

    /// 30 mm beside the plane make 200 mm seem 2.25 mm shorter; 3 mm make 0.02 mm, less than the noise.
    #[test]
    fn it_is_warned_of_where_it_exceeds_the_noise() {
        let all = [release("a#1", 1e5, 3e-3, 1e-4), release("a#2", 1e5, 30e-3, 1e-4)];
        assert!((all[1].out_of_plane.shortening() - 2.25e-3).abs() < 1e-12);
        assert_eq!(warning(all[..1].iter()), None);
        let words = warning(all.iter()).unwrap();
        assert!(words.starts_with("1 of 2 releases leave the plane of the model: a#2 by 30"), "{words}");
    }
}

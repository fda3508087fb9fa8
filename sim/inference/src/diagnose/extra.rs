//! What could be recorded besides the releases at hand.

use efam_experiments::release::{Point, Track};

use crate::calibrate::Trial;

/// What could be recorded besides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Extra {
    BodyMarkers,
    Angles,
    Payload,
    LongRecord,
}

use Extra::{Angles, BodyMarkers, LongRecord, Payload};

/// What may be recorded.
pub(super) const ONE_MORE: [&[Extra]; 4] = [&[BodyMarkers], &[Angles], &[Payload], &[LongRecord]];
/// The same where that is not enough.
pub(super) const TWO_MORE: [&[Extra]; 2] = [&[BodyMarkers, Payload], &[BodyMarkers, LongRecord]];
/// The same where that is not enough either.
pub(super) const ALL_MORE: [&[Extra]; 2] = [&[Angles, Payload], &[BodyMarkers, Angles, Payload, LongRecord]];

impl Extra {
    pub fn words(self) -> &'static str {
        match self {
            BodyMarkers => "with markers at 0.3, 0.55 and 0.8 of the length",
            Angles => "repeated from 25 degrees below",
            Payload => "repeated with 20 g at the tip",
            LongRecord => "three times as long",
        }
    }

    /// A release of the larger experiment beside those at hand; none where it is no other one.
    pub fn repeated(self, trial: &Trial) -> Option<Trial> {
        let mut trial = trial.clone();
        trial.is_straight().then_some(())?;
        match self {
            Angles => {
                let k = trial.model.index("release.angle").ok()?;
                trial.model.theta[k] -= 25f64.to_radians();
                trial.release.name += ", from 25 degrees below";
            }
            Payload if trial.release.payload == 0.0 => {
                trial.model = trial.model.with_effect("payload", &[("mass", 0.02)]).ok()?;
                trial.release.name += ", with 20 g";
            }
            Payload | BodyMarkers | LongRecord => return None,
        }
        Some(trial)
    }
}

/// Markers along the body, if there is one marker alone.
pub(super) fn add_body_markers(trial: &mut Trial) {
    let release = &mut trial.release;
    if let [only] = release.tracks.as_slice() {
        let first = only.clone();
        release.tracks.extend([0.3, 0.55, 0.8].map(|share| Track {
            marker: format!("at {share} of the length"),
            at: Point::Along(share),
            ..first.clone()
        }));
    }
}

/// Three times as long.
pub(super) fn lengthen(trial: &mut Trial) {
    let time = &mut trial.release.time;
    let (last, count) = (time.last().copied().unwrap_or(0.0), time.len());
    let step = last / count.max(1) as f64;
    time.extend((1..=2 * count).map(|k| last + step * k as f64));
}

//! Scale: all lengths are observed too long or too short by one share.
//!
//! Law:      x_seen = (1 + e) x
//!
//!   x   point from the clamp                 m
//!   e   relative error of lengths            –
//!
//! Assumes:  The same in both directions, and the origin at the clamp.
//! Off:      relative_error = 0.
//! Silent:   Never.
//! Source:   A camera calibrated with a wand whose length is off by a share e.

use super::{About, Kind, Law, Parameter, Place, Reach, Real, Separator, Sight, named};

/// Lengths that are off by a share.
pub struct Scale;

impl Law for Scale {
    const ABOUT: About = About {
        name: "scale",
        meaning: "all lengths are observed too long or too short by one share",
        kind: Kind::Measurement,
        places: &[Place::Sensor],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "relative_error",
            meaning: "relative error of lengths, positive where they look too long",
            unit: "",
            default: 0.01,
            range: (-0.9, 10.0),
            scale: 0.01,
            null_value: Some(0.0),
            plausible: Some((-0.02, 0.02)),
            ..Parameter::PLAIN
        }],
        signature: "every point is too far from the clamp by the same share, at rest and in motion",
        confounded_with: &["axial_compliance", "marker_offset", "out_of_plane"],
        separated_by: &[Separator::Metrology, Separator::BodyMarkers],
        reach: Reach::Muscle,
    };

    fn sensor<T: Real>(&self, at: &Sight<T>, theta: &[T]) -> [T; 2] {
        let [relative_error] = named(theta);
        at.position.map(|x| x + relative_error * x)
    }
}

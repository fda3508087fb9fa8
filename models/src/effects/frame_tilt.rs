//! Frame tilt: what is observed is turned about the clamp.
//!
//! Law:      x_seen = R(δ) x
//!
//!   x      point from the clamp                              m
//!   R(δ)   rotation by δ from x towards z                    –
//!   δ      angle by which points are seen turned             rad
//!
//! Assumes:  The frame of the cameras has its origin at the clamp, and its vertical off by δ. Gravity
//!           keeps its direction; a clamp that is not level is `rod.base_angle`.
//! Off:      angle = 0.
//! Silent:   Never.
//! Source:   Rotation of a plane frame.

use super::{About, Kind, Law, Parameter, Place, Reach, Real, Separator, Sight, named};

/// A frame that is not level.
pub struct FrameTilt;

impl Law for FrameTilt {
    const ABOUT: About = About {
        name: "frame_tilt",
        meaning: "what is observed is turned about the clamp",
        kind: Kind::Measurement,
        places: &[Place::Sensor],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "angle",
            meaning: "angle by which points are seen turned, from x towards z",
            unit: "rad",
            default: 0.01,
            range: (-6.3, 6.3),
            scale: 0.01,
            null_value: Some(0.0),
            plausible: Some((-0.05, 0.05)),
            ..Parameter::PLAIN
        }],
        signature: "the whole path lies turned, by the same angle at rest and in motion",
        confounded_with: &["set_curvature", "marker_offset", "clamp_compliance"],
        separated_by: &[Separator::Metrology, Separator::BodyMarkers],
        reach: Reach::Muscle,
    };

    fn sensor<T: Real>(&self, at: &Sight<T>, theta: &[T]) -> [T; 2] {
        let [angle] = named(theta);
        let [x, z] = at.position;
        let (sin, cos) = angle.sin_cos();
        [cos * x - sin * z, sin * x + cos * z]
    }
}

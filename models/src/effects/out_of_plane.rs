//! Out of plane: the rod swings in a plane that is turned from the one that is observed.
//!
//! Law:      x_seen = (1 − s) x,   z_seen = z
//!
//!   x   distance from the clamp along the horizontal     m
//!   s   share of it that is lost, 1 − cos ψ              –
//!   ψ   angle between the planes about the vertical      rad
//!
//! Assumes:  The rod stays in one plane through the vertical, and the camera is far away.
//! Off:      lost_share = 0.
//! Silent:   While the rod hangs straight down.
//! Source:   Parallel projection.

use super::{About, Kind, Law, Parameter, Place, Reach, Real, Separator, Sight, named};

/// A horizontal that looks short.
pub struct OutOfPlane;

impl Law for OutOfPlane {
    const ABOUT: About = About {
        name: "out_of_plane",
        meaning: "the rod swings in a plane that is turned from the one that is observed",
        kind: Kind::Measurement,
        places: &[Place::Sensor],
        memory: 0,
        timed: false,
        parameters: &[Parameter {
            name: "lost_share",
            meaning: "share of horizontal distances that is lost, one minus the cosine of the turn",
            unit: "",
            default: 0.01,
            range: (0.0, 1.0),
            scale: 0.01,
            null_value: Some(0.0),
            plausible: Some((0.0, 0.05)),
            ..Parameter::PLAIN
        }],
        signature: "the rod seems shorter the more it lies along the horizontal",
        confounded_with: &["scale", "axial_compliance"],
        separated_by: &[Separator::ThirdAxis],
        reach: Reach::Muscle,
    };

    fn sensor<T: Real>(&self, at: &Sight<T>, theta: &[T]) -> [T; 2] {
        let [lost_share] = named(theta);
        let [x, z] = at.position;
        [x - lost_share * x, z]
    }
}

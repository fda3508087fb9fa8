//! Marker offset: the tip's marker sits beside the point that the model takes for the tip.
//!
//! Law:      x_seen = x + a t + b n
//!
//!   x   observed tip, as the model has it                   m
//!   t   direction of the end body, outwards                 –
//!   n   a quarter turn from t, from x towards z             –
//!   a   offset along the body, outwards                     m
//!   b   offset across it                                    m
//!
//! Assumes:  The marker is fixed to the end body and turns with it. Markers along the rod are where
//!           they are said to be.
//! Off:      along = 0, if across = 0 as well.
//! Silent:   Never; an offset that does not turn is the frame's.
//! Source:   A point of a rigid body.

use super::{About, Kind, Law, Parameter, Place, Reach, Real, Separator, Sight, named};

/// A marker beside the tip.
pub struct MarkerOffset;

const fn offset(name: &'static str, meaning: &'static str, default: f64) -> Parameter {
    Parameter {
        name,
        meaning,
        unit: "m",
        default,
        range: (-1.0, 1.0),
        scale: 1e-3,
        null_value: Some(0.0),
        is_part: true,
        plausible: Some((-5e-3, 5e-3)),
        ..Parameter::PLAIN
    }
}

impl Law for MarkerOffset {
    const ABOUT: About = About {
        name: "marker_offset",
        meaning: "the tip's marker sits beside the point that the model takes for the tip",
        kind: Kind::Measurement,
        places: &[Place::Sensor],
        memory: 0,
        timed: false,
        parameters: &[
            offset("across", "offset across the end body, towards +z where it lies along x", 1e-3),
            offset("along", "offset along the end body, outwards", 0.0),
        ],
        signature: "the path of the tip lies beside that of the model by a distance that turns with it",
        confounded_with: &["scale", "frame_tilt", "tip_offset"],
        separated_by: &[Separator::Metrology, Separator::Angles],
        reach: Reach::Muscle,
    };

    fn sensor<T: Real>(&self, at: &Sight<T>, theta: &[T]) -> [T; 2] {
        let [across, along] = named(theta);
        if !at.is_tip {
            return at.position;
        }
        let [x, z] = at.tangent;
        [at.position[0] + along * x - across * z, at.position[1] + along * z + across * x]
    }
}

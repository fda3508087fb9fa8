//! Effects of the cameras alone: what happens stays as it is.

use super::Hidden::{self, *};

impl Hidden {
    /// Where a point at `[x, z]` is seen, m, in W; `tangent` is the direction of the rod's end if the
    /// point is the tip's marker.
    pub fn see(&self, [x, z]: [f64; 2], tangent: Option<[f64; 2]>) -> [f64; 2] {
        match (*self, tangent) {
            (FrameTilt { angle }, _) => {
                let (sin, cos) = angle.sin_cos();
                [cos * x - sin * z, sin * x + cos * z]
            }
            (Scale { excess }, _) => [x * (1.0 + excess), z * (1.0 + excess)],
            (MarkerOffset { along, across }, Some([tx, tz])) => {
                [x + along * tx - across * tz, z + along * tz + across * tx]
            }
            (OutOfPlane { share }, _) => [x * (1.0 - share), z],
            _ => [x, z],
        }
    }

    /// What the cameras' clock shows for a second.
    pub fn second(&self) -> f64 {
        if let Clock { excess } = *self { 1.0 + excess } else { 1.0 }
    }
}

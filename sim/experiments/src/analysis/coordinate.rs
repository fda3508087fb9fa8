//! The coordinate of a swing: the distance of the tip from its rest along one direction of the plane.
//!
//! That of the first mode, where a model gives it, or else the direction in which the tip moves most about its rest. The
//! height of the tip is the coordinate of the paper. It has two bumps in each swing where the tip hangs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a direction was chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Along {
    /// The tip's motion in the slowest mode about the rest.
    FirstMode,
    /// The largest motion of the tip about its rest, the small swings first.
    LargestMotion,
    /// Height, as in the paper.
    Height,
}

/// A direction in W along which the tip is analysed; upper peaks are on its positive side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Coordinate {
    /// How it was chosen.
    pub along: Along,
    /// Unit vector, along x and z.
    pub direction: [f64; 2],
}

/// Share of the largest distance from the rest beyond which samples hardly count for the direction: large swings are
/// curved.
const SMALL: f64 = 0.25;

impl Coordinate {
    /// Height, positive up.
    pub const HEIGHT: Self = Self { along: Along::Height, direction: [0.0, 1.0] };

    /// Along the motion of the tip in the first mode.
    pub fn first_mode(direction: [f64; 2]) -> Self {
        Self { along: Along::FirstMode, direction }
    }

    /// Along the largest motion of a path about a rest, m.
    pub fn largest_motion(path: impl Iterator<Item = [f64; 2]> + Clone, rest: [f64; 2]) -> Self {
        let off = |at: [f64; 2]| [at[0] - rest[0], at[1] - rest[1]];
        let square = |[x, z]: [f64; 2]| x * x + z * z;
        let largest = path.clone().map(|at| square(off(at))).fold(f64::MIN_POSITIVE, f64::max);
        let [mut xx, mut xz, mut zz] = [0.0; 3];
        for [x, z] in path.map(off) {
            let weight = (-square([x, z]) / (SMALL * SMALL * largest)).exp();
            xx += weight * x * x;
            xz += weight * x * z;
            zz += weight * z * z;
        }
        let (sin, cos) = (0.5 * (2.0 * xz).atan2(xx - zz)).sin_cos();
        Self { along: Along::LargestMotion, direction: [cos, sin] }
    }

    /// The same line, positive on the side of a displacement from the rest; without one, positive up.
    pub fn towards(self, displacement: [f64; 2]) -> Self {
        let [x, z] = self.direction;
        let along = x * displacement[0] + z * displacement[1];
        let sign = if along != 0.0 { along.signum() } else { f64::from(z >= 0.0) * 2.0 - 1.0 };
        Self { direction: [sign * x, sign * z], ..self }
    }

    /// Of a place or a displacement, m.
    pub fn of(&self, at: [f64; 2]) -> f64 {
        self.direction[0] * at[0] + self.direction[1] * at[1]
    }

    /// Angle of the direction, rad, from x towards z.
    pub fn angle(&self) -> f64 {
        self.direction[1].atan2(self.direction[0])
    }

    /// Its letter in charts and tables: z for the height, s otherwise.
    pub fn letter(&self) -> &'static str {
        if self.along == Along::Height { "z" } else { "s" }
    }

    /// What it is, for a title.
    pub fn title(&self) -> &'static str {
        match self.along {
            Along::FirstMode => "along the first mode",
            Along::LargestMotion => "along the largest motion",
            Along::Height => "height z",
        }
    }

    /// What it is, with its direction.
    pub fn name(&self) -> String {
        let title = self.title();
        if self.along == Along::Height {
            return title.to_owned();
        }
        let degrees = self.angle().to_degrees();
        // An angle that rounds to zero has no sign.
        let degrees = if degrees.abs() < 0.05 { 0.0 } else { degrees };
        format!("{title}, {degrees:.1} deg from x towards z")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tip on a circle about the clamp: the tangent at the rest, although the first swings are large.
    #[test]
    fn the_small_swings_give_the_direction() {
        for rest_angle in [-1.5f64, -1.1, -0.3] {
            let rest = [rest_angle.cos(), rest_angle.sin()];
            let path = (0..2000).map(|i| {
                let t = 0.01 * f64::from(i);
                let angle = rest_angle + rest_angle.abs() * (-0.3 * t).exp() * (8.0 * t).cos();
                [angle.cos(), angle.sin()]
            });
            let found = Coordinate::largest_motion(path, rest).towards([1.0, -rest[1]]);
            let error = (found.angle() - (rest_angle + std::f64::consts::FRAC_PI_2)).abs();
            // Samples of a quarter of the first swing count; their arc bends the direction by less than a degree.
            assert!(error < 0.02, "{rest_angle}: {}", found.name());
        }
    }

    #[test]
    fn a_path_at_rest_has_some_direction() {
        let still = Coordinate::largest_motion([[0.1, -0.2]; 3].into_iter(), [0.1, -0.2]);
        assert!((still.direction[0].hypot(still.direction[1]) - 1.0).abs() < 1e-15);
        assert_eq!(Coordinate::HEIGHT.towards([0.0, 0.0]), Coordinate::HEIGHT);
        assert_eq!(Coordinate::HEIGHT.towards([0.1, -0.2]).direction, [-0.0, -1.0]);
    }
}

//! A direction in the frame of a recording: one of its axes, or any vector.

/// A direction in a recording's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    /// An axis, 0 to 2, and its sign, 1 or −1.
    Axis(usize, f64),
    /// A unit vector.
    Vector([f64; 3]),
}

/// The axes as they are written.
pub const AXES: [(&str, Direction); 9] = [
    ("+x", Direction::Axis(0, 1.0)),
    ("-x", Direction::Axis(0, -1.0)),
    ("+y", Direction::Axis(1, 1.0)),
    ("-y", Direction::Axis(1, -1.0)),
    ("+z", Direction::Axis(2, 1.0)),
    ("-z", Direction::Axis(2, -1.0)),
    ("x", Direction::Axis(0, 1.0)),
    ("y", Direction::Axis(1, 1.0)),
    ("z", Direction::Axis(2, 1.0)),
];

impl Direction {
    /// As a unit vector.
    pub fn unit(self) -> [f64; 3] {
        match self {
            Direction::Vector(vector) => vector,
            Direction::Axis(axis, sign) => {
                let mut unit = [0.0; 3];
                unit[axis] = sign;
                unit
            }
        }
    }

    /// The axis that is nearest to a unit vector, and the angle between the two, rad.
    pub fn nearest(to: [f64; 3]) -> (Direction, f64) {
        let axis = (0..3).max_by(|&a, &b| to[a].abs().total_cmp(&to[b].abs())).unwrap_or(0);
        (Direction::Axis(axis, to[axis].signum()), to[axis].abs().min(1.0).acos())
    }

    /// As it is written in an experiment file.
    pub fn text(self) -> String {
        match self {
            Direction::Axis(axis, sign) => {
                format!("{}{}", if sign > 0.0 { '+' } else { '-' }, ["x", "y", "z"][axis])
            }
            Direction::Vector([x, y, z]) => format!("[{x:.4}, {y:.4}, {z:.4}]"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_axis_keeps_its_sign() {
        let (axis, angle) = Direction::nearest([0.1, -f64::sqrt(0.99), 0.0]);
        assert_eq!((axis.text(), axis.unit()), ("-y".to_owned(), [0.0, -1.0, 0.0]));
        assert!((angle - 0.1f64.asin()).abs() < 1e-12);
    }
}

//! Units: their size and their dimension.

/// Exponents of the base units that mechanics needs.
///
/// The radian is counted, so that `30 deg` cannot pass for a length's plain factor nor a bare
/// number for an angle, although an angle is a ratio; [`Dimension::fits`] says where it may drop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dimension {
    /// Exponent of the kilogram.
    pub kilogram: i32,
    /// Exponent of the metre.
    pub metre: i32,
    /// Exponent of the second.
    pub second: i32,
    /// Exponent of the radian.
    pub radian: i32,
}

/// A unit of measurement: a size in SI units and a dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// One of this unit in SI units.
    pub scale: f64,
    /// What it measures.
    pub dimension: Dimension,
}

impl Dimension {
    /// A ratio: no unit at all.
    pub const NONE: Dimension = dimension(0, 0, 0, 0);

    /// Whether a value of this dimension is accepted where `due` is due.
    ///
    /// The radian may be missing or superfluous beside mass or length, as in a compliance in
    /// 1/(N m). Angles and rates are compared in full: a frequency in Hz is not an angular
    /// velocity in rad/s, and 1 is not 1 rad.
    pub fn fits(self, due: Dimension) -> bool {
        let radian_may_drop = due.kilogram != 0 || due.metre != 0;
        let radian = if radian_may_drop { due.radian } else { self.radian };
        Dimension { radian, ..self } == due
    }

    fn times(self, other: Dimension, power: i32) -> Dimension {
        let sum = |a: i32, b: i32| a.saturating_add(b.saturating_mul(power));
        Dimension {
            kilogram: sum(self.kilogram, other.kilogram),
            metre: sum(self.metre, other.metre),
            second: sum(self.second, other.second),
            radian: sum(self.radian, other.radian),
        }
    }
}

impl Unit {
    /// The unit of a plain number.
    pub const ONE: Unit = Unit { scale: 1.0, dimension: Dimension::NONE };

    pub(super) fn times(self, other: Unit, power: i32) -> Unit {
        let scale = if power < 0 {
            // Dividing keeps 1/min at exactly 1/60.
            self.scale / other.scale.powi(-power)
        } else {
            self.scale * other.scale.powi(power)
        };
        Unit { scale, dimension: self.dimension.times(other.dimension, power) }
    }
}

pub(super) const fn dimension(kilogram: i32, metre: i32, second: i32, radian: i32) -> Dimension {
    Dimension { kilogram, metre, second, radian }
}

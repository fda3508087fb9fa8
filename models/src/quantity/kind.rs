//! Kinds of quantity for messages: what a dimension is called, and which units to offer for it.

use super::unit::{Dimension, Unit};

/// A kind of quantity.
pub(super) struct QuantityKind {
    /// Noun without article.
    pub name: &'static str,
    /// What people write it in; the first has the dimension of the kind, others fit it.
    pub units: &'static [&'static str],
}

impl QuantityKind {
    /// The kind of what is measured in `unit`, if it has a name.
    pub fn of(unit: &str) -> Option<&'static QuantityKind> {
        let dimension = Unit::parse(unit).ok()?.dimension;
        let exact = KINDS.iter().find(|kind| kind.dimension() == dimension);
        exact.or_else(|| (KINDS.iter()).find(|kind| dimension.fits(kind.dimension())))
    }

    fn dimension(&self) -> Dimension {
        let unit = Unit::parse(self.units[0]);
        unit.map_or(Dimension::NONE, |unit| unit.dimension)
    }
}

const KINDS: &[QuantityKind] = &[
    kind("ratio", &["%"]),
    kind("length", &["mm", "in"]),
    kind("mass", &["g", "kg"]),
    kind("time", &["s", "ms"]),
    kind("angle", &["deg", "rad"]),
    kind("pressure", &["psi", "kPa"]),
    kind("force", &["N", "lbf"]),
    kind("frequency or rate", &["1/s", "Hz"]),
    kind("angular velocity", &["rad/s", "rpm"]),
    kind("angular acceleration", &["rad/s^2"]),
    kind("velocity", &["m/s", "mm/s"]),
    kind("acceleration", &["m/s^2"]),
    kind("area", &["mm^2", "m^2"]),
    kind("volume", &["m^3"]),
    kind("curvature", &["1/m", "deg/m"]),
    kind("mass per length", &["kg/m", "g/m"]),
    kind("density", &["kg/m^3"]),
    kind("first moment of mass", &["kg m"]),
    kind("rotary inertia", &["kg m^2", "g mm^2"]),
    kind("force per length", &["N/m", "lbf/in"]),
    kind("damping constant", &["N s/m", "kg/s"]),
    kind("viscosity", &["Pa s"]),
    kind("moment or energy", &["N m", "J"]),
    kind("rotational stiffness", &["N m/rad", "N m/deg"]),
    kind("rotational damping constant", &["N m s/rad"]),
    kind("rotational compliance", &["rad/(N m)", "deg/(N m)"]),
    kind("power", &["W"]),
    kind("bending stiffness", &["N m^2"]),
    kind("bending viscosity", &["N m^2 s"]),
];

const fn kind(name: &'static str, units: &'static [&'static str]) -> QuantityKind {
    QuantityKind { name, units }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_one_dimension_and_its_own() {
        for (i, kind) in KINDS.iter().enumerate() {
            for unit in kind.units {
                let dimension = Unit::parse(unit).unwrap().dimension;
                assert!(dimension.fits(kind.dimension()), "{unit}");
            }
            let others = KINDS[..i].iter();
            assert!(others.into_iter().all(|other| other.dimension() != kind.dimension()), "{}", kind.name);
        }
    }
}

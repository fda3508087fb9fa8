//! The table of units by their names.

use super::unit::{Dimension, Unit, dimension};

const MASS: Dimension = dimension(1, 0, 0, 0);
const LENGTH: Dimension = dimension(0, 1, 0, 0);
const TIME: Dimension = dimension(0, 0, 1, 0);
const ANGLE: Dimension = dimension(0, 0, 0, 1);
const FORCE: Dimension = dimension(1, 1, -2, 0);
const PRESSURE: Dimension = dimension(1, -1, -2, 0);

/// Units that take a prefix: symbol, size in SI units, dimension.
const PREFIXABLE: &[(&str, f64, Dimension)] = &[
    ("g", 1e-3, MASS),
    ("m", 1.0, LENGTH),
    ("s", 1.0, TIME),
    ("rad", 1.0, ANGLE),
    ("N", 1.0, FORCE),
    ("Pa", 1.0, PRESSURE),
    ("J", 1.0, dimension(1, 2, -2, 0)),
    ("W", 1.0, dimension(1, 2, -3, 0)),
    ("Hz", 1.0, dimension(0, 0, -1, 0)),
];

/// Units that take none. The inch, pound, ounce, standard gravity and atmosphere are exact by
/// definition; the pound-force is 0.45359237 kg times 9.80665 m/s².
const FIXED: &[(&str, f64, Dimension)] = &[
    ("in", 0.0254, LENGTH),
    ("ft", 0.3048, LENGTH),
    ("lb", 0.45359237, MASS),
    ("oz", 0.45359237 / 16.0, MASS),
    ("lbf", LBF, FORCE),
    ("psi", LBF / (0.0254 * 0.0254), PRESSURE),
    ("bar", 1e5, PRESSURE),
    ("mbar", 100.0, PRESSURE),
    ("atm", 101325.0, PRESSURE),
    ("mmHg", 133.322387415, PRESSURE),
    ("min", 60.0, TIME),
    ("h", 3600.0, TIME),
    ("deg", std::f64::consts::PI / 180.0, ANGLE),
    ("°", std::f64::consts::PI / 180.0, ANGLE),
    ("rpm", std::f64::consts::PI / 30.0, dimension(0, 0, -1, 1)),
    ("%", 0.01, Dimension::NONE),
];

const LBF: f64 = 0.45359237 * 9.80665;

/// SI prefixes; `u` and both Unicode code points of µ are the same.
const PREFIXES: &[(&str, f64)] = &[
    ("n", 1e-9),
    ("u", 1e-6),
    ("µ", 1e-6),
    ("μ", 1e-6),
    ("m", 1e-3),
    ("c", 1e-2),
    ("k", 1e3),
    ("M", 1e6),
    ("G", 1e9),
];

/// The unit of this very name, `kPa` say.
pub(super) fn named(name: &str) -> Option<Unit> {
    let find = |table: &[(&str, f64, Dimension)], name: &str| {
        let &(_, scale, dimension) = table.iter().find(|unit| unit.0 == name)?;
        Some(Unit { scale, dimension })
    };
    let prefixed = || {
        PREFIXES.iter().find_map(|(prefix, factor)| {
            let unit = find(PREFIXABLE, name.strip_prefix(prefix)?)?;
            Some(Unit { scale: factor * unit.scale, ..unit })
        })
    };
    find(FIXED, name).or_else(|| find(PREFIXABLE, name)).or_else(prefixed)
}

/// Names of all units, without prefix.
pub(super) fn known() -> impl Iterator<Item = &'static str> {
    PREFIXABLE.iter().chain(FIXED).map(|unit| unit.0)
}

/// The known names, for messages.
pub(super) fn names() -> String {
    let list = |table: &[(&'static str, f64, Dimension)]| {
        let names: Vec<&str> = table.iter().map(|unit| unit.0).collect();
        names.join(", ")
    };
    format!("{} with or without an SI prefix, and {}", list(PREFIXABLE), list(FIXED))
}

//! What a formula of a law may name, place by place, and what it gives.

use crate::effects::{Bend, Edge, Flow, Mass, Place, Rod, Tip};

/// Something that a law sees.
#[derive(Clone, Copy, Debug)]
pub struct Name {
    /// As formulas have it.
    pub name: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// Its SI unit; that of the memory is the law's own.
    pub unit: &'static str,
    /// As a Rust law has it, where `at` is what it sees.
    pub rust: &'static str,
}

const fn name(name: &'static str, meaning: &'static str, unit: &'static str, rust: &'static str) -> Name {
    Name { name, meaning, unit, rust }
}

/// What all places but the clamp see, from the index 8 on.
const COMMON: [Name; 8] = [
    name(
        "position",
        "place along the rod, from 0 at the clamp to 1 at the end fitting",
        "",
        "T::from(at.position)",
    ),
    name("time", "time since the release", "s", "at.time"),
    name("length", "active length of the rod", "m", "at.rod.length"),
    name("mass", "distributed mass of the rod", "kg", "at.rod.mass"),
    name("bending_stiffness", "bending stiffness EI", "N m^2", "at.rod.bending_stiffness"),
    name("axial_stiffness", "axial stiffness EA", "N", "at.rod.axial_stiffness"),
    name("diameter", "outer diameter", "m", "at.rod.diameter"),
    name("pressure", "pressure inside above ambient", "Pa", "at.rod.pressure"),
];
/// The number of the first of these.
pub(crate) const FIRST_COMMON: usize = 8;
const POSITION: usize = 0;

const BEND: [Name; 4] = [
    name("kappa", "curvature, positive towards +z", "1/m", "at.kappa"),
    name("kappa_rate", "rate of the curvature", "1/(m s)", "at.kappa_rate"),
    name(MEMORY, "memory of the law at this bend", "", "at.memory"),
    name(MEAN_SQUARE, "mean square of the curvature over the rod", "1/m^2", "at.mean_square_curvature"),
];
const EDGE: [Name; 2] = [
    name("stretch", "current over rest length, minus one", "", "at.stretch"),
    name("stretch_rate", "rate of the stretch", "1/s", "at.stretch_rate"),
];
const FLOW: [Name; 2] = [
    name("v_t", "velocity along the edge, positive towards the tip", "m/s", "at.tangential_velocity"),
    name(
        "v_n",
        "velocity across the edge, positive to the left when looking to the tip",
        "m/s",
        "at.normal_velocity",
    ),
];
const TIP: [Name; 6] = [
    name("x", "position of the end of the rod, along the level", "m", "at.position[0]"),
    name("z", "position of the end of the rod, upwards", "m", "at.position[1]"),
    name("v_x", "its velocity along the level", "m/s", "at.velocity[0]"),
    name("v_z", "its velocity upwards", "m/s", "at.velocity[1]"),
    name("angle", "angle of the end fitting, from x towards z", "rad", "at.angle"),
    name("angular_velocity", "its rate", "rad/s", "at.angular_velocity"),
];

/// The memory, as formulas have it.
pub const MEMORY: &str = "memory";
/// What makes a law one of the whole rod.
pub const MEAN_SQUARE: &str = "mean_square_curvature";

/// Places where a law as text can act, by their names.
pub const PLACES: [(&str, Place); 6] = [
    ("bend", Place::Bend),
    ("edge", Place::Edge),
    ("flow", Place::Flow),
    ("mass", Place::Mass),
    ("tip", Place::Tip),
    ("clamp", Place::Clamp),
];

/// Something that a law gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// Its key.
    pub key: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// Its SI unit; the rate of the memory has that of the law's own, over a second.
    pub unit: &'static str,
    /// Where.
    pub place: Place,
}

const fn output(key: &'static str, meaning: &'static str, unit: &'static str, place: Place) -> Output {
    Output { key, meaning, unit, place }
}

/// All that a law can give.
pub const OUTPUTS: [Output; 15] = [
    output("moment", "resisting moment of a bend", "N m", Place::Bend),
    output("energy", "energy stored at a bend, per length", "J/m", Place::Bend),
    output("memory", "rate of the memory", "", Place::Bend),
    output("tension", "tension of an edge", "N", Place::Edge),
    output("edge_energy", "energy stored in an edge, per length", "J/m", Place::Edge),
    output("force", "force across an edge, per length", "N/m", Place::Flow),
    output("force_along", "force along an edge, per length", "N/m", Place::Flow),
    output("decay", "rate at which velocities decay", "1/s", Place::Mass),
    output("acceleration_x", "acceleration along the level", "m/s^2", Place::Mass),
    output("acceleration_z", "acceleration upwards", "m/s^2", Place::Mass),
    output("force_x", "force on the end of the rod, along the level", "N", Place::Tip),
    output("force_z", "force on the end of the rod, upwards", "N", Place::Tip),
    output("tip_moment", "moment on the end fitting, from x towards z", "N m", Place::Tip),
    output("tip_energy", "energy stored in the load on the end", "J", Place::Tip),
    output("compliance", "rotational compliance of the clamp", "rad/(N m)", Place::Clamp),
];
/// Places of [`OUTPUTS`].
pub(crate) mod out {
    pub const MOMENT: usize = 0;
    pub const ENERGY: usize = 1;
    pub const MEMORY: usize = 2;
    pub const TENSION: usize = 3;
    pub const EDGE_ENERGY: usize = 4;
    pub const FORCE: usize = 5;
    pub const FORCE_ALONG: usize = 6;
    pub const DECAY: usize = 7;
    pub const ACCELERATION_X: usize = 8;
    pub const ACCELERATION_Z: usize = 9;
    pub const FORCE_X: usize = 10;
    pub const FORCE_Z: usize = 11;
    pub const TIP_MOMENT: usize = 12;
    pub const TIP_ENERGY: usize = 13;
    pub const COMPLIANCE: usize = 14;
}

/// What a place sees, each with its number there.
pub fn names(place: Place) -> impl Iterator<Item = (u8, &'static Name)> {
    let own: &[Name] = match place {
        Place::Bend => &BEND,
        Place::Edge => &EDGE,
        Place::Flow => &FLOW,
        Place::Tip => &TIP,
        _ => &[],
    };
    let has_position = matches!(place, Place::Bend | Place::Edge | Place::Flow);
    let common: &[Name] = if place == Place::Clamp { &[] } else { &COMMON };
    let common = common.iter().enumerate().filter(move |(k, _)| has_position || *k != POSITION);
    let own = own.iter().enumerate();
    own.chain(common.map(|(k, name)| (k + FIRST_COMMON, name))).map(|(k, name)| (k as u8, name))
}

/// One of the [`COMMON`] names.
fn common<T: Copy + From<f64>>(k: u8, position: f64, time: T, rod: &Rod<T>) -> T {
    match usize::from(k) - FIRST_COMMON {
        POSITION => T::from(position),
        1 => time,
        2 => rod.length,
        3 => rod.mass,
        4 => rod.bending_stiffness,
        5 => rod.axial_stiffness,
        6 => rod.diameter,
        _ => rod.pressure,
    }
}

/// The values of names by their numbers.
pub(crate) fn of_bend<T: Copy + From<f64>>(at: &Bend<T>, k: u8) -> T {
    match k {
        0 => at.kappa,
        1 => at.kappa_rate,
        2 => at.memory,
        3 => at.mean_square_curvature,
        _ => common(k, at.position, at.time, at.rod),
    }
}

pub(crate) fn of_edge<T: Copy + From<f64>>(at: &Edge<T>, k: u8) -> T {
    match k {
        0 => at.stretch,
        1 => at.stretch_rate,
        _ => common(k, at.position, at.time, at.rod),
    }
}

pub(crate) fn of_flow<T: Copy + From<f64>>(at: &Flow<T>, k: u8) -> T {
    match k {
        0 => at.tangential_velocity,
        1 => at.normal_velocity,
        _ => common(k, at.position, at.time, at.rod),
    }
}

pub(crate) fn of_mass<T: Copy + From<f64>>(at: &Mass<T>, k: u8) -> T {
    common(k, 0.0, at.time, at.rod)
}

pub(crate) fn of_tip<T: Copy + From<f64>>(at: &Tip<T>, k: u8) -> T {
    match k {
        0 | 1 => at.position[usize::from(k)],
        2 | 3 => at.velocity[usize::from(k) - 2],
        4 => at.angle,
        5 => at.angular_velocity,
        _ => common(k, 1.0, at.time, at.rod),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every name gives the field that its Rust text names: each has a value of its own here.
    #[test]
    fn names_stand_where_their_numbers_say() {
        let rod = Rod {
            length: 20.0,
            mass: 21.0,
            bending_stiffness: 22.0,
            axial_stiffness: 23.0,
            diameter: 24.0,
            pressure: 25.0,
        };
        let rods = [
            "at.rod.length",
            "at.rod.mass",
            "at.rod.bending_stiffness",
            "at.rod.axial_stiffness",
            "at.rod.diameter",
            "at.rod.pressure",
        ];
        let due = |rust: &str, own: &[(&str, f64)]| {
            let rods = rods.iter().zip(20..).map(|(rust, value)| (*rust, f64::from(value)));
            rods.chain(own.iter().copied()).find(|(known, _)| *known == rust).expect("named here").1
        };
        let always = [("T::from(at.position)", 0.7), ("at.time", 9.0)];
        let bend = Bend {
            kappa: 1.0,
            kappa_rate: 2.0,
            mean_square_curvature: 4.0,
            branch: 0,
            memory: 3.0,
            position: 0.7,
            time: 9.0,
            rod: &rod,
        };
        let own = [
            ("at.kappa", 1.0),
            ("at.kappa_rate", 2.0),
            ("at.memory", 3.0),
            ("at.mean_square_curvature", 4.0),
        ];
        for (k, name) in names(Place::Bend) {
            assert_eq!(of_bend(&bend, k), due(name.rust, &[&own[..], &always].concat()), "{}", name.name);
        }
        let edge = Edge { stretch: 1.0, stretch_rate: 2.0, position: 0.7, time: 9.0, rod: &rod };
        for (k, name) in names(Place::Edge) {
            let own = [("at.stretch", 1.0), ("at.stretch_rate", 2.0)];
            assert_eq!(of_edge(&edge, k), due(name.rust, &[&own[..], &always].concat()), "{}", name.name);
        }
        let flow =
            Flow { tangential_velocity: 1.0, normal_velocity: 2.0, position: 0.7, time: 9.0, rod: &rod };
        for (k, name) in names(Place::Flow) {
            let own = [("at.tangential_velocity", 1.0), ("at.normal_velocity", 2.0)];
            assert_eq!(of_flow(&flow, k), due(name.rust, &[&own[..], &always].concat()), "{}", name.name);
        }
        for (k, name) in names(Place::Mass) {
            assert_eq!(of_mass(&Mass { time: 9.0, rod: &rod }, k), due(name.rust, &always), "{}", name.name);
        }
        let tip = Tip {
            position: [1.0, 2.0],
            velocity: [3.0, 4.0],
            angle: 5.0,
            angular_velocity: 6.0,
            center: [0.0; 2],
            time: 9.0,
            rod: &rod,
        };
        let own = [
            ("at.position[0]", 1.0),
            ("at.position[1]", 2.0),
            ("at.velocity[0]", 3.0),
            ("at.velocity[1]", 4.0),
            ("at.angle", 5.0),
            ("at.angular_velocity", 6.0),
        ];
        for (k, name) in names(Place::Tip) {
            assert_eq!(of_tip(&tip, k), due(name.rust, &[&own[..], &always].concat()), "{}", name.name);
        }
        assert_eq!(names(Place::Clamp).count(), 0);
    }

    #[test]
    fn outputs_stand_where_their_numbers_say() {
        use out::*;
        let all = [
            (MOMENT, "moment"),
            (ENERGY, "energy"),
            (MEMORY, "memory"),
            (TENSION, "tension"),
            (EDGE_ENERGY, "edge_energy"),
            (FORCE, "force"),
            (FORCE_ALONG, "force_along"),
            (DECAY, "decay"),
            (ACCELERATION_X, "acceleration_x"),
            (ACCELERATION_Z, "acceleration_z"),
            (FORCE_X, "force_x"),
            (FORCE_Z, "force_z"),
            (TIP_MOMENT, "tip_moment"),
            (TIP_ENERGY, "tip_energy"),
            (COMPLIANCE, "compliance"),
        ];
        assert_eq!(all.map(|(k, _)| k), std::array::from_fn(|k| k));
        assert!(all.iter().all(|(k, key)| OUTPUTS[*k].key == *key));
    }
}

//! A linear model of a rod about its rest, for those who design a controller: `ẋ = A x + B u`, `y = C x + D u`.
//!
//! States are the coordinates of nodes and end body, their rates, and what laws remember; all states, inputs and outputs
//! count from the rest. All of it comes from the exact tangents of [`SmallMotion`]. A pressure jumps no coordinate, but the
//! rates that damping sees: rates and memories of a model with the input `pressure` are those less
//! the jump, which no output shows. With a pressure line the input is its command, and the pressure in the rod the last state.

mod balanced;
mod modal;

use models::error::ModelError;
use models::line::SmallLine;
use models::model::Model;
use models::muscle::RodSlopes;
use models::nearest::{alike, offer};
use models::statics::{Equilibrium, SmallMotion, equilibrium};

use thiserror::Error;

pub use balanced::Reduced;
pub use modal::{Complex, Modal, Pole, settling};
pub use nalgebra::{DMatrix, DVector};

/// The input that a regulator moves; behind a pressure line its command.
const PRESSURE: &str = "pressure";

/// Matrices of `ẋ = A x + B u`, `y = C x + D u`; of one with samples, `x⁺ = A x + B u`.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpace {
    /// States by states.
    pub a: DMatrix<f64>,
    /// By inputs.
    pub b: DMatrix<f64>,
    /// Outputs by states.
    pub c: DMatrix<f64>,
    /// By inputs.
    pub d: DMatrix<f64>,
}

/// An input, a state or an output.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Such as `pressure` or `tip_z`.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Its value at the rest, from which it is counted.
    pub at_rest: f64,
}

/// A linear model about a rest.
#[derive(Clone, Debug)]
pub struct Linear {
    /// The matrices.
    pub matrices: StateSpace,
    /// What the states are.
    pub states: Vec<Signal>,
    /// What moves the rod.
    pub inputs: Vec<Signal>,
    /// What is seen of it.
    pub outputs: Vec<Signal>,
    /// Poles, modes and responses.
    pub modal: Modal,
    /// Whether the rod comes back when it is pushed.
    pub is_stable: bool,
    /// Time by which a pressure line delays the input `pressure`, s: no part of the matrices.
    pub dead_time: f64,
}

impl StateSpace {
    /// The same with an input that comes through a pressure line, whose pressure is one more state.
    fn behind(self, input: usize, line: SmallLine) -> Self {
        let Self { a, mut b, c, d } = self;
        let last = a.nrows();
        let mut a = a.resize(last + 1, last + 1, 0.0);
        a.view_mut((0, last), (last, 1)).copy_from(&b.column(input));
        a[(last, last)] = line.by_pressure;
        b.column_mut(input).fill(0.0);
        let mut b = b.insert_row(last, 0.0);
        b[(last, input)] = line.by_command;
        Self { a, b, c: c.insert_column(last, 0.0), d }
    }
}

/// Why there is no linear model.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LinearError {
    /// No rest, or a parameter that is no input.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// An input that there is not.
    #[error(
        "input {name}: no such input{offer}; there are pressure, force_x, force_z, moment, base_acceleration_x, \
         base_acceleration_z, and the parameters of the model, such as {example}"
    )]
    UnknownInput {
        /// Name found.
        name: String,
        /// What may be meant.
        offer: String,
        /// A parameter.
        example: String,
    },
    /// An output that there is not.
    #[error(
        "output {name}: no such output{offer}; there are tip_x, tip_z, tip_angle, and points of the rod such as \
         point_0.5_z, half way from the clamp"
    )]
    UnknownOutput {
        /// Name found.
        name: String,
        /// What may be meant.
        offer: String,
    },
    /// The pressure of a rod that is no muscle.
    #[error(
        "input pressure: the rod is no muscle, and does not follow a pressure; give a force, such as force_z"
    )]
    NoMuscle,
    /// An input without effect.
    #[error("input {name}: does not move the rod at this rest; leave it out")]
    NoEffect {
        /// Name of the input.
        name: String,
    },
    /// Neither inputs nor outputs, or the same one twice.
    #[error("{name}: give each input and output once, and at least one of both")]
    Listed {
        /// What is wrong.
        name: String,
    },
    /// A pole at zero.
    #[error(
        "the rod has a motion that nothing brings back (a pole at zero); stiffen it, or leave out the law that drifts"
    )]
    PoleAtZero,
    /// Poles that coincide with one shape.
    #[error(
        "two poles coincide with the same shape, as at critical damping; change a damping by a thousandth"
    )]
    Defective,
    /// A reduction of a model that does not decay.
    #[error(
        "only a model whose every motion decays can be reduced; {slowest}; give the rod damping, such as effects.rayleigh_mass.alpha=0.1"
    )]
    NoDecay {
        /// The pole that does not.
        slowest: String,
    },
    /// More states than there are, or none.
    #[error("reduce to {order} states: must lie in 1..={most}")]
    Order {
        /// Number requested.
        order: usize,
        /// How many there are that inputs reach and outputs see.
        most: usize,
    },
}

/// The linear model about the rest at time 0. A muscle has slopes by pressure.
///
/// ```
/// use efam_core::linear::linearise;
/// use models::effects::Rod;
/// use models::model::{Model, ModelSpec};
///
/// let rod = Rod { length: 0.2, mass: 0.03, bending_stiffness: 5.0, axial_stiffness: 5e5, diameter: 0.03, pressure: 0.0 };
/// let model = Model::new(&ModelSpec::of(rod).with(&[("rayleigh_stiffness.beta", 1e-4)]))?;
/// let linear = linearise(&model, None, &["force_z"], &["tip_z"])?;
/// let gain = linear.modal.static_gain()[(0, 0)];
/// assert!((gain / (0.2f64.powi(3) / (3.0 * 5.0)) - 1.0).abs() < 0.01, "{gain} m/N");
/// let small = linear.modal.reduced(4)?;
/// assert!(small.error_bound[(0, 0)] < 0.05 * gain);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// # Errors
/// [`LinearError`].
pub fn linearise(
    model: &Model,
    muscle: Option<RodSlopes>,
    inputs: &[impl AsRef<str>],
    outputs: &[impl AsRef<str>],
) -> Result<Linear, LinearError> {
    let inputs: Vec<&str> = inputs.iter().map(AsRef::as_ref).collect();
    let outputs: Vec<&str> = outputs.iter().map(AsRef::as_ref).collect();
    for (kind, all) in [("inputs", &inputs), ("outputs", &outputs)] {
        if all.is_empty() || (1..all.len()).any(|k| all[..k].contains(&all[k])) {
            return Err(LinearError::Listed { name: format!("{kind}: {}", all.join(",")) });
        }
    }
    // Forces at the end are the parameters of a load that may be zero.
    let model = model.with_effect("tip_load", &[])?;
    let rest = equilibrium(&model, None)?;
    let mut motion = SmallMotion::about(&model, &rest);
    let a = motion.state_matrix();
    let columns = inputs
        .iter()
        .map(|name| column(&model, &mut motion, &a, muscle, name))
        .collect::<Result<Vec<_>, _>>()?;
    let rows =
        outputs.iter().map(|name| row(&rest, &mut motion, a.nrows(), name)).collect::<Result<Vec<_>, _>>()?;
    let matrices = StateSpace {
        b: DMatrix::from_columns(&columns.iter().map(|own| own.1.clone()).collect::<Vec<_>>()),
        c: DMatrix::from_rows(&rows.iter().map(|own| own.1.transpose()).collect::<Vec<_>>()),
        d: DMatrix::zeros(rows.len(), columns.len()),
        a,
    };
    let mut states = states(&model, &rest, &motion);
    let inputs: Vec<Signal> = columns.into_iter().map(|own| own.0).collect();
    let line = inputs.iter().position(|input| input.name == PRESSURE).zip(SmallLine::of(&model));
    let matrices = match line {
        Some((input, line)) => {
            states.push(Signal { name: "rod_pressure".to_owned(), ..inputs[input].clone() });
            matrices.behind(input, line)
        }
        None => matrices,
    };
    let mut modal = matrices.modal()?;
    modal.mark(|pole, shape| motion.is_along(pole, shape));
    Ok(Linear {
        states,
        dead_time: line.map_or(0.0, |(_, line)| line.dead_time),
        inputs,
        outputs: rows.into_iter().map(|own| own.0).collect(),
        matrices,
        modal,
        is_stable: rest.stable,
    })
}

/// An input, and the rates of the states by it.
fn column(
    model: &Model,
    motion: &mut SmallMotion,
    a: &DMatrix<f64>,
    muscle: Option<RodSlopes>,
    name: &str,
) -> Result<(Signal, DVector<f64>), LinearError> {
    let signal = |unit: &str, at_rest| Signal { name: name.to_owned(), unit: unit.to_owned(), at_rest };
    let (signal, column) = match name {
        PRESSURE => {
            let [by_value, by_rate] = motion.by_pressure(muscle.ok_or(LinearError::NoMuscle)?);
            (signal("Pa", model.rod().pressure), by_value + a * by_rate)
        }
        "base_acceleration_x" => (signal("m/s^2", 0.0), motion.by_acceleration([1.0, 0.0])),
        "base_acceleration_z" => (signal("m/s^2", 0.0), motion.by_acceleration([0.0, 1.0])),
        _ => {
            let path = match name {
                "force_x" | "force_z" | "moment" => format!("effects.tip_load.{name}"),
                path => path.to_owned(),
            };
            let k = model.index(&path).map_err(|_| unknown_input(model, name))?;
            (signal(model.parameters[k].unit, model.theta[k]), motion.by_parameter(k)?)
        }
    };
    if column.amax() == 0.0 {
        return Err(LinearError::NoEffect { name: name.to_owned() });
    }
    Ok((signal, column))
}

fn unknown_input(model: &Model, name: &str) -> LinearError {
    let own = ["pressure", "force_x", "force_z", "moment", "base_acceleration_x", "base_acceleration_z"];
    let paths = model.parameters.iter().map(|parameter| parameter.path.as_str());
    let offer = offer(alike(name, own.into_iter().chain(paths)));
    let example = model.parameters.iter().rev().find(|own| own.path.starts_with("effects."));
    let example = example.map_or("rod.bending_stiffness", |own| &own.path).to_owned();
    LinearError::UnknownInput { name: name.to_owned(), offer, example }
}

/// An output, and its derivatives by the states.
fn row(
    rest: &Equilibrium,
    motion: &mut SmallMotion,
    states: usize,
    name: &str,
) -> Result<(Signal, DVector<f64>), LinearError> {
    let dof = motion.dof();
    let mut row = DVector::zeros(states);
    let signal = |unit: &str, at_rest| Signal { name: name.to_owned(), unit: unit.to_owned(), at_rest };
    if name == "tip_angle" {
        row[dof - 1] = 1.0;
        return Ok((signal("rad", rest.q[dof - 1]), row));
    }
    let unknown = || {
        let offer = offer(alike(name, ["tip_x", "tip_z", "tip_angle", "point_0.5_x", "point_0.5_z"]));
        LinearError::UnknownOutput { name: name.to_owned(), offer }
    };
    let (point, axis) = match name.rsplit_once('_') {
        Some((point, "x")) => (point, 0),
        Some((point, "z")) => (point, 1),
        _ => return Err(unknown()),
    };
    let share = || point.strip_prefix("point_")?.parse().ok().filter(|share| (0.0..=1.0).contains(share));
    let (position, moves) = match point {
        "tip" => motion.tip(),
        _ => motion.along(share().ok_or_else(unknown)?),
    };
    row.rows_mut(0, dof).copy_from(&moves.row(axis).transpose());
    Ok((signal("m", position[axis]), row))
}

/// Names of the states: nodes from the clamp, the end body's centre of mass and angle, their rates, memories by law and bend.
fn states(model: &Model, rest: &Equilibrium, motion: &SmallMotion) -> Vec<Signal> {
    let last = model.dof() - 1;
    let coordinate = |k: usize| match k {
        k if k == last => ("end_angle".to_owned(), "rad"),
        k if k + 2 >= last => (format!("end_{}", ["x", "z"][k % 2]), "m"),
        k => (format!("node_{}_{}", k / 2 + 1, ["x", "z"][k % 2]), "m"),
    };
    let mut all = Vec::new();
    for (k, at_rest) in rest.q.iter().enumerate() {
        let (name, unit) = coordinate(k);
        all.push(Signal { name, unit: unit.to_owned(), at_rest: *at_rest });
    }
    for k in 0..=last {
        let (name, unit) = coordinate(k);
        all.push(Signal { name: format!("{name}_rate"), unit: format!("{unit}/s"), at_rest: 0.0 });
    }
    for &k in motion.memory() {
        let active = model.effects.iter().find(|active| active.memory.contains(&k));
        let active = active.expect("each memory is of an effect");
        let (own, bends) = (k - active.memory.start, model.edges + 1);
        let law = active.effect.about().name;
        let name = format!("{law}_memory_{}_bend_{}", own / bends + 1, own % bends);
        all.push(Signal { name, unit: String::new(), at_rest: rest.z[k] });
    }
    all
}

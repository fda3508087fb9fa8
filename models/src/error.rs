//! What can be wrong with a model.

use thiserror::Error;

use crate::fault::Fault;

/// A model that cannot be built, or an equilibrium that was not found.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ModelError {
    /// Too few or too many nodes.
    #[error("rod.nodes = {nodes}: must lie in 4..=2000; 16 resolve the paper's muscle to 0.02 mm")]
    Nodes {
        /// Value found.
        nodes: usize,
    },
    /// A parameter outside its range, or not a number.
    #[error("{path} = {value}: must lie in {low}..={high}{unit}")]
    OutOfRange {
        /// Path of the parameter, such as `effects.air_drag.drag_coefficient`.
        path: String,
        /// Value found, SI.
        value: f64,
        /// Smallest admissible value.
        low: f64,
        /// Largest admissible value.
        high: f64,
        /// SI unit, with a space before it.
        unit: String,
    },
    /// No such parameter.
    #[error("{path}: no such parameter; the model has {known}")]
    UnknownParameter {
        /// Path found.
        path: String,
        /// Paths that there are.
        known: String,
    },
    /// No such effect.
    #[error("effects.{name}: no such effect; `efam effects` lists them")]
    UnknownEffect {
        /// Name found.
        name: String,
    },
    /// An effect that needs the rod's diameter, and a rod without one.
    #[error("effects.{effect} needs the diameter of the rod; give rod.diameter, such as \"27 mm\"")]
    DiameterMissing {
        /// Name of the effect.
        effect: &'static str,
    },
    /// Modes were requested about a posture that is not a stable equilibrium.
    #[error("the rest posture is not stable, and so has no frequencies; lower the load or stiffen the rod")]
    Unstable,
    /// An input of a linear model that moves the coordinates themselves.
    #[error(
        "{path}: a mass, a length or an angle of the clamp is no input of a linear model; linearise at two values of it"
    )]
    NoInput {
        /// Path of the parameter.
        path: String,
    },
    /// No load holds the end of the rod as it should.
    #[error(
        "no load was found that holds the end of the rod there: {reached_percent:.0} % of the way from its rest was \
         reached; hold it nearer to its rest, or by a hand that turns it"
    )]
    Held {
        /// Share of the way, per cent.
        reached_percent: f64,
    },
    /// A law that gives no number.
    #[error("no equilibrium found: {0}")]
    Law(Fault),
    /// Newton's method for the equilibrium gave up.
    #[error(
        "no equilibrium found: stalled at {load_percent:.1} % of the load after {iterations} iterations, \
         |imbalance| = {imbalance:.2e} N near node {node}; try a finer mesh (rod.nodes) or a stiffer rod"
    )]
    Equilibrium {
        /// Share of the load that was reached, per cent.
        load_percent: f64,
        /// Newton iterations so far.
        iterations: usize,
        /// Largest imbalance, N.
        imbalance: f64,
        /// Its node.
        node: usize,
    },
}

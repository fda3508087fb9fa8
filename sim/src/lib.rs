//! What we do with the models.

// The command line names the modules of this library as other crates do.
extern crate self as sim;

pub mod analysis;
pub mod calibrate;
pub mod cleaning;
pub mod cli;
pub mod diagnose;
pub mod escape;
pub mod experiment;
pub mod failure;
pub mod figures;
mod footer;
pub mod input;
pub mod memory;
mod normal;
pub mod observe;
pub mod predict;
mod quantile;
pub mod recording;
pub mod results;
pub mod scenario;
pub mod schema;
pub mod simulate;
pub mod sweep;

pub use efam_core::{
    accuracy, forward, integrate, levenberg_marquardt, limits, pace, rest, stepper, trajectory,
};

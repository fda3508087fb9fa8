//! What we do with the models.

pub mod analysis;
pub mod calibrate;
pub mod cleaning;
pub mod diagnose;
pub mod escape;
pub mod experiment;
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
pub mod sweep;

pub use efam_core::{
    accuracy, forward, integrate, levenberg_marquardt, limits, pace, rest, stepper, trajectory,
};

//! What releases determine of a rod: parameters with their uncertainty, effects that a model lacks, and releases that nobody
//! has made yet.

pub mod calibrate;
#[cfg(feature = "posterior")]
mod convergence;
pub mod diagnose;
#[cfg(test)]
mod example;
mod features;
mod listed;
pub mod normal;
#[cfg(feature = "posterior")]
mod nuts;
mod ordered;
pub mod predict;
pub mod pressure_line;

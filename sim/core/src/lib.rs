//! A planar discrete elastic rod in time.

pub mod accuracy;
pub mod forward;
pub mod initial;
pub mod integrate;
pub mod limits;
mod observed;
pub mod pace;
pub mod point;
pub mod rest;
pub mod run;
pub mod stepper;
pub mod trajectory;

//! A planar discrete elastic rod in time.

pub mod accuracy;
pub mod forward;
pub mod integrate;
pub mod limits;
mod observed;
pub mod pace;
pub mod point;
pub mod rest;
pub mod trajectory;

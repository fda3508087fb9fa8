//! What the world does: a planar discrete elastic rod, clamped at one end, with a rigid body at the other.
pub mod analytical;
pub mod banded;
pub mod effects;
pub mod error;
pub mod interpolate;
pub mod kinematics;
pub mod model;
pub mod muscle;
pub mod nearest;
pub mod posture;
pub mod pressure;
pub mod quantity;
mod root;
pub mod snapshot;
pub mod statics;
pub mod system;
mod tangent;

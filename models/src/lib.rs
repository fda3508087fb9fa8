//! What the world does: a planar discrete elastic rod, clamped at one end, with a rigid body at the other.
pub mod effects;
pub mod interpolate;
pub mod muscle;
pub mod nearest;
pub mod quantity;
pub mod snapshot;

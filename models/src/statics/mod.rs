//! What needs no time: rest postures, and small vibrations about them.
//!
//! [`equilibrium`](equilibrium::equilibrium) finds the posture in which a model hangs, and
//! [`modes`](modes::modes) its natural frequencies there.

pub mod equilibrium;
pub mod modes;
mod path;

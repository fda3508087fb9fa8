//! What needs no time: rest postures, and small vibrations about them.
//!
//! [`equilibrium()`] finds the posture in which a model hangs, and [`modes()`] its natural
//! frequencies there.

mod equilibrium;
mod modes;
mod path;

pub use equilibrium::{Equilibrium, equilibrium};
pub use modes::{Mode, modes};

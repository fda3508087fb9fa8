//! What needs no time: rest postures, and small vibrations about them.
//!
//! [`equilibrium()`] finds the posture in which a model hangs, [`modes()`] its natural frequencies
//! there, [`SmallMotion`] all linear motion about
//! it, [`section_share()`] what a thick section does to them; [`euler_bernoulli`] is the paper's linear beam.

mod equilibrium;
pub mod euler_bernoulli;
mod held;
mod modes;
mod path;
mod section;
mod small_motion;

pub use equilibrium::{Equilibrium, equilibrium, equilibrium_at};
pub use held::{Hold, held};
pub use modes::{Mode, modes};
pub use section::section_share;
pub use small_motion::SmallMotion;

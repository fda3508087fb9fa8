//! Laws as text, as `efam effects --rust` writes them: compiled as they would be in `models/src/effects`, whose names
//! are here, and `crate::formula` and `crate::written` at the root.

pub use models::effects::*;

#[path = "../../laws/my_cubic_stiffness.rs"]
pub mod my_cubic_stiffness;
#[path = "../../laws/my_dahl.rs"]
pub mod my_dahl;

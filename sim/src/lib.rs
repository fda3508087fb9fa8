//! What we do with the models.

pub mod analysis;
pub mod forward;
pub mod integrate;
pub mod observe;
pub mod results;
pub mod scenario;
pub mod trajectory;

//! What we do with the models.

pub mod accuracy;
pub mod analysis;
pub mod calibrate;
pub mod cleaning;
pub mod diagnose;
pub mod escape;
pub mod experiment;
pub mod figures;
mod footer;
pub mod forward;
pub mod input;
pub mod integrate;
pub mod limits;
pub mod memory;
mod normal;
pub mod observe;
mod observed;
pub mod pace;
pub mod predict;
mod quantile;
pub mod recording;
pub mod results;
pub mod scenario;
pub mod schema;
pub mod sweep;
pub mod trajectory;

//! What is simulated and what was measured: scenarios, experiments, recordings that are cut into releases, and the
//! analysis of a swing.

pub mod analyse;
pub mod analysis;
pub mod cleaning;
pub mod drive;
pub mod error;
pub mod events;
pub mod experiment;
pub mod gathered;
pub mod init;
pub mod kind;
pub mod release;
pub mod scenario;
pub mod summary;
pub mod table;

pub use cleaning::out_of_plane;

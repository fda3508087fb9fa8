//! What a run shows while it integrates.

#[cfg(feature = "rerun")]
pub mod rerun;

/// Version of the Rerun viewer that fits the library.
pub const VIEWER: &str = "0.36.3";

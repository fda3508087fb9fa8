//! What a run shows while it integrates.

#[cfg(feature = "rerun")]
pub mod rerun;

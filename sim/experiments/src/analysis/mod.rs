//! What a recording of the tip says by itself: frequency, damping, settling, and bending stiffness
//! of the beam that has the same tip. The paper's method, and what it leaves out.
//!
//! ```text
//! path ─▶ coordinate ─▶ Excursion ─▶ swing: spectrum ─▶ damped frequency ─┐
//!                           │                                             ▼
//!                           │                  peaks (needs the period) ─▶ decay: eq. 6 and 7; cycle by cycle
//!                           └──────▶ settling
//! late swing ───────▶ rest ─▶ bending_stiffness, static_stiffness: several models side by side
//! frequency ────────▶ dynamic_stiffness, at the amplitude of the swing
//! Release ─▶ gaps ──▶ measured: all of it for a recording
//! ```
//!
//! Simulated and measured tips take the same way, so that their numbers can be compared.

pub mod bending_stiffness;
pub mod brent;
pub mod coordinate;
pub mod decay;
pub mod dynamic_stiffness;
mod error;
pub mod excursion;
pub mod forced;
pub mod gaps;
pub mod measured;
pub mod nelder_mead;
pub mod peaks;
pub mod rest;
pub mod settling;
pub mod spectrum;
pub mod static_stiffness;
pub mod step;
pub mod swing;

pub use error::AnalysisError;
pub use excursion::Excursion;

//! The program `efam` from outside.

mod bench;
mod cli;
mod experiment;
#[cfg(feature = "rerun")]
mod live_view;

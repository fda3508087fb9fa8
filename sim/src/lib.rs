//! The program efam: its command line, the live view, and why it ends before its time.

// The command line names the modules of this library as other crates do.
extern crate self as sim;

pub mod cli;
pub mod failure;
pub mod observe;
pub mod simulate;

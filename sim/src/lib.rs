//! The program efam: its command line, the live view, and why it ends before its time.

pub mod catalogue;
pub mod cli;
pub mod failure;
pub mod figures;
pub mod observe;
pub mod rest;
pub mod simulate;

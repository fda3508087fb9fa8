//! The program `efam` from outside.

mod bench;
mod browser;
mod calibrate;
mod cli;
mod diagnose;
mod diagnosis_page;
mod experiment;
mod inspect;
#[cfg(feature = "rerun")]
mod live_view;
mod pages;
mod predict;

//! The program `efam` from outside.

mod bench;
mod browser;
mod calibrate;
mod cli;
mod diagnose;
mod diagnosis_page;
mod doctor;
mod experiment;
mod export;
mod inspect;
#[cfg(unix)]
mod interrupted;
#[cfg(feature = "rerun")]
mod live_view;
mod pages;
mod predict;
mod predict_rod;
mod schema;
mod sweep;
mod sweep_killed;
#[cfg(unix)]
mod tutorials;
mod view;

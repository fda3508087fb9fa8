//! The program `efam` from outside.

mod bench;
mod calibrate;
mod cli;
mod diagnose;
mod diagnosis_page;
mod doctor;
mod experiment;
mod inspect;
#[cfg(unix)]
mod interrupted;
#[cfg(feature = "rerun")]
mod live_view;
mod predict;
mod predict_rod;
mod schema;
#[cfg(unix)]
mod tutorials;
mod view;

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
mod faults;
mod inspect;
#[cfg(unix)]
mod interrupted;
#[cfg(unix)]
mod killed;
#[cfg(target_os = "linux")]
mod listening;
#[cfg(feature = "rerun")]
mod live_view;
mod names;
mod pages;
mod predict;
mod predict_rod;
mod schema;
mod sweep;
mod sweep_experiments;
mod sweep_killed;
#[cfg(unix)]
mod tutorials;
mod view;
mod work;

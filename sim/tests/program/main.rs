//! The program `efam` from outside.

mod bench;
mod bent_starts;
mod browser;
mod calibrate;
mod cli;
#[cfg(unix)]
mod cluster;
#[cfg(unix)]
mod command_lines;
mod diagnose;
mod diagnosis_page;
mod doctor;
#[cfg(unix)]
mod draws;
mod energies;
mod experiment;
mod export;
mod faults;
mod first_steps;
mod hidden_letters;
mod inspect;
#[cfg(unix)]
mod interrupted;
#[cfg(unix)]
mod killed;
mod laws;
mod limits;
mod linearise;
#[cfg(target_os = "linux")]
mod listening;
#[cfg(feature = "rerun")]
mod live_view;
mod names;
mod pages;
mod paper;
mod predict;
mod predict_rod;
mod reference;
mod says;
mod schema;
mod slides;
#[cfg(unix)]
mod strangers;
mod struck;
mod sweep;
mod sweep_experiments;
mod sweep_killed;
#[cfg(unix)]
mod terminated;
#[cfg(unix)]
mod terminated_phases;
#[cfg(unix)]
mod tutorials;
mod typed;
mod view;
#[cfg(unix)]
mod watched;
mod work;

//! Features in the words of a user.

use crate::calibrate::Trial;
use crate::features::{Plan, What};

/// What a feature is, in words with its unit, and its value in that unit.
pub fn words(plan: &Plan, trial: &Trial, what: What, value: f64) -> (String, f64) {
    let name = |coordinate: usize| plan.name_of(&trial.release, coordinate);
    let of = |coordinate: usize| match coordinate {
        0 if plan.tracks.len() == 1 => String::new(),
        _ => format!(" ({})", name(coordinate)),
    };
    let late = |window: usize| match window {
        0 => "in the first cycle".to_owned(),
        1 => "in cycles 2 to 3".to_owned(),
        window => format!("in cycles {} to {}", 1 << window, (2 << window) - 1),
    };
    let mm = 1e3 * value;
    match what {
        What::Start { coordinate } => (format!("place at the start{}, mm", of(coordinate)), mm),
        What::Turn { turn, coordinate } => (format!("place at turn {}{}, mm", turn + 1, of(coordinate)), mm),
        What::FirstTurn => ("time of the first turn, s".to_owned(), value.exp()),
        What::FirstHalfPeriod => ("time from the first turn to the second, s".to_owned(), value.exp()),
        What::Frequency { window } => (format!("frequency {}, Hz", late(window)), value.exp()),
        What::Amplitude { window: 0 } => ("amplitude in the first cycle, mm".to_owned(), 1e3 * value.exp()),
        What::Amplitude { window } => (format!("amplitude {}, over that before", late(window)), value.exp()),
        What::Damping { window } => (format!("damping ratio {}", late(window)), value),
        What::Mean { window, coordinate } => (format!("mean {}{}, mm", late(window), of(coordinate)), mm),
        What::Swing { window, coordinate } => (format!("swing {}{}, mm", late(window), of(coordinate)), mm),
        What::Second { window, coordinate } => {
            (format!("second harmonic {}{}, mm", late(window), of(coordinate)), mm)
        }
        What::Rest { coordinate } => (format!("place at rest{}, mm", of(coordinate)), mm),
        What::Drift { coordinate } => (format!("drift{}, mm", of(coordinate)), mm),
    }
}

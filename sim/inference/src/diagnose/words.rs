//! Features in the words of a user.

use crate::calibrate::Trial;
use crate::features::{Plan, What};

/// What a feature is in words, its unit, and its value in that unit.
pub fn words(plan: &Plan, trial: &Trial, what: What, value: f64) -> (String, &'static str, f64) {
    let of = |coordinate: usize| match coordinate {
        0 if plan.tracks.len() == 1 => String::new(),
        _ => format!(" ({})", plan.name_of(&trial.release, coordinate)),
    };
    let late = |window: usize| match window {
        0 => "in the first cycle".to_owned(),
        1 => "in cycles 2 to 3".to_owned(),
        window => format!("in cycles {} to {}", 1 << window, (2 << window) - 1),
    };
    let place = |name: String| (name, "mm", 1e3 * value);
    match what {
        What::Start { coordinate } => place(format!("place at the start{}", of(coordinate))),
        What::Turn { turn, coordinate } => place(format!("place at turn {}{}", turn + 1, of(coordinate))),
        What::FirstTurn => ("time of the first turn".to_owned(), "s", value.exp()),
        What::FirstHalfPeriod => ("time from the first turn to the second".to_owned(), "s", value.exp()),
        What::Frequency { window } => (format!("frequency {}", late(window)), "Hz", value.exp()),
        What::Amplitude { window: 0 } => ("amplitude in the first cycle".to_owned(), "mm", 1e3 * value.exp()),
        What::Amplitude { window } => {
            (format!("amplitude {} over that before", late(window)), "", value.exp())
        }
        What::Damping { window } => (format!("damping ratio {}", late(window)), "", value),
        What::Mean { window, coordinate } => place(format!("mean {}{}", late(window), of(coordinate))),
        What::Swing { window, coordinate } => place(format!("swing {}{}", late(window), of(coordinate))),
        What::Second { window, coordinate } => {
            place(format!("second harmonic {}{}", late(window), of(coordinate)))
        }
        What::Rest { coordinate } => place(format!("place at rest{}", of(coordinate))),
        What::Drift { coordinate } => place(format!("drift{}", of(coordinate))),
    }
}

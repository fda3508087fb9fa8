//! Predictions over pressures and payloads in words.

use efam_inference::predict::grid::Grid;

use crate::interval::with_interval;
use crate::picture::PASCAL_PER_PSI;
use crate::report::significant;

/// What the grid says beyond its numbers, in words.
pub fn answers(grid: &Grid) -> Vec<String> {
    let pressure = |pressure: Option<f64>| pressure.map_or(String::new(), |pressure| both(pressure) + ": ");
    let mut words = Vec::new();
    let asked = grid.past_straight_down.len();
    let always = grid.past_straight_down.iter().filter(|past| past.always).count();
    let never =
        grid.past_straight_down.iter().filter(|past| !past.always && past.payload_kg.is_none()).count();
    let at = |count: usize| match (count == asked, grid.pressures_pa.len()) {
        (true, 0 | 1) => String::new(),
        (true, _) => "at all pressures ".to_owned(),
        (false, _) => format!("at {count} of {asked} pressures "),
    };
    if always > 0 {
        words.push(format!(
            "{}a release takes the tip past straight down with every requested payload",
            at(always)
        ));
    }
    if never > 0 {
        words.push(format!("{}no requested payload takes the tip past straight down", at(never)));
    }
    for past in &grid.past_straight_down {
        words.extend(past.payload_kg.map(|payload| {
            format!(
                "{}a release takes the tip past straight down from {} on",
                pressure(past.pressure_pa),
                with_interval(payload, past.interval_95, 1e3, "g")
            )
        }));
    }
    for slowest in &grid.slowest {
        let end = if slowest.at_end { ", the end of the range: beyond it may be slower still" } else { "" };
        words.push(format!(
            "with {} g small swings are slowest at {}, {}{end}",
            significant(1e3 * slowest.payload_kg, 4),
            both(slowest.pressure_pa),
            with_interval(slowest.frequency_hz, slowest.interval_95, 1.0, "Hz")
        ));
    }
    words
}

/// A pressure, Pa, in the units of reports and of laboratories.
fn both(pressure: f64) -> String {
    format!("{} kPa ({} psi)", significant(1e-3 * pressure, 4), significant(pressure / PASCAL_PER_PSI, 3))
}

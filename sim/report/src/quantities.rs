//! The numbers of a run for people: in mm, degrees, Hz and s, each with what it is.

use efam_experiments::summary::Summary;

use crate::report::significant;

/// One number of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// What it is.
    pub name: &'static str,
    /// Unit in which it is given; empty if dimensionless.
    pub unit: &'static str,
    /// The number, or why there is none.
    pub value: Result<f64, String>,
}

impl Quantity {
    /// The number in four digits that count, or a dash.
    pub fn text(&self) -> String {
        self.value.as_ref().map_or("-".to_owned(), |value| significant(*value, 4))
    }
}

/// The numbers of a run, in the order in which they are reported.
pub fn quantities(summary: &Summary) -> Vec<Quantity> {
    const MILLI: f64 = 1e3;
    let degrees = 1.0f64.to_degrees();
    let mode = |number: usize| summary.modes.as_ref().and_then(|modes| modes.get(number).copied());
    let of = |name, unit, entry: &str, factor: f64, value: Option<f64>| {
        let why = || summary.missing.get(entry).cloned().unwrap_or_else(|| "there is none".to_owned());
        Quantity { name, unit, value: value.map(|value| factor * value).ok_or_else(why) }
    };
    let (rest, lowest, energy) = (summary.rest, summary.lowest, summary.energy);
    vec![
        of("tip at rest, x", "mm", "rest", MILLI, rest.map(|rest| rest.tip_x_m)),
        of("tip at rest, z", "mm", "rest", MILLI, rest.map(|rest| rest.tip_z_m)),
        of("angle of the tip at rest", "deg", "rest", degrees, rest.map(|rest| rest.tip_angle_rad)),
        of("lowest tip, z", "mm", "lowest", MILLI, lowest.map(|lowest| lowest.tip_z_m)),
        of("lowest tip, after", "s", "lowest", 1.0, lowest.and_then(|lowest| lowest.time_s)),
        of("minimum tip angle", "deg", "least_tip_angle_rad", degrees, summary.least_tip_angle_rad),
        of("damped frequency, spectrum", "Hz", "damped_frequency_hz", 1.0, summary.damped_frequency_hz),
        of("natural frequency, eq. 7", "Hz", "natural_frequency_hz", 1.0, summary.natural_frequency_hz),
        of("damping ratio, eq. 6", "", "damping_ratio", 1.0, summary.damping_ratio),
        of(
            "damped frequency, of the height",
            "Hz",
            "height",
            1.0,
            summary.height.map(|h| h.damped_frequency_hz),
        ),
        of("damping ratio, eq. 6, of the height", "", "height", 1.0, summary.height.map(|h| h.damping_ratio)),
        of("eq. 6 misses the peaks by", "mm", "decay_residual_m", MILLI, summary.decay_residual_m),
        of("first mode", "Hz", "modes", 1.0, mode(0).map(|mode| mode.natural_frequency_hz)),
        of("damping ratio of the first mode", "", "modes", 1.0, mode(0).map(|mode| mode.damping_ratio)),
        of("second mode", "Hz", "modes", 1.0, mode(1).map(|mode| mode.natural_frequency_hz)),
        of("third mode", "Hz", "modes", 1.0, mode(2).map(|mode| mode.natural_frequency_hz)),
        of("settled to 5 % after", "s", "settling_5_percent_s", 1.0, summary.settling_5_percent_s),
        of("settled to 2 % after", "s", "settling_2_percent_s", 1.0, summary.settling_2_percent_s),
        of("greatest speed of the tip", "m/s", "peak_speed", 1.0, summary.peak_speed.map(|p| p.speed_m_s)),
        of(
            "potential energy released",
            "mJ",
            "energy",
            MILLI,
            energy.map(|energy| energy.potential_released),
        ),
        of("energy dissipated", "mJ", "energy", MILLI, energy.map(|energy| energy.dissipated)),
        of("energy closed to", "ppm of that released", "energy", 1e6, energy.map(|energy| energy.closure)),
    ]
}

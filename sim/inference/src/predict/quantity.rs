//! The numbers of a prediction: what they mean, and where a run gives them.

use efam_experiments::summary::{Mode, Summary};
use models::muscle::Marker;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::interval::with_error;
use crate::normal::NORMAL_95;

/// One predicted number.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Quantity {
    /// Its name, with the unit.
    pub name: String,
    /// What it is, in words.
    pub meaning: String,
    /// SI unit; empty if dimensionless.
    pub unit: String,
    /// Its value; none where the run has none.
    pub value: Option<f64>,
    /// The interval that holds 95 % of what the errors of the calibration admit.
    pub interval_95: Option<[f64; 2]>,
    /// Why there is no value.
    pub missing: Option<String>,
}

/// What one run says.
pub(super) struct Told<'a> {
    pub summary: &'a Summary,
    /// Largest bending moment at the root, N m.
    pub root_moment: f64,
    /// The same at rest.
    pub root_moment_at_rest: f64,
    /// Lowest point of the tip, m.
    pub lowest: Option<f64>,
}

/// All numbers of a run, in the order of [`QUANTITIES`].
pub(super) fn numbers(told: &Told) -> Vec<Option<f64>> {
    QUANTITIES.iter().map(|kind| (kind.of)(told)).collect()
}

/// What a number is, as far as errors of the model go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Off {
    /// A position or height while the rod swings, m.
    Swing,
    /// A position at rest, m.
    Rest,
    /// An angle while it swings, rad.
    SwingAngle,
    /// An angle at rest, rad.
    RestAngle,
    /// A moment or a speed of the swing: the share of the distance.
    Share,
    /// A frequency of the first mode.
    Frequency,
    /// A damping ratio of the first mode, or a time in which it acts.
    Damping,
    /// What no recording of a swing shows.
    Untold,
}

/// The rest of the tip, along the level and in height; the first two of all numbers.
pub(super) const REST: [&str; 2] = ["rest_x_m", "rest_z_m"];
/// The rest of its marker, likewise.
pub(super) const SEEN: [&str; 2] = ["seen_rest_x_m", "seen_rest_z_m"];

/// The rest of the marker, from that of the tip. The errors of the rest and of the marker's offset are added as if they were
/// independent: a rod that is too soft in the calibration has its marker too high, so the interval is on the wide side.
pub(super) fn seen(quantities: &[Quantity], marker: &Marker) -> Vec<Quantity> {
    let along = |axis: usize| {
        let rest = quantities.iter().find(|quantity| quantity.name == REST[axis])?;
        let value = rest.value? + marker.offset_m[axis];
        let moved = |ends: [f64; 2]| {
            let ends = ends.map(|end| end + marker.offset_m[axis]);
            with_error(value, ends, NORMAL_95 * marker.standard_error_m[axis])
        };
        Some(Quantity {
            name: SEEN[axis].to_owned(),
            meaning: format!("marker of the {}", rest.meaning),
            value: Some(value),
            interval_95: rest.interval_95.map(moved),
            ..rest.clone()
        })
    };
    (0..SEEN.len()).filter_map(along).collect()
}

/// A kind of number.
pub(super) struct PredictedKind {
    pub name: &'static str,
    pub meaning: &'static str,
    pub unit: &'static str,
    /// Its entry in a summary, which says why it is missing.
    pub entry: &'static str,
    of: fn(&Told) -> Option<f64>,
    /// What the error of the model makes of it.
    pub off: Off,
}

/// Name and unit of every number, in the order in which they are reported.
pub fn units() -> impl Iterator<Item = (&'static str, &'static str)> {
    QUANTITIES.iter().map(|kind| (kind.name, kind.unit))
}

/// What every number is, in words, likewise.
pub fn meanings() -> impl Iterator<Item = &'static str> {
    QUANTITIES.iter().map(|kind| kind.meaning)
}

fn mode<'a>(told: &Told<'a>, number: usize) -> Option<&'a Mode> {
    told.summary.modes.as_ref()?.get(number)
}

const fn kind(
    name: &'static str,
    meaning: &'static str,
    unit: &'static str,
    entry: &'static str,
    of: fn(&Told) -> Option<f64>,
    off: Off,
) -> PredictedKind {
    PredictedKind { name, meaning, unit, entry, of, off }
}

/// All numbers, in the order in which they are reported.
#[rustfmt::skip]
pub(super) const QUANTITIES: [PredictedKind; 19] = [
    kind(REST[0], "tip at rest, along the level", "m", "rest", |t| Some(t.summary.rest?.tip_x_m), Off::Rest),
    kind(REST[1], "tip at rest, height over the clamp", "m", "rest", |t| Some(t.summary.rest?.tip_z_m), Off::Rest),
    kind("rest_angle_rad", "angle of the tip at rest", "rad", "rest", |t| Some(t.summary.rest?.tip_angle_rad), Off::RestAngle),
    kind("small_frequency_hz", "frequency of small swings", "Hz", "modes", |t| Some(mode(t, 0)?.natural_frequency_hz), Off::Frequency),
    kind("small_damping_ratio", "damping ratio of small swings", "", "modes", |t| Some(mode(t, 0)?.damping_ratio), Off::Damping),
    kind("second_mode_hz", "frequency of the second mode", "Hz", "modes", |t| Some(mode(t, 1)?.natural_frequency_hz), Off::Untold),
    kind("second_damping_ratio", "damping ratio of the second mode", "", "modes", |t| Some(mode(t, 1)?.damping_ratio), Off::Untold),
    kind("third_mode_hz", "frequency of the third mode", "Hz", "modes", |t| Some(mode(t, 2)?.natural_frequency_hz), Off::Untold),
    kind("third_damping_ratio", "damping ratio of the third mode", "", "modes", |t| Some(mode(t, 2)?.damping_ratio), Off::Untold),
    kind("frequency_hz", "frequency as released", "Hz", "damped_frequency_hz", |t| t.summary.damped_frequency_hz, Off::Frequency),
    kind("damping_ratio", "damping ratio as released, by eq. 6", "", "damping_ratio", |t| t.summary.damping_ratio, Off::Damping),
    kind("lowest_z_m", "lowest point of the tip", "m", "lowest", |t| t.lowest, Off::Swing),
    kind("least_angle_rad", "minimum tip angle", "rad", "least_tip_angle_rad", |t| t.summary.least_tip_angle_rad, Off::SwingAngle),
    kind("first_peak_m", "first upper peak, distance from the rest", "m", "peaks", |t| Some(t.summary.peaks.as_ref()?.first()?.excursion_m), Off::Swing),
    kind("peak_speed_m_s", "greatest speed of the tip", "m/s", "peak_speed", |t| Some(t.summary.peak_speed?.speed_m_s), Off::Share),
    kind("settling_5_percent_s", "settled to 5 % after", "s", "settling_5_percent_s", |t| t.summary.settling_5_percent_s, Off::Damping),
    kind("settling_2_percent_s", "settled to 2 % after", "s", "settling_2_percent_s", |t| t.summary.settling_2_percent_s, Off::Damping),
    kind("root_moment_at_rest_n_m", "bending moment at the root at rest", "N m", "rest", |t| Some(t.root_moment_at_rest), Off::Untold),
    kind("root_moment_n_m", "largest bending moment at the root", "N m", "rest", |t| Some(t.root_moment), Off::Share),
];

//! Where a case lies outside what was calibrated, and what its intervals do not hold.

use models::muscle::Known;

use super::errors::Errors;

/// How far what is asked goes.
pub(super) struct Extent<'a> {
    /// Pressures, Pa; of a rod that is no muscle none.
    pub pressures: &'a [f64],
    /// Payloads, kg.
    pub payloads: &'a [f64],
    /// Largest distance of the tip from its rest, m.
    pub excursion: f64,
}

/// What should be known before the numbers are used, in words.
pub(super) fn warnings(asked: &Extent, known: Option<&Known>, errors: Option<&Errors>) -> Vec<String> {
    let Some((known, errors)) = known.zip(errors) else {
        return vec![
            "no intervals: the file has no section [calibration]; take what efam calibrate writes, muscle.toml or rod.toml"
                .to_owned(),
        ];
    };
    let mut words = Vec::new();
    if let Some(pressures) = outside(asked.pressures, known.pressure_pa, (1e-3, 1, "kPa")) {
        let [low, high] = known.pressure_pa.map(|pressure| format!("{:.1}", 1e-3 * pressure));
        words.push(format!(
            "the pressure, {pressures}, lies outside what was calibrated, {low} to {high} kPa: the intervals are too narrow by what changes on the way"
        ));
    }
    if let Some(payloads) = outside(asked.payloads, known.payload_kg, (1e3, 0, "g")) {
        let [low, high] = known.payload_kg.map(|payload| format!("{:.0}", 1e3 * payload));
        words.push(format!(
            "the payload, {payloads}, lies outside what was calibrated, {low} to {high} g: that EI and losses are the same under it is assumed"
        ));
    }
    if known.excursion_m > 0.0 && asked.excursion > 1.05 * known.excursion_m {
        words.push(format!(
            "the tip goes {:.0} mm from its rest, and was calibrated to {:.0} mm: that EI and losses are the same there is assumed",
            1e3 * asked.excursion,
            1e3 * known.excursion_m
        ));
    }
    for path in &errors.undetermined {
        words.push(format!(
            "{path} is not determined by the calibration: it is taken to be known to its own size"
        ));
    }
    words
}

/// Those that lie outside, in words: one, or from which to which, in a unit so many times finer; none where all
/// lie within.
fn outside(
    values: &[f64],
    [low, high]: [f64; 2],
    (factor, digits, unit): (f64, usize, &str),
) -> Option<String> {
    let room = 1e-6 * high.abs().max(f64::MIN_POSITIVE);
    let mut out: Vec<f64> =
        values.iter().copied().filter(|value| !(low - room..=high + room).contains(value)).collect();
    out.sort_by(f64::total_cmp);
    let [first, last] = [out.first()?, out.last()?].map(|value| format!("{:.digits$}", factor * value));
    Some(if out.len() == 1 { format!("{first} {unit}") } else { format!("{first} to {last} {unit}") })
}

//! Where a case lies outside what was calibrated, and what its intervals do not hold.

use models::muscle::Known;
use models::quantity::format_si;

use super::errors::Errors;
use models::digits::significant;

/// The range of what is requested.
pub(super) struct Extent<'a> {
    /// Pressures, Pa; of a rod that is no muscle none.
    pub pressures: &'a [f64],
    /// Payloads, kg.
    pub payloads: &'a [f64],
    /// Largest distance of the tip from its rest, m.
    pub excursion: f64,
}

/// What should be known before the numbers are used, in words; `errors` are those of each case.
pub(super) fn warnings(asked: &Extent, known: Option<&Known>, errors: &[Errors]) -> Vec<String> {
    let Some(known) = known else {
        return vec![
            "no intervals: the file has no section [calibration]; take what efam calibrate writes, muscle.toml or rod.toml"
                .to_owned(),
        ];
    };
    let mut words = outside(asked, known);
    words.extend(interpolated(errors));
    words.extend(once(errors, Errors::of_loss));
    words.extend(once(errors, Errors::of_payload));
    let silent = asked.pressures.iter().filter(|pressure| known.is_silent_at(**pressure)).count();
    if silent > 0 {
        words.push(
            "the file has no error of interpolation between calibrated pressures, so the intervals exclude it; calibrate again"
                .to_owned(),
        );
    }
    words.extend(undetermined(errors));
    words
}

/// What some cases say, by the first of them.
fn once(errors: &[Errors], of: fn(&Errors) -> Option<String>) -> Option<String> {
    let all: Vec<String> = errors.iter().filter_map(of).collect();
    match &all[..] {
        [] => None,
        [only] => Some(only.clone()),
        [first, ..] => Some(format!("{} of {} cases: {first}", all.len(), errors.len())),
    }
}

/// How far interpolation over pressure may be off, at worst over some cases.
fn interpolated(errors: &[Errors]) -> Option<String> {
    let mut worst: Vec<(&str, f64)> = Vec::new();
    for (path, share) in errors.iter().flat_map(|errors| &errors.interpolated) {
        match worst.iter_mut().find(|(own, _)| own == path) {
            Some((_, own)) => *own = own.max(*share),
            None => worst.push((path, *share)),
        }
    }
    let count = errors.iter().filter(|errors| !errors.interpolated.is_empty()).count();
    let which = match (count, errors.len()) {
        (0, _) => return None,
        (1, 1) => "its pressure".to_owned(),
        (count, all) => format!("the pressure of {count} of {all} cases"),
    };
    let share = |(path, share): &(&str, f64)| format!("{path} to ±{} %", significant(100.0 * share, 2));
    let shares = worst.iter().map(share).collect::<Vec<_>>().join(", ");
    Some(format!(
        "{which} was not calibrated; interpolation gives {shares} (95 %), and the intervals include that"
    ))
}

/// Parameters that the calibration did not determine, each once.
fn undetermined(errors: &[Errors]) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    for errors in errors {
        for parameter in &errors.undetermined {
            let at = parameter.pressure_pa.map_or(String::new(), |p| format!(" at {}", format_si(p, "Pa")));
            let name = format!("{}{at}", parameter.path);
            let text = |value: f64| format_si(value, errors.unit(&parameter.path));
            let own = match parameter.standard_error {
                Some(error) => format!(
                    "the calibration cannot tell {name} from zero: {} with a standard error of {}; numbers that depend on it have wide intervals",
                    text(parameter.value),
                    text(error)
                ),
                None => format!(
                    "the calibration does not determine {name}, {}: the intervals take it to be known to its own size, or to its typical size where that is larger",
                    text(parameter.value)
                ),
            };
            if !words.contains(&own) {
                words.push(own);
            }
        }
    }
    words
}

/// Where the cases lie outside the calibration, in words.
pub(super) fn outside(asked: &Extent, known: &Known) -> Vec<String> {
    let mut words = Vec::new();
    let calibrated = |ends: [f64; 2], (factor, digits, unit): (f64, usize, &str)| {
        let [low, high] = ends.map(|end| format!("{:.digits$}", factor * end));
        if low == high { format!("{low} {unit}") } else { format!("{low} to {high} {unit}") }
    };
    let (kpa, g) = ((1e-3, 1, "kPa"), (1e3, 0, "g"));
    if let Some(pressures) = beyond(asked.pressures, known.pressure_pa, kpa) {
        words.push(format!(
            "the pressure, {pressures}, lies outside what was calibrated, {}: the change of EI and losses is extrapolated",
            calibrated(known.pressure_pa, kpa)
        ));
    }
    if let Some(payloads) = beyond(asked.payloads, known.payload_kg, g) {
        words.push(format!(
            "the payload, {payloads}, lies outside what was calibrated, {}: EI and losses are assumed to be the same under it",
            calibrated(known.payload_kg, g)
        ));
    }
    if known.excursion_m > 0.0 && asked.excursion > 1.05 * known.excursion_m {
        words.push(format!(
            "the tip goes {:.0} mm from its rest, and was calibrated to {:.0} mm: EI and losses are assumed to be the same there",
            1e3 * asked.excursion,
            1e3 * known.excursion_m
        ));
    }
    words
}

/// Those that lie outside, in words: one, or from which to which, in a unit so many times finer; none where all
/// lie within.
fn beyond(
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

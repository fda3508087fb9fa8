//! The few lines of a run that a person can quote.

use std::fmt::Write;

use models::digits::{fixed, rounded, unsigned_zero};
pub use models::digits::{short, significant, significant_or_dash};

use efam_core::accuracy::Errors;
use efam_core::trajectory::Status;
use efam_experiments::analysis::forced::Response;
use efam_experiments::analysis::step::Step;
use efam_experiments::events::EventKind;
use efam_experiments::summary::Summary;
use efam_experiments::summary::{Cycle, Mode, RunSettings};

/// Width that no line exceeds, save a folder's or a reason's own length.
const WIDTH: usize = 80;
/// Where values begin.
const COLUMN: usize = 17;

/// Factor and unit in which a number of an SI unit is printed: lengths in mm, angles in degrees, pressures in kPa, masses
/// in g, energies in mJ.
pub(super) fn readable(unit: &str) -> (f64, &str) {
    match unit {
        "m" => (1e3, "mm"),
        "rad" => (1.0f64.to_degrees(), "deg"),
        "Pa" => (1e-3, "kPa"),
        "kg" => (1e3, "g"),
        "J" => (1e3, "mJ"),
        unit => (1.0, unit),
    }
}

/// A table of a run, lines up to 80 wide; numbers are rounded to what a reader can use.
pub fn report(summary: &Summary) -> String {
    let mut lines = Lines::default();
    let millimetres = |metres: f64| millimetres(metres, summary.errors.as_ref());
    lines.row("run", &format!("{}, {}", summary.name, run(summary)));
    lines.entry(
        summary,
        "rest",
        summary.rest.as_ref().map(|rest| {
            let [x, z] = [rest.tip_x_m, rest.tip_z_m].map(millimetres);
            format!("tip at x {x} mm, z {z} mm, {}", degrees(rest.tip_angle_rad))
        }),
    );
    responses(&mut lines, summary, &millimetres);
    let lowest = summary.lowest.as_ref().map(|lowest| {
        format!("z {} mm at {} s", millimetres(lowest.tip_z_m), fixed(lowest.time_s.unwrap_or(0.0), 2))
    });
    lines.entry(summary, "lowest", lowest);
    let least_angle = summary.least_tip_angle_rad.map(|angle| {
        let beyond = if summary.beyond_straight_down == Some(true) { ", beyond straight down" } else { "" };
        format!("down to {}{beyond}", degrees(angle))
    });
    lines.entry(summary, "least_tip_angle_rad", least_angle);
    lines.entry(summary, "coordinate", summary.coordinate.map(|coordinate| coordinate.name()));
    lines.entry(
        summary,
        "peaks",
        summary.peaks.as_ref().map(|peaks| match peaks.first() {
            Some(first) => {
                let size = millimetres(first.excursion_m);
                format!("{} upper; first at {} s, {size} mm from rest", peaks.len(), fixed(first.time_s, 3))
            }
            None => "none".to_owned(),
        }),
    );
    let natural = summary
        .natural_frequency_hz
        .map_or(String::new(), |hz| format!(", {} Hz natural (eq. 7)", fixed(hz, 3)));
    let frequency = summary.damped_frequency_hz.map(|hz| format!("{} Hz damped{natural}", fixed(hz, 3)));
    lines.entry(summary, "damped_frequency_hz", frequency);
    let by_cycle = by_cycle(summary, &millimetres);
    let ratio = summary.damping_ratio.map(|ratio| format!("{} by eq. 6{by_cycle}", significant(ratio, 3)));
    lines.entry(summary, "damping_ratio", ratio);
    if let Some(of) = &summary.height {
        let [hz, ratio] = [of.damped_frequency_hz, of.damping_ratio].map(|value| significant(value, 3));
        lines.row("height, as paper", &format!("{hz} Hz damped, damping ratio {ratio} by eq. 6"));
    }
    let stuck = if summary.slipping_modes.is_some() { "friction sticking: " } else { "" };
    lines.entry(summary, "modes", summary.modes.as_ref().map(|modes| format!("{stuck}{}", listed(modes))));
    if let Some(modes) = &summary.slipping_modes {
        let modes = if modes.is_empty() { "not found".to_owned() } else { listed(modes) };
        lines.row("", &format!("friction slipping: {modes}"));
    }
    lines.entry(summary, "settling_2_percent_s", settling(summary));
    lines.entry(
        summary,
        "peak_speed",
        summary
            .peak_speed
            .as_ref()
            .map(|peak| format!("{} m/s at {} s", fixed(peak.speed_m_s, 2), fixed(peak.time_s, 2))),
    );
    lines.entry(
        summary,
        "energy",
        summary.energy.as_ref().map(|energy| {
            let released = significant(1e3 * energy.potential_released, 3);
            format!("{released} mJ released, closed to {}", parts(energy.closure))
        }),
    );
    lines.row("effort", &effort(summary));
    if let Some(errors) = &summary.errors {
        lines.row("tip error", &tip_error(errors, &summary.settings));
    }
    for warning in &summary.warnings {
        lines.row("warning", warning);
    }
    lines.0
}

/// Times after which the swing stays within 2 and 5 per cent of its size.
fn settling(summary: &Summary) -> Option<String> {
    summary.settling_2_percent_s.or(summary.settling_5_percent_s).map(|_| {
        let within =
            |time: Option<f64>| time.map_or("not reached".to_owned(), |time| format!("{} s", fixed(time, 2)));
        let [two, five] = [summary.settling_2_percent_s, summary.settling_5_percent_s].map(within);
        format!("{two} to 2 %, {five} to 5 %")
    })
}

/// Damping ratios of the first and the last cycle.
fn by_cycle(summary: &Summary, millimetres: &dyn Fn(f64) -> String) -> String {
    let cycles = summary.cycles.as_deref().unwrap_or_default();
    match (cycles.first(), cycles.last()) {
        (Some(first), Some(last)) => {
            let at = |cycle: &Cycle| {
                format!("{} at {} mm", significant(cycle.damping_ratio, 3), millimetres(cycle.amplitude_m))
            };
            format!("; by cycle {}, {}", at(first), at(last))
        }
        _ => String::new(),
    }
}

/// How the tip answered each event.
fn responses(lines: &mut Lines, summary: &Summary, millimetres: &dyn Fn(f64) -> String) {
    for event in &summary.events {
        if event.kind != EventKind::Release || summary.events.len() > 1 {
            lines.row("event", &event.name());
        }
        for (letter, own) in [("x", &event.x), ("z", &event.z)] {
            if let Some(own) = own {
                lines.row(&format!("{letter}, response"), &response(own, millimetres));
            } else if let Some(why) = event.missing.get(letter).filter(|_| summary.missing.len() < EXPLAINED)
            {
                lines.row(&format!("{letter}, response"), &format!("- {why}"));
            }
        }
        for (letter, own) in [("x", &event.forced_x), ("z", &event.forced_z)] {
            let why = event.missing.get(&format!("forced_{letter}")).map(|why| format!("- {why}"));
            if let Some(text) = own.as_ref().map(forced).or(why) {
                lines.row(&format!("{letter}, forced"), &text);
            }
        }
    }
}

/// Numbers of a summary that are missing from which on the first of them says enough.
const EXPLAINED: usize = 4;

/// A step response, as `stepinfo` has it.
fn response(of: &Step, millimetres: &dyn Fn(f64) -> String) -> String {
    let time =
        |time: Option<f64>| time.map_or("not reached".to_owned(), |time| format!("{} s", fixed(time, 2)));
    let overshoot = fixed(of.overshoot_percent, 1);
    format!(
        "{} to {} mm; rise {}, overshoot {overshoot} %, settled {} to 2 %",
        millimetres(of.start_m),
        millimetres(of.steady_m),
        time(of.rise_s),
        time(of.settling_2_percent_s)
    )
}

/// Gain and phase.
fn forced(of: &Response) -> String {
    let [amplitude, gain] = [of.amplitude_m, of.gain_m_per_n].map(|value| significant(1e3 * value, 3));
    format!("{amplitude} mm, gain {gain} mm/N, phase {}", degrees(of.phase_rad))
}

/// Frequencies, with damping ratios.
fn listed(modes: &[Mode]) -> String {
    let mode = |mode: &Mode| {
        let [hz, ratio] = [mode.natural_frequency_hz, mode.damping_ratio].map(|value| significant(value, 3));
        format!("{hz} Hz ({ratio})")
    };
    modes.iter().map(mode).collect::<Vec<_>>().join(", ")
}

/// Label of an entry of the summary.
fn label(entry: &str) -> &str {
    match entry {
        "lowest" => "lowest tip",
        "least_tip_angle_rad" => "tip angle",
        "damped_frequency_hz" => "frequency",
        "damping_ratio" => "damping ratio",
        "modes" => "modes (damping)",
        "settling_2_percent_s" => "settled",
        "peak_speed" => "fastest tip",
        entry => entry,
    }
}

#[derive(Default)]
struct Lines(String);

impl Lines {
    /// A value, or a dash and why there is none.
    fn entry(&mut self, summary: &Summary, entry: &str, value: Option<String>) {
        let why = || format!("- {}", summary.missing.get(entry).map_or("", String::as_str));
        self.row(label(entry), &value.unwrap_or_else(why));
    }

    /// A label and its value, which goes on in the next line where it is too long.
    fn row(&mut self, label: &str, value: &str) {
        let mut line = format!("{label:<COLUMN$}");
        for (k, word) in value.split_whitespace().enumerate() {
            if k > 0 && line.chars().count() + 1 + word.chars().count() > WIDTH {
                let _ = writeln!(self.0, "{line}");
                line = " ".repeat(COLUMN);
            } else if k > 0 {
                line.push(' ');
            }
            line.push_str(word);
        }
        let _ = writeln!(self.0, "{}", line.trim_end());
    }
}

fn run(summary: &Summary) -> String {
    let simulated = summary.simulated_s;
    match &summary.status {
        Status::Complete => format!("complete, {} s", fixed(simulated, 2)),
        Status::CutShort { time } => {
            format!("cut short at {} s of {} s", fixed(*time, 2), fixed(summary.settings.duration_s, 2))
        }
        Status::Failed { time, reason } => format!("failed at {} s: {reason}", fixed(*time, 4)),
    }
}

fn tip_error(errors: &Errors, settings: &RunSettings) -> String {
    let [mesh, step, asked] =
        [errors.mesh_m, errors.step_m, errors.requested_m].map(|error| rounded(1e3 * error, 2));
    let steps = match settings.fixed_step_s {
        Some(step) => format!("{} s each", rounded(step, 2)),
        None => format!("tolerance {:.0e}", settings.tolerance),
    };
    format!(
        "{mesh} mm by the mesh ({} nodes), {step} mm by the steps ({steps}); {asked} mm requested",
        settings.nodes
    )
}

fn effort(summary: &Summary) -> String {
    let mut text = format!("{} steps, {} rejected", summary.effort.steps, summary.effort.rejected);
    if let Some(factor) = summary.real_time_factor {
        let [wall, factor] = [summary.wall_time_s, factor].map(|value| significant(value, 2));
        let _ = write!(text, ", {wall} s, {factor} times real time");
    }
    text
}

/// To a tenth of a millimetre, or to the last digit that is a few times what the tip may be wrong by; a zero has no
/// sign.
fn millimetres(metres: f64, errors: Option<&Errors>) -> String {
    let last = errors.map_or(0.1, |errors| LAST_DIGIT * 1e3 * errors.requested_m);
    let decimals = (-last.log10()).floor().clamp(1.0, 9.0) as usize;
    unsigned_zero(format!("{:.decimals$}", 1e3 * metres))
}

/// Smallest unit of a last digit, over the requested accuracy.
const LAST_DIGIT: f64 = 4.0;

fn degrees(angle: f64) -> String {
    unsigned_zero(format!("{:.1}", angle.to_degrees())) + " deg"
}

/// A share as a power of ten that a reader grasps.
fn parts(share: f64) -> String {
    match share {
        share if share >= 1e-3 => format!("{} %", significant(100.0 * share, 2)),
        share => format!("{share:.0e} of that"),
    }
}

#[cfg(test)]
mod tests {
    use efam_core::example::{muscle_at_15_psi, released};
    use efam_core::rest::rest;
    use efam_experiments::summary::{MODES, summarise};

    use super::*;

    fn of(duration: f64) -> String {
        let model = muscle_at_15_psi();
        let (run, trajectory) = released(&model, duration);
        let (mut summary, _) = summarise(&model, &run, &trajectory, &rest(&model, duration, MODES));
        summary.name = "release".to_owned();
        summary.warnings.push("a pressure outside the table is extrapolated ".repeat(3));
        report(&summary)
    }

    #[test]
    fn the_report_fits_a_terminal_and_says_what_a_reader_wants() {
        let report = of(20.0);
        println!("{report}");
        assert!(report.lines().all(|line| line.chars().count() <= WIDTH), "{report}");
        assert!((14..=22).contains(&report.lines().count()), "{report}");
        for expected in [
            "release, complete, 20.00 s",
            "beyond straight down",
            "natural (eq. 7)",
            "by eq. 6; by cycle",
            " to 2 %, ",
        ] {
            assert!(report.contains(expected), "{expected}: {report}");
        }
    }

    #[test]
    fn what_is_missing_has_its_reason() {
        let report = of(0.05);
        println!("{report}");
        assert!(report.lines().all(|line| line.chars().count() <= WIDTH), "{report}");
        assert!(report.contains("settled          - not settled:"), "{report}");
    }

    #[test]
    fn a_zero_has_no_sign() {
        assert_eq!(millimetres(-1e-9, None), "0.0");
        assert_eq!(degrees(-1e-9), "0.0 deg");
    }
}

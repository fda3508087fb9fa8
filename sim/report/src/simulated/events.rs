//! The events of a run on its page: what happened, and how the tip responded.

use efam_experiments::analysis::forced::Response;
use efam_experiments::analysis::step::Step;
use efam_experiments::events::{Event, EventKind};
use efam_experiments::summary::Summary;
use models::digits::significant_or_dash;

use crate::page::{Page, Table};

/// The events, with the response of the tip.
pub(super) fn events(page: &mut Page, summary: &Summary) {
    let mut rows = Vec::new();
    for event in &summary.events {
        for (letter, own) in [("x", &event.x), ("z", &event.z)] {
            let text = |of: fn(&Step) -> Option<f64>, factor: f64| {
                let value = own.as_ref().and_then(of).map(|value| factor * value);
                significant_or_dash(value, 4)
            };
            rows.push(vec![
                event.name(),
                letter.to_owned(),
                text(|step| Some(step.start_m), 1e3),
                text(|step| Some(step.steady_m), 1e3),
                text(|step| step.rise_s, 1.0),
                text(|step| Some(step.overshoot_percent), 1.0),
                text(|step| Some(step.peak_s), 1.0),
                text(|step| step.settling_5_percent_s, 1.0),
                text(|step| step.settling_2_percent_s, 1.0),
                event.missing.get(letter).cloned().unwrap_or_default(),
            ]);
        }
    }
    let is_forced = |event: &&Event| event.kind == EventKind::SteadyForcing;
    let (forced, stepped): (Vec<&Event>, Vec<&Event>) = summary.events.iter().partition(is_forced);
    if !stepped.is_empty() {
        rows.retain(|row| stepped.iter().any(|event| event.name() == row[0]));
        page.folded(
            "Response to each event",
            &Table {
                caption: "As `stepinfo` of MATLAB defines them; times count from the event",
                heads: &[
                    "event",
                    "coordinate",
                    "start, mm",
                    "steady state, mm",
                    "rise, s",
                    "overshoot, %",
                    "peak, s",
                    "settled to 5 %, s",
                    "settled to 2 %, s",
                    "reason if missing",
                ],
                rows,
            },
        );
    }
    let mut rows = Vec::new();
    for event in forced {
        for (letter, own) in [("x", &event.forced_x), ("z", &event.forced_z)] {
            let text = |of: fn(&Response) -> f64, factor: f64| {
                significant_or_dash(own.as_ref().map(|own| factor * of(own)), 4)
            };
            rows.push(vec![
                event.name(),
                letter.to_owned(),
                text(|of| of.amplitude_m, 1e3),
                text(|of| of.gain_m_per_n, 1e3),
                text(|of| of.phase_rad, 1f64.to_degrees()),
                event.missing.get(&format!("forced_{letter}")).cloned().unwrap_or_default(),
            ]);
        }
    }
    if !rows.is_empty() {
        page.table(&Table {
            caption: "Steady forcing: the tip at the frequency of the force",
            heads: &["force", "coordinate", "amplitude, mm", "gain, mm/N", "phase, deg", "reason if missing"],
            rows,
        });
    }
}

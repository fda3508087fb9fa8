//! The page of a linear model.

use std::time::SystemTime;

use crate::Request;
use crate::linear::{LinearAnswer, SignalAnswer, in_psi, pole_cells};
use crate::page::{BeforeUse, Page, Table};
use crate::picture::Picture;
use crate::report::{readable, significant};

/// What any linear model takes for granted.
const ASSUMED: [&str; 3] = [
    "Motions are small. An error grows with the square of the swing, and with the change of pressure.",
    "The muscle follows its table, and the pressure its command: at once, or behind a pressure line without its rate limit.",
    "Friction holds as a spring in motions this small.",
];

/// Vibrations in the table.
const SHOWN: usize = 8;

pub(super) fn of(
    request: &Request,
    answer: &LinearAnswer,
    pictures: &[Picture],
    written: SystemTime,
) -> String {
    let mut page = Page::new(&format!("Linear model: {}", answer.name), "Linear", &lead(answer));
    page.section("Poles");
    let intervals = match answer.draws {
        0 => String::new(),
        draws => format!("; 95 % intervals of {draws} draws from the errors of the calibration"),
    };
    page.table(&Table {
        caption: &format!("Bending vibrations about the rest, slowest first{intervals}"),
        heads: &["pole", "frequency, Hz", "damping ratio", "settling to 5 %, s"],
        rows: answer
            .vibrations()
            .take(SHOWN)
            .enumerate()
            .map(|(k, pole)| pole_cells(k, pole, "", "").to_vec())
            .collect(),
    });
    answer.decays().iter().for_each(|decays| page.text(&format!("{decays}.")));
    page.section("Gains");
    let inputs = answer.inputs.iter().map(|input| input.name.as_str());
    let heads: Vec<&str> = [""].into_iter().chain(inputs).collect();
    let mut gains = |caption: &str, gains: &[Vec<f64>], intervals: Option<_>| {
        page.table(&Table { caption, heads: &heads, rows: answer.gains(gains, intervals) });
    };
    let caption = "Static gain: change of an output at rest over that of an input";
    gains(caption, &answer.static_gain, answer.static_gain_95.as_ref());
    if let Some(reduced) = &answer.reduced {
        let (states, band) = (reduced.states, significant(reduced.band_hz, 3));
        let found = format!("Largest error up to {band} Hz of the model reduced to {states} states");
        gains(&found, &reduced.error_found, None);
        gains("Bound of its error at any frequency", &reduced.error_bound, None);
    }
    page.section("Responses");
    pictures.iter().for_each(|picture| page.figure(picture));
    page.section("The rest");
    let row = |own: &SignalAnswer| {
        let (factor, unit) = in_psi(&own.unit).unwrap_or_else(|| readable(&own.unit));
        vec![own.name.clone(), significant(factor * own.at_rest, 5), unit.to_owned()]
    };
    page.table(&Table {
        caption: "Inputs and outputs at the rest, from which the model counts",
        heads: &["", "value", "unit"],
        rows: answer.inputs.iter().chain(&answer.outputs).map(row).collect(),
    });
    page.before_use(&BeforeUse {
        warnings: answer.warnings.clone(),
        assumed: ASSUMED.map(str::to_owned).to_vec(),
        ..BeforeUse::default()
    });
    page.facts_of(request, written, vec![("states".to_owned(), answer.states.len().to_string())]);
    page.finish()
}

fn lead(answer: &LinearAnswer) -> String {
    let slowest = answer.vibrations().next().map(|pole| {
        let [_, frequency, ratio, settling] = pole_cells(0, pole, "Hz", "s");
        format!("first vibration {frequency}, damping ratio {ratio}, settling to 5 % in {settling}; ")
    });
    let gains = answer.gains(&answer.static_gain, answer.static_gain_95.as_ref());
    let gain = format!("{} to {}: {}", answer.inputs[0].name, gains[0][0], gains[0][1]);
    format!("{}static gain from {gain}.", slowest.unwrap_or_default())
}

//! Responses of a linear model: what a Bode plot shows, and steps.

use std::f64::consts::{PI, TAU};

use efam_core::linear::{Complex, Modal};

use crate::linear::{LinearAnswer, SignalAnswer, gain_unit};
use crate::picture::Picture;
use crate::picture::drawing::drawn;
use crate::picture::lines::{Lines, Named};
use crate::picture::panel::{heading, px};

/// Frequencies of a Bode plot, over that of the first vibration.
const REACH: (f64, f64) = (0.05, 30.0);
const POINTS: usize = 600;
/// Time of a step response, in settling times of the first vibration.
const SETTLED_TIMES: f64 = 1.5;

/// A picture for each input, with a line for each output.
pub fn linear_pictures(answer: &LinearAnswer, modal: &Modal) -> Vec<Picture> {
    (0..answer.inputs.len()).map(|input| of_input(answer, modal, input)).collect()
}

fn of_input(answer: &LinearAnswer, modal: &Modal, input: usize) -> Picture {
    let own = &answer.inputs[input];
    let slowest = answer.poles.iter().find(|pole| pole.imaginary_per_s > 0.0);
    let first = slowest.map_or(1.0, |pole| pole.frequency_hz);
    let end = answer.settling_5_percent_s.unwrap_or(5.0 / first) * SETTLED_TIMES;
    let share = |k: usize| k as f64 / (POINTS - 1) as f64;
    let frequencies = (0..POINTS).map(|k| first * REACH.0 * (REACH.1 / REACH.0).powf(share(k)));
    let response: Vec<_> =
        frequencies.map(|f| (f.log10(), modal.response(Complex::new(0.0, TAU * f)))).collect();
    let steps: Vec<_> = (0..POINTS).map(|k| (end * share(k), modal.step(end * share(k)))).collect();
    let lines = |has_unit: bool, of: &dyn Fn(usize, f64) -> Vec<(f64, f64)>| -> Vec<Named> {
        let line = |(output, signal): (usize, &SignalAnswer)| {
            let (factor, unit) = gain_unit(signal, own);
            let unit = if has_unit { format!(", {unit}") } else { String::new() };
            (format!("{}{unit}", signal.name), of(output, factor))
        };
        answer.outputs.iter().enumerate().map(line).collect()
    };
    let gains = lines(true, &|output, factor| {
        response.iter().map(|(f, gain)| (*f, (factor * gain[(output, input)].norm()).log10())).collect()
    });
    let phases = lines(false, &|output, _| {
        continued(response.iter().map(|(f, gain)| (*f, gain[(output, input)].arg())))
    });
    let jumps = lines(true, &|output, factor| {
        steps.iter().map(|(t, step)| (*t, factor * step[(output, input)])).collect()
    });
    let drawing = drawn((1200, 840), |page| {
        heading(page, &format!("Responses to {}", own.name))?;
        let panels = page.below(px(34.0)).split_evenly((2, 2));
        let panel = |title, x, y| Lines { title, x, y, marks: false, from_zero: false, why: "no outputs" };
        let frequency = "log10 of frequency, Hz";
        panel("Gain", frequency, "log10 of gain").draw(&panels[0], &gains)?;
        panel("Step response", "time, s", "output by input").draw(&panels[1], &jumps)?;
        panel("Phase", frequency, "phase, deg").draw(&panels[2], &phases)
    });
    Picture {
        name: format!("linear-{}", input + 1),
        title: format!("Responses to {}", own.name),
        caption: "Gain and phase over frequency, and the output after the input has jumped by one unit."
            .to_owned(),
        drawing,
    }
}

/// Phases in degrees, without jumps by a turn.
fn continued(phases: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut last = None;
    let unwrapped = phases.map(|(f, phase)| {
        let phase = last.map_or(phase, |last: f64| phase - TAU * ((phase - last) / TAU).round());
        last = Some(phase);
        (f, phase * 180.0 / PI)
    });
    unwrapped.collect()
}

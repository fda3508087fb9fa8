//! Frequency and step responses of a linear model.

use std::f64::consts::TAU;

use efam_core::linear::{Complex, Linear};

use super::ResponseAnswer;

/// Frequencies of a Bode plot, over that of the first vibration.
const REACH: (f64, f64) = (0.05, 30.0);
const POINTS: usize = 600;
/// Time of a step response, in settling times of the first vibration; in its periods if it does not settle.
const SETTLED_TIMES: f64 = 1.5;
const PERIODS: f64 = 7.5;

/// Each output by each input, those of the first output first.
pub(super) fn of(linear: &Linear) -> Vec<ResponseAnswer> {
    let vibrations = linear.modal.vibrations();
    let first = vibrations.first().map_or(1.0, |pole| pole.frequency);
    let settling = vibrations.first().map(|pole| SETTLED_TIMES * pole.settling());
    let end = settling.filter(|end| end.is_finite()).unwrap_or(PERIODS / first);
    let share = |k: usize| k as f64 / (POINTS - 1) as f64;
    let frequency = |k: usize| first * REACH.0 * (REACH.1 / REACH.0).powf(share(k));
    let frequencies: Vec<f64> = (0..POINTS).map(frequency).collect();
    let times: Vec<f64> = (0..POINTS).map(|k| end * share(k)).collect();
    let of_frequency = |f: &f64| linear.modal.response(Complex::new(0.0, TAU * f));
    let response: Vec<_> = frequencies.iter().map(of_frequency).collect();
    let steps: Vec<_> = times.iter().map(|time| linear.modal.step(*time)).collect();
    let one = |(output, input): (usize, usize)| ResponseAnswer {
        input: linear.inputs[input].name.clone(),
        output: linear.outputs[output].name.clone(),
        frequency_hz: frequencies.clone(),
        gain: response.iter().map(|all| all[(output, input)].norm()).collect(),
        gain_95: Vec::new(),
        phase_rad: continued(response.iter().map(|all| all[(output, input)].arg())),
        phase_rad_95: Vec::new(),
        time_s: times.clone(),
        step: steps.iter().map(|all| all[(output, input)]).collect(),
        step_95: Vec::new(),
    };
    let inputs = linear.inputs.len();
    (0..linear.outputs.len() * inputs).map(|k| one((k / inputs, k % inputs))).collect()
}

/// Phases without jumps by a turn.
fn continued(phases: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut last = None;
    let unwrapped = phases.map(|phase| {
        let phase = last.map_or(phase, |last: f64| phase - TAU * ((phase - last) / TAU).round());
        last = Some(phase);
        phase
    });
    unwrapped.collect()
}

//! The amplitude spectrum of a swing, with its damped frequency and those of modes.

use std::f64::consts::TAU;

use efam_experiments::analysis::spectrum::Spectrum;
use models::digits::significant;

use crate::picture::panel::{Axis, Drawn, Key, Panel, Stroke};
use crate::picture::{Area, BLACK, BLUE, MILLI, VERMILION};

/// Frequencies drawn, in damped frequencies.
const REACH: f64 = 3.5;

/// One panel; the damped frequency, and natural ones of modes from the lowest on, in Hz.
pub fn spectrum(area: &Area, title: &str, of: &Spectrum, damped: f64, modes: &[f64]) -> Drawn {
    let reach = REACH * damped.max(modes.first().copied().unwrap_or(0.0));
    let step = of.frequency_step / TAU;
    let line = || {
        let bins = of.amplitude.iter().enumerate();
        bins.map(|(k, amplitude)| (step * k as f64, MILLI * amplitude)).take_while(|bin| bin.0 <= reach)
    };
    let (curve, at_peak) = (Stroke::new(BLUE, 1.8), Stroke::dashed(VERMILION, 2.8, 2.0, 2.0));
    let of_mode = Stroke::dashed(BLACK, 1.2, 6.0, 4.0);
    let mut keys = vec![Key::line(curve, "amplitude"), Key::line(at_peak, format!("damped {damped:.3} Hz"))];
    if !modes.is_empty() {
        let hertz: Vec<String> = modes.iter().map(|mode| significant(*mode, 3)).collect();
        keys.push(Key::line(of_mode, format!("modes {} Hz", hertz.join(", "))));
    }
    let y = 0.0..1.08 * line().map(|bin| bin.1).fold(f64::MIN_POSITIVE, f64::max);
    let (low, high) = (y.start, y.end);
    let mut panel =
        Panel::new(area, title, &Axis(0.0..reach, "frequency, Hz"), &Axis(y, "amplitude, mm"), &keys)?;
    panel.line([(damped, low), (damped, high)].into_iter(), &at_peak)?;
    for mode in modes.iter().filter(|mode| **mode <= reach) {
        panel.line([(*mode, low), (*mode, high)].into_iter(), &of_mode)?;
    }
    panel.line(line(), &curve)
}

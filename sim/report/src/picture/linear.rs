//! Responses of a linear model: what a Bode plot shows, and steps.

use crate::linear::{LinearAnswer, ResponseAnswer, SignalAnswer, gain_unit};
use crate::picture::Picture;
use crate::picture::drawing::drawn;
use crate::picture::lines::{Band, Lines, Named};
use crate::picture::panel::{heading, px};

/// A picture for each input, with a line for each output.
pub fn linear_pictures(answer: &LinearAnswer) -> Vec<Picture> {
    (0..answer.inputs.len()).map(|input| of_input(answer, input)).collect()
}

/// What is drawn over x, with its intervals.
type Drawn<'a> = (&'a [f64], &'a [f64], &'a [[f64; 2]]);

fn of_input(answer: &LinearAnswer, input: usize) -> Picture {
    let own = &answer.inputs[input];
    let responses =
        || answer.outputs.iter().zip(answer.responses.iter().skip(input).step_by(answer.inputs.len()));
    type At<'a> = &'a dyn Fn(f64, f64) -> f64;
    let panel = |has_unit: bool, of: fn(&ResponseAnswer) -> Drawn<'_>, x: &dyn Fn(f64) -> f64, y: At| {
        let one = |(signal, response): (&SignalAnswer, &ResponseAnswer)| -> (Named, Band) {
            let (factor, unit) = gain_unit(signal, own);
            let unit = if has_unit { format!(", {unit}") } else { String::new() };
            let (places, values, ends) = of(response);
            let line = places.iter().zip(values).map(|(place, value)| (x(*place), y(factor, *value)));
            let band =
                places.iter().zip(ends).map(|(place, ends)| (x(*place), ends.map(|end| y(factor, end))));
            ((format!("{}{unit}", signal.name), line.collect()), band.collect())
        };
        responses().map(one).unzip::<_, _, Vec<_>, Vec<_>>()
    };
    let (gains, of_gains) =
        panel(true, |own| (&own.frequency_hz, &own.gain, &own.gain_95), &f64::log10, &|by, x| {
            (by * x).log10()
        });
    let (phases, of_phases) =
        panel(false, |own| (&own.frequency_hz, &own.phase_rad, &own.phase_rad_95), &f64::log10, &|_, x| {
            x.to_degrees()
        });
    let (jumps, of_jumps) =
        panel(true, |own| (&own.time_s, &own.step, &own.step_95), &|time| time, &|by, x| by * x);
    let drawing = drawn((1200, 840), |page| {
        heading(page, &format!("Responses to {}", own.name))?;
        let panels = page.below(px(34.0)).split_evenly((2, 2));
        let panel = |title, x, y| Lines { title, x, y, marks: false, from_zero: false, why: "no outputs" };
        let frequency = "log10 of frequency, Hz";
        panel("Gain", frequency, "log10 of gain").draw_in(&panels[0], &gains, &of_gains)?;
        panel("Step response", "time, s", "output by input").draw_in(&panels[1], &jumps, &of_jumps)?;
        panel("Phase", frequency, "phase, deg").draw_in(&panels[2], &phases, &of_phases)
    });
    let bands =
        if answer.draws > 0 { " Bands hold 95 % of what the errors of the calibration admit." } else { "" };
    Picture {
        name: format!("linear-{}", input + 1),
        title: format!("Responses to {}", own.name),
        caption: format!(
            "Gain and phase over frequency, and the output after the input has jumped by one unit.{bands}"
        ),
        drawing,
    }
}

//! Cleaned and analysed releases as text for a terminal.

use std::f64::consts::TAU;
use std::io::{self, Write};

use efam_experiments::analyse::Analysed;
use efam_experiments::analysis::AnalysisError;
use efam_experiments::analysis::bending_stiffness::StiffnessFit;
use efam_experiments::analysis::decay::Cycle;
use efam_experiments::analysis::measured::{COUNTED_LATER, Measured};
use efam_experiments::cleaning::{BasePose, Cleaned, mm};
use efam_experiments::out_of_plane;
use models::digits::{fixed, with_error};
use models::quantity::format_si;

use crate::aligned::{Aligned, Side};

/// A line for each release.
/// # Errors
/// As it is written.
pub fn table(out: &mut impl Write, cleaned: &Cleaned) -> io::Result<()> {
    let heads =
        ["pressure", "instant s", "hold deg", "drop mm", "samples", "masked %", "out mm (%)", "noise mm"]
            .map(|head| (head, Side::Number));
    let mut table = Aligned::new(&[&[("release", Side::Words)], &heads[..], &[("", Side::Name)]].concat());
    for of in &cleaned.releases {
        let s = &of.statistics;
        let pressure = of.release.pressure.map_or("-".to_owned(), |p| format_si(p, "Pa"));
        let instant = with_error(of.instant, of.release.release_uncertainty);
        let out_of_plane = format!("{:.2} ({:.1})", 1e3 * s.out_of_plane, 1e2 * s.out_of_plane_share);
        let kept = match (&of.dropped, of.release.held_out, of.representative) {
            (Some(why), _, _) => format!("dropped: {why}"),
            (None, true, _) => "held out".to_owned(),
            (None, false, true) if cleaned.releases.len() > 1 => "kept, representative".to_owned(),
            (None, false, _) => "kept".to_owned(),
        };
        table.row([
            of.release.name.clone(),
            pressure,
            instant,
            format!("{:.1}", s.hold_angle.to_degrees()),
            s.static_drop.map_or("-".to_owned(), |drop| format!("{:.2}", 1e3 * drop)),
            s.samples.to_string(),
            format!("{:.2}", 1e2 * s.masked_share),
            out_of_plane,
            format!("{:.4}", 1e3 * s.noise),
            kept,
        ]);
    }
    write!(out, "{table}")?;
    let over = out_of_plane::over_pressures(cleaned.used().map(|used| &used.release));
    if let Some(over) = over {
        writeln!(out, "from the vertical plane through the clamp's axis: {}", over.words())?;
    }
    let bases = || cleaned.recordings.iter().filter_map(|recording| recording.base.as_ref());
    let most = |of: fn(&BasePose) -> f64| bases().map(of).reduce(f64::max);
    let place = most(|base| base.deviation.into_iter().fold(0.0, f64::max));
    if let (Some(place), Some(turn)) = (place, most(|base| base.turn_deviation)) {
        let (place, turn) = (mm(place), turn.to_degrees());
        writeln!(out, "standard deviation of the base: {place} along an axis, {turn:.3} deg, at most")?;
    }
    Ok(())
}

/// Every decision with the key that decides otherwise.
/// # Errors
/// As it is written.
pub fn decisions(out: &mut impl Write, cleaned: &Cleaned) -> io::Result<()> {
    for decision in &cleaned.decisions {
        writeln!(out, "{}: {} [{}]", decision.about, decision.what, decision.key)?;
    }
    Ok(())
}

/// What is said of an analysed release.
/// # Errors
/// As it is written.
pub fn analysed_table(out: &mut impl Write, one: &Analysed) -> io::Result<()> {
    writeln!(out, "\n{}", one.of.release.name)?;
    let mut facts = Aligned::new(&[("", Side::Name), ("", Side::Words)]).indented(2);
    let mut line = |name: &str, text: String| facts.row([name, &text]);
    if let Some(drop) = one.static_drop().map(|drop| 1e3 * drop) {
        let drop = one.rest.map_or_else(|| fixed(drop, 2), |rest| with_error(drop, 1e3 * rest.error[1]));
        line("static drop", format!("{drop} mm"));
    }
    if let Some(warning) = one.rest_warning() {
        line("  warning", warning);
    }
    match &one.measured {
        Err(error) => line("frequency", error.to_string()),
        Ok(measured) => swing_facts(one, measured, &mut line),
    }
    match &one.in_motion {
        None => {}
        Some(Ok(found)) => line(
            "EI from the frequency",
            format!(
                "{} ({:.2} % for each % of frequency; a swing of this size is {:.2} % slower than the mode)",
                format_si(found.bending_stiffness, "N m^2"),
                found.sensitivity,
                100.0 * (1.0 - found.swing_over_mode)
            ),
        ),
        Some(Err(error)) => line("EI from the frequency", error.to_string()),
    }
    if let Some(why) = one.no_beam.as_ref().filter(|_| !one.at_rest.is_empty()) {
        line("Euler-Bernoulli", why.clone());
    }
    write!(out, "{facts}")?;
    stiffness_table(out, one)
}

/// Frequency, damping, and the samples that show them.
fn swing_facts(one: &Analysed, measured: &Measured, line: &mut dyn FnMut(&str, String)) {
    match &measured.damped_frequency {
        Ok(omega) => {
            let error = measured
                .frequency_error()
                .map_or(String::new(), |error| format!(", cycles agree to {} %", fixed(1e2 * error, 2)));
            line("coordinate", measured.coordinate.name());
            line("damped frequency", format!("{:.3} Hz by the spectrum{error}", omega / TAU));
        }
        Err(why) => line("damped frequency", why.clone()),
    }
    if let Ok(decay) = &measured.decay {
        let (natural, ratio) = (decay.natural_frequency / TAU, decay.damping_ratio);
        let count = measured.peaks.len();
        line("natural frequency", format!("{natural:.3} Hz by eq. 7"));
        let residual = 1e3 * decay.rms_residual;
        line(
            "damping ratio",
            format!(
                "{} by eq. 6 on {count} upper peaks, which leave {} mm rms",
                with_error(ratio, decay.ratio_error),
                fixed(residual, 3)
            ),
        );
    }
    if let Some(warning) = one.few_samples() {
        line("  warning", warning);
    }
    if let Ok([first, .., last]) = measured.cycles.as_deref() {
        let at = |cycle: &Cycle| {
            let ratio = with_error(cycle.damping_ratio, cycle.ratio_error);
            format!("{ratio} at {} mm", fixed(1e3 * cycle.amplitude, 2))
        };
        line("  cycle by cycle", format!("{} to {}", at(first), at(last)));
    }
    if measured.since > 0.0 {
        line("  counted from", format!("{:.2} s on: {COUNTED_LATER}", measured.since));
    }
    let bridged = &measured.bridged;
    if bridged.filled > 0 {
        let longest = 1e3 * bridged.longest;
        line(
            "bridged",
            format!(
                "{} samples, gaps of up to {longest:.0} ms, for the spectrum and peaks only",
                bridged.filled
            ),
        );
    }
    if let Some(at) = bridged.cut_at {
        line("left out", format!("all after {at:.2} s, where a gap is too long to be bridged"));
    }
}

/// Bending stiffness from the tip at rest, by each model and search.
fn stiffness_table(out: &mut impl Write, one: &Analysed) -> io::Result<()> {
    if one.at_rest.is_empty() {
        return Ok(());
    }
    let heads =
        ["Nelder-Mead", "Gauss-Newton", "± %", "off mm", "evaluations"].map(|head| (head, Side::Number));
    let mut table =
        Aligned::new(&[&[("EI from the tip, N m^2", Side::Name)], &heads[..]].concat()).indented(2);
    let (mut wrong, mut unmodified) = (Vec::new(), None);
    let ei = |fit: &Result<StiffnessFit, AnalysisError>| {
        fit.as_ref().map_or("-".to_owned(), |fit| format_si(fit.bending_stiffness, ""))
    };
    for row in &one.at_rest {
        let name = row.nodes.map_or("  Euler-Bernoulli".to_owned(), |nodes| format!("  PDER, {nodes} nodes"));
        let fits = (&row.nelder_mead, &row.gauss_newton);
        let off = fits
            .1
            .as_ref()
            .or(fits.0.as_ref())
            .map_or("-".to_owned(), |fit| fixed(1e3 * fit.residual[0].hypot(fit.residual[1]), 2));
        let count = |fit: &Result<StiffnessFit, AnalysisError>| {
            fit.as_ref().map_or("-".to_owned(), |fit| fit.evaluations.to_string())
        };
        let counts = format!("{} / {}", count(fits.0), count(fits.1));
        let error = one.rest.and_then(|rest| row.relative_error(rest.error));
        let error = error.map_or("-".to_owned(), |error| fixed(100.0 * error, 2));
        if let (Err(error), Err(_)) = fits {
            wrong.push(format!("{}: {error}", name.trim()));
        }
        unmodified = unmodified.or(row.unmodified);
        table.row([name, ei(fits.0), ei(fits.1), error, off, counts]);
    }
    write!(out, "{table}")?;
    if let Some(warning) = one.no_rest() {
        writeln!(out, "    warning: {warning}")?;
    }
    if let Some([_, z]) = unmodified {
        let text = "without the walk along its curve (unmodified in the paper)";
        let measured = 1e3 * one.tip_at_rest()[1];
        writeln!(out, "    that beam's tip {text}: z {:.1} mm, measured {measured:.1} mm", 1e3 * z)?;
    }
    wrong.iter().try_for_each(|line| writeln!(out, "    {line}"))
}

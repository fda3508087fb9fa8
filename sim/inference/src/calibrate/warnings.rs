//! What should be known before the numbers of a calibration are used.

use efam_core::left_out;

use super::PartFit;
use super::calibration::{Calibrated, ReleaseFit};
use super::problem::{Problem, Trial};
use super::unknowns::{CLAMP_ANGLE, HOLD_ANGLE, RELEASE_INSTANT};
use crate::normal::CLEAR;

/// Distance of a fit from its recording over the motion, from which on the setup is doubted before the model: what a
/// diagnosis calls missing the first swings.
const OF_MOTION: f64 = 0.2;
/// What is to be checked then, in the order of how often it is wrong.
pub(crate) const SETUP: &str =
    "first check up, unit, angle (or start) and clamp of its [[recording]], and base_angle";
/// Variance over that of the stated noise from which on something is missing.
const MISFIT: f64 = 1.5;
/// Share of samples held back that is more than chance and a few ghosts.
const HELD_BACK: f64 = 0.04;
/// Share of the noise that the errors of mesh and step may have.
const NUMERICS: f64 = 0.1;

pub(super) fn of_search(fit: &PartFit) -> Option<String> {
    let names: Vec<_> = fit.objective.part.members.iter().map(|trial| trial.release.name.as_str()).collect();
    (!fit.found.converged).then(|| {
        format!(
            "the search for {} did not converge in {} evaluations, and another step would still lower the cost by {:.2e}; check whether the model can follow these releases",
            names.join(", "),
            fit.effort[0],
            fit.found.predicted
        )
    })
}

pub(super) fn of_release(fit: &ReleaseFit) -> Vec<String> {
    let mut words = Vec::new();
    let name = &fit.name;
    let share = 1e-3 * fit.misfit.distance_mm / fit.excursion_m;
    if share > OF_MOTION {
        words.push(format!(
            "{name}: the fit is {:.1} mm from the recording, {:.0} % of its motion: {SETUP}",
            fit.misfit.distance_mm,
            1e2 * share
        ));
    }
    for track in &fit.tracks {
        let marker = &track.marker;
        if track.reduced_chi_squared > MISFIT {
            words.push(format!(
                "{name}, {marker}: residuals of {:.3} mm where the noise is {:.3} mm, autocorrelation {:.2}: the model lacks something that the recording shows (`efam diagnose` looks for it), or the noise is understated; the intervals are widened for it, but not for a wrong model",
                track.noise_mm, track.stated_noise_mm, track.autocorrelation
            ));
        }
        if track.held_back as f64 > HELD_BACK * track.samples as f64 {
            words.push(format!(
                "{name}, {marker}: {} of {} samples are outliers and are held back; look at the residuals",
                track.held_back, track.samples
            ));
        }
    }
    let noise = fit.tracks.iter().map(|track| track.noise_mm).fold(f64::INFINITY, f64::min);
    let left = fit.numerical_error_left_mm;
    if left > NUMERICS * noise {
        let finer = (left / (NUMERICS * noise)).sqrt();
        words.push(format!(
            "{name}: mesh and step errors may be {left:.3} mm, more than a tenth of the noise ({noise:.3} mm); take {finer:.1} times as many nodes (rod.nodes)"
        ));
    }
    words
}

/// What the model of the heaviest payload leaves out, which what is fitted takes up.
pub(super) fn of_left_out(problem: &Problem) -> Vec<String> {
    let payload = |trial: &Trial| trial.model.value_or_zero("effects.payload.mass");
    let heaviest = problem.trials().max_by(|a, b| payload(a).total_cmp(&payload(b)));
    heaviest.map_or_else(Vec::new, |own| left_out::warnings(&own.model, own.release.pressure.is_some(), 1))
}

/// Estimates far from their priors, the farthest first.
pub(super) fn of_beliefs<'a>(all: impl Iterator<Item = &'a Calibrated>) -> Vec<String> {
    let off = |own: &Calibrated| own.prior.map(|prior| ((own.value - prior.mean) / prior.deviation).abs());
    let mut contradicted: Vec<(f64, &Calibrated)> =
        all.filter_map(|own| Some((off(own)?, own))).filter(|(off, _)| *off > CLEAR).collect();
    contradicted.sort_by(|a, b| b.0.total_cmp(&a.0));
    let words = |(off, own): (f64, &Calibrated)| {
        format!(
            "{} is estimated at {}, {off:.1} times its admitted deviation; check its stated value and the recording, or admit more with {}",
            own.label(),
            models::quantity::format_si(own.value, &own.unit),
            key(&own.name),
        )
    };
    contradicted.into_iter().map(words).collect()
}

/// The key that says how far a value may be off.
fn key(name: &str) -> &'static str {
    match name {
        HOLD_ANGLE => "hold_angle in [calibrate]",
        CLAMP_ANGLE => "clamp_angle in [calibrate]",
        RELEASE_INSTANT => "instant_error in [[recording]]",
        name if name.starts_with("offset of") => "offset in [calibrate]",
        _ => "a wider prior in its [[calibrate.parameter]]",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::misfit::{FrequencyAndDamping, Misfit};

    /// Of a motion of 100 mm, 20 mm are a fifth.
    #[test]
    fn a_fit_that_misses_the_motion_asks_for_the_setup_first() {
        let warnings = |distance_mm: f64| {
            of_release(&ReleaseFit {
                name: "made-up".to_owned(),
                pressure_pa: None,
                payload_kg: 0.0,
                excursion_m: 0.1,
                held_out: false,
                duration_s: 8.0,
                measured: FrequencyAndDamping::default(),
                fitted: FrequencyAndDamping::default(),
                tracks: Vec::new(),
                misfit: Misfit { distance_mm, ..Default::default() },
                numerical_error_mm: 0.0,
                numerical_error_left_mm: 0.0,
            })
        };
        assert_eq!(warnings(19.0), Vec::<String>::new());
        assert!(warnings(21.0)[0].contains("21 % of its motion: first check up, unit, angle"));
    }
}

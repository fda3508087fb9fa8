//! Bending stiffness from the frequency of a swing: the EI with which the model swings as fast as the recording, at the
//! amplitude of the recording.
//!
//! A large swing is slower than a small one: at 40 psi by 1 %. Where gravity holds the muscle as well, EI moves by
//! 11 % for each per cent of frequency there, so a linear mode against a large swing is 12 % off. So the model is let
//! go, too, with the decay of the recording; both frequencies are found in the same way, and their ratio is that of the
//! linear modes:
//!
//! ```text
//! ω₁(EI) = ω_measured ω₁ / ω_swing,    ω₁ the slowest mode, ω_swing the model's own swing
//! ```
//!
//! Where the model is let go from another height, the difference of ω_swing and ω₁ is scaled by the square of the
//! amplitudes. This is the EI of motion: a muscle that is stiffer in motion than at rest shows here.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use efam_core::forward::{FAST_TOLERANCE, Run, forward};
use efam_core::quantile::usual_step;
use efam_core::rest::rest;
use models::model::Model;
use models::statics::{equilibrium, modes};

use super::AnalysisError;
use super::coordinate::Coordinate;
use super::measured::{self, Measured};
use crate::release::{Point, Release, Track};
use crate::scenario::Case;

/// A factor by which EI may differ from the model's own, either way.
const REACH: f64 = 1e3;
/// Change of the logarithm of EI that counts as none.
const SETTLED: f64 = 1e-10;
/// Runs of the model at most; each leaves a tenth of the error before, or less.
const MOST_RUNS: usize = 8;
/// Change of EI between runs, as a share, at which they end: below what a spectrum of noisy data resolves.
const SAME: f64 = 1e-4;
/// Difference of the decay, as a share, that moves EI by no more than that: a ratio that is a tenth off moves the
/// frequency of the swing by some 1e-4.
const SAME_RATIO: f64 = 0.01;

/// EI from a frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicStiffness {
    /// EI, N m².
    pub bending_stiffness: f64,
    /// Relative change of EI for one of frequency, from the model: 2 where bending alone drives it,
    /// more where gravity helps.
    pub sensitivity: f64,
    /// Frequency of the model's swing, as large as the recording's, over that of its slowest mode; 1 if the swing could not
    /// be simulated, and EI is that of the linear mode.
    pub swing_over_mode: f64,
    /// Eigenvalue problems that were solved.
    pub evaluations: usize,
}

/// What a swing is compared by.
struct Swing {
    /// Damped angular frequency, rad/s.
    frequency: f64,
    /// Damping ratio by eq. 6.
    ratio: f64,
    /// Amplitude of eq. 6 at the release, m.
    amplitude: f64,
    /// Along which it is seen.
    coordinate: Coordinate,
}

impl Swing {
    fn of(measured: &Measured) -> Option<Self> {
        let decay = measured.decay.as_ref().ok()?;
        Some(Self {
            frequency: decay.damped_frequency,
            ratio: decay.damping_ratio,
            amplitude: decay.initial_amplitude,
            coordinate: measured.coordinate,
        })
    }
}

/// The EI with which the model of a case swings as a release was measured to.
/// # Errors
/// [`AnalysisError::FrequencyOutOfReach`] as [`fit`]; [`AnalysisError::NoOscillation`] without a measured decay.
pub fn fit_swing(
    case: &Case,
    release: &Release,
    measured: &Measured,
) -> Result<DynamicStiffness, AnalysisError> {
    let Some(seen) = Swing::of(measured) else {
        return Err(AnalysisError::NoOscillation { lowest: 0.0 });
    };
    let mut model = case.model.clone();
    model.schedule = None;
    let natural = measured.natural_frequency().unwrap_or(seen.frequency);
    // First the linear mode; then one run after the other, each with what the one before was off by.
    let mut found = fit(&model, natural)?;
    let mut ratio = None;
    for _ in 0..MOST_RUNS {
        model.set("rod.bending_stiffness", found.bending_stiffness).ok();
        let Some((own, mode)) = simulated(&mut model, case, release, &seen, ratio) else { break };
        let size = (seen.amplitude / own.amplitude).powi(2);
        let swing_over_mode = 1.0 + (own.frequency / mode - 1.0) * size;
        let next = fit(&model, seen.frequency / swing_over_mode)?;
        let change = (next.bending_stiffness / found.bending_stiffness).ln();
        let evaluations = found.evaluations + next.evaluations;
        found = DynamicStiffness { swing_over_mode, evaluations, ..next };
        ratio = Some(own.ratio);
        if change.abs() < SAME && (own.ratio / seen.ratio - 1.0).abs() < SAME_RATIO {
            break;
        }
    }
    Ok(found)
}

/// The swing of the model over the times of a release, by the same analysis, and its slowest mode, rad/s. Mass damping
/// is first moved by what the model's decay differed from the measured one: that of the run before, or of the mode.
fn simulated(
    model: &mut Model,
    case: &Case,
    release: &Release,
    seen: &Swing,
    ratio: Option<f64>,
) -> Option<(Swing, f64)> {
    let at_rest = rest(model, 0.0, 1).ok()?;
    let (hertz, of_mode) = *at_rest.modes.as_ref().ok()?.first()?;
    let alpha = model.index("effects.rayleigh_mass.alpha").ok()?;
    let missing = seen.ratio - ratio.unwrap_or(of_mode);
    model.theta[alpha] = (model.theta[alpha] + 2.0 * seen.frequency * missing).max(0.0);
    let run = Run {
        initial: case.run.initial.clone(),
        tolerance: FAST_TOLERANCE,
        ..Run::release(*release.time.last()?, usual_step(&release.time)?.recip())
    };
    let trajectory = forward(model, &run, &mut |_| ControlFlow::Continue(())).ok()?;
    let track = Track {
        marker: String::new(),
        at: Point::Tip,
        position: trajectory.tip.iter().map(|at| Some(*at)).collect(),
        noise: 0.0,
        discrepancy: 0.0,
    };
    let simulated = Release { time: trajectory.times, tracks: vec![track], ..release.clone() };
    let own = measured::analyse_along(&simulated, at_rest.tip, seen.coordinate).ok()?;
    Some((Swing::of(&own)?, TAU * hertz))
}

/// Finds the EI with which the slowest mode has a natural angular frequency, rad/s.
/// # Errors
/// [`AnalysisError::FrequencyOutOfReach`] if no EI within a thousandth and a thousandfold of the model's
/// gives it.
pub fn fit(model: &Model, natural_frequency: f64) -> Result<DynamicStiffness, AnalysisError> {
    let mut model = model.clone();
    model.schedule = None;
    let Ok(index) = model.index("rod.bending_stiffness") else {
        unreachable!("every rod has a bending stiffness");
    };
    let start = model.theta[index];
    let mut evaluations = 0;
    let mut slowest = |logarithm: f64| -> Option<f64> {
        evaluations += 1;
        model.theta[index] = start * logarithm.exp();
        let rest = equilibrium(&model, None).ok()?;
        modes(&model, &rest, 1).ok()?.first().map(|mode| mode.angular_frequency)
    };
    let reach = REACH.ln();
    let out_of_reach =
        AnalysisError::FrequencyOutOfReach { natural_frequency, bending_stiffness: start, reach: REACH };
    let here = slowest(0.0).ok_or(out_of_reach.clone())?;
    // Outwards by factors of two, which bending alone would make ones of √2 in frequency.
    let outwards = if here < natural_frequency { 1.0 } else { -1.0 };
    let (mut near, mut far) = ((0.0, here), None);
    let mut at = 0.0;
    while far.is_none() {
        at += outwards * std::f64::consts::LN_2;
        if at.abs() > reach {
            return Err(out_of_reach);
        }
        // Where a rod so limp has no rest that is found, its frequency is below all.
        let omega = slowest(at).unwrap_or(0.0);
        if (omega - natural_frequency) * outwards >= 0.0 {
            far = Some((at, omega))
        } else {
            near = (at, omega)
        }
    }
    let mut far = far.unwrap_or(near);
    for _ in 0..100 {
        let middle = 0.5 * (near.0 + far.0);
        let omega = slowest(middle).unwrap_or(0.0);
        if (omega - natural_frequency) * outwards >= 0.0 {
            far = (middle, omega)
        } else {
            near = (middle, omega)
        }
        if (far.0 - near.0).abs() < SETTLED {
            break;
        }
    }
    let found = 0.5 * (near.0 + far.0);
    const STEP: f64 = 1e-3;
    let (less, more) = (slowest(found - STEP), slowest(found + STEP));
    let sensitivity = match (less, more) {
        (Some(less), Some(more)) if more > less => 2.0 * STEP / (more / less).ln(),
        _ => 2.0,
    };
    let bending_stiffness = start * found.exp();
    Ok(DynamicStiffness { bending_stiffness, sensitivity, swing_over_mode: 1.0, evaluations })
}

#[cfg(test)]
mod tests {
    use efam_core::example::muscle_at_15_psi;

    use super::*;

    #[test]
    fn the_stiffness_of_a_model_is_found_from_its_own_frequency() {
        let model = muscle_at_15_psi();
        let rest = equilibrium(&model, None).unwrap();
        let omega = modes(&model, &rest, 1).unwrap()[0].angular_frequency;
        for factor in [0.2, 1.0, 7.0] {
            let mut start = model.clone();
            start.set("rod.bending_stiffness", 0.00709 * factor).unwrap();
            let found = fit(&start, omega).unwrap();
            assert!((found.bending_stiffness / 0.00709 - 1.0).abs() < 1e-6, "{found:?} from {factor}");
            assert!(found.sensitivity > 2.0, "gravity holds a hanging rod as well: {found:?}");
        }
    }

    /// A weightless cantilever without end body: `ω = 1.8751² √(EI / (m L³))`.
    #[test]
    fn a_level_beam_has_the_closed_form() {
        let mut model = muscle_at_15_psi();
        for (path, value) in [
            ("effects.gravity.acceleration", 0.0),
            ("effects.end_fitting.mass", 0.0),
            ("effects.end_fitting.rotary_inertia", 0.0),
        ] {
            model.set(path, value).unwrap();
        }
        let (length, mass) = (0.20295f64, 0.02418);
        let omega = 1.875_104_f64.powi(2) * (0.01 / (mass * length.powi(3))).sqrt();
        let found = fit(&model, omega).unwrap();
        // 31 edges: second order in the edge length; some 1e-3 of the frequency.
        assert!((found.bending_stiffness / 0.01 - 1.0).abs() < 5e-3, "{found:?}");
        assert!((found.sensitivity - 2.0).abs() < 1e-4, "{found:?}");
    }

    #[test]
    fn a_frequency_that_no_stiffness_gives_is_refused() {
        let error = fit(&muscle_at_15_psi(), 1e-3).unwrap_err();
        assert!(matches!(error, AnalysisError::FrequencyOutOfReach { .. }), "{error}");
    }
}

//! Bending stiffness from the natural frequency: the EI with which the slowest mode of the model about
//! its own rest has that frequency.
//!
//! It holds for small swings and for the model as it is, with its distributed mass, its end fitting and
//! gravity. The EI of motion: a muscle that is stiffer in motion than at rest shows here.

use models::model::Model;
use models::statics::{equilibrium, modes};

use super::AnalysisError;

/// A factor by which EI may differ from the model's own, either way.
const REACH: f64 = 1e3;
/// Change of the logarithm of EI that counts as none.
const SETTLED: f64 = 1e-10;

/// EI from a frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicStiffness {
    /// EI, N m².
    pub bending_stiffness: f64,
    /// Relative change of EI for one of frequency, from the model: 2 where bending alone drives it,
    /// more where gravity helps.
    pub sensitivity: f64,
    /// Eigenvalue problems that were solved.
    pub evaluations: usize,
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
        match (omega - natural_frequency) * outwards >= 0.0 {
            true => far = Some((at, omega)),
            false => near = (at, omega),
        }
    }
    let mut far = far.unwrap_or(near);
    for _ in 0..100 {
        let middle = 0.5 * (near.0 + far.0);
        let omega = slowest(middle).unwrap_or(0.0);
        match (omega - natural_frequency) * outwards >= 0.0 {
            true => far = (middle, omega),
            false => near = (middle, omega),
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
    Ok(DynamicStiffness { bending_stiffness: start * found.exp(), sensitivity, evaluations })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::tests::muscle_at_15_psi;

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

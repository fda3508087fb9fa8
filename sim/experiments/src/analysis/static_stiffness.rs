//! Bending stiffness from the tip at rest by several models side by side: the paper's beam, and the
//! discrete rod with several numbers of nodes; each by the paper's simplex search and by Gauss-Newton.

use models::model::Model;
use models::statics::equilibrium;
use models::statics::euler_bernoulli::EulerBernoulli;
use models::system::System;

use super::AnalysisError;
use super::bending_stiffness::{StiffnessFit, fit, fit_gauss_newton};

/// Node counts of the paper.
pub const NODES: [usize; 5] = [4, 8, 16, 32, 40];

/// One model's answer.
#[derive(Clone, Debug, PartialEq)]
pub struct StaticFit {
    /// Nodes of the discrete rod; none for the Euler-Bernoulli beam.
    pub nodes: Option<usize>,
    /// By Nelder and Mead.
    pub nelder_mead: Result<StiffnessFit, AnalysisError>,
    /// By Gauss and Newton.
    pub gauss_newton: Result<StiffnessFit, AnalysisError>,
    /// Change of the predicted tip for one of the logarithm of EI, m.
    pub slope: Option<[f64; 2]>,
    /// Tip of the Euler-Bernoulli beam with this EI as its equations have it, without the walk along the curve, m: the
    /// paper's unmodified tip. None for the discrete rod.
    pub unmodified: Option<[f64; 2]>,
}

impl StaticFit {
    /// Standard error of EI over its value, from that of each coordinate of the tip, m.
    pub fn relative_error(&self, tip: [f64; 2]) -> Option<f64> {
        let [x, z] = self.slope?;
        Some((x * tip[0]).hypot(z * tip[1]) / (x * x + z * z))
    }
}

/// Angle of a base below which it counts as level, rad: what a laboratory levels to.
const LEVEL: f64 = 1e-3;

/// Why the paper's beam is not fitted to a rod: it is clamped level.
pub fn no_beam(model: &Model) -> Option<String> {
    let angle = model.value_or_zero("rod.base_angle");
    (angle.abs() > LEVEL).then(|| {
        format!(
            "not fitted: the paper's beam is clamped level, this base is inclined by {:.1} deg",
            angle.to_degrees()
        )
    })
}

/// Fits all models to a tip at rest, in W, m; `models` are of the same rod with several meshes.
///
/// The root and the mass are those of the models: an EI belongs to both. The paper's beam is among them where the
/// base is level, see [`no_beam`].
pub fn compare(tip: [f64; 2], models: &[Model]) -> Vec<StaticFit> {
    let beam = models.first().filter(|model| no_beam(model).is_none()).map(|model| {
        let beam = beam(model);
        let reach = model.tip_distance;
        let predict = |bending_stiffness: f64| {
            let end = EulerBernoulli { bending_stiffness, ..beam }.end();
            let [x, z] = end.position;
            Some([x + reach * end.angle.cos(), z + reach * end.angle.sin()])
        };
        let fit = both(None, tip, beam.bending_stiffness, predict);
        let found = fit.gauss_newton.as_ref().or(fit.nelder_mead.as_ref()).ok();
        let own =
            |found: &StiffnessFit| EulerBernoulli { bending_stiffness: found.bending_stiffness, ..beam };
        let unmodified = found.map(|found| own(found).unmodified(reach));
        StaticFit { unmodified, ..fit }
    });
    let rods = models.iter().map(|model| {
        let start = model.rod().bending_stiffness;
        both(Some(model.edges + 1), tip, start, |bending_stiffness| rest_tip(model, bending_stiffness))
    });
    beam.into_iter().chain(rods).collect()
}

fn both(
    nodes: Option<usize>,
    tip: [f64; 2],
    start: f64,
    predict: impl Fn(f64) -> Option<[f64; 2]>,
) -> StaticFit {
    let nelder_mead = fit(tip, start, &predict);
    let gauss_newton = fit_gauss_newton(tip, start, &predict);
    let found = gauss_newton.as_ref().or(nelder_mead.as_ref()).ok();
    let slope = found.and_then(|found| {
        let [less, more] = [-STEP, STEP].map(|step| predict(found.bending_stiffness * step.exp()));
        let (less, more) = (less?, more?);
        Some([0, 1].map(|k| (more[k] - less[k]) / (2.0 * STEP)))
    });
    StaticFit { nodes, nelder_mead, gauss_newton, slope, unmodified: None }
}

/// Step of the differences in the logarithm of EI.
const STEP: f64 = 1e-3;

/// The rod as the paper's beam, with the rod's own bending stiffness; end fitting and payload are one weight at their common centre of mass.
pub fn beam(model: &Model) -> EulerBernoulli {
    let gravity = model.value_or_zero("effects.gravity.acceleration");
    let bodies = ["end_fitting", "payload"].map(|name| {
        (
            model.value_or_zero(&format!("effects.{name}.mass")),
            model.value_or_zero(&format!("effects.{name}.center_of_mass")),
        )
    });
    let mass: f64 = bodies.iter().map(|(mass, _)| mass).sum();
    let moment: f64 = bodies.iter().map(|(mass, at)| mass * at).sum();
    let rod = model.rod();
    EulerBernoulli {
        bending_stiffness: rod.bending_stiffness,
        length: rod.length,
        weight_per_length: rod.mass * gravity / rod.length,
        tip_weight: mass * gravity,
        tip_offset: if mass > 0.0 { moment / mass } else { 0.0 },
    }
}

fn rest_tip(model: &Model, bending_stiffness: f64) -> Option<[f64; 2]> {
    let mut model = model.clone();
    model.schedule = None;
    model.set("rod.bending_stiffness", bending_stiffness).ok()?;
    let rest = equilibrium(&model, None).ok()?;
    let mut system = System::new(&model);
    let at_rest = vec![0.0; rest.q.len()];
    system.assembly.posture(&rest.q, &at_rest);
    Some(system.observed_tip(&rest.q, &at_rest).0)
}

#[cfg(test)]
mod tests {
    use efam_core::example::muscle_at_15_psi;

    use super::*;

    /// The mesh that made the tip finds its own EI; the beam, which is linear, another.
    #[test]
    fn a_rod_is_recovered_by_both_searches_and_the_beam_is_not_the_rod() {
        let model = muscle_at_15_psi();
        let tip = rest_tip(&model, 0.00709).unwrap();
        let fits = compare(tip, &[model]);
        assert_eq!(fits.iter().map(|fit| fit.nodes).collect::<Vec<_>>(), [None, Some(32)]);
        for found in [&fits[1].nelder_mead, &fits[1].gauss_newton] {
            let found = found.as_ref().unwrap();
            // The simplex settles to 1e-6.
            assert!((found.bending_stiffness / 0.00709 - 1.0).abs() < 3e-6, "{found:?}");
        }
        let beam = fits[0].gauss_newton.as_ref().unwrap().bending_stiffness;
        assert!((beam / 0.00709 - 1.0).abs() > 0.02 && (beam / 0.00709 - 1.0).abs() < 0.5, "{beam}");
    }
}

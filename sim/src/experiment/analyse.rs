//! The paper's analysis of every release, and what a model says of it: EI from the tip at rest and from
//! the frequency.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::{Experiment, ExperimentError};
use crate::analysis::dynamic_stiffness::{self, DynamicStiffness};
use crate::analysis::measured::{self, Measured};
use crate::analysis::static_stiffness::{self, StaticFit};
use crate::analysis::{AnalysisError, bending_stiffness::StiffnessFit};
use crate::cleaning::{CleanRelease, Cleaned};

/// What is said of one release.
#[derive(Clone, Debug)]
pub struct Analysed<'a> {
    /// The release.
    pub of: &'a CleanRelease,
    /// By itself.
    pub measured: Result<Measured, AnalysisError>,
    /// EI from the tip at rest; nothing without a model.
    pub at_rest: Vec<StaticFit>,
    /// EI from the frequency; nothing without a model or a frequency.
    pub in_motion: Option<Result<DynamicStiffness, AnalysisError>>,
}

/// Analyses all releases that are used; `nodes` are those of the static fits.
/// # Errors
/// [`ExperimentError`] for a model that cannot be.
pub fn analyse<'a>(
    experiment: &Experiment,
    cleaned: &'a Cleaned,
    nodes: &[usize],
) -> Result<Vec<Analysed<'a>>, ExperimentError> {
    cleaned.used().map(|of| one(experiment, of, nodes)).collect()
}

fn one<'a>(
    experiment: &Experiment,
    of: &'a CleanRelease,
    nodes: &[usize],
) -> Result<Analysed<'a>, ExperimentError> {
    let measured = measured::analyse(&of.release, of.statistics.rest);
    let Some(model) = of.model(experiment)? else {
        return Ok(Analysed { of, measured, at_rest: Vec::new(), in_motion: None });
    };
    let mut meshes = Vec::new();
    for count in nodes {
        let case = experiment.case_with(of.recording, of.angle, Some(*count))?;
        meshes.extend(case.map(|case| case.model));
    }
    let at_rest = static_stiffness::compare(of.statistics.rest, &meshes);
    let natural = measured.as_ref().ok().and_then(Measured::natural_frequency);
    let in_motion = natural.map(|natural| dynamic_stiffness::fit(&model, natural));
    Ok(Analysed { of, measured, at_rest, in_motion })
}

impl Analysed<'_> {
    /// As one JSON object.
    pub fn json(&self) -> Value {
        let mut value =
            json!({ "name": self.of.release.name, "static_drop_m": self.of.statistics.static_drop });
        match &self.measured {
            Err(error) => value["why_not"] = error.to_string().into(),
            Ok(measured) => {
                let hertz = |omega: f64| omega / TAU;
                let decay = measured.decay.as_ref();
                value["coordinate"] = measured.coordinate.name().into();
                value["damped_frequency_hz"] =
                    json!(measured.damped_frequency.as_ref().ok().map(|w| hertz(*w)));
                value["frequency_error_share"] = json!(measured.frequency_error());
                value["natural_frequency_hz"] = json!(measured.natural_frequency().map(hertz));
                value["damping_ratio"] = json!(decay.ok().map(|decay| decay.damping_ratio));
                value["decay_residual_m"] = json!(decay.ok().map(|decay| decay.rms_residual));
                value["why_no_decay"] = json!(decay.err());
                value["counted_from_s"] = measured.since.into();
                value["bridged_samples"] = measured.bridged.filled.into();
                value["longest_bridge_s"] = measured.bridged.longest.into();
                value["left_out_after_s"] = json!(measured.bridged.cut_at);
                let cycles = measured.cycles.as_deref().unwrap_or_default();
                value["cycles"] = cycles
                    .iter()
                    .map(|cycle| {
                        json!({
                            "time_s": cycle.time, "amplitude_m": cycle.amplitude,
                            "damping_ratio": cycle.damping_ratio,
                            "damped_frequency_hz": hertz(cycle.damped_frequency),
                        })
                    })
                    .collect();
            }
        }
        let fit = |fit: &Result<StiffnessFit, AnalysisError>| match fit {
            Ok(fit) => json!({
                "bending_stiffness_n_m2": fit.bending_stiffness, "residual_m": fit.residual,
                "evaluations": fit.evaluations,
            }),
            Err(error) => json!({ "why_not": error.to_string() }),
        };
        value["static_stiffness"] = (self.at_rest.iter())
            .map(|row| {
                json!({
                    "model": if row.nodes.is_some() { "pder" } else { "euler_bernoulli" }, "nodes": row.nodes,
                    "nelder_mead": fit(&row.nelder_mead), "gauss_newton": fit(&row.gauss_newton),
                })
            })
            .collect();
        value["dynamic_stiffness"] = match &self.in_motion {
            None => Value::Null,
            Some(Ok(found)) => json!({
                "bending_stiffness_n_m2": found.bending_stiffness, "sensitivity": found.sensitivity,
            }),
            Some(Err(error)) => json!({ "why_not": error.to_string() }),
        };
        value
    }
}

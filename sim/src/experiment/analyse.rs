//! The paper's analysis of every release, and what a model says of it: EI from the tip at rest and from
//! the frequency.

use std::f64::consts::TAU;

use serde::Serialize;

use super::{Experiment, ExperimentError};
use crate::analysis::dynamic_stiffness::{self, DynamicStiffness};
use crate::analysis::measured::{self, Measured};
use crate::analysis::static_stiffness::{self, StaticFit};
use crate::analysis::{AnalysisError, bending_stiffness::StiffnessFit};
use crate::cleaning::{CleanRelease, Cleaned};
use crate::results::summary::Cycle;
use crate::schema::JsonSchema;

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

/// What is written of an analysed release; what could not be found is none, and its reason stands beside it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Said<'a> {
    /// Name of the release.
    pub name: &'a str,
    /// How far the tip sinks from hold to rest.
    pub static_drop_m: f64,
    /// Why nothing could be said of the swing.
    pub why_not: Option<String>,
    /// The coordinate that was analysed, x or z.
    pub coordinate: Option<&'static str>,
    /// From the spectrum.
    pub damped_frequency_hz: Option<f64>,
    /// How well the cycles agree about it.
    pub frequency_error_share: Option<f64>,
    /// By eq. 7.
    pub natural_frequency_hz: Option<f64>,
    /// By eq. 6 on the upper peaks.
    pub damping_ratio: Option<f64>,
    /// Root mean square distance of the peaks from that fit.
    pub decay_residual_m: Option<f64>,
    /// Why there is no such fit.
    pub why_no_decay: Option<&'a str>,
    /// Time after the release from which on spectrum and peaks count.
    pub counted_from_s: Option<f64>,
    /// Samples in gaps that were bridged.
    pub bridged_samples: Option<usize>,
    /// The longest of these gaps.
    pub longest_bridge_s: Option<f64>,
    /// Time of a gap that is too long to be bridged: what follows is left out.
    pub left_out_after_s: Option<f64>,
    /// Damping and frequency from each upper peak to the next.
    pub cycles: Vec<Cycle>,
    /// EI from the tip at rest, by model; empty without a model.
    pub static_stiffness: Vec<AtRest>,
    /// EI from the frequency; none without a model or a frequency.
    pub dynamic_stiffness: Option<InMotion>,
}

/// EI from the tip at rest.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct AtRest {
    /// pder or euler_bernoulli.
    pub model: &'static str,
    /// Nodes of the discrete rod.
    pub nodes: Option<usize>,
    /// By Nelder and Mead.
    pub nelder_mead: Stiffness,
    /// By Gauss and Newton.
    pub gauss_newton: Stiffness,
}

/// EI with which a model meets the tip at rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Stiffness {
    /// EI.
    pub bending_stiffness_n_m2: Option<f64>,
    /// Measured tip minus predicted, in W.
    pub residual_m: Option<[f64; 2]>,
    /// Tips that were predicted on the way.
    pub evaluations: Option<usize>,
    /// Why there is none.
    pub why_not: Option<String>,
}

/// EI with which the slowest mode has the measured frequency.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct InMotion {
    /// EI.
    pub bending_stiffness_n_m2: Option<f64>,
    /// Relative change of EI for one of frequency.
    pub sensitivity: Option<f64>,
    /// Why there is none.
    pub why_not: Option<String>,
}

impl Analysed<'_> {
    /// What is written of it.
    pub fn said(&self) -> Said<'_> {
        let (name, static_drop_m) = (self.of.release.name.as_str(), self.of.statistics.static_drop);
        let own = Said {
            name,
            static_drop_m,
            static_stiffness: self.at_rest.iter().map(at_rest).collect(),
            dynamic_stiffness: self.in_motion.as_ref().map(in_motion),
            ..Said::default()
        };
        let measured = match &self.measured {
            Ok(measured) => measured,
            Err(error) => return Said { why_not: Some(error.to_string()), ..own },
        };
        let decay = measured.decay.as_ref();
        Said {
            coordinate: Some(measured.coordinate.name()),
            damped_frequency_hz: measured.damped_frequency.as_ref().ok().map(|omega| omega / TAU),
            frequency_error_share: measured.frequency_error(),
            natural_frequency_hz: measured.natural_frequency().map(|omega| omega / TAU),
            damping_ratio: decay.ok().map(|decay| decay.damping_ratio),
            decay_residual_m: decay.ok().map(|decay| decay.rms_residual),
            why_no_decay: decay.err().map(String::as_str),
            counted_from_s: Some(measured.since),
            bridged_samples: Some(measured.bridged.filled),
            longest_bridge_s: Some(measured.bridged.longest),
            left_out_after_s: measured.bridged.cut_at,
            cycles: measured.cycles.as_deref().unwrap_or_default().iter().map(Cycle::from).collect(),
            ..own
        }
    }
}

fn at_rest(row: &StaticFit) -> AtRest {
    let stiffness = |fit: &Result<StiffnessFit, AnalysisError>| match fit {
        Ok(fit) => Stiffness {
            bending_stiffness_n_m2: Some(fit.bending_stiffness),
            residual_m: Some(fit.residual),
            evaluations: Some(fit.evaluations),
            why_not: None,
        },
        Err(error) => Stiffness { why_not: Some(error.to_string()), ..Stiffness::default() },
    };
    AtRest {
        model: if row.nodes.is_some() { "pder" } else { "euler_bernoulli" },
        nodes: row.nodes,
        nelder_mead: stiffness(&row.nelder_mead),
        gauss_newton: stiffness(&row.gauss_newton),
    }
}

fn in_motion(found: &Result<DynamicStiffness, AnalysisError>) -> InMotion {
    match found {
        Ok(found) => InMotion {
            bending_stiffness_n_m2: Some(found.bending_stiffness),
            sensitivity: Some(found.sensitivity),
            why_not: None,
        },
        Err(error) => InMotion { why_not: Some(error.to_string()), ..InMotion::default() },
    }
}

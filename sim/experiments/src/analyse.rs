//! The paper's analysis of every release, and what a model says of it: EI from the tip at rest and from
//! the frequency.

use std::f64::consts::TAU;

use schemars::JsonSchema;
use serde::Serialize;

use crate::analysis::AnalysisError;
use crate::analysis::bending_stiffness::StiffnessFit;
use crate::analysis::coordinate::Coordinate;
use crate::analysis::dynamic_stiffness::{self, DynamicStiffness};
use crate::analysis::measured::{self, COUNTED_LATER, KnownRest, Measured};
use crate::analysis::rest::{self, RestEstimate};
use crate::analysis::static_stiffness::{self, StaticFit};
use crate::cleaning::{CleanRelease, Cleaned};
use crate::experiment::{Experiment, ExperimentError};
use crate::summary::Cycle;

/// What is said of one release.
#[derive(Clone, Debug)]
pub struct Analysed<'a> {
    /// The release.
    pub of: &'a CleanRelease,
    /// By itself.
    pub measured: Result<Measured, AnalysisError>,
    /// Where the tip comes to rest, by its decay; none without a frequency.
    pub rest: Option<RestEstimate>,
    /// EI from the tip at rest; nothing without a model.
    pub at_rest: Vec<StaticFit>,
    /// Why the Euler-Bernoulli beam is not among them.
    pub no_beam: Option<String>,
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
    let (measured, rest) = measured(of);
    let Some(case) = of.case_at_rest(experiment, of.angle.or(Some(of.statistics.hold_angle)), None)? else {
        return Ok(Analysed { of, measured, rest, at_rest: Vec::new(), no_beam: None, in_motion: None });
    };
    let mut meshes = Vec::new();
    for count in nodes {
        let case = of.case_at_rest(experiment, of.angle, Some(*count))?;
        meshes.extend(case.map(|case| case.model));
    }
    let tip = rest.map_or(of.statistics.rest, |rest| rest.position);
    let at_rest = static_stiffness::compare(tip, &meshes);
    let no_beam = static_stiffness::no_beam(&case.model);
    let has_decay = |measured: &&Measured| measured.decay.is_ok();
    let in_motion = measured.as_ref().ok().filter(has_decay);
    let in_motion = in_motion.map(|measured| dynamic_stiffness::fit_swing(&case, &of.release, measured));
    Ok(Analysed { of, measured, rest, at_rest, no_beam, in_motion })
}

/// Samples of a period below which the parabola through three of them is no measure of an upper peak: with eight, the outer
/// two are 45 degrees from it.
const FEW_SAMPLES: f64 = 8.0;

/// Samples of a period below which a swing of at most twice the frequency looks the same.
const FEWEST_SAMPLES: f64 = 3.0;

/// Share of the tip's distance from the clamp by which a fit may miss its rest: a clamp that leans by six degrees more than
/// stated takes the tip as far.
const FAR_FROM_REST: f64 = 0.1;

/// A release by itself, and its rest. The rest is first the mean of a window, then where the decay leads.
pub fn measured(of: &CleanRelease) -> (Result<Measured, AnalysisError>, Option<RestEstimate>) {
    let first = measured::analyse(&of.release, of.statistics.rest);
    let rest = first.as_ref().ok().and_then(|first| {
        let decay = first.decay.as_ref().ok();
        let frequency = first.damped_frequency.as_ref().ok()?;
        let rate = decay.map_or(0.0, |decay| decay.damping_ratio * decay.natural_frequency);
        let position = &of.release.tracks[0].position;
        rest::estimate(&of.release.time, position, of.swings_until, *frequency, rate)
    });
    match rest {
        Some(found) => {
            let known = KnownRest { position: found.position, error: found.error };
            (measured::analyse(&of.release, known), rest)
        }
        None => (first, None),
    }
}

/// What is written of an analysed release; what could not be found is none, and its reason is beside it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Said<'a> {
    /// Name of the release.
    pub name: &'a str,
    /// How far the tip sinks from hold to rest; none where the recording begins in mid-swing.
    pub static_drop_m: Option<f64>,
    /// Where the tip comes to rest, in W.
    pub rest_m: [f64; 2],
    /// Standard error of each coordinate of the rest; none where it is a mean of the end alone.
    pub rest_error_m: Option<[f64; 2]>,
    /// Amplitude of the swing that is left at the end.
    pub swing_left_m: Option<f64>,
    /// Whether that is below 2 % of the first excursion, so that the recording shows the rest itself.
    pub settled: Option<bool>,
    /// Why nothing could be said of the swing.
    pub why_not: Option<String>,
    /// The coordinate that was analysed.
    pub coordinate: Option<Coordinate>,
    /// From the spectrum.
    pub damped_frequency_hz: Option<f64>,
    /// How well the cycles agree about it.
    pub frequency_error_share: Option<f64>,
    /// By eq. 7.
    pub natural_frequency_hz: Option<f64>,
    /// By eq. 6 on the upper peaks.
    pub damping_ratio: Option<f64>,
    /// Its standard error: from the scatter of the peaks or the noise, and from the error of the rest.
    pub damping_ratio_error: Option<f64>,
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
    /// Why the Euler-Bernoulli beam is not among them.
    pub why_no_beam: Option<&'a str>,
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
    /// Standard error of EI over its value, from that of the rest alone.
    pub relative_error: Option<f64>,
    /// Tip of the Euler-Bernoulli beam with the same EI without the walk along its curve, in W: the paper's unmodified tip.
    pub unmodified_tip_m: Option<[f64; 2]>,
}

/// EI with which a model reproduces the tip at rest.
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
    /// Frequency of the model's swing, as large as the recording's, over that of its slowest mode.
    pub swing_over_mode: Option<f64>,
    /// Why there is none.
    pub why_not: Option<String>,
}

impl Analysed<'_> {
    /// Where the tip comes to rest, in W, m.
    pub fn tip_at_rest(&self) -> [f64; 2] {
        self.rest.map_or(self.of.statistics.rest, |rest| rest.position)
    }

    /// How far the tip sinks from hold to rest, m; nothing where the recording shows no hold.
    pub fn static_drop(&self) -> Option<f64> {
        self.of.statistics.static_drop.map(|_| self.of.statistics.hold[1] - self.tip_at_rest()[1])
    }

    /// Whether the swing is over at the end of the recording; none where that is not known.
    pub fn is_settled(&self) -> Option<bool> {
        let ([x, z], [held_x, held_z]) = (self.tip_at_rest(), self.of.statistics.hold);
        self.rest.map(|rest| rest.is_settled((held_x - x).hypot(held_z - z)))
    }

    /// What should be known before its numbers are used, each led by its name.
    pub fn warnings(&self) -> Vec<String> {
        let mut words: Vec<String> = self.rest_warning().into_iter().collect();
        words.extend(self.no_beam.as_ref().map(|why| format!("Euler-Bernoulli: {why}")));
        words.extend(self.no_rest());
        match &self.measured {
            Err(error) => words.push(error.to_string()),
            Ok(measured) => {
                words.extend(measured.decay.as_ref().err().map(|why| format!("no damping ratio: {why}")));
                if measured.since > 0.0 {
                    words.push(format!("counted from {:.2} s on: {COUNTED_LATER}", measured.since));
                }
                words.extend(self.few_samples());
                if let Some(at) = measured.bridged.cut_at {
                    words.push(format!(
                        "nothing after {at:.2} s counts, where a gap is too long to be bridged"
                    ));
                }
            }
        }
        words.into_iter().map(|words| format!("{}: {words}", self.of.release.name)).collect()
    }

    /// That the sampling is too slow for the upper peaks, in words.
    pub fn few_samples(&self) -> Option<String> {
        let samples = self.measured.as_ref().ok()?.samples_in_a_period()?;
        (samples < FEW_SAMPLES).then(|| {
            // Sampled so, a swing that is as much faster than half the rate as this is slower looks the same.
            let alias = 1.0 / self.measured.as_ref().map_or(f64::NAN, |measured| measured.bridged.step)
                * (1.0 - 1.0 / samples);
            let alias = if samples < FEWEST_SAMPLES {
                format!(", and a swing of {alias:.3} Hz would look the same")
            } else {
                String::new()
            };
            format!(
                "only {samples:.1} samples in a period, and upper peaks need {FEW_SAMPLES}: the damping ratio may be off by more \
                 than its error{alias}; record at a higher rate"
            )
        })
    }

    /// That no EI puts the tip where it rests, in words.
    pub fn no_rest(&self) -> Option<String> {
        let fits =
            self.at_rest.iter().filter_map(|row| row.gauss_newton.as_ref().or(row.nelder_mead.as_ref()).ok());
        let off = fits.map(|fit| fit.residual[0].hypot(fit.residual[1])).reduce(f64::min)?;
        let [x, z] = self.tip_at_rest();
        (off > FAR_FROM_REST * x.hypot(z)).then(|| {
            format!(
                "no EI puts the tip where it rests: the nearest leaves {:.0} mm; check up and clamp in [[recording]], \
                 rod.base_angle and rod.length",
                1e3 * off
            )
        })
    }

    /// What should be known of its rest, in words.
    pub fn rest_warning(&self) -> Option<String> {
        let rest = self.rest.filter(|_| self.is_settled() == Some(false))?;
        Some(format!(
            "not settled: the tip swings by {:.1} mm at the end; the rest follows from the decay, to {:.2} mm (one standard error)",
            1e3 * rest.swing_left,
            1e3 * rest.largest_error()
        ))
    }

    /// What is written of it.
    pub fn said(&self) -> Said<'_> {
        let own = Said {
            name: self.of.release.name.as_str(),
            static_drop_m: self.static_drop(),
            rest_m: self.tip_at_rest(),
            rest_error_m: self.rest.map(|rest| rest.error),
            swing_left_m: self.rest.map(|rest| rest.swing_left),
            settled: self.is_settled(),
            static_stiffness: self.at_rest.iter().map(|row| at_rest(row, self.rest)).collect(),
            why_no_beam: self.no_beam.as_deref(),
            dynamic_stiffness: self.in_motion.as_ref().map(in_motion),
            ..Said::default()
        };
        let measured = match &self.measured {
            Ok(measured) => measured,
            Err(error) => return Said { why_not: Some(error.to_string()), ..own },
        };
        let decay = measured.decay.as_ref();
        Said {
            coordinate: Some(measured.coordinate),
            damped_frequency_hz: measured.damped_frequency.as_ref().ok().map(|omega| omega / TAU),
            frequency_error_share: measured.frequency_error(),
            natural_frequency_hz: measured.natural_frequency().map(|omega| omega / TAU),
            damping_ratio: decay.ok().map(|decay| decay.damping_ratio),
            damping_ratio_error: decay.ok().map(|decay| decay.ratio_error),
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

fn at_rest(row: &StaticFit, rest: Option<RestEstimate>) -> AtRest {
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
        relative_error: rest.and_then(|rest| row.relative_error(rest.error)),
        unmodified_tip_m: row.unmodified,
    }
}

fn in_motion(found: &Result<DynamicStiffness, AnalysisError>) -> InMotion {
    match found {
        Ok(found) => InMotion {
            bending_stiffness_n_m2: Some(found.bending_stiffness),
            sensitivity: Some(found.sensitivity),
            swing_over_mode: Some(found.swing_over_mode),
            why_not: None,
        },
        Err(error) => InMotion { why_not: Some(error.to_string()), ..InMotion::default() },
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use efam_recordings::{ReadOptions, parse};

    use super::*;
    use crate::cleaning::clean_all;

    /// A swing of 1.6 Hz about 0.14 m below the level, let go after a second or recorded from its midst on: only the first shows how
    /// far the tip sinks from its hold.
    #[test]
    fn a_recording_that_begins_in_mid_swing_has_no_static_drop() {
        for (begin, start, has_drop) in [(1.0, "held", true), (-0.13, "in motion", false)] {
            let mut text = "t_s,A_x_m,A_z_m\n".to_owned();
            for time in (0..900).map(|k| 0.01 * f64::from(k)) {
                let since = f64::max(time - begin, 0.0);
                let height = -0.14 + 0.14 * (-0.4 * since).exp() * (10.0 * since).cos();
                text += &format!("{time:.2},0.4,{height:.9}\n");
            }
            let recording =
                parse(text.into_bytes(), Path::new("a.csv"), &ReadOptions::default()).expect("a table");
            let entry =
                format!("[[recording]]\nfile = \"a.csv\"\ntip = \"A\"\nup = \"+z\"\nstart = \"{start}\"\n");
            let experiment = Experiment::parse(Path::new("e.toml"), &entry, &[]).expect("an experiment");
            let cleaned = clean_all(&experiment, vec![recording]).expect("a swing");
            let analysed = analyse(&experiment, &cleaned, &[]).expect("no model");
            assert_eq!(analysed.len(), 1);
            let drop = analysed[0].said().static_drop_m;
            assert_eq!(drop.is_some(), has_drop, "{start}");
            assert!(drop.is_none_or(|drop| (drop - 0.14).abs() < 1e-3), "{drop:?}");
        }
    }
}

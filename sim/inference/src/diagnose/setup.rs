//! The hypothesis that nothing is missing: what the experiment states, and what a laboratory leaves open beside it.

use models::error::ModelError;
use models::quantity::format_si;

use super::hypothesis::Hypothesis;
use super::unknown::{Act, Role, Scaled, Unknown};
use crate::calibrate::hold::pulls;
use crate::calibrate::problem::is_of_pressure;
use crate::calibrate::repeats::grouped_trials;
use crate::calibrate::unknowns::{ALPHA, BASE_ANGLE, RELEASE_ANGLE};
use crate::calibrate::waves::BETA;
use crate::calibrate::{FittedParameter, Problem, Scale, Scope, Trial};
use crate::features::Plan;

/// Deviations of the logarithm: a stiffness from a static test, which the swing need not show; one that is a guess, or from a table
/// of a material that is stiffer in motion; a loss that is only known to be there.
const TESTED_STIFFNESS: f64 = 0.15;
const GUESSED_STIFFNESS: f64 = 0.3;
const LOSS: f64 = 1.5;
/// Usual damping ratios by mass and by stiffness, medians.
const MASS_DAMPING: f64 = 0.02;
const STIFFNESS_DAMPING: f64 = 0.01;
/// Length by a ruler to soft ends, masses by a balance with what hangs on them: logarithmic deviations.
const LENGTH: f64 = 0.01;
const MASS: f64 = 0.01;
/// Angle of the clamp and of the camera, by eye or a bubble, rad: one degree.
const ANGLE: f64 = 0.017_453_292_519_943_295;
/// Place of a marker on the end, m, for rods of up to a third of a metre, and longer ones in proportion; of one along the rod, a
/// share of its length.
const MARKER: f64 = 1e-3;
const MARKER_LENGTH: f64 = 0.3;
const PLACE: f64 = 0.01;
/// Curvature without load, over that of one radian over the length: of a rod that is stated straight, of one that hangs curved.
const CURVATURE: f64 = 0.1;
const HELD_CURVATURE: f64 = 0.3;
/// Instant of release, s: a hand opens within two frames of a usual camera; and in sample intervals.
const INSTANT: f64 = 0.01;
const INSTANT_SAMPLES: f64 = 0.3;
/// Angular velocity that a hand gives, over that of a free fall.
const PUSH: f64 = 0.01;
/// By how much the stiffness and the losses of a release differ from those of others, logarithmic deviations. A regulator holds a
/// pressure to half a per cent, and a rubber remembers the release before.
const REPEATED_STIFFNESS: f64 = 0.005;
const REPEATED_LOSS: f64 = 0.03;
/// Nodes at least, and where their mesh errors are lost in the noise: those of sixteen edges are a twentieth of a millimetre on
/// the paper's muscle.
pub const NODES: usize = 17;

const EI: &str = "rod.bending_stiffness";
const TILT: &str = "effects.frame_tilt.angle";

/// Statements that may be freed, by how much wider their prior then is.
pub const FREED: [(&str, f64); 10] = [
    ("stiffness", 5.0),
    ("length", 10.0),
    ("mass", 30.0),
    ("end fitting", 30.0),
    ("payload", 30.0),
    ("clamp", 10.0),
    ("camera", 10.0),
    ("marker", 10.0),
    ("curvature", 10.0),
    ("hold", 10.0),
];

/// The trials on their own mesh or on the coarsest, with the effects of the setup at zero.
/// # Errors
/// [`ModelError`] where a model cannot have them.
pub fn trials(problem: &Problem, is_coarse: bool) -> Result<Vec<Trial>, ModelError> {
    problem
        .trials
        .iter()
        .map(|trial| {
            let mut trial = Trial::clone(trial);
            let nodes = trial.model.edges + 1;
            if nodes < NODES || (is_coarse && nodes > NODES) {
                (trial.model, trial.run) = trial.run.on_mesh(&trial.model, NODES)?;
            }
            for (effect, keys) in [
                ("frame_tilt", &["angle"][..]),
                ("marker_offset", &["along", "across"]),
                ("set_curvature", &["natural_curvature", "curvature_over_pressure"]),
            ] {
                if trial.model.effect(effect).is_none() {
                    let values: Vec<_> = keys.iter().map(|key| (*key, 0.0)).collect();
                    trial = trial.with_effect(effect, &values)?;
                }
            }
            Ok(trial)
        })
        .collect()
}

/// The hypothesis that nothing is missing, of trials that all show a swing, each with its plan; those that are held out last.
/// # Errors
/// [`ModelError`] for a parameter that a model has not.
pub fn nothing(problem: &Problem, trials: Vec<Trial>, plans: &[&Plan]) -> Result<Hypothesis, ModelError> {
    let mut made = Making { trials: &trials, unknowns: Vec::new() };
    let frequency = plans.iter().map(|plan| plan.frequency).sum::<f64>() / plans.len().max(1) as f64;
    for own in &problem.parameters {
        made.parameter(own, frequency)?;
    }
    let first = &trials[0];
    let rod = first.model.rod();
    let is_known = |path: &str| problem.parameters.iter().any(|own| own.path == path);
    for (statement, label, path, deviation) in [
        ("length", "length", "rod.length", LENGTH),
        ("mass", "mass of the rod", "rod.mass", MASS),
        ("end fitting", "mass of the end fitting", "effects.end_fitting.mass", MASS),
        ("payload", "mass of the payload", "effects.payload.mass", MASS),
    ] {
        let has_some = made.any(|trial| trial.model.index(path).is_ok_and(|k| trial.model.theta[k] > 0.0));
        if has_some && !is_known(path) {
            let unit = if path == "rod.length" { "m" } else { "kg" };
            made.shared(Unknown::setup(statement, label, unit, Scaled::Factor(deviation)), &[path])?;
        }
    }
    let clamp = problem.nuisances.clamp_angle.unwrap_or(ANGLE);
    let clamp = Unknown::setup("clamp", "angle of the clamp", "rad", Scaled::Shift(clamp));
    if !is_known(BASE_ANGLE) {
        made.shared(clamp, &[BASE_ANGLE])?;
    }
    if !is_known(TILT) {
        made.grouped("camera", "tilt of the camera", "rad", Scaled::Shift(ANGLE), TILT)?;
    }
    let marker = MARKER * (rod.length / MARKER_LENGTH).max(1.0);
    for (key, label) in
        [("along", "place of the tip's marker along"), ("across", "place of the tip's marker across")]
    {
        let unknown = Unknown::setup("marker", label, "m", Scaled::Shift(marker));
        made.shared(unknown, &[&format!("effects.marker_offset.{key}")])?;
    }
    let is_held = made.any(Trial::is_held);
    let curvature = if is_held { HELD_CURVATURE } else { CURVATURE } / rod.length;
    for (key, label) in [("natural_curvature", "set curvature"), ("taper", "taper of the set curvature")] {
        let unknown = Unknown::setup("curvature", label, "1/m", Scaled::Shift(curvature));
        made.shared(unknown, &[&format!("effects.set_curvature.{key}")])?;
    }
    let shared = made.unknowns.len();
    for (r, plan) in plans.iter().enumerate() {
        made.release(problem, r, plan)?;
    }
    made.unknowns[shared..].iter_mut().for_each(|unknown| unknown.is_own = true);
    let unknowns = made.unknowns;
    Ok(Hypothesis { trials, unknowns, freed: None })
}

/// Unknowns as they are collected.
struct Making<'a> {
    trials: &'a [Trial],
    unknowns: Vec<Unknown>,
}

impl Making<'_> {
    fn any(&self, is: impl Fn(&Trial) -> bool) -> bool {
        self.trials.iter().any(is)
    }

    /// Adds an unknown that acts on parameters of the releases for which `is_of` holds.
    fn acting(
        &mut self,
        mut unknown: Unknown,
        paths: &[&str],
        is_of: impl Fn(usize) -> bool,
    ) -> Result<(), ModelError> {
        for (r, trial) in self.trials.iter().enumerate().filter(|(r, _)| is_of(*r)) {
            let places = paths.iter().map(|path| trial.model.index(path)).collect::<Result<_, _>>()?;
            unknown.acts.push((r, Act::Theta(places)));
        }
        self.unknowns.push(unknown);
        Ok(())
    }

    fn shared(&mut self, unknown: Unknown, paths: &[&str]) -> Result<(), ModelError> {
        self.acting(unknown, paths, |_| true)
    }

    /// An unknown for each pressure.
    fn grouped(
        &mut self,
        statement: &'static str,
        label: &str,
        unit: &'static str,
        scaled: Scaled,
        path: &str,
    ) -> Result<(), ModelError> {
        for (pressure, group) in by_pressure(self.trials) {
            let unknown = Unknown::setup(statement, &labelled(label, pressure), unit, scaled);
            self.acting(Unknown { pressure, ..unknown }, &[path], |r| group.contains(&r))?;
        }
        Ok(())
    }

    /// A parameter that the experiment has fitted.
    fn parameter(&mut self, own: &FittedParameter, frequency: f64) -> Result<(), ModelError> {
        let model = &self.trials[0].model;
        let k = model.index(&own.path)?;
        let (value, known) = (own.start.unwrap_or(model.theta[k]), model.parameters[k].clone());
        let swing = 2.0 * std::f64::consts::TAU * frequency;
        let scaled = match (own.prior, own.path.as_str()) {
            (Some(prior), EI) if prior.mean > 0.0 => {
                Scaled::LogNormal(prior.mean, (prior.deviation / prior.mean).max(TESTED_STIFFNESS))
            }
            (Some(prior), _) => Scaled::Normal(prior.mean, prior.deviation),
            (None, EI) => Scaled::Factor(GUESSED_STIFFNESS),
            (None, ALPHA) => Scaled::LogNormal(MASS_DAMPING * swing, LOSS),
            (None, BETA) => Scaled::LogNormal(STIFFNESS_DAMPING * 4.0 / swing, LOSS),
            (None, _) if own.scale == Some(Scale::Logarithmic) && value > 0.0 => {
                Scaled::LogNormal(value, LOSS)
            }
            (None, _) => Scaled::Normal(value, 3.0 * known.scale.max(value.abs())),
        };
        let statement = if own.path == EI { "stiffness" } else { "parameter" };
        let groups = match own.scope {
            Scope::Shared => vec![(None, (0..self.trials.len()).collect())],
            Scope::PerPressure => by_pressure(self.trials),
            Scope::PerRelease => (0..self.trials.len()).map(|r| (None, vec![r])).collect(),
        };
        let limits = own.bounds.unwrap_or(known.range);
        for (pressure, group) in &groups {
            let name = if own.path == EI { "EI" } else { own.path.rsplit('.').next().unwrap_or(&own.path) };
            let mut unknown = Unknown::setup(statement, &labelled(name, *pressure), known.unit, scaled);
            (unknown.limits, unknown.pressure) = (limits, *pressure);
            unknown.is_own = own.scope == Scope::PerRelease;
            let first = &self.trials[group[0]].model;
            let of_model = first.value(&own.path)?;
            if of_model > 0.0 {
                unknown.start = scaled.place(of_model, own.start.unwrap_or(of_model)).clamp(-3.0, 3.0);
            }
            self.acting(unknown, &[&own.path], |r| group.contains(&r))?;
        }
        Ok(())
    }

    /// What each release has of its own.
    fn release(&mut self, problem: &Problem, r: usize, plan: &Plan) -> Result<(), ModelError> {
        let trial = &self.trials[r];
        let tag = if self.trials.len() > 1 { format!(" of {}", trial.release.name) } else { String::new() };
        let label = |what: &str| format!("{what}{tag}");
        let interval = (plan.time[1] - plan.time[0]).abs();
        let deviation = INSTANT.max(INSTANT_SAMPLES * interval).max(trial.release.release_uncertainty);
        // Of a start in motion the first sample is the start.
        if !trial.is_in_motion() {
            let scaled = Scaled::Normal(0.0, deviation);
            let mut instant = Unknown::setup("instant", &label("instant"), "s", scaled);
            instant.acts.push((r, Act::Instant));
            self.unknowns.push(instant);
        }
        if let Some(deviation) = problem.nuisances.offset {
            for (axis, letter) in ["x", "z"].into_iter().enumerate() {
                let name = label(&format!("offset in {letter}"));
                let mut offset = Unknown::setup("offset", &name, "m", Scaled::Normal(0.0, deviation));
                offset.acts.push((r, Act::Offset(axis)));
                self.unknowns.push(offset);
            }
        }
        for (name, path, deviation) in [
            ("EI", EI, REPEATED_STIFFNESS),
            ("mass damping", ALPHA, REPEATED_LOSS),
            ("stiffness damping", BETA, REPEATED_LOSS),
        ] {
            let own = trial.model.index(path).ok().filter(|k| trial.model.theta[*k] > 0.0);
            if let Some(k) = own.filter(|_| self.trials.len() > 1) {
                let unit = trial.model.parameters[k].unit;
                let unknown = Unknown::setup("repeat", &label(name), unit, Scaled::Factor(deviation));
                self.acting(unknown, &[path], |own| own == r)?;
            }
        }
        for (place, track) in plan.tracks.iter().enumerate() {
            let track = &trial.release.tracks[*track];
            if let efam_experiments::release::Point::Along(_) = track.at {
                let name = label(&format!("place of {}", track.marker));
                let mut unknown = Unknown::setup("marker", &name, "", Scaled::Shift(PLACE));
                unknown.acts.push((r, Act::Place(place)));
                self.unknowns.push(unknown);
            }
        }
        if trial.is_straight() {
            let fall = (3.0 * 9.81 / trial.model.rod().length).sqrt();
            let hold = problem.nuisances.hold_angle.unwrap_or(0.5f64.to_radians());
            let hold = Unknown::setup("hold", &label("hold angle"), "rad", Scaled::Shift(hold));
            self.acting(hold, &[RELEASE_ANGLE], |own| own == r)?;
            let push = Unknown::setup("push", &label("push"), "rad/s", Scaled::Shift(PUSH * fall));
            self.acting(push, &["release.angular_velocity"], |own| own == r)?;
        }
        if trial.is_held() {
            for (path, unit, size) in pulls(trial)? {
                let name = label(path.rsplit('.').next().unwrap_or(path));
                let mut pull = Unknown::setup("hand", &name, unit, Scaled::Normal(0.0, size));
                let value = trial.model.value(path)?;
                pull.start = (value / size).clamp(-6.0, 6.0);
                self.acting(pull, &[path], |own| own == r)?;
            }
        }
        Ok(())
    }
}

/// Releases by pressure, in the order of the releases, with the pressure, Pa, where there are several; all in one group where a
/// pressure is unknown.
pub fn by_pressure(trials: &[Trial]) -> Vec<(Option<f64>, Vec<usize>)> {
    if trials.iter().any(|trial| trial.release.pressure.is_none()) {
        return vec![(None, (0..trials.len()).collect())];
    }
    let pressure = |trial: &Trial| trial.release.pressure;
    let groups = grouped_trials(trials.iter(), |_| true, |a, b| is_of_pressure(pressure(a), pressure(b)));
    let is_alone = groups.len() == 1;
    groups.into_iter().map(|own| (pressure(&trials[own[0]]).filter(|_| !is_alone), own)).collect()
}

/// A name with the pressure that it belongs to.
pub fn labelled(name: &str, pressure: Option<f64>) -> String {
    pressure.map_or_else(|| name.to_owned(), |own| format!("{name} at {}", format_si(own, "Pa")))
}

/// The hypothesis with a statement freed, and by how much its unknowns' priors are wider; none where nothing is stated of it.
pub fn freed(of: &Hypothesis, statement: &'static str, factor: f64) -> Option<Hypothesis> {
    let is_of = |unknown: &Unknown| unknown.role == Role::Setup(statement);
    if of.freed.is_some() || !of.unknowns.iter().any(is_of) {
        return None;
    }
    let wider = |own: &Unknown| if is_of(own) { own.freed(factor) } else { own.clone() };
    let unknowns = of.unknowns.iter().map(wider).collect();
    Some(Hypothesis { unknowns, freed: Some(statement), ..of.clone() })
}

//! What every effect keeps, whoever wrote it and in whichever language: the tests of the catalogue, as functions of an
//! effect. Tests run them over the catalogue, and `efam effects --check` over a law as text.

mod derivatives;

use std::sync::Arc;

use crate::effects::{Catalogue, Effect, Kind, LANES, Parameter, Place, Real, Sight};
use crate::lanes::{seeded, slopes};
use crate::model::{Model, ModelSpec};
use crate::muscle::{Extrapolation, Muscle};
use crate::pressure::PressureSchedule;
use crate::sensor::Sensor;
use crate::system::{System, TimePass};
pub use derivatives::{State, force_is_gradient, parameters_match_differences, tangents_match_differences};

/// First time at which laws are evaluated, s: not the release, at which a drift has not begun.
const NOW: f64 = 0.3;
/// The same of a law that changes in time: spread over the default duration of a run, and no multiples of each other.
const LATER: [f64; 4] = [1.1, 3.7, 9.1, 19.7];
/// Pressure of the muscle, Pa: 40 psi.
const PRESSURE: f64 = 40.0 * 6_894.757_293_168_36;

/// What a test found that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The effect keeps it.
    Holds,
    /// It does not apply to the effect, for this reason.
    NotTested(&'static str),
}

/// A test of an effect; what is wrong is said in words.
pub type Test = fn(&'static dyn Effect) -> Result<Outcome, String>;

/// The tests, each with what it makes sure of.
pub const TESTS: [(&str, Test); 7] = [
    ("units, ranges and defaults", parameters),
    ("off is exactly off, and on is on", off_and_on),
    ("at off the sensitivity is not zero", sensitive_at_off),
    ("never feeds energy", feeds_no_energy),
    ("the same in every direction of the laboratory", frame_indifferent),
    ("derivatives match differences", derivatives),
    ("the force at rest is the gradient of the energy", gradient),
];

fn ensure(holds: bool, message: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(message()) }
}

/// The muscle of 40 psi, its fitting and nothing else.
fn base(effect: &'static dyn Effect) -> Result<ModelSpec, String> {
    let muscle = Muscle::built_in("garbulinski-2022").map_err(|error| error.to_string())?;
    let at = muscle.at(PRESSURE, "pder_32", Extrapolation::Refused).map_err(|error| error.to_string())?;
    let mut catalogue = Catalogue::default();
    if effect.text().is_some() {
        catalogue = catalogue.with(effect).map_err(|error| error.to_string())?;
    }
    // Nothing else may lose energy, or it would hide what the effect feeds.
    let lossless = [("rayleigh_mass.alpha", 0.0), ("rayleigh_stiffness.beta", 0.0)];
    let spec = ModelSpec { nodes: 8, catalogue, ..muscle.spec(&at) }.with(&lossless);
    if !effect.about().places.contains(&Place::Line) {
        return Ok(spec);
    }
    // A line needs a command: 4 psi more within half a second.
    let rows = [(0.05, PRESSURE), (0.55, 1.1 * PRESSURE)];
    let schedule = PressureSchedule::new(muscle, "pder_32", Extrapolation::Refused, &rows);
    let schedule = schedule.map_err(|error| error.to_string())?;
    Ok(ModelSpec { schedule: Some(Arc::new(schedule)), ..spec })
}

/// A model in which the effect acts, each parameter [turned on](turned_on) but for those at `off`.
fn with(effect: &'static dyn Effect, off: impl Fn(&Parameter) -> bool) -> Result<Model, String> {
    let about = effect.about();
    let values = about
        .parameters
        .iter()
        .map(|p| (p.name.to_owned(), p.null_value.filter(|_| off(p)).unwrap_or(turned_on(p))));
    let mut spec = base(effect)?;
    spec.effects.push((about.name.to_owned(), values.collect()));
    Model::new(&spec).map_err(|error| error.to_string())
}

/// The default, or half the scale where that is off: admissible.
fn turned_on(p: &Parameter) -> f64 {
    let is_off = Some(p.default) == p.null_value || p.default == 0.0;
    if is_off { (0.5 * p.scale).clamp(p.range.0, p.range.1) } else { p.default }
}

fn on(effect: &'static dyn Effect) -> Result<Model, String> {
    with(effect, |_| false)
}

/// A rod bent and stretched without symmetry, and moving.
fn moving(model: &Model) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let (mut q, mut v) = System::new(model).assembly.straight(-0.5, 1.0);
    for k in 0..q.len() {
        q[k] += 0.004 * ((k * k) as f64).sin();
        v[k] += 0.2 * (3.0 * k as f64).cos();
    }
    let z = vec![0.1; model.memory()];
    (q, v, z)
}

/// Times at which an effect is evaluated, s. One that changes in time is off before it begins, so it is also evaluated
/// after each time that is a parameter of it, and after all of them together.
fn times(effect: &'static dyn Effect) -> Vec<f64> {
    let about = effect.about();
    if !about.timed {
        return vec![NOW];
    }
    let all = own_times(effect).sum::<f64>();
    [NOW]
        .into_iter()
        .chain(LATER)
        .chain(own_times(effect).map(|time| time + NOW))
        .chain([all + NOW])
        .collect()
}

/// Times that are parameters of an effect, s.
fn own_times(effect: &'static dyn Effect) -> impl Iterator<Item = f64> {
    let times = effect.about().parameters.iter().filter(|p| p.unit == "s");
    times.map(turned_on).filter(|time| *time > 0.0)
}

fn force(model: &Model, time: f64) -> Vec<f64> {
    let (q, v, z) = moving(model);
    let mut force = vec![0.0; q.len()];
    let mut rate = vec![0.0; z.len()];
    System::new(model).force(time, &q, &v, &z, &mut force, &mut rate);
    force
}

/// A point of the end body, and one of the rod.
fn sights<T: Real>() -> [Sight<T>; 2] {
    let of = |[x, z]: [f64; 2], angle: f64, share, is_tip| {
        let tangent = [angle.cos(), angle.sin()].map(T::from);
        Sight { position: [x, z].map(T::from), tangent, share, is_tip }
    };
    [of([0.11, -0.13], -0.9, 1.0, true), of([0.09, -0.04], -0.6, 0.5, false)]
}

/// A time of a recording, s.
const RECORDED: f64 = 0.7;

/// Wherever an effect can show: forces at a state in motion at some times, masses, the state in which the straight
/// rod is let go, and what is seen of it and when.
fn trace(model: &Model, times: &[f64]) -> Vec<f64> {
    let system = System::new(model);
    let straight = system.assembly.straight_at_release();
    let (q, v) = system.assembly.let_go(model, straight);
    let sensor = Sensor::new(model, model.theta.clone());
    let seen = sights().map(|sight| sensor.see(sight));
    let forces = times.iter().map(|time| force(model, *time)).collect::<Vec<_>>().concat();
    [&forces[..], &system.mass, &q, &v, seen.as_flattened(), &[sensor.instant(RECORDED)]].concat()
}

/// Derivatives of the [`trace`] by one parameter.
fn trace_by(model: &Model, parameter: usize, times: &[f64]) -> Vec<f64> {
    let (q, v, z) = moving(model);
    let mut system = System::new(model);
    let watched = [Some(parameter)];
    system.watch(&watched);
    let mut forces = Vec::new();
    for time in times {
        let (mut by_theta, mut rates) = (vec![[0.0; LANES]; q.len()], vec![[0.0; LANES]; z.len()]);
        system.by_parameters(0, *time, &q, &v, &z, &mut by_theta, &mut rates);
        forces.extend(by_theta);
    }
    let (by_q, by_v) = system.let_go_by_parameters(0, system.straight_by_parameters(0));
    let sensor = Sensor::new(model, seeded(&model.theta, &watched));
    let seen = sights().map(|sight| sensor.see(sight)).into_iter().flatten();
    let seen = seen.chain([sensor.instant(RECORDED.into())]).map(|x| slopes(&x));
    let by_mass = system.mass_by_parameters(0);
    forces.into_iter().chain(by_mass).chain(by_q).chain(by_v).chain(seen).map(|row| row[0]).collect()
}

fn parameters(effect: &'static dyn Effect) -> Result<Outcome, String> {
    let about = effect.about();
    for p in about.parameters {
        crate::quantity::Unit::parse(p.unit).map_err(|error| format!("{}: {error}", p.name))?;
        ensure(p.range.0 <= p.default && p.default <= p.range.1, || {
            format!("{}: default out of range", p.name)
        })?;
    }
    let page = effect.page();
    for heading in ["Law:", "Assumes:", "Off:", "Silent:", "Source:"] {
        ensure(page.contains(heading), || format!("the page lacks {heading}"))?;
    }
    let is_name = |name: &str| name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
    match about.confounded_with.iter().find(|name| !is_name(name)) {
        Some(name) => Err(format!("confounded_with: `{name}` is no name of an effect")),
        None => Ok(Outcome::Holds),
    }
}

/// Why an effect without a switch is not tested for what the switch does.
const NO_SWITCH: Outcome = Outcome::NotTested("no parameter has a value at which it is off");

fn off_and_on(effect: &'static dyn Effect) -> Result<Outcome, String> {
    let about = effect.about();
    let switches = || about.parameters.iter().filter(|p| p.null_value.is_some());
    if switches().next().is_none() {
        return Ok(NO_SWITCH);
    }
    let times = &times(effect);
    let trace = |model: &Model| trace(model, times);
    let without = |model: &Model| {
        let mut without = model.clone();
        without.effects.retain(|active| active.effect.about().name != about.name);
        trace(&without)
    };
    // Each that can do so alone, and all parts together.
    let alone = switches().filter(|p| !p.is_part).map(|p| vec![p.name]);
    let parts: Vec<_> = switches().filter(|p| p.is_part).map(|p| p.name).collect();
    for off in alone.chain((!parts.is_empty()).then_some(parts)) {
        let model = with(effect, |p| off.contains(&p.name))?;
        let still =
            || format!("with {} at off it still acts; give another off value, or none", off.join(", "));
        ensure(trace(&model) == without(&model), still)?;
        // A model leaves out what is off, so its law is evaluated close to off.
        let near = beside(&model, effect, &off)?;
        let on = on(effect)?;
        let apart = |model: &Model| {
            let pairs = trace(model).into_iter().zip(without(model));
            pairs.fold([0.0_f64; 2], |[apart, size], (a, b)| [apart.max((a - b).abs()), size.max(a.abs())])
        };
        let ([near, size], [far, _]) = (apart(&near), apart(&on));
        ensure(near <= 1e3 * BESIDE * far + 1e-12 * size, still)?;
    }
    let model = on(effect)?;
    ensure(trace(&model) != without(&model), || {
        format!("at its defaults it does nothing in motion at {}", listed(times))
    })?;
    for part in switches().filter(|p| p.is_part) {
        let alone = with(effect, |p| p.is_part && p.name != part.name)?;
        ensure(trace(&alone) != without(&alone), || format!("the part {} alone does nothing", part.name))?;
    }
    Ok(Outcome::Holds)
}

/// Times in words.
fn listed(times: &[f64]) -> String {
    let words: Vec<String> = times.iter().map(|time| format!("{} s", crate::digits::short(*time))).collect();
    words.join(", ")
}

/// Distance from off at which a law is evaluated, over the scale of the parameter.
const BESIDE: f64 = 1e-9;

/// The model with some parameters next to off.
fn beside(model: &Model, effect: &'static dyn Effect, off: &[&str]) -> Result<Model, String> {
    let about = effect.about();
    let mut model = model.clone();
    for p in about.parameters.iter().filter(|p| off.contains(&p.name)) {
        let k =
            model.index(&format!("effects.{}.{}", about.name, p.name)).map_err(|error| error.to_string())?;
        let step = if model.theta[k] < p.range.1 { BESIDE } else { -BESIDE };
        model.theta[k] += step * p.scale;
    }
    Ok(model)
}

fn sensitive_at_off(effect: &'static dyn Effect) -> Result<Outcome, String> {
    let about = effect.about();
    if about.parameters.iter().all(|p| p.null_value.is_none()) {
        return Ok(NO_SWITCH);
    }
    let times = times(effect);
    for p in about.parameters.iter().filter(|p| p.null_value.is_some()) {
        // All others on; of parts, all off.
        let model = with(effect, |other| other.name == p.name || (p.is_part && other.is_part))?;
        let path = format!("effects.{}.{}", about.name, p.name);
        let k = model.index(&path).map_err(|error| error.to_string())?;
        ensure(trace_by(&model, k, &times).iter().any(|slope| *slope != 0.0), || {
            format!("{}: no fit can start there, because nothing changes with it to first order", p.name)
        })?;
    }
    Ok(Outcome::Holds)
}

fn feeds_no_energy(effect: &'static dyn Effect) -> Result<Outcome, String> {
    let about = effect.about();
    // The loads of the catalogue have an energy.
    if about.kind == Kind::Load && effect.text().is_some() {
        return Ok(Outcome::NotTested("a load acts from outside, and may feed energy"));
    }
    let model = on(effect)?;
    let (q, v, z) = moving(&model);
    let mut pass = TimePass::new(&model);
    for time in times(effect) {
        let (lost, supplied) = System::new(&model).powers(&mut pass, time, &q, &v, &z);
        let scale: f64 = force(&model, time).iter().zip(&v).map(|(f, v)| (f * v).abs()).sum();
        ensure(lost >= -1e-12 * scale, || {
            format!(
                "it feeds {:.3e} W to the rod at {time} s; turn its sign, or give the energy that it takes this \
                 from (energy, edge_energy, tip_energy), or kind = \"load\" if it acts from outside",
                -lost
            )
        })?;
        let is_timed = about.timed || about.places.contains(&Place::Line);
        ensure(is_timed || supplied == 0.0, || "it depends on time unsaid".to_owned())?;
    }
    Ok(Outcome::Holds)
}

/// Effects that pull towards places or directions of the laboratory, and so know its frame.
const FIXED_IN_THE_LABORATORY: [&str; 5] = ["gravity", "tip_load", "tip_hold", "hose", "hand_release"];

/// Whether a law as text may know the directions of the laboratory: on the end, or on all mass.
fn may_be_fixed(effect: &'static dyn Effect) -> bool {
    let can_be = |place: &Place| matches!(place, Place::Tip | Place::Mass);
    effect.text().is_some() && effect.about().places.iter().any(can_be)
}

fn frame_indifferent(effect: &'static dyn Effect) -> Result<Outcome, String> {
    if FIXED_IN_THE_LABORATORY.contains(&effect.about().name) {
        return Ok(Outcome::NotTested("it pulls towards a place or a direction of the laboratory"));
    }
    for turn in TURNS {
        for time in times(effect) {
            match turns_with_the_rod(effect, turn, time) {
                Err(_) if may_be_fixed(effect) => {
                    return Ok(Outcome::NotTested(
                        "it is not the same when the clamp is turned, as a law of the tip or of all mass may be",
                    ));
                }
                turned => turned?,
            }
        }
    }
    Ok(Outcome::Holds)
}

/// Angles by which all is turned, rad.
const TURNS: [f64; 2] = [0.9, -2.1];

/// Turning everything turns the forces, and what is let go: with the clamp, the gravity off. What is
/// observed has no part in it: a camera does not turn with the rod.
fn turns_with_the_rod(effect: &'static dyn Effect, turn: f64, time: f64) -> Result<(), String> {
    let mut still = on(effect)?;
    still.set("effects.gravity.acceleration", 0.0).map_err(|error| error.to_string())?;
    let mut turned = still.clone();
    for path in ["rod.base_angle", "release.angle"] {
        turned.set(path, turn).map_err(|error| error.to_string())?;
    }
    let (q, v, z) = moving(&still);
    let rotate = |x: &[f64], angle: f64| -> Vec<f64> {
        let mut y: Vec<f64> = Vec::new();
        for pair in x[..x.len() - 1].chunks(2) {
            y.push(turn.cos() * pair[0] - turn.sin() * pair[1]);
            y.push(turn.sin() * pair[0] + turn.cos() * pair[1]);
        }
        y.push(x[x.len() - 1] + angle);
        y
    };
    let at = |model: &Model, q: &[f64], v: &[f64]| {
        let mut force = vec![0.0; q.len()];
        let mut rate = vec![0.0; z.len()];
        System::new(model).force(time, q, v, &z, &mut force, &mut rate);
        force
    };
    let expected = rotate(&at(&still, &q, &v), 0.0);
    let found = at(&turned, &rotate(&q, turn), &rotate(&v, 0.0));
    let scale = expected.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
    for (found, expected) in found.iter().zip(&expected) {
        ensure((found - expected).abs() < 1e-11 * scale, || {
            format!("turned, a force is {found} N, not {expected} N")
        })?;
    }
    let let_go = |model: &Model| {
        let assembly = &System::new(model).assembly;
        assembly.let_go(model, assembly.straight_at_release())
    };
    let ((q, v), (turned_q, turned_v)) = (let_go(&still), let_go(&turned));
    let expected = [rotate(&q, turn), rotate(&v, 0.0)].concat();
    for (found, expected) in turned_q.iter().chain(&turned_v).zip(&expected) {
        ensure((found - expected).abs() < 1e-14, || "its start does not turn with the rod".to_owned())?;
    }
    Ok(())
}

fn derivatives(effect: &'static dyn Effect) -> Result<Outcome, String> {
    let model = on(effect)?;
    // The later, the more a difference by a frequency is off.
    let start = State::of(&model).time;
    let begun = own_times(effect).map(|time| time + NOW).filter(|_| effect.about().timed);
    for time in [start].into_iter().chain(begun) {
        let state = State { time, ..State::of(&model) };
        tangents_match_differences(&model, &state)?;
        parameters_match_differences(&model, &state)?;
    }
    Ok(Outcome::Holds)
}

/// Where the effect gives back what it takes. A memory that is driven by the rate holds its energy itself, and its moment
/// is no gradient; nothing that acts from outside without an energy needs to be one.
fn gradient(effect: &'static dyn Effect) -> Result<Outcome, String> {
    let about = effect.about();
    let acts_on = |place| about.places.contains(&place);
    let reasons = [
        (about.memory > 0, "a memory may hold the energy"),
        (about.timed, "it changes in time"),
        (acts_on(Place::Flow), "the flow acts from outside"),
        (acts_on(Place::Whole), "it depends on the curvature of the whole rod"),
    ];
    if let Some((_, reason)) = reasons.into_iter().find(|(applies, _)| *applies) {
        return Ok(Outcome::NotTested(reason));
    }
    let model = on(effect)?;
    force_is_gradient(&model, &State::of(&model))?;
    Ok(Outcome::Holds)
}

/// Whether a law is the same bent up and bent down, and moving either way: of a law as text at bends, edges or in the
/// flow. No test, as a rod may well differ: what its author should know.
pub fn is_mirrored(effect: &'static dyn Effect) -> Result<bool, String> {
    let mut model = on(effect)?;
    model.set("effects.gravity.acceleration", 0.0).map_err(|error| error.to_string())?;
    let (q, v, z) = moving(&model);
    // z of a node, and the angle of the end body, which comes last.
    let mirror = |x: &[f64]| -> Vec<f64> {
        let last = x.len() - 1;
        x.iter().enumerate().map(|(k, x)| if k % 2 == 1 || k == last { -x } else { *x }).collect()
    };
    let at = |time: f64, q: &[f64], v: &[f64], z: &[f64]| {
        let (mut force, mut rate) = (vec![0.0; q.len()], vec![0.0; z.len()]);
        System::new(&model).force(time, q, v, z, &mut force, &mut rate);
        force
    };
    let other: Vec<f64> = z.iter().map(|z| -z).collect();
    Ok(times(effect).into_iter().all(|time| {
        let (here, there) = (mirror(&at(time, &q, &v, &z)), at(time, &mirror(&q), &mirror(&v), &other));
        let scale = here.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        here.iter().zip(&there).all(|(a, b)| (a - b).abs() < 1e-11 * scale)
    }))
}

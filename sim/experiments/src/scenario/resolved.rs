//! A case as a scenario in SI units that needs no other file and gives the same bits.

use std::fmt::Write;

use efam_core::forward::{CurvePoint, Initial, Run};
use efam_core::pace::DEFAULT_RATE;
use models::history::History;
use models::model::{Model, Scheme};
use models::muscle::Extrapolation;
use models::posture::Posture;

use super::Case;
use super::plan::{METHODS, MassPlan, Plan, Pressure, fits_name};
use super::start::is_kinked;
use super::units::ROD;

pub(super) fn text(case: &Case, plan: &Plan) -> String {
    let Case { name, model, run, .. } = case;
    let mut out = String::from(
        "# What was simulated, in SI units and with nothing left to defaults: written by efam,\n\
         # and run again by `efam simulate` to the same bits.\n",
    );
    put(&mut out, "name", quoted(name));
    muscle(&mut out, plan);
    let has = |k: usize| ROD[k].0 != "diameter" || plan.muscle.is_some() || plan.rod[k].is_some();
    rod(&mut out, model, &has);
    start(&mut out, model, run);
    if matches!(run.initial, Initial::Straight) {
        put(&mut out, "from", quoted("straight"));
    }
    out += "\n[run]\n";
    put(&mut out, "duration", si(run.duration, "s"));
    put(&mut out, "rate", si(case.rate.unwrap_or(DEFAULT_RATE), "Hz"));
    if let Some(accuracy) = case.goal.accuracy {
        put(&mut out, "accuracy", si(accuracy, "m"));
    }
    out += "\n[integrator]\n";
    let method = METHODS.iter().find(|(_, method)| *method == run.method);
    put(&mut out, "method", quoted(method.map_or("", |method| method.0)));
    put(&mut out, "tolerance", si(run.tolerance, ""));
    put(&mut out, "most_steps", run.most_steps);
    if let Some(step) = run.steps.fixed() {
        put(&mut out, "fixed_step", si(step, "s"));
    }
    effects(&mut out, model);
    out
}

/// A model and where its run starts as a scenario; `head` is a comment. A rod that a hand holds keeps its place under
/// another payload: the hand then holds that as well.
pub fn plain(head: &str, name: &str, model: &Model, run: &Run, duration: f64) -> String {
    let mut out: String = head.lines().map(|line| format!("# {line}\n")).collect();
    let name: String = name.chars().map(|c| if fits_name(c) { c } else { '-' }).collect();
    put(&mut out, "name", quoted(&format!("{}{name}", if name.starts_with('.') { "-" } else { "" })));
    let has_diameter = model.rod().diameter > 0.0;
    rod(&mut out, model, &|k| ROD[k].0 != "diameter" || has_diameter);
    let mut run = run.clone();
    if run.initial.is_in_a_hand()
        && let Initial::Equilibrium { own, .. } = &mut run.initial
    {
        own.extend(model.effect("payload").into_iter().flat_map(|payload| payload.theta.clone()));
    }
    start(&mut out, model, &run);
    out += "\n[run]\n";
    put(&mut out, "duration", si(duration, "s"));
    effects(&mut out, model);
    out
}

/// The rod, but for data that it has not.
fn rod(out: &mut String, model: &Model, has: &dyn Fn(usize) -> bool) {
    *out += "\n[rod]\n";
    put(out, "nodes", model.edges + 1);
    put(out, "scheme", quoted(if model.scheme == Scheme::Paper { "paper" } else { "consistent" }));
    put(out, "base_angle", si(model.value_or_zero("rod.base_angle"), "rad"));
    put(out, "tip", si(model.tip_distance, "m"));
    for (_, (key, unit)) in ROD.into_iter().enumerate().filter(|(k, _)| has(*k)) {
        put(out, key, si(model.value_or_zero(&format!("rod.{key}")), unit));
    }
}

/// Where the rod starts.
fn start(out: &mut String, model: &Model, run: &Run) {
    let [base, angle, rate] =
        ["rod.base_angle", "release.angle", "release.angular_velocity"].map(|path| model.value_or_zero(path));
    let is_kinked = model.effect("clamp_compliance").is_none() && is_kinked(base, angle);
    *out += "\n[release]\n";
    let is_straight = matches!(run.initial, Initial::Straight);
    // No scenario says that a rod starts straight beside its clamp, as it may in a fit. Two points say it.
    if !(is_straight && is_kinked) && (is_straight || angle != base || rate != 0.0) {
        put(out, "angle", si(angle, "rad"));
        put(out, "angular_velocity", si(rate, "rad/s"));
    }
    let of_posture = |posture: &Posture<f64>| {
        let point = |(&position, &velocity)| CurvePoint { position, velocity };
        posture.nodes.iter().zip(&posture.velocities).map(point).collect::<Vec<_>>()
    };
    match &run.initial {
        Initial::Straight if is_kinked => {
            points(out, &of_posture(&Posture::straight(1, model.rod().length, angle, rate)));
        }
        Initial::Straight => {}
        Initial::Equilibrium { .. } => put(out, "from", quoted("equilibrium")),
        Initial::Curve(curve) => points(out, curve),
        Initial::Posture(posture) => points(out, &of_posture(posture)),
    }
    if let Some(History { hung, raised, held }) = run.history {
        let [hung, raised, held] = [hung, raised, held].map(|time| si(time, "s"));
        put(out, "history", format!("{{ hung = {hung}, raised = {raised}, held = {held} }}"));
    }
    if let Initial::Equilibrium { hold, own } = &run.initial {
        parameters(out, "release.hold.", hold, own);
    }
}

fn points(out: &mut String, curve: &[CurvePoint]) {
    *out += "nodes = [\n";
    for CurvePoint { position: [x, z], velocity: [vx, vz] } in curve {
        let row = [si(*x, "m"), si(*z, "m"), si(*vx, "m/s"), si(*vz, "m/s")].join(", ");
        let _ = writeln!(out, "  [{row}],");
    }
    *out += "]\n";
}

fn effects(out: &mut String, model: &Model) {
    let all: Vec<_> = model.effects.iter().flat_map(|active| active.theta.clone()).collect();
    parameters(out, "", model, &all);
    for text in model.effects.iter().filter_map(|active| active.effect.text()) {
        *out += "\n";
        *out += text;
    }
}

/// With a pressure that changes the model needs the muscle itself.
fn muscle(out: &mut String, plan: &Plan) {
    let Some(muscle) = &plan.muscle else { return };
    let Pressure::Schedule(rows) = &muscle.pressure else { return };
    *out += "\n[muscle]\n";
    *out += "pressure = [\n";
    for (time, pressure) in rows {
        let _ = writeln!(out, "  [{}, {}],", si(*time, "s"), si(*pressure, "Pa"));
    }
    *out += "]\n";
    put(out, "stiffness", quoted(&muscle.stiffness));
    let allowed = muscle.extrapolation == Extrapolation::Allowed;
    put(out, "extrapolation", quoted(if allowed { "allowed" } else { "refused" }));
    let conserved = muscle.mass == MassPlan::Conserved;
    put(out, "mass", quoted(if conserved { "conserved" } else { "per_length" }));
    put(out, "text", quoted(&muscle.text));
}

/// Parameters of a model, table by table; all belong to tables behind one another in `theta`.
fn parameters(out: &mut String, prefix: &str, model: &Model, which: &[usize]) {
    let mut open = String::new();
    for k in which {
        let parameter = &model.parameters[*k];
        let (table, key) = parameter.path.rsplit_once('.').unwrap_or_default();
        if table != open {
            let _ = write!(out, "\n[{prefix}{table}]\n");
            open = table.to_owned();
        }
        put(out, key, si(model.theta[*k], parameter.unit));
    }
}

fn put(out: &mut String, key: &str, value: impl std::fmt::Display) {
    let _ = writeln!(out, "{key} = {value}");
}

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

/// A number that is read back to the same bits: the shortest that does, in a unit of scale 1.
fn si(value: f64, unit: &str) -> String {
    if unit.is_empty() { format!("{value:?}") } else { format!("\"{value:?} {unit}\"") }
}

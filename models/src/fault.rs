//! Which law is to blame where a model cannot be evaluated, or changes too fast to be followed.

use std::fmt;

use num_dual::Dual64;

use crate::assembly::{Acting, Assembly};
use crate::effects::{Mass, MassLoad, Place, Scalar, TipLoad, bend_at, edge_at, flow_at};
use crate::model::{Active, Model};
use crate::quantity::format_si;
use crate::system::System;
use crate::written::names::{self, OUTPUTS, out};

/// A law that gives no number, or none that changes smoothly.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// The formula or the effect, such as `laws.my_drag.force`.
    pub law: String,
    /// Where it was evaluated, in words; empty for the clamp.
    pub place: String,
    /// When, s after release.
    pub time: f64,
    /// What it sees there and its parameters, in words.
    pub values: String,
    /// Whether it is the slope alone that is no number.
    pub is_slope: bool,
    /// Whether it is a law as text.
    pub is_written: bool,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let what = if self.is_slope { "has no finite slope" } else { "is not a finite number" };
        let Fault { law, place, time, values, .. } = self;
        let next = if self.is_written {
            "change the formula, or the range of its parameters, so that it is finite there"
        } else {
            "try smaller values of its parameters, or a smaller step"
        };
        write!(f, "{law} {what}{place} at t = {time:.4} s, where {values}; {next}")
    }
}

/// The state at which a law is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct At<'a> {
    /// Time after release, s.
    pub time: f64,
    /// Coordinates.
    pub q: &'a [f64],
    /// Their rates.
    pub v: &'a [f64],
    /// Memory.
    pub z: &'a [f64],
}

type Values = Vec<(&'static str, f64, &'static str)>;

/// What one law gives at one point: its formula's place among [`OUTPUTS`], the value with a slope, the point in words,
/// and what it sees.
type Given = (usize, Dual64, String, Values);

/// Finds the first point at which a law is not finite, in an assembly that was placed at `q` and with memory `z`.
type Find = fn(&mut Assembly<Dual64>, &Active, q: &[Dual64], z: &[Dual64]) -> Option<Given>;

/// The first law that is not finite in a state, by its value or by its slopes; none where what laws see is not finite
/// itself.
pub fn find(model: &Model, at: At) -> Option<Fault> {
    let theta = model.theta.iter().map(|value| Dual64::from(*value)).collect();
    let mut assembly = Assembly::new(model, theta, Acting::new(model));
    // Slopes along a direction in which every strain and rate changes.
    let lift = |values: &[f64], phase: f64| -> Vec<Dual64> {
        let slope = |k: usize| ((k * k) as f64 * 0.7 + phase).sin();
        values.iter().enumerate().map(|(k, value)| Dual64::new(*value, slope(k))).collect()
    };
    let (q, v, z) = (lift(at.q, 0.3), lift(at.v, 1.1), lift(at.z, 2.0));
    assembly.place(model, Dual64::from(at.time).derivative(), &q, &v);
    let acting = assembly.acting.clone();
    let mut first = |list: &[usize], find: Find| {
        list.iter().find_map(|k| {
            let active = &model.effects[*k];
            let given = find(&mut assembly, active, &q, &z)?;
            // Otherwise the state is at fault.
            let sees_numbers = given.3.iter().all(|(_, value, _)| value.is_finite());
            sees_numbers.then(|| fault(model, active, at.time, given))
        })
    };
    // A compliance that is no number leaves no curvature that is one.
    if let Some(fault) = first(&acting.clamp, of_clamp) {
        return Some(fault);
    }
    let places: [(&[usize], Find); 5] = [
        (&acting.bend, of_bends),
        (&acting.edge, of_edges),
        (&acting.flow, of_flows),
        (&acting.mass, of_mass),
        (&acting.tip, of_tip),
    ];
    places.into_iter().find_map(|(list, find)| first(list, find))
}

fn is_finite(x: &Dual64) -> bool {
    x.re.is_finite() && x.eps.is_finite()
}

fn of_bends(assembly: &mut Assembly<Dual64>, active: &Active, _: &[Dual64], z: &[Dual64]) -> Option<Given> {
    let z = &z[active.memory.clone()];
    let Assembly { context: c, fields: f, .. } = assembly;
    f.moment.fill(0.0.into());
    let mut rate = vec![Dual64::from(0.0); z.len()];
    Dual64::laws(active.effect).add_moments(c, &c.theta[active.theta.clone()], f, z, &mut rate);
    let bends = c.edges + 1;
    let moment = f.moment.iter().position(|x| !is_finite(x)).map(|i| (out::MOMENT, i, f.moment[i]));
    let memory = || rate.iter().position(|x| !is_finite(x)).map(|i| (out::MEMORY, i, rate[i]));
    let (output, i, value) = moment.or_else(memory)?;
    let here = bend_at(c, f, i % bends, i / bends, z);
    let seen = seen(Place::Bend, active, |k| names::of_bend(&here, k));
    Some((output, value, format!(" at bend {} of {bends}", i % bends + 1), seen))
}

fn of_edges(assembly: &mut Assembly<Dual64>, active: &Active, _: &[Dual64], _: &[Dual64]) -> Option<Given> {
    let Assembly { context: c, fields: f, .. } = assembly;
    f.tension.fill(0.0.into());
    Dual64::laws(active.effect).add_tensions(c, &c.theta[active.theta.clone()], f);
    let j = f.tension.iter().position(|x| !is_finite(x))?;
    let here = edge_at(c, f, j);
    let seen = seen(Place::Edge, active, |k| names::of_edge(&here, k));
    Some((out::TENSION, f.tension[j], format!(" at edge {} of {}", j + 1, c.edges), seen))
}

fn of_flows(assembly: &mut Assembly<Dual64>, active: &Active, _: &[Dual64], _: &[Dual64]) -> Option<Given> {
    let Assembly { context: c, fields: f, .. } = assembly;
    (0..c.edges).find_map(|j| {
        let here = flow_at(c, f, j);
        let [along, across] = Dual64::laws(active.effect).flow(&here, &c.theta[active.theta.clone()]);
        let (output, value) = not_finite([(out::FORCE_ALONG, along), (out::FORCE, across)])?;
        let seen = seen(Place::Flow, active, |k| names::of_flow(&here, k));
        Some((output, value, format!(" at edge {} of {}", j + 1, c.edges), seen))
    })
}

fn of_mass(assembly: &mut Assembly<Dual64>, active: &Active, _: &[Dual64], _: &[Dual64]) -> Option<Given> {
    let c = &assembly.context;
    let here = Mass { time: c.time, rod: &c.rod };
    let theta = &c.theta[active.theta.clone()];
    let MassLoad { acceleration: [x, z], rate } = Dual64::laws(active.effect).mass(&here, theta);
    let all = [(out::DECAY, rate), (out::ACCELERATION_X, x), (out::ACCELERATION_Z, z)];
    let (output, value) = not_finite(all)?;
    Some((output, value, String::new(), seen(Place::Mass, active, |k| names::of_mass(&here, k))))
}

fn of_tip(assembly: &mut Assembly<Dual64>, active: &Active, q: &[Dual64], _: &[Dual64]) -> Option<Given> {
    let here = assembly.tip(q[2 * assembly.context.edges]);
    let theta = &assembly.context.theta[active.theta.clone()];
    let TipLoad { force: [x, z], moment } = Dual64::laws(active.effect).tip(&here, theta);
    let all = [(out::FORCE_X, x), (out::FORCE_Z, z), (out::TIP_MOMENT, moment)];
    let (output, value) = not_finite(all)?;
    let seen = seen(Place::Tip, active, |k| names::of_tip(&here, k));
    Some((output, value, " at the tip".to_owned(), seen))
}

fn of_clamp(assembly: &mut Assembly<Dual64>, active: &Active, _: &[Dual64], _: &[Dual64]) -> Option<Given> {
    let value = Dual64::laws(active.effect).clamp(&assembly.context.theta[active.theta.clone()]);
    (!is_finite(&value)).then(|| (out::COMPLIANCE, value, " at the clamp".to_owned(), Vec::new()))
}

fn not_finite<const N: usize>(all: [(usize, Dual64); N]) -> Option<(usize, Dual64)> {
    all.into_iter().find(|(_, value)| !is_finite(value))
}

/// What a law sees at a place alone, and the time if it depends on that.
fn seen(place: Place, active: &Active, value: impl Fn(u8) -> Dual64) -> Values {
    let about = active.effect.about();
    names::names(place)
        .filter(|(k, name)| match name.name {
            "time" => about.timed,
            names::MEMORY => about.memory > 0,
            names::MEAN_SQUARE => about.places.contains(&Place::Whole),
            _ => usize::from(*k) < names::FIRST_COMMON,
        })
        .map(|(k, name)| (name.name, value(k).re, name.unit))
        .collect()
}

fn fault(model: &Model, active: &Active, time: f64, (output, value, place, mut values): Given) -> Fault {
    let about = active.effect.about();
    let is_written = active.effect.text().is_some();
    let law = if is_written {
        format!("laws.{}.{}", about.name, OUTPUTS[output].key)
    } else {
        format!("effects.{}", about.name)
    };
    let theta = &model.theta[active.theta.clone()];
    values.extend(about.parameters.iter().zip(theta).map(|(own, value)| (own.name, *value, own.unit)));
    let words = values.iter().map(|(name, value, unit)| format!("{name} = {}", format_si(*value, unit)));
    let values = words.collect::<Vec<_>>().join(", ");
    Fault { law, place, time, values, is_slope: value.re.is_finite(), is_written }
}

/// The effect whose force on the rod changes most from one state to another, each force as the acceleration of what it
/// acts on.
pub fn fastest(model: &Model, before: At, after: At) -> Option<&'static str> {
    let mut system = System::new(model);
    let mut change = |k: usize| {
        system.assembly.acting = Acting::only(model, k);
        let mut force = |At { time, q, v, z }: At| {
            let (mut force, mut rate) = (vec![0.0; q.len()], vec![0.0; z.len()]);
            system.force(time, q, v, z, &mut force, &mut rate);
            force
        };
        let (before, after) = (force(before), force(after));
        let pairs = before.iter().zip(&after).zip(&system.mass);
        pairs.map(|((before, after), mass)| (after - before).powi(2) / mass).sum::<f64>()
    };
    let changes = (0..model.effects.len()).map(|k| (k, change(k)));
    let (k, change) = changes.max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    (change > 0.0).then(|| model.effects[k].effect.about().name)
}

/// The model with one of its effects alone, beside those that only make the shape and the masses of the rod.
pub fn alone(model: &Model, effect: usize) -> Model {
    let mut alone = model.clone();
    let mut k = 0;
    alone.effects.retain(|active| {
        let places = active.effect.about().places;
        let is_shape =
            places.iter().all(|place| matches!(place, Place::Body | Place::Inertia | Place::Clamp));
        k += 1;
        k - 1 == effect || is_shape
    });
    alone
}

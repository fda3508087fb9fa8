//! Observed points: from coordinates to what a recording shows of the rod.
//!
//! Between the two act the effects on what is observed (`models::sensor`). They move no rod, so
//! their sensitivities are algebra at each sample, and take no part in the integration.

use models::effects::{LANES, Lanes, Real, Sight};
use models::lanes::{Moving, seeded, slopes, with_slopes};
use models::model::Model;
use models::posture::Between;
use models::sensor::Sensor;
use models::system::System;

use crate::integrate::State;
use crate::integrate::variational::{Variational, lane_order};
use crate::point::Point;
use crate::run::Run;
use crate::trajectory::Trajectory;

/// What a run observes, and how: from states to the entries of a [`Trajectory`].
pub(crate) struct Observer {
    points: Vec<Observed>,
    /// Whether a recording shows the tip elsewhere than it is.
    sees_tip: bool,
    sensor: Sensor<Moving>,
    /// With derivatives, one entry a group of [`LANES`] parameters: first the groups that are
    /// integrated, then those that change only what is observed.
    sensors: Vec<Sensor<Lanes>>,
    /// Lane of each parameter of [`Run::sensitivities`], counted over all groups.
    lanes: Vec<usize>,
    /// Times of the samples by the clock of the recording and since release, s, and which is next.
    recorded: Vec<f64>,
    instants: Vec<f64>,
    next: usize,
    row: Vec<[f64; LANES]>,
}

impl Observer {
    pub fn new(model: &Model, run: &Run) -> Self {
        let sensor = Sensor::new(model, model.theta.iter().map(|value| Moving::from(*value)).collect());
        let instant = |recorded: &f64| sensor.instant(Moving::from(*recorded)).re.max(0.0);
        let order = lane_order(model, &run.sensitivities);
        let of_sensor = run.sensitivities.iter().copied().filter(|k| model.is_of_sensor(*k));
        let algebraic: Vec<usize> = of_sensor.collect();
        let groups: Vec<&[usize]> = order.chunks(LANES).chain(algebraic.chunks(LANES)).collect();
        let watched = |group: &&[usize]| -> Sensor<Lanes> {
            let watched: Vec<_> = group.iter().map(|k| Some(*k)).collect();
            Sensor::new(model, seeded(&model.theta, &watched))
        };
        let lane = |k: &usize| {
            let of_group = |group: &&[usize]| group.iter().position(|other| other == k);
            let found = groups.iter().enumerate().find_map(|(g, group)| Some(g * LANES + of_group(group)?));
            found.expect("each parameter is integrated or algebraic")
        };
        let has_points = !run.points.is_empty() || model.has_sensor();
        let recorded = if run.keep_samples && has_points { run.samples.clone() } else { Vec::new() };
        Self {
            points: run.points.iter().map(|point| Observed::new(*point, model.edges)).collect(),
            sees_tip: model.has_sensor(),
            sensors: groups.iter().map(watched).collect(),
            lanes: run.sensitivities.iter().map(lane).collect(),
            instants: recorded.iter().map(instant).collect(),
            recorded,
            next: 0,
            row: vec![[0.0; LANES]; model.dof()],
            sensor,
        }
    }

    /// Time since release, s, of what the last sample sees; zero if there is nothing to see.
    pub fn end(&self) -> f64 {
        self.instants.last().copied().unwrap_or(0.0)
    }

    /// Time since release, s, of the next sample of the points, if it lies before `end`.
    pub fn due(&self, end: f64) -> Option<f64> {
        self.instants.get(self.next).copied().filter(|instant| *instant <= end)
    }

    /// Sees the points at the sample that is due, from the state at that time.
    pub fn see(
        &mut self,
        system: &System,
        variational: Option<&Variational>,
        state: &State,
        step: [f64; 2],
        into: &mut Trajectory,
    ) {
        let State { q, v, .. } = state;
        let recorded = self.recorded[self.next];
        // Before the release the rod is held: nothing moves with the instant.
        let held = |instant: f64| if instant < 0.0 { 0.0 } else { 1.0 };
        let instant = self.sensor.instant(Moving::from(recorded).derivative());
        let pace = held(instant.re) * instant.eps;
        let body = &system.assembly.context.body;
        let center = [body.center_of_mass, body.offset];
        let arm = center.map(Moving::from);
        let moving = |k: usize| Moving::new(q[k], v[k] * pace);
        let seen = |point: &Observed| self.sensor.see(point.sight(&system.model, arm, &moving));
        if self.sees_tip {
            into.seen_tip.push(seen(&Observed::Tip).map(|x| x.re));
        }
        if !self.points.is_empty() {
            let all: Vec<_> = self.points.iter().map(seen).collect();
            into.points.push(all.iter().map(|x| x.map(|x| x.re)).collect());
            into.point_velocities.push(all.iter().map(|x| x.map(|x| x.eps)).collect());
        }
        self.next += 1;
        if self.lanes.is_empty() || self.points.is_empty() {
            return;
        }
        let mut of_points = vec![Vec::with_capacity(self.sensors.len() * LANES); self.points.len()];
        for (group, sensor) in self.sensors.iter().enumerate() {
            let integrated = variational.filter(|variational| group < variational.slopes.len());
            let arm = match integrated {
                Some(variational) => {
                    variational.interpolate(group, step, state.time, 0, &mut self.row);
                    let body = &variational.system().watched(group).body;
                    [body.center_of_mass, body.offset]
                }
                None => {
                    self.row.fill([0.0; LANES]);
                    center.map(Lanes::from)
                }
            };
            let instant = sensor.instant(Lanes::from(recorded));
            let later = (instant - instant.re) * held(instant.re);
            let moved = |k: usize| with_slopes(q[k], self.row[k]) + later * v[k];
            for (point, of_point) in self.points.iter().zip(&mut of_points) {
                let [x, z] = sensor.see(point.sight(&system.model, arm, &moved)).map(|x| slopes(&x));
                of_point.extend(x.into_iter().zip(z).map(|(x, z)| [x, z]));
            }
        }
        into.points_by_parameters.push(of_points.iter().map(|of_point| self.in_order(of_point)).collect());
    }

    /// Derivatives of the tip itself, at a state within the last step.
    pub fn tip_by_parameters(
        &mut self,
        variational: Option<&Variational>,
        state: &State,
        step: [f64; 2],
    ) -> Vec<[f64; 2]> {
        let mut of_tip = Vec::with_capacity(self.sensors.len() * LANES);
        if let Some(variational) = variational {
            let first = state.q.len() - 3; // it hangs on the end body alone
            for group in 0..variational.slopes.len() {
                variational.interpolate(group, step, state.time, first, &mut self.row);
                let moved = |k: usize| with_slopes(state.q[k], self.row[k]);
                let system = variational.system();
                let body = &system.watched(group).body;
                let arm = [body.center_of_mass, body.offset];
                let [x, z] = Observed::Tip.sight(&system.model, arm, &moved).position.map(|x| slopes(&x));
                of_tip.extend(x.into_iter().zip(z).map(|(x, z)| [x, z]));
            }
        }
        // What is only observed moves no tip.
        of_tip.resize(self.sensors.len() * LANES, [0.0; 2]);
        self.in_order(&of_tip)
    }

    /// Whether derivatives are requested.
    pub fn is_differentiated(&self) -> bool {
        !self.lanes.is_empty()
    }

    fn in_order(&self, slopes: &[[f64; 2]]) -> Vec<[f64; 2]> {
        self.lanes.iter().map(|lane| slopes[*lane]).collect()
    }
}

/// An observed point in the coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Observed {
    /// The observed tip.
    Tip,
    /// Between nodes.
    Along {
        /// Place along the rod.
        share: f64,
        /// The same among the nodes.
        between: Between,
    },
}

impl Observed {
    /// A point of a rod of so many edges, three at least.
    pub fn new(point: Point, edges: usize) -> Self {
        match point {
            Point::Tip => Observed::Tip,
            Point::Along(share) => {
                let share = share.clamp(0.0, 1.0);
                Observed::Along { share, between: Between::of(share, edges) }
            }
        }
    }

    /// Where it is and how the rod runs there, with coordinates `q` and the centre of mass of the end
    /// body at `arm` along and across its axis from the last node, m.
    fn sight<T: Real>(&self, model: &Model, arm: [T; 2], q: &impl Fn(usize) -> T) -> Sight<T> {
        let last = 2 * model.edges;
        let axis = || [q(last).cos(), q(last).sin()];
        let on_body = |beyond: T, [x, z]: [T; 2]| {
            let [along, across] = [beyond - arm[0], -arm[1]];
            [q(last - 2) + x * along - z * across, q(last - 1) + z * along + x * across]
        };
        match self {
            Observed::Tip => {
                let tangent = axis();
                let position = on_body(T::from(model.tip_distance), tangent);
                Sight { position, tangent, share: 1.0, is_tip: true }
            }
            Observed::Along { share, between: Between { first, weights, slopes } } => {
                let zero = T::from(0.0);
                let (mut position, mut along) = ([zero; 2], [zero; 2]);
                for (node, (weight, slope)) in (*first..).zip(weights.iter().zip(slopes)) {
                    let x = match node {
                        0 => continue,
                        node if node == model.edges => on_body(zero, axis()),
                        node => [0, 1].map(|k| q(2 * node - 2 + k)),
                    };
                    for k in 0..2 {
                        position[k] += x[k] * *weight;
                        along[k] += x[k] * *slope;
                    }
                }
                let per_length = (along[0] * along[0] + along[1] * along[1]).sqrt().recip();
                Sight { position, tangent: along.map(|x| x * per_length), share: *share, is_tip: false }
            }
        }
    }
}

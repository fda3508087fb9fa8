//! Forces and energies of a state: kinematics and laws of one model, over a scalar that may carry derivatives.

use crate::context::Context;
use crate::effects::{Body, Effect, Kind, LineMass, Mass, MassLoad, Place, Rod, Scalar, Tip};
use crate::kinematics::Fields;
use crate::line::Through;
use crate::model::{
    AXIAL_STIFFNESS, Active, BASE_ANGLE, BENDING_STIFFNESS, DIAMETER, LENGTH, MASS, Model, PRESSURE,
};
use crate::plane::cross;
use crate::stencil::Stencil;

impl<T: Scalar> Context<T> {
    pub(crate) fn new(model: &Model, theta: Vec<T>) -> Self {
        let zero = T::from(0.0);
        let edges = model.edges;
        let per_edges = 1.0 / edges as f64;
        let rod = Rod {
            length: theta[LENGTH],
            mass: theta[MASS],
            bending_stiffness: theta[BENDING_STIFFNESS],
            axial_stiffness: theta[AXIAL_STIFFNESS],
            diameter: theta[DIAMETER],
            pressure: theta[PRESSURE],
        };
        let LineMass { inert, heavy } = beside_the_rod(model, &rod, &theta);
        let weightless_mass = (inert - heavy) * rod.length * per_edges;
        let node_mass = theta[MASS] * per_edges + inert * rod.length * per_edges;
        let base = theta[BASE_ANGLE];
        let stencil = Stencil::new(model.scheme, edges);
        let half_cell = half_cell(&stencil, node_mass, theta[LENGTH] * per_edges);
        let bodies = bodies(model, &theta);
        let fixed = together(&bodies);
        let weightless = Body { mass: weightless_mass * 0.5, ..half_cell };
        let weightless_body = bodies.iter().map(|body| Body { mass: body.mass - body.heavy, ..*body });
        let mut context = Self {
            edges,
            per_edges,
            time: zero,
            rod,
            base_axis: [base.cos(), base.sin()],
            body: together(&[half_cell, fixed]),
            fixed,
            node_mass,
            weightless_mass,
            weightless_body: together(&[weightless].into_iter().chain(weightless_body).collect::<Vec<_>>()),
            rest_length: zero,
            rest_rate: zero,
            per_rest_length: zero,
            per_voronoi: vec![zero; edges + 1],
            stencil,
            line: Through::new(model, &theta),
            theta,
        };
        context.set_time(model, zero, None);
        context
    }

    /// Lets the rod follow its schedule, on the piece of it in which `since` lies; at rest, with none.
    pub(crate) fn set_time(&mut self, model: &Model, time: T, since: Option<f64>) {
        self.time = time;
        self.rest_rate = T::from(0.0);
        if let Some(schedule) = &model.schedule {
            let now = time.re();
            let piece = since.unwrap_or(now);
            let ([length, bending, axial, diameter], length_rate, change) = if let Some(line) = &self.line {
                let [pressure, rate] = line.at(model, &self.theta, time, piece);
                let off = pressure - pressure.re();
                let relative = schedule.relative(pressure.re()).expect("a line has a command");
                let [_, slope, curve] = relative[0];
                let along = |[value, slope, _]: [f64; 3]| off * slope + value;
                (relative.map(along), (off * curve + slope) * rate, pressure)
            } else {
                let factors = schedule.factors(now, piece);
                let (change, rate) = schedule.pressure_change(now, piece);
                let [_, first, second] = factors[0];
                let along = |[value, rate, _]: [f64; 3]| T::from(value) + (time - now) * rate;
                (factors.map(along), (time - now) * second + first, (time - now) * rate + change)
            };
            self.rod.length = self.theta[LENGTH] * length;
            self.rod.bending_stiffness = self.theta[BENDING_STIFFNESS] * bending;
            self.rod.axial_stiffness = self.theta[AXIAL_STIFFNESS] * axial;
            self.rod.diameter = self.theta[DIAMETER] * diameter;
            self.rod.pressure = self.theta[PRESSURE] + change;
            if since.is_some() {
                self.rest_rate = length_rate / length;
            }
        }
        self.rest_length = self.rod.length * self.per_edges;
        self.per_rest_length = self.rest_length.recip();
        for (bend, per) in self.per_voronoi.iter_mut().enumerate() {
            *per = self.per_rest_length / self.stencil.weight(bend);
        }
        let mut compliance = T::from(0.0);
        for active in at(model, Place::Clamp) {
            compliance += T::laws(active.effect).clamp(&self.theta[active.theta.clone()]);
        }
        self.stencil.set_clamp(compliance, self.rod.bending_stiffness, self.rest_length);
    }

    /// Diagonal of the mass matrix, kg and, for the angle of the end body, kg m².
    pub fn mass(&self) -> Vec<T> {
        let mut mass = vec![self.node_mass; 2 * self.edges + 1];
        mass[2 * self.edges - 2] = self.body.mass;
        mass[2 * self.edges - 1] = self.body.mass;
        mass[2 * self.edges] = self.body.rotary_inertia;
        mass
    }
}

/// The rod's last half cell, a thin rod that turns with the end body; of the edge length at release, whatever the
/// pressure does to it later.
fn half_cell<T: Scalar>(stencil: &Stencil<T>, node_mass: T, rest_length: T) -> Body<T> {
    let mass = node_mass * 0.5;
    let before = rest_length * stencil.last_half_cell();
    let about_node = mass * rest_length * rest_length / 12.0;
    let offset = T::from(0.0);
    Body {
        mass,
        heavy: mass,
        center_of_mass: -before,
        offset,
        rotary_inertia: about_node - mass * before * before,
    }
}

/// End fitting, payload and their like.
fn bodies<T: Scalar>(model: &Model, theta: &[T]) -> Vec<Body<T>> {
    let mut bodies = Vec::new();
    let mut shift = T::from(0.0);
    for active in at(model, Place::Body) {
        let effect = T::laws(active.effect);
        bodies.push(effect.body(&theta[active.theta.clone()]));
        shift += effect.shift(&theta[active.theta.clone()]);
    }
    bodies.iter_mut().for_each(|body| body.center_of_mass += shift);
    bodies
}

/// Rigid bodies as one; without any mass its centre lies at the end of the active length.
fn together<T: Scalar>(bodies: &[Body<T>]) -> Body<T> {
    let sum = |of: &dyn Fn(&Body<T>) -> T| bodies.iter().fold(T::from(0.0), |sum, body| sum + of(body));
    let mass = sum(&|body| body.mass);
    let mean = |of: &dyn Fn(&Body<T>) -> T| {
        let moment = sum(&|body| body.mass * of(body));
        if mass.re() > 0.0 { moment / mass } else { T::from(0.0) }
    };
    let (center_of_mass, offset) = (mean(&|body| body.center_of_mass), mean(&|body| body.offset));
    let rotary_inertia = sum(&|body| {
        let (along, across) = (body.center_of_mass - center_of_mass, body.offset - offset);
        body.rotary_inertia + body.mass * (along * along + across * across)
    });
    Body { mass, heavy: sum(&|body| body.heavy), center_of_mass, offset, rotary_inertia }
}

/// Mass per length beside the rod's own.
fn beside_the_rod<T: Scalar>(model: &Model, at_release: &Rod<T>, theta: &[T]) -> LineMass<T> {
    let zero = T::from(0.0);
    at(model, Place::Inertia).fold(LineMass { inert: zero, heavy: zero }, |sum, active| {
        let own = T::laws(active.effect).inertia(at_release, &theta[active.theta.clone()]);
        LineMass { inert: sum.inert + own.inert, heavy: sum.heavy + own.heavy }
    })
}

/// All effects of a place, at off or not.
fn at(model: &Model, place: Place) -> impl Iterator<Item = &Active> {
    model.effects.iter().filter(move |active| active.effect.about().places.contains(&place))
}

/// Which effects act where.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Acting {
    pub bend: Vec<usize>,
    pub whole: Vec<usize>,
    pub edge: Vec<usize>,
    pub flow: Vec<usize>,
    pub mass: Vec<usize>,
    pub tip: Vec<usize>,
    pub clamp: Vec<usize>,
}

impl Acting {
    pub(crate) fn new(model: &Model) -> Self {
        Self::of(model, &[])
    }

    /// What makes forces that move with the watched parameters. One that is of a law alone moves those of its own effect;
    /// any other moves all, but for those of an effect that is off.
    pub(crate) fn watching(model: &Model, watched: &[Option<usize>]) -> Self {
        let watched: Vec<usize> = watched.iter().copied().flatten().collect();
        let is_own = |k: usize| watched.iter().any(|own| model.effects[k].theta.contains(own));
        let others_move = !watched.iter().all(|own| model.is_of_law(*own));
        let mut all = Self::of(model, &watched);
        all.retain(|k| is_own(k) || (others_move && !model.is_off(&model.effects[k])));
        all
    }

    fn of(model: &Model, watched: &[usize]) -> Self {
        let at = |place| model.acting(place, watched);
        Self {
            bend: at(Place::Bend),
            whole: at(Place::Whole),
            edge: at(Place::Edge),
            flow: at(Place::Flow),
            mass: at(Place::Mass),
            tip: at(Place::Tip),
            clamp: at(Place::Clamp),
        }
    }

    pub(crate) fn only(model: &Model, k: usize) -> Self {
        let mut all = Self::new(model);
        all.retain(|other| other == k);
        all
    }

    fn retain(&mut self, keeps: impl Fn(usize) -> bool) {
        let Self { bend, whole, edge, flow, mass, tip, clamp } = self;
        for list in [bend, whole, edge, flow, mass, tip, clamp] {
            list.retain(|k| keeps(*k));
        }
    }
}

/// Kinematics and laws over one scalar.
#[derive(Clone, Debug)]
pub struct Assembly<T> {
    /// Parameters as the laws see them.
    pub context: Context<T>,
    /// Posture, and what the laws say of it.
    pub fields: Fields<T>,
    /// Share of the loads with mass and at the tip that acts: 1, except while statics puts them on.
    pub(crate) load_share: f64,
    /// Whether the rod is looked at as if its pressure stayed: statics.
    pub(crate) stands_still: bool,
    /// A time of the piece of the schedule that the rod follows; none: that of the evaluation.
    pub(crate) since: Option<f64>,
    pub(crate) acting: Acting,
}

impl<T: Scalar> Assembly<T> {
    pub(crate) fn new(model: &Model, theta: Vec<T>, acting: Acting) -> Self {
        Self {
            context: Context::new(model, theta),
            fields: Fields::new(model.edges),
            load_share: 1.0,
            stands_still: false,
            since: None,
            acting,
        }
    }

    /// Puts the rod at a state.
    pub fn place(&mut self, model: &Model, time: T, q: &[T], v: &[T]) {
        if model.schedule.is_some() {
            let since = self.since.unwrap_or(time.re());
            self.context.set_time(model, time, (!self.stands_still).then_some(since));
        }
        self.context.time = time;
        self.fields.place(&self.context, q, v);
        if !self.acting.whole.is_empty() {
            self.fields.average(&self.context);
        }
    }

    /// The last node and the end body at its angle, rad, as laws at the tip see them.
    pub fn tip(&self, angle: T) -> Tip<'_, T> {
        let n = self.context.edges;
        Tip {
            position: self.fields.position[n],
            velocity: self.fields.velocity[n],
            angle,
            angular_velocity: self.fields.body_rate,
            center: [self.context.fixed.center_of_mass, self.context.fixed.offset],
            time: self.context.time,
            rod: &self.context.rod,
        }
    }

    /// How much of an effect acts.
    pub(crate) fn share(&self, effect: &dyn Effect) -> f64 {
        if effect.about().kind == Kind::Load { self.load_share } else { 1.0 }
    }

    /// Force that bears the weight of what has none in the end body, N, and where it acts, from the last node, m.
    pub(crate) fn borne_at_the_end(&self) -> ([T; 2], [T; 2]) {
        let weightless = &self.context.weightless_body;
        let force = self.fields.acceleration.map(|acceleration| -acceleration * weightless.mass);
        (force, weightless.arm(self.fields.body_axis))
    }

    pub(crate) fn add_loads(&mut self, model: &Model, angle: T) {
        for &k in &self.acting.mass {
            let active = &model.effects[k];
            let share = self.share(active.effect);
            let effect = T::laws(active.effect);
            let c = &self.context;
            let at = Mass { time: c.time, rod: &c.rod };
            let MassLoad { acceleration, rate } = effect.mass(&at, &c.theta[active.theta.clone()]);
            self.fields.acceleration[0] += acceleration[0] * share;
            self.fields.acceleration[1] += acceleration[1] * share;
            self.fields.decay_rate += rate;
        }
        let (borne, arm) = self.borne_at_the_end();
        self.fields.tip[2] += cross(arm, borne);
        for k in 0..2 {
            self.fields.tip[k] += borne[k];
        }
        for &k in &self.acting.tip {
            let active = &model.effects[k];
            let share = self.share(active.effect);
            let effect = T::laws(active.effect);
            let load = effect.tip(&self.tip(angle), &self.context.theta[active.theta.clone()]);
            self.fields.tip[0] += load.force[0] * share;
            self.fields.tip[1] += load.force[1] * share;
            self.fields.tip[2] += load.moment * share;
        }
    }

    /// Generalised forces, shape `[2N+1]`, and rates of the memory at a state.
    #[expect(clippy::too_many_arguments, reason = "a state and its two rates")]
    pub fn force(
        &mut self,
        model: &Model,
        time: T,
        q: &[T],
        v: &[T],
        z: &[T],
        force: &mut [T],
        z_rate: &mut [T],
    ) {
        self.place(model, time, q, v);
        self.add_laws(model, q[2 * model.edges], z, z_rate);
        self.fields.resist(&self.context, !self.acting.clamp.is_empty());
        self.fields.gather(&self.context, v, force);
    }

    /// Adds what the laws say where the rod [was put](Self::place), with the end body at an angle, rad.
    pub(crate) fn add_laws(&mut self, model: &Model, angle: T, z: &[T], z_rate: &mut [T]) {
        self.add_stresses(model, z, z_rate);
        let Self { context: c, fields: f, acting, .. } = self;
        for &k in &acting.flow {
            let active = &model.effects[k];
            let effect = T::laws(active.effect);
            effect.add_flows(c, &c.theta[active.theta.clone()], f);
        }
        self.add_loads(model, angle);
    }

    /// Adds moments and tensions alone, and writes the rates of memories.
    fn add_stresses(&mut self, model: &Model, z: &[T], z_rate: &mut [T]) {
        let Self { context: c, fields: f, acting, .. } = self;
        for &k in &acting.bend {
            let active = &model.effects[k];
            let effect = T::laws(active.effect);
            let own = active.memory.clone();
            effect.add_moments(c, &c.theta[active.theta.clone()], f, &z[own.clone()], &mut z_rate[own]);
        }
        for &k in &acting.edge {
            let active = &model.effects[k];
            let effect = T::laws(active.effect);
            effect.add_tensions(c, &c.theta[active.theta.clone()], f);
        }
    }

    /// Bending moment at the root at a state, N m.
    pub(crate) fn root_moment(&mut self, model: &Model, time: T, q: &[T], v: &[T], z: &[T]) -> T {
        self.place(model, time, q, v);
        self.add_stresses(model, z, &mut z.to_vec());
        self.fields.resist(&self.context, !self.acting.clamp.is_empty());
        self.fields.bending_moment(0)
    }

    /// Stored energy of all effects and of weight at a state, J: `(elastic, potential)`.
    pub fn energy(&mut self, model: &Model, time: T, q: &[T], v: &[T], z: &[T]) -> (T, T) {
        self.place(model, time, q, v);
        self.energy_here(model, q, z)
    }

    /// Stored energy where the rod [was put](Self::place).
    pub(crate) fn energy_here(&mut self, model: &Model, q: &[T], z: &[T]) -> (T, T) {
        let angle = q[2 * model.edges];
        self.add_loads(model, angle);
        let (c, f) = (&self.context, &self.fields);
        let tip = self.tip(angle);
        let mut elastic = c.stencil.clamp_energy(&f.angle);
        let mut potential = T::from(0.0);
        for active in &model.effects {
            let about = active.effect.about();
            let effect = T::laws(active.effect);
            let theta = &c.theta[active.theta.clone()];
            let energy = effect.energy(c, theta, f, &z[active.memory.clone()], &tip);
            if about.places.contains(&Place::Tip) {
                potential += energy;
            } else {
                elastic += energy;
            }
        }
        let n = c.edges;
        for k in 0..2 {
            let weightless = f.position[n][k] + c.weightless_body.arm(f.body_axis)[k];
            let mut moment = q[2 * n - 2 + k] * c.body.mass - weightless * c.weightless_body.mass;
            for i in 1..n {
                moment += q[2 * i - 2 + k] * (c.node_mass - c.weightless_mass);
            }
            potential -= f.acceleration[k] * moment;
        }
        (elastic, potential)
    }
}

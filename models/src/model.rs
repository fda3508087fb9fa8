//! A model: a rod, its clamp, its effects, and one flat list of named parameters.

mod axial;
mod spec;
mod values;

use std::ops::Range;
use std::sync::Arc;

use crate::effects::{Catalogue, Effect, EffectFor, Flow, Kind, Place, Rod};
use crate::error::ModelError;

pub use crate::stencil::Scheme;
pub use axial::AxialSource;
pub use spec::ModelSpec;

/// A parameter of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelParameter {
    /// Its path, such as `rod.length` or `effects.air_drag.drag_coefficient`.
    pub path: String,
    /// What it is.
    pub meaning: &'static str,
    /// SI unit; empty if dimensionless.
    pub unit: &'static str,
    /// Smallest and largest admissible value.
    pub range: (f64, f64),
    /// A typical size.
    pub scale: f64,
    /// Value at which its effect vanishes.
    pub null_value: Option<f64>,
}

/// An effect that is part of a model.
#[derive(Clone)]
pub struct Active {
    /// The effect.
    pub effect: &'static dyn Effect,
    /// Its parameters in `theta`.
    pub theta: Range<usize>,
    /// Its memories: shape `[memories, N+1]`.
    pub memory: Range<usize>,
}

/// A rod whose properties change with time because the pressure does.
pub trait Schedule: Send + Sync {
    /// Length, bending stiffness, axial stiffness and diameter relative to the model's own, each
    /// with its first and second rate, 1/s and 1/s².
    ///
    /// `since`, at most `time`, lies in the same piece between two breakpoints, each of which belongs to
    /// the piece after it. So a step that ends at a breakpoint sees the rates before it.
    fn factors(&self, time: f64, since: f64) -> [[f64; 3]; 4];
    /// Pressure above that of the model, Pa, with its rate, Pa/s: for laws that see the pressure
    /// itself. `since` as for [`factors`](Self::factors).
    fn pressure_change(&self, _time: f64, _since: f64) -> (f64, f64) {
        (0.0, 0.0)
    }
    /// What [`factors`](Self::factors) has at a change of the pressure, Pa, with its first and second derivative by that, 1/Pa
    /// and 1/Pa²; none where it is no pressure that is commanded, which no line delays.
    fn relative(&self, _change: f64) -> Option<[[f64; 3]; 4]> {
        None
    }
    /// When a pressure line goes on, s, and at which change of the pressure, Pa; none for one that has settled at the release.
    fn resumes(&self) -> Option<(f64, f64)> {
        None
    }
    /// Times at which a rate jumps, s, ascending.
    fn breakpoints(&self) -> &[f64];
}

/// Effects that every model has. Without payload, damping and so on their parameters are at off.
pub const BASELINE: [&str; 7] =
    ["stretch", "bend", "gravity", "end_fitting", "payload", "rayleigh_mass", "rayleigh_stiffness"];

pub(crate) const LENGTH: usize = 0;
pub(crate) const MASS: usize = 1;
pub(crate) const BENDING_STIFFNESS: usize = 2;
pub(crate) const AXIAL_STIFFNESS: usize = 3;
pub(crate) const DIAMETER: usize = 4;
pub(crate) const PRESSURE: usize = 5;
pub(crate) const BASE_ANGLE: usize = 6;
pub(crate) const RELEASE_ANGLE: usize = 7;
pub(crate) const RELEASE_RATE: usize = 8;

type RodParameter = (&'static str, &'static str, &'static str, (f64, f64), f64);

/// Path, meaning, unit, range and scale of what a rod itself has, in the order of `theta`.
const ROD_PARAMETERS: [RodParameter; 9] = [
    ("rod.length", "active length without load", "m", (1e-3, 100.0), 0.1),
    ("rod.mass", "distributed mass in all", "kg", (1e-9, 1e4), 0.01),
    ("rod.bending_stiffness", "bending stiffness EI", "N m^2", (0.0, 1e9), 1e-3),
    ("rod.axial_stiffness", "axial stiffness EA", "N", (1e-6, 1e12), 10.0),
    ("rod.diameter", "outer diameter", "m", (0.0, 10.0), 0.01),
    ("rod.pressure", "pressure inside above ambient", "Pa", (-1.1e5, 1e9), 1e5),
    ("rod.base_angle", "angle of the clamp above the horizontal", "rad", (-6.3, 6.3), 0.1),
    ("release.angle", "angle above the horizontal at which the rod is let go", "rad", (-6.3, 6.3), 0.1),
    ("release.angular_velocity", "angular velocity with which it is let go", "rad/s", (-1e3, 1e3), 0.1),
];

/// A rod with its clamp, its end body and its effects.
///
/// ```
/// use models::effects::Rod;
/// use models::model::{Model, ModelSpec};
///
/// let rod = Rod {
///     length: 0.2,
///     mass: 0.03,
///     bending_stiffness: 5e-3,
///     axial_stiffness: 500.0,
///     diameter: 0.03,
///     pressure: 0.0,
/// };
/// let spec = ModelSpec { nodes: 24, ..ModelSpec::of(rod) };
/// let mut model = Model::new(&spec.with(&[("rayleigh_mass.alpha", 1.0), ("air_drag.drag_coefficient", 1.2)]))?;
/// model.set("effects.payload.mass", 0.02)?;
/// assert!(model.effect("air_drag").is_some());
///
/// // A path that is misspelt and a value that cannot be are errors.
/// assert!(model.set("effects.payload.mas", 0.02).is_err());
/// assert!(model.set("rod.length", -0.2).is_err());
/// # Ok::<(), models::error::ModelError>(())
/// ```
#[derive(Clone)]
pub struct Model {
    /// Number of edges `N`.
    pub edges: usize,
    /// How the rod is made discrete.
    pub scheme: Scheme,
    /// Distance of the observed tip beyond the end of the active length, m.
    pub tip_distance: f64,
    /// What the parameters are, in the order of `theta`.
    pub parameters: Vec<ModelParameter>,
    /// Their values, SI.
    pub theta: Vec<f64>,
    /// The effects.
    pub effects: Vec<Active>,
    /// The effects that it may have.
    pub catalogue: Catalogue,
    /// A pressure that changes.
    pub schedule: Option<Arc<dyn Schedule>>,
    /// Where the axial stiffness comes from.
    pub axial_source: AxialSource,
    memory: usize,
}

impl Model {
    /// Builds and checks a model.
    /// # Errors
    /// [`ModelError`] for a node count, effect, or parameter that cannot be.
    pub fn new(spec: &ModelSpec) -> Result<Self, ModelError> {
        if !(4..=2000).contains(&spec.nodes) {
            return Err(ModelError::Nodes { nodes: spec.nodes });
        }
        let rod = &spec.rod;
        let mut model = Self {
            edges: spec.nodes - 1,
            scheme: spec.scheme,
            tip_distance: spec.tip_distance,
            parameters: ROD_PARAMETERS.map(rod_parameter).to_vec(),
            theta: vec![
                rod.length,
                rod.mass,
                rod.bending_stiffness,
                rod.axial_stiffness,
                if rod.diameter.is_nan() { 0.0 } else { rod.diameter },
                rod.pressure,
                spec.base_angle,
                spec.release_angle,
                spec.release_rate,
            ],
            effects: Vec::new(),
            catalogue: spec.catalogue.clone(),
            schedule: spec.schedule.clone(),
            axial_source: AxialSource::Given,
            memory: 0,
        };
        for name in BASELINE {
            model.switch_on(name)?;
        }
        for (name, values) in &spec.effects {
            model.add(name, values.iter().map(|(key, value)| (key.as_str(), *value)))?;
        }
        model.choose_axial_stiffness();
        model.check()?;
        if rod.diameter.is_nan() {
            model.check_without_diameter()?;
        }
        Ok(model)
    }

    /// Adds an effect, unless the model has it, and sets parameters of it.
    fn add<'v>(
        &mut self,
        name: &str,
        values: impl Iterator<Item = (&'v str, f64)>,
    ) -> Result<(), ModelError> {
        self.switch_on(name)?;
        for (key, value) in values {
            self.set(&format!("effects.{name}.{key}"), value)?;
        }
        Ok(())
    }

    /// Adds an effect with its defaults, unless the model has it.
    fn switch_on(&mut self, name: &str) -> Result<(), ModelError> {
        let Some(effect) = self.catalogue.by_name(name) else {
            return Err(ModelError::UnknownEffect { name: name.to_owned() });
        };
        if self.effect(name).is_some() {
            return Ok(());
        }
        let about = effect.about();
        let first = self.theta.len();
        for p in about.parameters {
            self.parameters.push(ModelParameter {
                path: format!("effects.{name}.{}", p.name),
                meaning: p.meaning,
                unit: p.unit,
                range: p.range,
                scale: p.scale,
                null_value: p.null_value,
            });
            self.theta.push(p.default);
        }
        let memory = self.memory..self.memory + about.memory * (self.edges + 1);
        self.memory = memory.end;
        self.effects.push(Active { effect, theta: first..self.theta.len(), memory });
        Ok(())
    }

    /// The same model with one more effect; one that it has keeps its parameters but for `values`.
    /// # Errors
    /// [`ModelError`] for an effect or a parameter that cannot be.
    pub fn with_effect(&self, name: &str, values: &[(&str, f64)]) -> Result<Self, ModelError> {
        let mut model = self.clone();
        model.add(name, values.iter().copied())?;
        Ok(model)
    }

    /// The same model on another mesh.
    /// # Errors
    /// [`ModelError::Nodes`].
    pub fn with_nodes(&self, nodes: usize) -> Result<Self, ModelError> {
        if !(4..=2000).contains(&nodes) {
            return Err(ModelError::Nodes { nodes });
        }
        let mut model = Self { edges: nodes - 1, memory: 0, ..self.clone() };
        for active in &mut model.effects {
            active.memory = model.memory..model.memory + active.effect.about().memory * nodes;
            model.memory = active.memory.end;
        }
        Ok(model)
    }

    /// The same model under another pressure over time, or under one that stays.
    pub(crate) fn under(&self, schedule: Option<Arc<dyn Schedule>>) -> Self {
        Self { schedule, ..self.clone() }
    }

    /// The active effect of that name.
    pub fn effect(&self, name: &str) -> Option<&Active> {
        self.effects.iter().find(|active| active.effect.about().name == name)
    }

    /// Number of generalised coordinates: two for each free node but the last, three for the end
    /// body.
    pub fn dof(&self) -> usize {
        2 * self.edges + 1
    }

    /// Number of memory variables of all effects.
    pub fn memory(&self) -> usize {
        self.memory
    }

    /// Number of memory variables up to the last that a moment depends on: an effect that is off has none such.
    pub fn felt_memory(&self) -> usize {
        self.effects
            .iter()
            .filter(|active| !self.is_off(active))
            .map(|active| active.memory.end)
            .max()
            .unwrap_or(0)
    }

    /// An effect that needs a diameter answers with not-a-number when the diameter is none.
    fn check_without_diameter(&self) -> Result<(), ModelError> {
        let rod = Rod { diameter: f64::NAN, ..self.rod() };
        let at = Flow { tangential_velocity: 1.0, normal_velocity: 1.0, position: 0.5, time: 0.0, rod: &rod };
        for active in &self.effects {
            let theta = &self.theta[active.theta.clone()];
            let is_lost =
                EffectFor::<f64>::flow(active.effect, &at, theta).iter().any(|force| force.is_nan());
            if is_lost || (active.effect.needs_diameter() && !self.is_off(active)) {
                return Err(ModelError::DiameterMissing { effect: active.effect.about().name });
            }
        }
        Ok(())
    }

    /// The rod at release.
    pub fn rod(&self) -> Rod<f64> {
        Rod {
            length: self.theta[LENGTH],
            mass: self.theta[MASS],
            bending_stiffness: self.theta[BENDING_STIFFNESS],
            axial_stiffness: self.theta[AXIAL_STIFFNESS],
            diameter: self.theta[DIAMETER],
            pressure: self.theta[PRESSURE],
        }
    }

    /// Whether a law or the rod depends on the time itself.
    pub fn is_timed(&self) -> bool {
        self.schedule.is_some() || self.effects.iter().any(|active| active.effect.about().timed)
    }

    /// Whether the model keeps its energy: nothing dissipates, remembers or depends on time. A load as text may do what
    /// it wants with the energy.
    pub fn is_conservative(&self) -> bool {
        let may_lose = |effect: &dyn Effect| match effect.about().kind {
            Kind::Dissipative | Kind::Description => true,
            Kind::Load => effect.text().is_some(),
            _ => false,
        };
        let loses = |active: &Active| may_lose(active.effect) && !self.is_off(active);
        !self.is_timed() && self.memory == 0 && !self.effects.iter().any(loses)
    }

    /// The model as it swings where its frictions slip: without them. None if it has no friction.
    pub fn slipping(&self) -> Option<Model> {
        let mut slipping = self.clone();
        let mut slips = false;
        for active in self.effects.iter().filter(|active| !self.is_off(active)) {
            for (p, k) in active.effect.about().parameters.iter().zip(active.theta.clone()) {
                if let (true, Some(off)) = (p.is_friction, p.null_value) {
                    slipping.theta[k] = off;
                    slips = true;
                }
            }
        }
        slips.then_some(slipping)
    }

    /// Whether the effect's parameters have values at which it vanishes.
    pub(crate) fn is_off(&self, active: &Active) -> bool {
        active.effect.about().is_off(&self.theta[active.theta.clone()])
    }

    /// Names of the effects that exert a force at the present parameters.
    pub fn exerting(&self) -> Vec<&'static str> {
        let places =
            [Place::Bend, Place::Edge, Place::Flow, Place::Mass, Place::Tip, Place::Inertia, Place::Clamp];
        let mut all: Vec<usize> = places.iter().flat_map(|place| self.acting(*place, &[])).collect();
        all.sort_unstable();
        all.dedup();
        all.into_iter().map(|k| self.effects[k].effect.about().name).collect()
    }

    /// Whether a parameter, as an index into `theta`, moves points of the rod at fixed coordinates or
    /// changes the mass matrix, and not only what the laws say.
    pub(crate) fn is_geometric(&self, parameter: usize) -> bool {
        let of_effect = self.effects.iter().find(|active| active.theta.contains(&parameter));
        match of_effect {
            Some(active) => {
                let places = active.effect.about().places;
                [Place::Body, Place::Inertia, Place::Clamp].iter().any(|place| places.contains(place))
            }
            // What fills the rod weighs by its pressure and its diameter.
            None if [PRESSURE, DIAMETER].contains(&parameter) => {
                self.effects.iter().any(|active| active.effect.about().places.contains(&Place::Inertia))
            }
            None => [LENGTH, MASS, BASE_ANGLE].contains(&parameter),
        }
    }

    /// Whether a parameter, as an index into `theta`, changes what one effect's law says, and nothing else.
    pub fn is_of_law(&self, parameter: usize) -> bool {
        let is_own = |active: &Active| {
            active.theta.contains(&parameter) && !active.effect.about().places.contains(&Place::Line)
        };
        !self.is_geometric(parameter) && self.effects.iter().any(is_own)
    }

    /// Whether a parameter, as an index into `theta`, changes only what is observed.
    pub fn is_of_sensor(&self, parameter: usize) -> bool {
        let is_own = |active: &&Active| active.theta.contains(&parameter);
        self.effects.iter().find(is_own).is_some_and(|active| active.effect.about().places == [Place::Sensor])
    }

    /// Whether an effect acts between the rod and its observation.
    pub fn has_sensor(&self) -> bool {
        !self.acting(Place::Sensor, &[]).is_empty()
    }

    /// The effects that act at a place and are not at off, or have one of the `watched` parameters.
    /// An effect with memory always counts: its memory goes on even where its force is off.
    pub(crate) fn acting(&self, place: Place, watched: &[usize]) -> Vec<usize> {
        let acts = |active: &Active| {
            let about = active.effect.about();
            let is_watched = || watched.iter().any(|k| active.theta.contains(k));
            about.places.contains(&place) && (about.memory > 0 || !self.is_off(active) || is_watched())
        };
        (0..self.effects.len()).filter(|&k| acts(&self.effects[k])).collect()
    }
}

fn rod_parameter((path, meaning, unit, range, scale): RodParameter) -> ModelParameter {
    ModelParameter { path: path.to_owned(), meaning, unit, range, scale, null_value: None }
}

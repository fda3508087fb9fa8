//! From what a scenario says to models and runs.

use std::sync::Arc;

use efam_core::accuracy::Goal;
use efam_core::forward::{CurvePoint, Initial, Run};
use efam_recordings::TOO_FAR;
use models::effects::Rod;
use models::error::ModelError;
use models::model::{Model, ModelSpec, Scheme};
use models::muscle::AtPressure;
use models::pressure::PressureSchedule;
use models::quantity::{Quantity, format_si};
use models::statics::held;

use super::document::Document;
use super::error::{ScenarioError, ScenarioProblem};
use super::plan::{MassPlan, MusclePlan, Plan, Pressure};
use super::start::{From, Hold, Holder};
use super::units::ROD;
use super::{Case, Scenario};

/// Share of its length by which a posture may be longer or shorter than the rod, without a warning
/// and at all.
const STRETCH: [f64; 2] = [0.01, 0.5];
/// Share of its length that a hold may differ by without a warning.
const HELD_STRETCH: f64 = 1e-3;

pub(super) fn cases(scenario: &Scenario) -> Result<Vec<Case>, ScenarioError> {
    let builder =
        Builder { document: &scenario.document, plan: &scenario.plan, pressure_key: "muscle.pressure" };
    let rows = |muscle: &MusclePlan| -> Vec<(String, Option<f64>)> {
        let row = |pressure: &f64| (format!("{}-{}", scenario.name, psi(*pressure)), Some(*pressure));
        muscle.muscle.pressures().iter().map(row).collect()
    };
    let asked = match scenario.plan.muscle.as_ref().map(|muscle| (muscle, &muscle.pressure)) {
        Some((muscle, Pressure::AllRows)) => rows(muscle),
        Some((_, Pressure::Constant(pressure))) => vec![(scenario.name.clone(), Some(*pressure))],
        Some((_, Pressure::Schedule(_))) | None => vec![(scenario.name.clone(), None)],
        Some((_, Pressure::Elsewhere)) => unreachable!("a scenario says its pressure"),
    };
    asked
        .into_iter()
        .map(|(name, pressure)| Ok(builder.case(name, pressure)?.with_loss(&scenario.plan).paced()))
        .collect()
}

/// The model of a scenario whose pressure is constant, at another one, Pa: nothing is read again.
pub(super) fn model_at(scenario: &Scenario, pressure: f64) -> Option<Model> {
    let plan = &scenario.plan;
    let is_constant = matches!(plan.muscle.as_ref()?.pressure, Pressure::Constant(_));
    let builder = Builder { document: &scenario.document, plan, pressure_key: "muscle.pressure" };
    let case = is_constant.then(|| builder.case(scenario.name.clone(), Some(pressure)))?;
    Some(case.ok()?.with_loss(plan).model)
}

/// Commands of a regulator for a rod of a scenario whose pressure is constant; see [`PressureSchedule::steered`].
pub(super) fn steered(
    scenario: &Scenario,
    release: f64,
    resumes: (f64, f64),
    commands: &[(f64, f64)],
) -> Option<PressureSchedule> {
    let muscle = scenario.plan.muscle.as_ref()?;
    matches!(muscle.pressure, Pressure::Constant(_)).then_some(())?;
    let (stiffness, extrapolation) = (&muscle.stiffness, muscle.extrapolation);
    PressureSchedule::steered(muscle.muscle.clone(), stiffness, extrapolation, release, resumes, commands)
        .ok()
}

/// The case of an experiment's plan at a pressure, Pa, given at `pressure_key`.
pub(crate) fn at_pressure(
    document: &Document,
    plan: &Arc<Plan>,
    name: String,
    pressure: Option<f64>,
    pressure_key: &str,
) -> Result<Case, ScenarioError> {
    Builder { document, plan, pressure_key }.case(name, pressure)
}

/// `005psi`: sorts as the pressures do.
fn psi(pressure: f64) -> String {
    let psi = Quantity::parse("1 psi").map_or(1.0, |psi| psi.si());
    let psi = (pressure / psi * 1e3).round() / 1e3;
    let digits = if psi.fract() == 0.0 { 3 } else { 7 };
    format!("{psi:0digits$.decimals$}psi", decimals = digits - 3 - usize::from(digits > 3))
}

/// Nodes where neither the scenario nor an accuracy says how many: the paper's tables belong to 32.
fn usual_nodes(scheme: Scheme) -> usize {
    match scheme {
        Scheme::Consistent => 16,
        Scheme::Paper => 32,
    }
}

/// Rods longer than that, m, are probably given in another unit.
const DOUBTFUL_LENGTH: f64 = 50.0;

struct Builder<'a> {
    document: &'a Document,
    plan: &'a Arc<Plan>,
    /// Key of the pressure at release.
    pressure_key: &'a str,
}

impl Builder<'_> {
    /// Where a model of the scenario starts.
    fn initial(&self, model: &Model, warnings: &mut Vec<String>) -> Result<Initial, ScenarioError> {
        Ok(match &self.plan.from {
            From::Straight => Initial::Straight,
            From::HeldBy(holder) => {
                let end_angle = (*holder == Holder::Hand).then_some(self.plan.angle);
                let hold = models::statics::Hold { direction: self.plan.angle, end_angle };
                let (hold, own) = held(model, &hold).map_err(|error| self.of_model("release.", error))?;
                Initial::Equilibrium { hold: Box::new(hold), own }
            }
            From::Equilibrium(hold) => self.held(hold, model, warnings)?,
            From::Points(points) => self.curve(points, model, warnings)?,
        })
    }

    fn case(&self, name: String, pressure: Option<f64>) -> Result<Case, ScenarioError> {
        let plan = &**self.plan;
        let mut warnings = Vec::new();
        let mut effects: Vec<(String, Vec<(String, f64)>)> = Vec::new();
        let mut schedule = None;
        let mut at = None;
        let rod = match &plan.muscle {
            None => self.plain_rod(pressure)?,
            Some(muscle) => {
                let at_release = match &muscle.pressure {
                    Pressure::Schedule(rows) => {
                        let built = self.schedule(muscle, rows, &mut warnings)?;
                        let at_release = *built.at_release();
                        schedule = Some(built);
                        at_release
                    }
                    _ => self.at(muscle, pressure.unwrap_or_default(), self.pressure_key, &mut warnings)?,
                };
                warnings.extend(muscle.muscle.contradictions());
                at = Some(at_release.pressure);
                effects = of_muscle(muscle, &at_release);
                overridden(rod_of(muscle, &at_release), &plan.rod)
            }
        };
        if rod.length > DOUBTFUL_LENGTH {
            let length = format_si(rod.length, "m");
            warnings.push(format!("the rod is {length} long: {TOO_FAR}"));
        }
        for (name, values) in &plan.effects {
            let values = values.iter().map(|(parameter, value)| (parameter.name.to_owned(), *value));
            effects.push(((*name).to_owned(), values.collect()));
        }
        if let From::Equilibrium(hold) = &plan.from {
            self.let_go(hold, &mut effects)?;
        }
        if let From::HeldBy(_) = plan.from
            && effects.iter().all(|(name, _)| name != "tip_load")
        {
            // The load that holds the rod, which is gone once it is let go.
            effects.push(("tip_load".to_owned(), Vec::new()));
        }
        // The order of `theta` is that of the catalogue, however a scenario comes by its effects.
        effects.sort_by_key(|(name, _)| plan.catalogue.position(name));
        let spec = ModelSpec {
            nodes: plan.nodes.unwrap_or(usual_nodes(plan.scheme)),
            rod,
            base_angle: plan.base_angle,
            release_angle: plan.angle,
            release_rate: plan.angular_velocity,
            scheme: plan.scheme,
            tip_distance: 0.0,
            effects,
            catalogue: plan.catalogue.clone(),
            schedule: schedule.map(|schedule| schedule as _),
        };
        let mut model = Model::new(&spec).map_err(|error| self.of_model("", error))?;
        warnings.extend(model.axial_warning());
        let center = model.index("effects.end_fitting.center_of_mass").map(|k| model.theta[k]);
        model.tip_distance = plan.tip.unwrap_or(center.unwrap_or_default());
        let run = Run { initial: self.initial(&model, &mut warnings)?, ..plan.run.clone() };
        if run.history.is_some() && model.memory() == 0 {
            warnings
                .push("release.history: no effect of this model has a memory, so it changes nothing".into());
        }
        let goal = Goal {
            accuracy: plan.accuracy,
            chooses_mesh: plan.nodes.is_none() && plan.scheme == Scheme::Consistent,
            chooses_tolerance: plan.chooses_tolerance,
        };
        let (rate, plan) = (plan.rate, self.plan.clone());
        Ok(Case { name, model, run, goal, rate, warnings, pressure: at, loss: None, plan })
    }

    fn plain_rod(&self, pressure: Option<f64>) -> Result<Rod<f64>, ScenarioError> {
        let needed = |k: usize, example: &'static str| {
            let missing = || self.document.keys().table("rod").map(|rod| rod.missing(ROD[k].0, example));
            match self.plan.rod[k] {
                Some(value) => Ok(value),
                None => Err(missing()?),
            }
        };
        let length = needed(0, "length = \"300 mm\", or a [muscle]")?;
        let mass = needed(1, "mass = \"30 g\"")?;
        let bending_stiffness = needed(2, "bending_stiffness = \"0.05 N m^2\"")?;
        let plain = Rod::plain(length, mass, bending_stiffness);
        Ok(Rod {
            axial_stiffness: self.plan.rod[3].unwrap_or(plain.axial_stiffness),
            diameter: self.plan.rod[4].unwrap_or(plain.diameter),
            pressure: self.plan.rod[5].or(pressure).unwrap_or(plain.pressure),
            ..plain
        })
    }

    fn at(
        &self,
        muscle: &MusclePlan,
        pressure: f64,
        key: &str,
        warnings: &mut Vec<String>,
    ) -> Result<AtPressure, ScenarioError> {
        let at = muscle.muscle.at(pressure, &muscle.stiffness, muscle.extrapolation);
        let at = at.map_err(|error| self.document.error_of(key, ScenarioProblem::Muscle(error)))?;
        if let Some(extrapolated) = at.extrapolated {
            warnings.push(format!("{key}: {extrapolated}"));
        }
        Ok(at)
    }

    fn schedule(
        &self,
        muscle: &MusclePlan,
        rows: &[(f64, f64)],
        warnings: &mut Vec<String>,
    ) -> Result<Arc<PressureSchedule>, ScenarioError> {
        for (_, pressure) in rows {
            self.at(muscle, *pressure, self.pressure_key, warnings)?;
        }
        warnings.dedup();
        PressureSchedule::new(muscle.muscle.clone(), &muscle.stiffness, muscle.extrapolation, rows)
            .map(Arc::new)
            .map_err(|error| self.document.error_of(self.pressure_key, ScenarioProblem::Muscle(error)))
    }

    /// Effects that only hold the rod are part of the model, but off, once it is let go.
    fn let_go(
        &self,
        hold: &Hold,
        effects: &mut Vec<(String, Vec<(String, f64)>)>,
    ) -> Result<(), ScenarioError> {
        for (name, _) in &hold.effects {
            if models::model::BASELINE.contains(name) || effects.iter().any(|(known, _)| known == name) {
                continue;
            }
            let parameters =
                self.plan.catalogue.by_name(name).map_or(&[][..], |effect| effect.about().parameters);
            let off: Vec<_> = (parameters.iter())
                .filter_map(|p| p.null_value.map(|off| (p.name.to_owned(), off)))
                .collect();
            let is_zero = parameters.iter().all(|p| p.default == 0.0);
            if off.is_empty() && !is_zero {
                let message = format!("say what it is after the release; add [effects.{name}]");
                let path = format!("release.hold.effects.{name}");
                return Err(self.document.error_of(&path, ScenarioProblem::Other { message }));
            }
            effects.push(((*name).to_owned(), off));
        }
        Ok(())
    }

    fn held(&self, hold: &Hold, model: &Model, warnings: &mut Vec<String>) -> Result<Initial, ScenarioError> {
        let mut held = model.clone();
        // The equilibrium is that of the pressure at release, or of the hold's own.
        held.schedule = None;
        let mut own: Vec<(String, f64)> = Vec::new();
        if let (Some(pressure), Some(muscle)) = (hold.pressure, &self.plan.muscle) {
            let at = self.at(muscle, pressure, "release.hold.pressure", warnings)?;
            for (k, value) in parts(&rod_of(muscle, &at)).into_iter().enumerate() {
                let is_same =
                    value == model.theta[k] && muscle.mass == MassPlan::Conserved && ROD[k].0 == "mass";
                if self.plan.rod[k].is_none() && hold.rod[k].is_none() && !is_same {
                    own.push((format!("rod.{}", ROD[k].0), value));
                }
            }
        }
        for (value, (key, _)) in hold.rod.iter().zip(ROD) {
            own.extend(value.map(|value| (format!("rod.{key}"), value)));
        }
        for (name, values) in &hold.effects {
            own.extend(values.iter().map(|(p, value)| (format!("effects.{name}.{}", p.name), *value)));
        }
        let mut indices = Vec::new();
        for (path, value) in &own {
            held.set(path, *value).map_err(|error| self.of_model("release.hold.", error))?;
            indices.extend(held.index(path));
        }
        indices.sort_unstable();
        let [held_length, length] = [held.rod().length, model.rod().length];
        if (held_length / length - 1.0).abs() > HELD_STRETCH {
            warnings.push(format!(
                "release.hold: the rod is {} long while it is held and {} when it is let go; it will ring \
                 along itself, which takes very many steps unless stiffness damping calms it",
                format_si(held_length, "m"),
                format_si(length, "m")
            ));
        }
        Ok(Initial::Equilibrium { hold: Box::new(held), own: indices })
    }

    fn curve(
        &self,
        points: &[[f64; 4]],
        model: &Model,
        warnings: &mut Vec<String>,
    ) -> Result<Initial, ScenarioError> {
        let curve: Vec<_> = points.iter().map(|p| [p[0], p[1]]).collect();
        let length: f64 = curve.windows(2).map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1])).sum();
        let rod = model.rod().length;
        let stretch = (length / rod - 1.0).abs();
        if stretch > STRETCH[0] {
            let message = format!(
                "the posture is {} long, the rod {}; a rod of this stretch springs back along itself",
                format_si(length, "m"),
                format_si(rod, "m")
            );
            if stretch > STRETCH[1] {
                let message = format!("{message}; give points of the whole active length, in metres");
                return Err(self.document.error_of("release.posture", ScenarioProblem::Other { message }));
            }
            warnings.push(format!("release.posture: {message}"));
        }
        let point = |&[x, z, vx, vz]: &[f64; 4]| CurvePoint { position: [x, z], velocity: [vx, vz] };
        Ok(Initial::Curve(points.iter().map(point).collect()))
    }

    /// Gives the place in the scenario of a value that a model refuses.
    fn of_model(&self, prefix: &str, error: ModelError) -> ScenarioError {
        let document = self.document;
        match error {
            ModelError::OutOfRange { path, value, low, high, unit } => {
                let unit = unit.trim();
                let key = format!("{prefix}{path}");
                let mut range = format!("{low}..={high} {unit}");
                if unit == "rad" {
                    range += &format!(" ({:.0}..={:.0} deg)", low.to_degrees(), high.to_degrees());
                }
                let mut error =
                    document.error_of(&key, ScenarioProblem::OutOfRange { range: range.trim().into() });
                // Where the scenario does not say the value, the message does.
                if let Some(at) = error.at.as_mut().filter(|at| at.text.is_empty()) {
                    at.key = format!("{key} = {value} {unit}").trim_end().to_owned();
                }
                error
            }
            ModelError::Nodes { .. } => document.error_of("rod.nodes", ScenarioProblem::Model(error)),
            ModelError::DiameterMissing { effect } => {
                let path = format!("effects.{effect}");
                document.error_of(&path, ScenarioProblem::Model(error))
            }
            ModelError::Held { .. } => document.error_of("release.angle", ScenarioProblem::Model(error)),
            error => ScenarioError { at: None, problem: ScenarioProblem::Model(error).into() },
        }
    }
}

fn rod_of(muscle: &MusclePlan, at: &AtPressure) -> Rod<f64> {
    let rest = &muscle.muscle.rest;
    let length = match muscle.mass {
        MassPlan::Conserved => rest.length,
        MassPlan::PerLength => at.length,
    };
    at.rod(rest.mass_per_length * length)
}

/// What the muscle's file says of effects.
fn of_muscle(muscle: &MusclePlan, at: &AtPressure) -> Vec<(String, Vec<(String, f64)>)> {
    let fitting = &muscle.muscle.end_fitting;
    let of = |name: &str, values: &[(&str, f64)]| {
        (name.to_owned(), values.iter().map(|(key, value)| ((*key).to_owned(), *value)).collect())
    };
    let mut effects = vec![
        of("gravity", &[("acceleration", muscle.muscle.gravity)]),
        of(
            "end_fitting",
            &[
                ("mass", fitting.mass),
                ("center_of_mass", fitting.center_of_mass),
                ("rotary_inertia", fitting.rotary_inertia),
            ],
        ),
    ];
    if muscle.mass == MassPlan::Conserved {
        effects.push(of("enclosed_air", &[("inner_diameter", at.inner_diameter)]));
    }
    effects.extend(at.rayleigh_mass.map(|alpha| of("rayleigh_mass", &[("alpha", alpha)])));
    effects.extend(at.rayleigh_stiffness.map(|beta| of("rayleigh_stiffness", &[("beta", beta)])));
    effects.extend(at.viscoelastic.map(|[stiffness, time]| {
        of("viscoelastic", &[("branch_stiffness", stiffness), ("relaxation_time", time)])
    }));
    effects
}

/// In the order of [`ROD`].
fn parts(rod: &Rod<f64>) -> [f64; 6] {
    [rod.length, rod.mass, rod.bending_stiffness, rod.axial_stiffness, rod.diameter, rod.pressure]
}

fn overridden(rod: Rod<f64>, own: &[Option<f64>; 6]) -> Rod<f64> {
    let mut values = parts(&rod);
    for (value, own) in values.iter_mut().zip(own) {
        *value = own.unwrap_or(*value);
    }
    let [length, mass, bending_stiffness, axial_stiffness, diameter, pressure] = values;
    Rod { length, mass, bending_stiffness, axial_stiffness, diameter, pressure }
}

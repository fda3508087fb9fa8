//! Scenarios: what to simulate, as a TOML file says it.
//!
//! ```toml
//! [muscle]
//! name = "garbulinski-2022"   # built in; or file = "mine.toml", relative to the scenario
//! pressure = "15 psi"         # or [["0 s", "15 psi"], ["5 s", "20 psi"]], or "all rows" of its table
//! stiffness = "pder_32"       # which estimate of the bending stiffness
//! extrapolation = "refused"   # or "allowed": pressures outside the table
//! mass = "conserved"          # or "per_length": the resting mass per length at every pressure
//! [rod]                       # without a muscle length, mass and both stiffnesses must be given here
//! nodes = 16                  # chosen for the accuracy unless it is given
//! scheme = "consistent"       # or "paper"
//! base_angle = "0 deg"
//! tip = "0.662 in"            # the observed point beyond the active length
//! [release]
//! angle = "0 deg"
//! angular_velocity = "0 rad/s"
//! from = "straight"           # or "equilibrium", or posture = "points.csv"
//! [release.hold]              # pressure, rod.…, effects.… under which it rests before an "equilibrium"
//! pressure = "20 psi"
//! [run]
//! duration = "20 s"
//! rate = "100 Hz"             # more where the rod swings faster
//! accuracy = "0.02 mm"        # largest error of the tip's path; of small swings a thousandth
//! [integrator]
//! method = "auto"             # verlet, rodas4, tr_bdf2, esdirk34
//! tolerance = 1e-6            # chosen for the accuracy unless it is given
//! [effects.payload]           # any effect of `efam effects`, with any of its parameters
//! mass = "80 g"
//! [laws.my_drag]              # an effect of your own, as text; then [effects.my_drag] switches it on
//! place = "flow"
//! force = "-c * v_n * abs(v_n) * diameter"
//! parameters.c = { unit = "kg/m^3", default = 0.6, range = [0, 10] }
//! [calibration]               # how well a calibration knows these numbers: written by efam, for predictions
//! ```
//!
//! Every quantity carries its unit. What is left out has the value above, except the payload.

pub(crate) mod case;
pub mod document;
mod error;
mod laws;
pub mod loss;
pub mod plan;
mod posture;
mod release;
pub mod resolved;
pub(crate) mod start;
pub(crate) mod tables;
pub mod units;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use efam_core::accuracy::Goal;
use efam_core::accuracy::first;
use efam_core::forward::{Run, uniform};
use efam_core::linear::{Linear, LinearError, linearise};
use efam_core::pace::Pace;
use efam_core::rest::rest;
use models::model::{Model, Schedule};
use models::muscle::{Known, Muscle, RodSlopes};

use document::Document;
pub use error::{At, ScenarioError, ScenarioProblem};
pub(crate) use laws::LAWS;
pub use laws::{effects_of, parse_laws, read_laws};
use loss::Loss;
use plan::Plan;
pub use release::ReleaseOptions;
pub use units::unit_of;

/// What to simulate, read and checked.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Name: as given, or that of the file.
    pub name: String,
    /// Its file.
    pub path: PathBuf,
    document: Document,
    plan: Arc<Plan>,
}

/// One run of a scenario.
#[derive(Clone)]
pub struct Case {
    /// Name of the scenario, with the pressure if there are several.
    pub name: String,
    /// The model.
    pub model: Model,
    /// How to run it; the energies are followed. When it is sampled depends on how fast the rod swings, see
    /// [`Case::paced`].
    pub run: Run,
    /// How accurately, and what may be chosen for that.
    pub goal: Goal,
    /// Samples a second, if the scenario says that.
    pub rate: Option<f64>,
    /// What a reader of the results must know, such as extrapolation.
    pub warnings: Vec<String>,
    /// Pressure at release, Pa.
    pub pressure: Option<f64>,
    /// What its loss is at its frequency, where a calibration found that at another one and the model has it so.
    pub loss: Option<Loss>,
    plan: Arc<Plan>,
}

impl Case {
    /// The case with its samples and its trace, which follow from the rod's slowest mode unless the scenario
    /// gives a rate; and a warning where that is too low to show the swing.
    pub fn paced(mut self) -> Self {
        let pace = Pace::of(&self.model, self.rate, self.run.duration);
        self.run.samples = uniform(self.run.duration, pace.rate);
        self.run.trace_step = Some(pace.trace_step);
        self.rate = Some(pace.rate);
        self.warnings.extend(pace.warning);
        self
    }

    /// The case with the mesh and the tolerance with which a run of its accuracy begins, as far as the scenario
    /// leaves them open. Their errors are not estimated.
    pub fn begun(self) -> Self {
        match first(&self.model, &self.run, &self.goal) {
            Ok((model, run)) => Self { model, run, ..self },
            // What is wrong with its start is said when it is run.
            Err(_) => self,
        }
    }

    /// Root moment, N m, of the muscle at rest under its end fitting alone, its clamp level, as it was when its
    /// stiffness was measured; none for a plain rod.
    pub fn measured_moment(&self) -> Option<f64> {
        self.plan.muscle.as_ref()?;
        let mut bare = self.model.clone();
        bare.set("rod.base_angle", 0.0).ok()?;
        for path in ["effects.payload.mass", "effects.tip_mass.mass"] {
            if bare.index(path).is_ok() {
                bare.set(path, 0.0).ok()?;
            }
        }
        Some(rest(&bare, 0.0, 0).ok()?.root_moment)
    }

    /// The muscle that its rod is, if it is one.
    pub fn muscle(&self) -> Option<&Muscle> {
        self.plan.muscle.as_ref().map(|plan| &plan.muscle)
    }

    /// The case whose frictions slip, and so hold nothing; itself without friction.
    pub fn slipping(self) -> Self {
        let model = self.model.slipping().unwrap_or_else(|| self.model.clone());
        Self { model, ..self }
    }

    /// How its rod follows the pressure, if it is a muscle at a pressure.
    pub fn rod_slopes(&self) -> Option<RodSlopes> {
        let (plan, pressure) = self.plan.muscle.as_ref().zip(self.pressure)?;
        let found = plan.muscle.rod_slopes(pressure, &plan.stiffness, plan.extrapolation);
        Some(found.expect("the case has been built at this pressure"))
    }

    /// The linear model about its rest; without inputs by the pressure, or the force along z of a rod that is no muscle.
    /// # Errors
    /// [`LinearError`].
    pub fn linearise(
        &self,
        inputs: &[impl AsRef<str>],
        outputs: &[impl AsRef<str>],
    ) -> Result<Linear, LinearError> {
        let muscle = self.rod_slopes();
        let usual = if muscle.is_some() { "pressure" } else { "force_z" };
        let inputs: Vec<&str> = inputs.iter().map(AsRef::as_ref).collect();
        let inputs = if inputs.is_empty() { vec![usual] } else { inputs };
        linearise(&self.model, muscle, &inputs, outputs)
    }

    /// The case with another mesh, or other settings.
    pub fn run_as(&self, model: &Model, run: &Run) -> Self {
        Self { model: model.clone(), run: run.clone(), ..self.clone() }
    }

    /// The case as a scenario in SI units that needs no other file and gives the same bits.
    pub fn resolved(&self) -> String {
        resolved::text(self, &self.plan)
    }
}

impl Scenario {
    /// Reads a scenario and sets `overrides` over it, each as `path=value`.
    /// # Errors
    /// [`ScenarioError`], with file, line and column where there is one.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Scenario, ScenarioError> {
        Scenario::of(path, Document::load(path, overrides)?)
    }

    /// The same with the laws as text of other files.
    /// # Errors
    /// As [`Scenario::load`], for those files as well.
    pub fn load_with(path: &Path, overrides: &[String], laws: &[PathBuf]) -> Result<Scenario, ScenarioError> {
        let mut document = Document::load(path, overrides)?;
        for file in laws {
            document.include(file, LAWS)?;
        }
        Scenario::of(path, document)
    }

    /// The scenario that a text describes; `path` names it, and files in it are relative to that.
    /// # Errors
    /// As [`Scenario::load`].
    pub fn parse(path: &Path, text: &str, overrides: &[String]) -> Result<Scenario, ScenarioError> {
        Scenario::of(path, Document::parse(path, text, overrides)?)
    }

    fn of(path: &Path, document: Document) -> Result<Scenario, ScenarioError> {
        let plan = Arc::new(Plan::read(&document)?);
        let name = plan::name(&document, path, "scenario")?;
        Ok(Scenario { name, path: path.to_owned(), document, plan })
    }

    /// The text of its file, without what is set over it.
    pub fn text(&self) -> &str {
        self.document.text()
    }

    /// The files of which it is made, each with its text: its own, and those of its laws.
    pub fn files(&self) -> impl Iterator<Item = (&str, &str)> {
        self.document.files()
    }

    /// Whether it requests every pressure of a muscle's table.
    pub fn is_all_rows(&self) -> bool {
        self.plan.is_all_rows()
    }

    /// Name of the muscle, if the rod is one.
    pub fn muscle_name(&self) -> Option<&str> {
        self.plan.muscle.as_ref().map(|muscle| muscle.muscle.name.as_str())
    }

    /// How well a calibration knows its rod: by its own section `[calibration]`, or else that of its muscle.
    pub fn known(&self) -> Option<&Known> {
        self.plan.known.as_ref()
    }

    /// What its files say, each as `path=value`: set over its text, that needs no other file.
    pub fn without_files(&self) -> Vec<String> {
        let keys = self.document.keys();
        let names = |table: &str, key: &str| keys.table(table).is_ok_and(|table| table.has(key));
        let mut set = Vec::new();
        if let Some(muscle) = self.plan.muscle.as_ref().filter(|_| names("muscle", "file")) {
            set.push(format!("muscle.text={}", serde_json::Value::from(muscle.text.as_str())));
        }
        if let (start::From::Points(points), true) = (&self.plan.from, names("release", "posture")) {
            let row = |[x, z, vx, vz]: &[f64; 4]| {
                format!("[\"{x:?} m\", \"{z:?} m\", \"{vx:?} m/s\", \"{vz:?} m/s\"]")
            };
            let rows: Vec<String> = points.iter().map(row).collect();
            set.push(format!("release.nodes=[{}]", rows.join(", ")));
        }
        set
    }

    /// The runs that it requests: one, or one for each row of the muscle's table.
    /// # Errors
    /// [`ScenarioError`] for what the muscle or the model refuses.
    pub fn cases(&self) -> Result<Vec<Case>, ScenarioError> {
        case::cases(self)
    }

    /// The model of its muscle at another constant pressure, Pa, for a controller that changes it at every step: it costs a
    /// part of reading a scenario. None where the scenario has no constant pressure, or refuses this one.
    pub fn model_at(&self, pressure: f64) -> Option<Model> {
        case::model_at(self, pressure)
    }

    /// The pressure over time of the same muscle behind a pressure line: commands, each held from its time, s, to the next, Pa;
    /// the line goes on at a time from a pressure, of a rod that was let go at the pressure `release`. None as for
    /// [`model_at`](Self::model_at).
    pub fn steered(
        &self,
        release: f64,
        resumes: (f64, f64),
        commands: &[(f64, f64)],
    ) -> Option<Arc<dyn Schedule>> {
        Some(Arc::new(case::steered(self, release, resumes, commands)?))
    }
}

#[cfg(test)]
mod tests;

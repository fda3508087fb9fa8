//! The keys of a scenario, read and checked one by one.

use std::path::Path;

use efam_core::forward::{DEFAULT_METHOD, DEFAULT_TOLERANCE, Run};
use efam_core::integrate::{Method, Steps};
use efam_core::pace;
use models::effects::Catalogue;
use models::history::History;
use models::model::Scheme;
use models::muscle::{CALIBRATED, Extrapolation, Known, Muscle};
use models::quantity::format_si;

use super::document::{Document, Keys};
use super::error::{ScenarioError, ScenarioProblem};
use super::laws::{self, LAWS};
use super::start::{From, is_kinked, read_from};
use super::tables::{EffectPlan, read_effects, read_file, read_rod};
use super::units::{OF_INTEGRATOR, OF_MUSCLE, OF_RELEASE, OF_ROD, OF_RUN, ROD, SCENARIO};

/// What a scenario says, in SI units; `None` where it says nothing.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub muscle: Option<MusclePlan>,
    /// Values of the rod's keys, in the order of `ROD`.
    pub rod: [Option<f64>; 6],
    /// If it is given.
    pub nodes: Option<usize>,
    pub scheme: Scheme,
    pub base_angle: f64,
    pub tip: Option<f64>,
    pub angle: f64,
    pub angular_velocity: f64,
    pub from: From,
    /// Samples a second, if that is given.
    pub rate: Option<f64>,
    /// Largest error of the tip's path, m, if that is given.
    pub accuracy: Option<f64>,
    /// Whether the tolerance is left open.
    pub chooses_tolerance: bool,
    /// Everything but where it starts and when it is sampled.
    pub run: Run,
    pub effects: Vec<EffectPlan>,
    /// The effects that there are: those of the catalogue, and laws as text.
    pub catalogue: Catalogue,
    /// How well a calibration knows the model.
    pub known: Option<Known>,
}

#[derive(Clone, Debug)]
pub(crate) struct MusclePlan {
    pub muscle: Muscle,
    /// Its file.
    pub text: String,
    pub pressure: Pressure,
    pub stiffness: String,
    pub extrapolation: Extrapolation,
    pub mass: MassPlan,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum MassPlan {
    Conserved,
    PerLength,
}

#[derive(Clone, Debug)]
pub(crate) enum Pressure {
    Constant(f64),
    /// Rows of time and pressure.
    Schedule(Vec<(f64, f64)>),
    AllRows,
    /// Each recording of an experiment has its own.
    Elsewhere,
}

pub(crate) const METHODS: [(&str, Method); 5] = [
    ("auto", Method::Auto),
    ("verlet", Method::Verlet),
    ("rodas4", Method::Rodas4),
    ("tr_bdf2", Method::TrBdf2),
    ("esdirk34", Method::Esdirk34),
];

/// The section of what a calibration says of the model's numbers.
const CALIBRATION: &str = "calibration";

/// Samples that a run may have: more is a slip of the rate or the duration.
const MOST_SAMPLES: f64 = 1e7;

impl Plan {
    pub fn read(document: &Document) -> Result<Plan, ScenarioError> {
        let keys = document.keys();
        keys.only(&SCENARIO)?;
        let mut plan = Plan::of(document, true)?;
        if keys.has(CALIBRATION) {
            let known = Known::read(document.text());
            plan.known = known.map_err(|error| keys.wrong(CALIBRATION, ScenarioProblem::Muscle(error)))?;
        }
        // Numbers that belong to a mesh are taken with it.
        plan.nodes = plan.nodes.or(plan.known.as_ref().and_then(|known| known.nodes));
        Ok(plan)
    }

    /// The model of an experiment, whose muscle has its pressure elsewhere; none without muscle and rod.
    pub fn of_experiment(document: &Document) -> Result<Option<Plan>, ScenarioError> {
        let keys = document.keys();
        if ["muscle", "rod"].into_iter().any(|key| keys.has(key)) {
            return Plan::of(document, false).map(Some);
        }
        if !["effects", "integrator", LAWS].into_iter().any(|key| keys.has(key)) {
            Ok(None)
        } else {
            Err(keys.missing(
                "rod",
                "[rod] or [muscle], for [effects], [laws] and [integrator] belong to a model",
            ))
        }
    }

    fn of(document: &Document, has_pressure: bool) -> Result<Plan, ScenarioError> {
        let keys = document.keys();
        let catalogue = laws::catalogue(document)?;
        let rod = keys.table("rod")?;
        rod.only(&[&OF_ROD[..], &ROD.map(|(key, _)| key)].concat())?;
        let release = keys.table("release")?;
        release.only(&OF_RELEASE)?;
        let RunPlan { rate, accuracy, chooses_tolerance, run } = read_run(&keys)?;
        let run = Run { history: read_history(&release)?, ..run };
        let schemes = [("consistent", Scheme::Consistent), ("paper", Scheme::Paper)];
        // `root` is what the key was called while it decided of nothing else.
        let scheme = if rod.has("root") { "root" } else { "scheme" };
        if rod.has("root") && rod.has("scheme") {
            let message = "this is the old name of rod.scheme, which is given too; keep that".to_owned();
            return Err(rod.wrong("root", ScenarioProblem::Other { message }));
        }
        let muscle = read_muscle(document, &keys.table("muscle")?, has_pressure)?;
        let base_angle = rod.quantity("base_angle", "rad")?.unwrap_or(0.0);
        let angle = release.quantity("angle", "rad")?.unwrap_or(base_angle);
        let is_clamped = !keys.table("effects")?.table("clamp_compliance")?.is_given();
        Ok(Plan {
            rod: read_rod(&rod)?,
            nodes: rod.count("nodes")?,
            scheme: rod.word(scheme, &schemes)?.unwrap_or_default(),
            base_angle,
            tip: rod.quantity_that("tip", "m", "lie in -1..=10 m", |tip| (-1.0..=10.0).contains(&tip))?,
            angle,
            angular_velocity: release.quantity("angular_velocity", "rad/s")?.unwrap_or(0.0),
            from: read_from(
                document,
                &release,
                muscle.is_some(),
                is_clamped && is_kinked(base_angle, angle),
                &catalogue,
            )?,
            rate,
            accuracy,
            chooses_tolerance,
            run,
            effects: read_effects(&keys.table("effects")?, &catalogue)?,
            catalogue,
            known: muscle.as_ref().and_then(|muscle| muscle.muscle.known.clone()),
            muscle,
        })
    }

    pub fn is_all_rows(&self) -> bool {
        self.muscle.as_ref().is_some_and(|muscle| matches!(muscle.pressure, Pressure::AllRows))
    }
}

/// The name that a document gives itself, or else that of its file, or else `usual`.
pub fn name(document: &Document, path: &Path, usual: &str) -> Result<String, ScenarioError> {
    let keys = document.keys();
    let Some((name, _)) = keys.text("name")? else {
        return Ok(path.file_stem().map_or(usual.into(), |stem| stem.to_string_lossy()).into_owned());
    };
    if name.trim().is_empty() || name.starts_with('.') || !name.chars().all(fits_name) {
        let must = "be made of letters, digits and - _ + . because folders are named after it";
        return Err(keys.wrong("name", ScenarioProblem::Must { must }));
    }
    Ok(name.to_owned())
}

/// Whether a name may have this character.
pub(crate) fn fits_name(c: char) -> bool {
    c.is_alphanumeric() || "-_.+ ".contains(c)
}

fn read_muscle(
    document: &Document,
    keys: &Keys,
    has_pressure: bool,
) -> Result<Option<MusclePlan>, ScenarioError> {
    if !keys.is_given() {
        return Ok(None);
    }
    keys.only(&OF_MUSCLE)?;
    let given: Vec<_> = ["name", "file", "text"].into_iter().filter(|key| keys.has(key)).collect();
    let text = match given[..] {
        ["name"] => {
            let name = keys.text("name")?.map_or("", |name| name.0);
            // Looked up first, for its message with the names that there are.
            Muscle::built_in(name).map_err(|error| keys.wrong("name", ScenarioProblem::Muscle(error)))?;
            models::muscle::BUILT_IN
                .iter()
                .find(|muscle| muscle.0 == name)
                .map_or("", |muscle| muscle.1)
                .into()
        }
        ["file"] => read_file(document, keys, "file")?.1,
        [_text] => keys.text("text")?.map_or(String::new(), |text| text.0.to_owned()),
        [] => return Err(keys.missing("name", "name = \"garbulinski-2022\", or file = \"mine.toml\"")),
        [_, second, ..] => {
            let message = "a muscle has one source; keep one of name, file and text".to_owned();
            return Err(keys.wrong(second, ScenarioProblem::Other { message }));
        }
    };
    let muscle = Muscle::from_toml(&text).map_err(|error| {
        let file = keys.text(given[0]).ok().flatten().filter(|_| given[0] != "text");
        let file = file.map_or("its text".to_owned(), |file| file.0.to_owned());
        let problem = ScenarioProblem::MuscleFile { file, error };
        document.error_of(&keys.path_of(given[0]), problem)
    })?;
    let sources: Vec<_> = muscle.stiffness_sources().collect();
    let stiffness = match keys.text("stiffness")? {
        Some((stiffness, _)) => stiffness.to_owned(),
        None if sources.contains(&CALIBRATED) => CALIBRATED.to_owned(),
        None if sources.contains(&"pder_32") => "pder_32".to_owned(),
        None if sources.len() == 1 => sources[0].to_owned(),
        None => return Err(keys.missing("stiffness", "stiffness = with the column that you mean")),
    };
    let extrapolation = [("refused", Extrapolation::Refused), ("allowed", Extrapolation::Allowed)];
    let extrapolation = keys.word("extrapolation", &extrapolation)?.unwrap_or_default();
    let middle = muscle.pressures()[0];
    (muscle.at(middle, &stiffness, extrapolation))
        .map_err(|error| keys.wrong("stiffness", ScenarioProblem::Muscle(error)))?;
    let masses = [("conserved", MassPlan::Conserved), ("per_length", MassPlan::PerLength)];
    Ok(Some(MusclePlan {
        text,
        pressure: if has_pressure { read_pressure(keys)? } else { elsewhere(keys)? },
        stiffness,
        extrapolation,
        mass: keys.word("mass", &masses)?.unwrap_or(MassPlan::Conserved),
        muscle,
    }))
}

/// Recordings have their pressures.
fn elsewhere(keys: &Keys) -> Result<Pressure, ScenarioError> {
    if !keys.has("pressure") {
        Ok(Pressure::Elsewhere)
    } else {
        let message = "each [[recording]] has its own pressure; move it there".to_owned();
        Err(keys.wrong("pressure", ScenarioProblem::Other { message }))
    }
}

fn read_pressure(keys: &Keys) -> Result<Pressure, ScenarioError> {
    if !keys.has("pressure") {
        return Err(keys.missing("pressure", "pressure = \"15 psi\""));
    }
    let form = "a row of time and pressure, such as [\"5 s\", \"20 psi\"],";
    if let Some(rows) = keys.rows("pressure", &["s", "Pa"], form)? {
        let rows: Vec<_> = rows.iter().map(|row| (row[0], row[1])).collect();
        if rows.is_empty() || rows.windows(2).any(|pair| pair[0].0 >= pair[1].0) {
            let must = "have one row at least, and each time later than the one before";
            return Err(keys.wrong("pressure", ScenarioProblem::Must { must }));
        }
        return Ok(Pressure::Schedule(rows));
    }
    if keys.text("pressure").is_ok_and(|text| text.is_some_and(|(text, _)| text == "all rows")) {
        return Ok(Pressure::AllRows);
    }
    Ok(Pressure::Constant(keys.quantity("pressure", "Pa")?.unwrap_or_default()))
}

fn read_history(release: &Keys) -> Result<Option<History>, ScenarioError> {
    let history = release.table("history")?;
    if !history.is_given() {
        return Ok(None);
    }
    history.only(&["hung", "raised", "held"])?;
    let not_negative = |key: &'static str, example: &'static str| {
        let time = history.quantity_that(key, "s", "not be negative", |time| time >= 0.0)?;
        time.ok_or_else(|| history.missing(key, example))
    };
    let raised = history.quantity_that("raised", "s", "be positive", |time| time > 0.0)?;
    Ok(Some(History {
        hung: not_negative("hung", "hung = \"20 s\"")?,
        raised: raised.ok_or_else(|| history.missing("raised", "raised = \"3 s\""))?,
        held: not_negative("held", "held = \"5 s\"")?,
    }))
}

/// What `[run]` and `[integrator]` say.
struct RunPlan {
    rate: Option<f64>,
    accuracy: Option<f64>,
    chooses_tolerance: bool,
    run: Run,
}

fn read_run(keys: &Keys) -> Result<RunPlan, ScenarioError> {
    let run = keys.table("run")?;
    run.only(&OF_RUN)?;
    let duration =
        run.quantity_that("duration", "s", "be positive", |duration| duration > 0.0)?.unwrap_or(20.0);
    let rate = run.quantity_that("rate", "Hz", "be positive", |rate| rate > 0.0)?;
    if duration * rate.unwrap_or(pace::DEFAULT_RATE) > MOST_SAMPLES {
        let must = "give no more than ten million samples; lower run.rate or run.duration";
        return Err(
            run.wrong(if rate.is_some() { "rate" } else { "duration" }, ScenarioProblem::Must { must })
        );
    }
    let must = "lie in 1e-9..=0.1 m";
    let accuracy = run.quantity_that("accuracy", "m", must, |accuracy| (1e-9..=0.1).contains(&accuracy))?;
    let integrator = keys.table("integrator")?;
    integrator.only(&OF_INTEGRATOR)?;
    let mut settings = Run { samples: Vec::new(), ..Run::release(duration, pace::DEFAULT_RATE) };
    let admitted = |tolerance: f64| (1e-12..=0.1).contains(&tolerance);
    settings.method = integrator.word("method", &METHODS)?.unwrap_or(DEFAULT_METHOD);
    let tolerance = integrator.quantity_that("tolerance", "", "lie in 1e-12..=0.1", admitted)?;
    settings.tolerance = tolerance.unwrap_or(DEFAULT_TOLERANCE);
    let fixed_step = integrator.quantity_that("fixed_step", "s", "be positive", |step| step > 0.0)?;
    settings.steps = fixed_step.map_or(Steps::Adaptive, Steps::Fixed);
    settings.most_steps = integrator.count("most_steps")?.unwrap_or(settings.most_steps);
    if settings.most_steps == 0 {
        return Err(integrator.wrong("most_steps", ScenarioProblem::Must { must: "be at least 1" }));
    }
    // How long the releases of an experiment last, only its recordings say.
    if let Some(step) = fixed_step.filter(|_| !keys.has("recording")) {
        let (steps, most) = ((duration / step).ceil(), settings.most_steps);
        if steps > most as f64 {
            let [least, duration] = [duration / most as f64, duration].map(|time| format_si(time, "s"));
            let message = format!(
                "takes {steps:.1e} steps for {duration}, and integrator.most_steps is {most}; give {least} or more, \
                 or raise integrator.most_steps"
            );
            return Err(integrator.wrong("fixed_step", ScenarioProblem::Other { message }));
        }
    }
    settings.energy = true;
    let chooses_tolerance = tolerance.is_none() && fixed_step.is_none();
    Ok(RunPlan { rate, accuracy, chooses_tolerance, run: settings })
}

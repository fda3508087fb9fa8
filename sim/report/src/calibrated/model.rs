//! The model with what a calibration has found, and how well that is known: what `efam simulate` and `efam predict`
//! take.

use efam_experiments::experiment::Experiment;
use efam_experiments::scenario::resolved::plain;
use efam_inference::calibrate::calibration::{Calibrated, Correlations, ReleaseFit};
use efam_inference::calibrate::problem::is_of_pressure;
use efam_inference::calibrate::{Calibration, Problem, Settings};
use models::muscle::{CalibratedColumn, CalibratedParameter, Found, Known, Misfit, Muscle, MuscleError};

/// A file with a calibrated model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelFile {
    /// Its name: `muscle.toml`, or `rod.toml`.
    pub name: String,
    /// What stands in it.
    pub text: String,
}

/// Parameters that a muscle file has columns for.
const COLUMNS: [(&str, &str); 3] = [
    (STIFFNESS, "bending_stiffness_calibrated"),
    ("effects.rayleigh_mass.alpha", "rayleigh_mass"),
    ("effects.rayleigh_stiffness.beta", "rayleigh_stiffness"),
];

const STIFFNESS: &str = "rod.bending_stiffness";
/// Parameters for which it has a constant.
const ROD_MASS: &str = "rod.mass";
const END_FITTING_MASS: &str = "effects.end_fitting.mass";

/// The files that a calibration of an experiment writes, to simulate and predict with: of its muscle, or of its rods.
/// # Errors
/// As for [`muscle_file`].
pub fn models(
    experiment: &Experiment,
    problem: &Problem,
    settings: &Settings,
    calibration: &Calibration,
) -> Result<Vec<ModelFile>, MuscleError> {
    let source = format!(
        "calibrated by efam {} from {} releases of {}",
        env!("CARGO_PKG_VERSION"),
        calibration.releases.iter().filter(|release| !release.held_out).count(),
        experiment.path.display()
    );
    let kept = problem.trials.first().filter(|_| !settings.remove_mesh);
    let nodes = kept.map(|trial| trial.model.edges + 1);
    match experiment.muscle().zip(experiment.stiffness()) {
        Some((muscle, stiffness)) => {
            Ok(muscle_file(muscle, calibration, nodes, stiffness, &source)?.into_iter().collect())
        }
        None => Ok(rod_files(problem, calibration, nodes, &source)),
    }
}

/// The muscle file of a calibration; nothing where it found nothing that has a column, or has a value
/// for each release. `stiffness` is the muscle's estimate of bending stiffness whose shape over pressure is kept
/// between calibrated pressures.
/// # Errors
/// [`MuscleError`] for a pressure at which the muscle is none.
pub fn muscle_file(
    muscle: &Muscle,
    calibration: &Calibration,
    nodes: Option<usize>,
    stiffness: &str,
    source: &str,
) -> Result<Option<ModelFile>, MuscleError> {
    let mut columns = Vec::new();
    let usable = |path: &str| {
        let found = calibration.of(path);
        let is_usable = !found.is_empty() && found.iter().all(|one| one.release.is_none());
        is_usable.then_some(found)
    };
    for (path, name) in COLUMNS {
        let Some(found) = usable(path) else { continue };
        // What all pressures share stands at any of them.
        let anywhere = calibration.releases.iter().find_map(|release| release.pressure_pa).unwrap_or(0.0);
        let values = found.iter().map(|one| (one.pressure_pa.unwrap_or(anywhere), one.value));
        // One EI for all pressures has no shape.
        let keeps_shape = path == STIFFNESS && found.iter().all(|one| one.pressure_pa.is_some());
        let shape = keeps_shape.then(|| stiffness.to_owned());
        columns.push(CalibratedColumn { name, values: values.collect(), shape });
    }
    if columns.is_empty() {
        return Ok(None);
    }
    let shared = |path: &str| usable(path).filter(|found| found.len() == 1).map(|found| found[0].value);
    let mut known = known(calibration, nodes, &|one| {
        let path = one.name.as_str();
        COLUMNS.iter().any(|(column, _)| *column == path) || [ROD_MASS, END_FITTING_MASS].contains(&path)
    });
    known.interpolation = muscle.interpolation(&known, stiffness)?;
    let found =
        Found { columns, rod_mass: shared(ROD_MASS), end_fitting_mass: shared(END_FITTING_MASS), known };
    let text = muscle.calibrated(source, &found)?;
    Ok(Some(ModelFile { name: "muscle.toml".to_owned(), text }))
}

/// The rods of a calibration that are no muscle, each a scenario of its first release with what was found in it: one
/// for each pressure.
pub fn rod_files(
    problem: &Problem,
    calibration: &Calibration,
    nodes: Option<usize>,
    source: &str,
) -> Vec<ModelFile> {
    let mut pressures: Vec<Option<f64>> = Vec::new();
    let mut files = Vec::new();
    let known = known(calibration, nodes, &|_| true);
    let applied = calibration.applied(problem);
    for trial in applied.trials.iter().filter(|trial| !trial.release.held_out) {
        let pressure = trial.release.pressure;
        if pressures
            .iter()
            .any(|known| known.is_some() == pressure.is_some() && is_of_pressure(*known, pressure))
        {
            continue;
        }
        pressures.push(pressure);
        let duration = trial.release.time.last().copied().unwrap_or(20.0);
        let own = known.of(|parameter| is_of_pressure(parameter.pressure_pa, pressure));
        let text = plain(source, &trial.release.name, &trial.model, duration) + "\n" + &own.section();
        files.push(ModelFile { name: format!("rod-{}.toml", files.len() + 1), text });
    }
    if let [only] = &mut files[..] {
        only.name = "rod.toml".to_owned();
    }
    files
}

/// How far the model is from releases, root mean square; none without any.
fn misfit<'a>(releases: impl Iterator<Item = &'a ReleaseFit>) -> Option<Misfit> {
    let releases: Vec<_> = releases.collect();
    let mean = |of: &dyn Fn(&ReleaseFit) -> Option<f64>| {
        let values: Vec<f64> = releases.iter().filter_map(|release| of(release)).collect();
        (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
    };
    let frequencies = || releases.iter().filter_map(|release| release.misfit.frequency_hz);
    (!releases.is_empty()).then(|| Misfit {
        distance: mean(&|release| Some(1e-3 * release.misfit.distance_mm / release.excursion_m)),
        rest: mean(&|release| Some(1e-3 * release.misfit.rest_mm / release.excursion_m)),
        frequency: mean(&|release| release.misfit.frequency),
        damping_ratio: mean(&|release| release.misfit.damping_ratio),
        frequency_hz: frequencies().next().map(|_| Known::span(frequencies())),
    })
}

/// How well a calibration knows some of its numbers.
fn known(calibration: &Calibration, nodes: Option<usize>, is_told: &dyn Fn(&Calibrated) -> bool) -> Known {
    let is_told = |one: &&Calibrated| one.release.is_none() && is_told(one);
    let own: Vec<&Calibrated> = calibration.parameters.iter().filter(is_told).collect();
    let correlation = |a: &Calibrated, b: &Calibrated| {
        if a.label() == b.label() {
            return 1.0;
        }
        let together = |group: &&Correlations| {
            let at = |one: &Calibrated| group.names.iter().position(|name| *name == one.label());
            Some(group.matrix[at(a)?][at(b)?].clamp(-1.0, 1.0))
        };
        calibration.correlations.iter().find_map(|group| together(&group)).unwrap_or(0.0)
    };
    let parameter = |one: &&Calibrated| CalibratedParameter {
        path: one.name.clone(),
        pressure_pa: one.pressure_pa,
        value: one.value,
        standard_error: one.standard_error,
        correlations: own.iter().map(|other| correlation(one, other)).collect(),
    };
    let fitted = || calibration.releases.iter().filter(|release| !release.held_out);
    Known {
        releases: fitted().count(),
        pressure_pa: Known::span(fitted().filter_map(|release| release.pressure_pa)),
        payload_kg: Known::span(fitted().map(|release| release.payload_kg)),
        excursion_m: fitted().map(|release| release.excursion_m).fold(0.0, f64::max),
        nodes,
        misfit: misfit(fitted().filter(|release| release.excursion_m > 0.0)),
        interpolation: Vec::new(),
        parameter: own.iter().map(parameter).collect(),
    }
}

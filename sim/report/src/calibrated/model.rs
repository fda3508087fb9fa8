//! The model with what a calibration has found, and how well that is known: what `efam simulate` and `efam predict`
//! take.

use efam_experiments::experiment::Experiment;
use efam_experiments::scenario::resolved::plain;
use efam_inference::calibrate::calibration::{Calibrated, Correlations, ReleaseFit};
use efam_inference::calibrate::problem::is_of_pressure;
use efam_inference::calibrate::{Calibration, CalibrationSettings, Problem};
use models::model::Model;
use models::muscle::{
    CalibratedColumn, CalibratedParameter, Found, Known, Marker, Misfit, Muscle, MuscleError,
};
use models::statics::{equilibrium, modes};

/// A file with a calibrated model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelFile {
    /// Its name: `muscle.toml`, or `rod.toml`.
    pub name: String,
    /// Its content.
    pub text: String,
}

/// Parameters that a muscle file has columns for.
const COLUMNS: [(&str, &str); 3] = [
    (STIFFNESS, "bending_stiffness_calibrated"),
    (LOSSES[0], "rayleigh_mass"),
    (LOSSES[1], "rayleigh_stiffness"),
];

const STIFFNESS: &str = "rod.bending_stiffness";
const LOSSES: [&str; 2] = ["effects.rayleigh_mass.alpha", "effects.rayleigh_stiffness.beta"];
/// Parameters for which it has a constant.
const ROD_MASS: &str = "rod.mass";
const END_FITTING_MASS: &str = "effects.end_fitting.mass";

/// The files that a calibration of an experiment writes, to simulate and predict with: of its muscle, or of its rods.
/// # Errors
/// As for [`muscle_file`].
pub fn models(
    experiment: &Experiment,
    problem: &Problem,
    settings: &CalibrationSettings,
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
            let setup =
                Setup { marker: calibration.marker(problem), nodes, swings: swings(problem, calibration) };
            Ok(muscle_file(muscle, calibration, setup, stiffness, &source)?.into_iter().collect())
        }
        None => Ok(rod_files(problem, calibration, nodes, &source)),
    }
}

/// What a calibration knows beside its numbers.
#[derive(Clone, Debug, Default)]
pub struct Setup {
    /// Offset of the tip's marker.
    pub marker: Option<Marker>,
    /// Nodes that the numbers belong to, if they belong to a mesh.
    pub nodes: Option<usize>,
    /// Frequencies of small swings of the rods that were fitted, Hz.
    pub swings: Vec<f64>,
}

/// Frequencies of small swings of the rods that were fitted, Hz.
fn swings(problem: &Problem, calibration: &Calibration) -> Vec<f64> {
    let swing = |model: &Model| {
        let rest = equilibrium(model, None).ok()?;
        Some(modes(model, &rest, 1).ok()?.first()?.angular_frequency / std::f64::consts::TAU)
    };
    let applied = calibration.applied(problem);
    applied.trials().filter(|trial| !trial.release.held_out).filter_map(|trial| swing(&trial.model)).collect()
}

/// The muscle file of a calibration; nothing where it found nothing that has a column, or has a value
/// for each release. `stiffness` is the muscle's estimate of bending stiffness whose shape over pressure is kept
/// between calibrated pressures.
/// # Errors
/// [`MuscleError`] for a pressure at which the muscle is none.
pub fn muscle_file(
    muscle: &Muscle,
    calibration: &Calibration,
    setup: Setup,
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
        // What all pressures share is given at any of them.
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
    let mut known = known(calibration, setup, &|one| {
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
    let setup = Setup { marker: calibration.marker(problem), nodes, swings: swings(problem, calibration) };
    let known = known(calibration, setup, &|_| true);
    let held = calibration.as_held(problem);
    for trial in held.trials.iter().filter(|trial| !trial.release.held_out) {
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
        let text =
            plain(source, &trial.release.name, &trial.model, &trial.run, duration) + "\n" + &own.section();
        files.push(ModelFile { name: format!("rod-{}.toml", files.len() + 1), text });
    }
    if let [only] = &mut files[..] {
        only.name = "rod.toml".to_owned();
    }
    files
}

/// How far the model is from releases, root mean square; none without any. A stiffness fits one frequency and a loss one
/// damping ratio: a release that took no part is farther off than those that were fitted, by the degrees of freedom.
/// Frequencies are those as released, and those of small swings of the fitted rods, Hz.
fn misfit<'a>(
    releases: impl Iterator<Item = &'a ReleaseFit>,
    [stiffnesses, losses]: [usize; 2],
    swings: &[f64],
) -> Option<Misfit> {
    let releases: Vec<_> = releases.collect();
    let mean = |fitted: usize, of: &dyn Fn(&ReleaseFit) -> Option<f64>| {
        let values: Vec<f64> = releases.iter().filter_map(|release| of(release)).collect();
        // As many numbers as releases fit exactly, and show nothing.
        let degrees = if values.len() > fitted { values.len() - fitted } else { values.len().max(1) };
        (values.iter().map(|value| value * value).sum::<f64>() / degrees as f64).sqrt()
    };
    let frequencies = || releases.iter().filter_map(|release| release.misfit.frequency_hz);
    (!releases.is_empty()).then(|| Misfit {
        distance: mean(0, &|release| Some(1e-3 * release.misfit.distance_mm / release.excursion_m)),
        rest: mean(0, &|release| Some(1e-3 * release.misfit.rest_mm / release.excursion_m)),
        frequency: mean(stiffnesses, &|release| release.misfit.frequency),
        damping_ratio: mean(losses, &|release| release.misfit.damping_ratio),
        frequency_hz: frequencies().next().map(|_| Known::span(frequencies().chain(swings.iter().copied()))),
    })
}

/// How well a calibration knows some of its numbers.
fn known(calibration: &Calibration, setup: Setup, is_told: &dyn Fn(&Calibrated) -> bool) -> Known {
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
    let [stiffnesses, losses] = [&[STIFFNESS][..], &LOSSES]
        .map(|paths| calibration.parameters.iter().filter(|one| paths.contains(&one.name.as_str())).count());
    Known {
        releases: fitted().count(),
        pressure_pa: Known::span(fitted().filter_map(|release| release.pressure_pa)),
        payload_kg: Known::span(fitted().map(|release| release.payload_kg)),
        excursion_m: fitted().map(|release| release.excursion_m).fold(0.0, f64::max),
        nodes: setup.nodes,
        misfit: misfit(
            fitted().filter(|release| release.excursion_m > 0.0),
            [stiffnesses, losses],
            &setup.swings,
        ),
        marker: setup.marker,
        interpolation: Vec::new(),
        parameter: own.iter().map(parameter).collect(),
    }
}

#[cfg(test)]
mod tests {
    use efam_inference::calibrate::misfit::{FrequencyAndDamping, Misfit};

    use super::*;

    /// Five releases of two pressures, whose frequencies are 1 % off: three degrees of freedom are left beside two
    /// stiffnesses. One release and one stiffness leave none.
    #[test]
    fn what_was_fitted_is_met_more_nearly_than_what_was_not() {
        let release = |frequency: f64| ReleaseFit {
            name: "made-up".to_owned(),
            pressure_pa: None,
            payload_kg: 0.0,
            excursion_m: 0.1,
            held_out: false,
            duration_s: 8.0,
            measured: FrequencyAndDamping::default(),
            fitted: FrequencyAndDamping::default(),
            tracks: Vec::new(),
            misfit: Misfit { frequency: Some(frequency), ..Default::default() },
            numerical_error_mm: 0.0,
            numerical_error_left_mm: 0.0,
        };
        let five = [0.01, -0.01, 0.01, -0.01, 0.01].map(release);
        let found = misfit(five.iter(), [2, 2], &[]).unwrap().frequency;
        assert!((found / (0.01 * (5f64 / 3.0).sqrt()) - 1.0).abs() < 1e-12, "{found}");
        assert!((misfit(five[..1].iter(), [1, 2], &[]).unwrap().frequency - 0.01).abs() < 1e-12);
    }
}

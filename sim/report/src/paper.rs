//! What the paper's Figures 4 to 9 show: from runs of our own, or from the recordings of an experiment.
//!
//! The paper publishes no trajectory and no position of a marker. So without recordings, its measurements are replaced
//! by a release that is simulated at every pressure of its table. That rod has the bending stiffness that the paper's
//! 32-node rod was fitted with, and the root and the mass that belong to that (see `SCENARIO`). The tip at rest of that
//! run replaces the measured tip; the paper's beam and its rods of 4 to 40 nodes are fitted to it as the paper fits
//! them. So the rod of 32 nodes finds the table's own stiffness again, and no error: by construction.
//!
//! With an experiment the tips are recorded, and the models are fitted to their rests.
//!
//! Source: Bending Properties of an Extensile Fluidic Artificial Muscle, Results, Figures 4 to 9 and Table 2.

use std::f64::consts::TAU;

use efam_core::rest::{Rest, rest as rest_of};
use efam_core::trajectory::Trajectory;
use efam_experiments::analyse::Analysed;
use efam_experiments::analysis::AnalysisError;
use efam_experiments::analysis::bending_stiffness::StiffnessFit;
use efam_experiments::analysis::coordinate::Coordinate;
use efam_experiments::analysis::decay::Decay;
use efam_experiments::analysis::measured::{Measured, analyse_along};
use efam_experiments::analysis::rest;
use efam_experiments::analysis::spectrum::Spectrum;
use efam_experiments::analysis::static_stiffness::{NODES, StaticFit, beam, compare};
use efam_experiments::experiment::{Experiment, ExperimentError};
use efam_experiments::release::Point;
use efam_experiments::scenario::Case;
use efam_experiments::summary::{MODES, OfCoordinate, Summary, Swings, summarise};
use efam_inference::calibrate::problem::is_same_pressure;
use models::model::Model;
use models::muscle::{Extrapolation, Muscle, MuscleError};
use models::statics::euler_bernoulli::EulerBernoulli;

/// The muscle of the figures that are simulated.
pub const MUSCLE: &str = "garbulinski-2022";
/// What is simulated for them: the paper's setup, as far as it is said.
pub const SCENARIO: &str = r#"# Purpose: what `efam figures` simulates.
# Expected: Table 2's stiffness is used as it was fitted: 32 nodes, a whole Voronoi length at the clamp, the resting
# mass per length at every pressure. The paper gives no Rayleigh constants: both are assumed.
name = "figures"

[muscle]
name = "garbulinski-2022"
pressure = "all rows"
stiffness = "pder_32"
mass = "per_length"

[rod]
nodes = 32
scheme = "paper"

[effects.rayleigh_mass]
alpha = "1 1/s"

[effects.rayleigh_stiffness]
beta = "2 ms"
"#;
/// Pieces into which the curve of the beam is divided.
const PIECES: usize = 32;
/// Places along two shapes at which they are compared.
const PLACES: usize = 50;
/// Nodes of the rod whose slowest mode is set beside a recorded frequency: the paper's choice.
const OF_MODE: usize = 32;

/// One pressure.
pub struct Pressure {
    /// Above ambient, Pa.
    pub pressure: f64,
    /// Name of the run or of the release.
    pub name: String,
    /// Times of the path, s after release.
    pub times: Vec<f64>,
    /// Path of the tip, m.
    pub path: Vec<[f64; 2]>,
    /// Where the tip comes to rest, m.
    pub tip_at_rest: Option<[f64; 2]>,
    /// Points of the rod at rest, as share of the active length and position, m: nodes, or markers.
    pub body_at_rest: Vec<(f64, [f64; 2])>,
    /// EI of the muscle's table: from the axial test, of the beam, of the rod of 32 nodes, N m².
    pub published: [Option<f64>; 3],
    /// EI and tip error of the beam and of the rods of [`NODES`], fitted to the tip at rest.
    pub fits: Vec<StaticFit>,
    /// Their shapes at rest with that EI.
    pub shapes: Vec<Shape>,
    /// Frequency and damping.
    pub numbers: Numbers,
    /// Where all that comes from.
    pub origin: Origin,
}

/// Frequency and damping at a pressure; what could not be found is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Numbers {
    /// From the spectrum, Hz.
    pub damped_frequency_hz: Option<f64>,
    /// By eq. 7, Hz.
    pub natural_frequency_hz: Option<f64>,
    /// By eq. 6.
    pub damping_ratio: Option<f64>,
    /// Slowest mode about the rest, Hz; of a recording that of the rod of 32 nodes with the EI of the tip at rest.
    pub first_mode_hz: Option<f64>,
    /// Whether the tip passed beyond straight down; none where only the end body's angle would show it.
    pub beyond_straight_down: Option<bool>,
}

/// Whether a pressure was simulated or recorded, and what figure 8 needs of it.
pub enum Origin {
    /// By ourselves.
    Simulated(Box<Simulated>),
    /// In an experiment; none where there are too few samples for a spectrum.
    Recorded(Option<Box<Measured>>),
}

/// A simulated release.
pub struct Simulated {
    /// What was simulated.
    pub model: Model,
    /// The release.
    pub trajectory: Trajectory,
    /// Its rest, if it has one.
    pub rest: Option<Rest>,
    /// Its numbers.
    pub summary: Summary,
    /// Its spectra and decays.
    pub swings: Swings,
}

/// A shape at rest, from the clamp to the tip.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Nodes of the rod; none for the beam.
    pub nodes: Option<usize>,
    /// Points, m: along the active length, then the tip.
    pub points: Vec<[f64; 2]>,
    /// Farthest distance from the body at rest at one share of the active length, m; none without such points.
    pub off: Option<f64>,
}

impl Pressure {
    /// What the figures need of a simulated case.
    /// # Errors
    /// [`MuscleError`] of a pressure that Table 2 does not hold.
    pub fn simulated(case: &Case, trajectory: Trajectory) -> Result<Self, MuscleError> {
        let pressure = case.pressure.unwrap_or_default();
        let muscle = Muscle::built_in(MUSCLE)?;
        let mut published = [None; 3];
        for (value, source) in published.iter_mut().zip(COLUMNS) {
            *value = Some(muscle.at(pressure, source, Extrapolation::Refused)?.bending_stiffness);
        }
        let model = case.model.clone();
        let end = trajectory.times.last().copied().unwrap_or(0.0);
        let rest = rest_of(&model, end, MODES);
        let (mut summary, swings) = summarise(&model, &case.run, &trajectory, &rest);
        summary.name = case.name.clone();
        let rest = rest.ok();
        let meshes: Vec<Model> = NODES.iter().filter_map(|nodes| model.with_nodes(*nodes).ok()).collect();
        let body_at_rest = rest.as_ref().map(|rest| by_share(&rest.nodes)).unwrap_or_default();
        let fits = rest.as_ref().map_or(Vec::new(), |rest| compare(rest.tip, &meshes));
        let mode = summary.modes.as_ref().and_then(|modes| modes.first());
        let [damped_frequency_hz, natural_frequency_hz, damping_ratio] = summary.as_paper();
        Ok(Self {
            pressure,
            name: case.name.clone(),
            times: trajectory.times.clone(),
            path: trajectory.tip.clone(),
            tip_at_rest: rest.as_ref().map(|rest| rest.tip),
            published,
            shapes: fits.iter().filter_map(|fit| shape(&meshes, fit, &body_at_rest)).collect(),
            fits,
            body_at_rest,
            numbers: Numbers {
                damped_frequency_hz,
                natural_frequency_hz,
                damping_ratio,
                first_mode_hz: mode.map(|mode| mode.natural_frequency_hz),
                beyond_straight_down: summary.beyond_straight_down,
            },
            origin: Origin::Simulated(Box::new(Simulated { model, trajectory, rest, summary, swings })),
        })
    }

    /// What the figures need of an analysed release at a known pressure, Pa.
    fn recorded(experiment: &Experiment, one: &Analysed, pressure: f64) -> Result<Self, ExperimentError> {
        let mut meshes = Vec::new();
        for nodes in NODES {
            let case = one.of.case_at_rest(experiment, one.of.angle, Some(nodes))?;
            meshes.extend(case.map(|case| case.model));
        }
        let measured = by_height(one);
        let decay = measured.as_ref().and_then(|measured| measured.decay.as_ref().ok());
        let published = COLUMNS.map(|source| {
            let muscle = experiment.muscle()?;
            Some(muscle.at(pressure, source, Extrapolation::Refused).ok()?.bending_stiffness)
        });
        let tip = one.tip_at_rest();
        let body_at_rest = markers_at_rest(one);
        let seen = one.of.release.time.iter().zip(&one.of.release.tracks[0].position);
        let (times, path) =
            seen.filter(|(time, _)| **time >= 0.0).filter_map(|(time, at)| Some((*time, (*at)?))).unzip();
        let fitted =
            one.at_rest.iter().find(|fit| fit.nodes == Some(OF_MODE)).and_then(|fit| found(fit).ok());
        let mode = fitted.and_then(|fit| {
            let mut model = meshes.iter().find(|mesh| mesh.edges + 1 == OF_MODE)?.clone();
            model.set("rod.bending_stiffness", fit.bending_stiffness).ok()?;
            rest_of(&model, 0.0, 1).ok()?.modes.ok()?.first().map(|(hertz, _)| *hertz)
        });
        Ok(Self {
            pressure,
            name: one.of.release.name.clone(),
            times,
            path,
            tip_at_rest: Some(tip),
            published,
            shapes: one.at_rest.iter().filter_map(|fit| shape(&meshes, fit, &body_at_rest)).collect(),
            fits: one.at_rest.clone(),
            body_at_rest,
            numbers: Numbers {
                damped_frequency_hz: measured
                    .as_ref()
                    .and_then(|measured| measured.damped_frequency.as_ref().ok().map(|omega| omega / TAU)),
                natural_frequency_hz: decay.map(|decay| decay.natural_frequency / TAU),
                damping_ratio: decay.map(|decay| decay.damping_ratio),
                first_mode_hz: mode,
                beyond_straight_down: None,
            },
            origin: Origin::Recorded(measured.map(Box::new)),
        })
    }

    /// The fit of the beam, or of a rod of so many nodes.
    pub fn fit(&self, nodes: Option<usize>) -> Option<&StiffnessFit> {
        self.fits.iter().find(|fit| fit.nodes == nodes).and_then(|fit| found(fit).ok())
    }

    /// The tip error of that fit, m.
    pub fn tip_error(&self, nodes: Option<usize>) -> Option<f64> {
        self.fit(nodes).map(|fit| fit.residual[0].hypot(fit.residual[1]))
    }

    /// Whether it was recorded.
    pub fn is_recorded(&self) -> bool {
        matches!(self.origin, Origin::Recorded(_))
    }

    /// Its amplitude spectrum.
    pub fn spectrum(&self) -> Option<&Spectrum> {
        match &self.origin {
            Origin::Simulated(own) => own.shown().map(|own| &own.swing.spectrum),
            Origin::Recorded(own) => own.as_ref().map(|own| &own.spectrum),
        }
    }

    /// Eq. 6 fitted to its upper peaks.
    pub fn decay(&self) -> Option<&Decay> {
        match &self.origin {
            Origin::Simulated(own) => own.shown()?.swing.decay.as_ref().ok(),
            Origin::Recorded(own) => own.as_ref()?.decay.as_ref().ok(),
        }
    }

    /// The coordinate that was analysed: the height, or that of the largest motion where the height has no upper peaks.
    pub fn coordinate(&self) -> Coordinate {
        match &self.origin {
            Origin::Recorded(own) => own.as_ref().map_or(Coordinate::HEIGHT, |own| own.coordinate),
            Origin::Simulated(own) => own.shown().map_or(Coordinate::HEIGHT, |own| own.coordinate),
        }
    }
}

impl Simulated {
    /// The swing of the height, or where that has no upper peaks, along the first mode.
    pub fn shown(&self) -> Option<&OfCoordinate> {
        let of_height = self.swings.height.as_ref().filter(|own| own.swing.decay.is_ok());
        of_height.or(self.swings.coordinate.as_ref())
    }
}

/// The paper's analysis of a release: of the height, where its frequency is that of the swing.
fn by_height(one: &Analysed) -> Option<Measured> {
    let own = one.measured.as_ref().ok()?;
    let of_height = analyse_along(&one.of.release, one.tip_at_rest(), Coordinate::HEIGHT).ok();
    let is_the_swing = |height: &Measured| match (&height.decay, &own.damped_frequency) {
        (Ok(decay), Ok(omega)) => (decay.damped_frequency / omega - 1.0).abs() < SAME_SWING,
        _ => false,
    };
    Some(of_height.filter(is_the_swing).unwrap_or_else(|| own.clone()))
}

/// Share by which frequencies of two coordinates of one swing differ at most; harmonics differ by a half and more.
const SAME_SWING: f64 = 0.25;

/// The estimates of bending stiffness of Table 2.
const COLUMNS: [&str; 3] = ["axial", "euler", "pder_32"];

/// Why an experiment has no figures.
#[derive(Debug, thiserror::Error)]
pub enum FiguresError {
    /// No model, or no pressures.
    #[error("{file}: the figures are over pressure, of a rod that is known; {what}")]
    Incomplete {
        /// The experiment.
        file: String,
        /// What is missing, and the next move.
        what: &'static str,
    },
    /// A model that cannot be.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
}

/// Whether an experiment can have figures: checked before its recordings are read.
/// # Errors
/// [`FiguresError::Incomplete`] without a model or without pressures.
pub fn admit(experiment: &Experiment) -> Result<(), FiguresError> {
    let missing = |what: &'static str| {
        Err(FiguresError::Incomplete { file: experiment.path.display().to_string(), what })
    };
    if !experiment.has_model() {
        return missing("add [muscle] or [rod] to the experiment");
    }
    if experiment.recordings.iter().all(|entry| entry.pressure.is_none()) {
        return missing("give the pressure of each [[recording]]");
    }
    Ok(())
}

/// The figures of an experiment's releases, analysed with [`NODES`], by pressure. Of several releases at one pressure the one with the lightest
/// payload counts, a level base before an inclined one, and then the representative.
/// # Errors
/// [`FiguresError`] for an experiment without a model or without pressures.
pub fn of_experiment(experiment: &Experiment, analysed: &[Analysed]) -> Result<Vec<Pressure>, FiguresError> {
    admit(experiment)?;
    let mut chosen: Vec<(f64, &Analysed)> = Vec::new();
    // The smaller, the better.
    let rank = |one: &Analysed| {
        (one.of.release.payload, u8::from(one.no_beam.is_some()), u8::from(!one.of.representative))
    };
    for one in analysed {
        let Some(pressure) = one.of.release.pressure else { continue };
        match chosen.iter_mut().find(|(known, _)| is_same_pressure(*known, pressure)) {
            Some((_, best)) if rank(one) < rank(best) => *best = one,
            Some(_) => {}
            None => chosen.push((pressure, one)),
        }
    }
    chosen.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all = chosen.into_iter().map(|(pressure, one)| Pressure::recorded(experiment, one, pressure));
    Ok(all.collect::<Result<_, _>>()?)
}

/// Where markers on the body come to rest, clamp first; none but the clamp without such markers.
fn markers_at_rest(one: &Analysed) -> Vec<(f64, [f64; 2])> {
    let release = &one.of.release;
    let decay = one.measured.as_ref().ok().and_then(|own| own.decay.as_ref().ok());
    let rested = |position: &[Option<[f64; 2]>]| {
        let by_decay = decay.and_then(|decay| {
            let rate = decay.damping_ratio * decay.natural_frequency;
            rest::estimate(&release.time, position, one.of.swings_until, decay.damped_frequency, rate)
        });
        by_decay.map(|rest| rest.position)
    };
    let mut all = vec![(0.0, [0.0, 0.0])];
    all.extend(release.tracks.iter().filter_map(|track| match track.at {
        Point::Along(share) => Some((share, rested(&track.position)?)),
        Point::Tip => None,
    }));
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

/// The paper's search; where it stalled, the other one, which minimises the same.
pub fn found(fit: &StaticFit) -> Result<&StiffnessFit, &AnalysisError> {
    fit.nelder_mead.as_ref().or(fit.gauss_newton.as_ref())
}

/// The shape of a fitted model beside points of the body at rest.
fn shape(meshes: &[Model], fit: &StaticFit, body: &[(f64, [f64; 2])]) -> Option<Shape> {
    let bending_stiffness = found(fit).ok()?.bending_stiffness;
    let (active, tip) = match fit.nodes {
        None => {
            let beam = EulerBernoulli { bending_stiffness, ..beam(meshes.first()?) };
            let active: Vec<[f64; 2]> = beam.shape(PIECES).iter().map(|pose| pose.position).collect();
            (active, beam.tip().position)
        }
        Some(nodes) => {
            let mut mesh = meshes.iter().find(|mesh| mesh.edges + 1 == nodes)?.clone();
            mesh.set("rod.bending_stiffness", bending_stiffness).ok()?;
            let rest = rest_of(&mesh, 0.0, 1).ok()?;
            (rest.nodes, rest.tip)
        }
    };
    let distance = |(share, at): &(f64, [f64; 2])| {
        let own = along(&active, *share);
        (own[0] - at[0]).hypot(own[1] - at[1])
    };
    // The clamp alone says nothing.
    let off = (body.len() > 1).then(|| body.iter().map(distance).fold(0.0, f64::max));
    let points = active.into_iter().chain([tip]).collect();
    Some(Shape { nodes: fit.nodes, points, off })
}

/// Points of a rod at even shares of its length.
fn by_share(nodes: &[[f64; 2]]) -> Vec<(f64, [f64; 2])> {
    let share = |k: usize| k as f64 / PLACES as f64;
    (0..=PLACES).map(|k| (share(k), along(nodes, share(k)))).collect()
}

/// The point at a share of the length of a line through points.
fn along(points: &[[f64; 2]], share: f64) -> [f64; 2] {
    let length = |pair: &[[f64; 2]]| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
    let whole: f64 = points.windows(2).map(length).sum();
    let mut left = share * whole;
    for pair in points.windows(2) {
        let own = length(pair);
        if left <= own && own > 0.0 {
            let part = left / own;
            return [0, 1].map(|k| pair[0][k] + part * (pair[1][k] - pair[0][k]));
        }
        left -= own;
    }
    points.last().copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_along_a_bent_line_is_found_by_its_length() {
        let bent = [[0.0, 0.0], [3.0, 0.0], [3.0, -1.0]];
        assert_eq!(along(&bent, 0.0), [0.0, 0.0]);
        assert_eq!(along(&bent, 0.5), [2.0, 0.0]);
        assert_eq!(along(&bent, 0.875), [3.0, -0.5]);
        let end = along(&bent, 1.0);
        assert!((end[0] - 3.0).abs() < 1e-12 && (end[1] + 1.0).abs() < 1e-12, "{end:?}");
    }
}

//! What a run comes to, as numbers: `summary.json`.
//!
//! All in SI, with the unit in the name; frequencies in Hz. What cannot be computed, because the run
//! was too short, did not swing, or was cut short, is null, and [`Summary::missing`] says why.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt::Display;

use efam_core::accuracy::Errors;
use efam_core::forward::{Initial, Run};
use efam_core::integrate::{Effort, Method};
use efam_core::rest::{Rest, rest, slipping_modes};
use efam_core::trajectory::{Instant, Status, Trace, Trajectory};
use models::digits::{short, significant};
use models::model::{Model, Scheme};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::analysis::coordinate::Coordinate;
use crate::analysis::decay::{self, Decay};
use crate::analysis::peaks;
use crate::analysis::settling::settling_time;
use crate::analysis::spectrum::Spectrum;
use crate::analysis::swing::{self, Known, swing_along};
use crate::analysis::{AnalysisError, Excursion};
use crate::drive::Drive;
use crate::events::{self, Event, EventKind};

/// Number of modes in a summary.
pub const MODES: usize = 3;

/// Results of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Summary {
    /// Name of the run.
    pub name: String,
    /// Whether it came to its end: complete, cut short, or failed and why.
    pub status: Status,
    /// Last time sampled, s after release.
    pub simulated_s: f64,
    /// Number of samples.
    pub samples: usize,
    /// Static equilibrium under the pressure and the loads at the end of the run.
    pub rest: Option<Place>,
    /// What happened, by time: the release, steps and ramps of pressure and force, steady forcing, each with the response
    /// of the tip in x and in z.
    #[serde(default)]
    pub events: Vec<Event>,
    /// Time of the event that frequency, peaks, damping and settling follow: the release, or else the first step or ramp.
    /// Their times count from it.
    #[serde(default)]
    pub event_s: Option<f64>,
    /// The direction along which frequency, peaks, damping and settling are measured: that of the first mode about the rest,
    /// positive on the side of the start.
    pub coordinate: Option<Coordinate>,
    /// Upper peaks of the coordinate, one in a period.
    pub peaks: Option<Vec<Peak>>,
    /// Where the tip first turned upwards.
    pub first_low: Option<Place>,
    /// Where it was lowest.
    pub lowest: Option<Place>,
    /// Whether the tip passed beyond straight down, which gives z(t) a second bump in each swing.
    pub beyond_straight_down: Option<bool>,
    /// Least angle of the end body, rad from x towards z; below −π/2 is beyond straight down.
    pub least_tip_angle_rad: Option<f64>,
    /// Damped frequency: where the amplitude spectrum of the coordinate is highest about the first mode.
    pub damped_frequency_hz: Option<f64>,
    /// Natural frequency, from the damped one by eq. 7.
    pub natural_frequency_hz: Option<f64>,
    /// Damping ratio of eq. 6 fitted to the upper peaks.
    pub damping_ratio: Option<f64>,
    /// A0 of that fit.
    pub decay_amplitude_m: Option<f64>,
    /// Root mean square distance of the peaks from the fit; large where damping depends on amplitude.
    pub decay_residual_m: Option<f64>,
    /// The same of the tip's height, as the paper has it.
    pub height: Option<OfHeight>,
    /// Damping and frequency from each upper peak to the next.
    pub cycles: Option<Vec<Cycle>>,
    /// Small vibrations about the rest, slowest first. Friction, where there is any, sticks in them.
    pub modes: Option<Vec<Mode>>,
    /// Those of the rod whose friction slips, as in a swing that is large against it; only where there is friction, and
    /// empty where they are not found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slipping_modes: Option<Vec<Mode>>,
    /// Time after which the coordinate stays within 2 % of its largest excursion.
    pub settling_2_percent_s: Option<f64>,
    /// The same for 5 %.
    pub settling_5_percent_s: Option<f64>,
    /// Greatest speed of the tip.
    pub peak_speed: Option<PeakSpeed>,
    /// How well the energy adds up.
    pub energy: Option<EnergyBalance>,
    /// How wrong the tip may be; null where the run did not come to its end, or it was not estimated.
    #[serde(default)]
    pub errors: Option<Errors>,
    /// Why entries are null, by their names.
    pub missing: BTreeMap<String, String>,
    /// Caveats of the run.
    pub warnings: Vec<String>,
    /// Effort of the run.
    pub effort: Effort,
    /// Wall-clock time of the simulation.
    pub wall_time_s: f64,
    /// Simulated over wall-clock time.
    pub real_time_factor: Option<f64>,
    /// How it was run.
    pub settings: RunSettings,
    /// Every parameter of the model, SI, by its path.
    pub parameters: BTreeMap<String, RunParameter>,
    /// SHA-256 of what was read, by name.
    pub inputs_sha256: BTreeMap<String, String>,
    /// What wrote this.
    pub versions: Versions,
    /// The command.
    pub argv: Vec<String>,
    /// When this was written, such as `20260131T235959Z`.
    pub written_utc: String,
}

/// Where the tip is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Place {
    /// When; null for the rest.
    pub time_s: Option<f64>,
    /// Along the undeformed rod.
    pub tip_x_m: f64,
    /// Up.
    pub tip_z_m: f64,
    /// Angle of the end body from x towards z.
    pub tip_angle_rad: f64,
}

/// An upper peak of the coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Peak {
    /// After the event.
    pub time_s: f64,
    /// Distance from the rest.
    #[serde(alias = "height_m")]
    pub excursion_m: f64,
}

/// Frequency and damping by the paper's method, from the height of the tip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OfHeight {
    /// From the spectrum.
    pub damped_frequency_hz: f64,
    /// By eq. 7.
    pub natural_frequency_hz: f64,
    /// By eq. 6 on the upper peaks.
    pub damping_ratio: f64,
}

/// From one upper peak to the next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Cycle {
    /// Midway between the two.
    pub time_s: f64,
    /// Geometric mean of their excursions.
    pub amplitude_m: f64,
    /// From their logarithmic decrement.
    pub damping_ratio: f64,
    /// Its standard error, from the noise of the peaks and the error of the rest; zero in a simulation.
    #[serde(default)]
    pub damping_ratio_error: f64,
    /// From the time between them.
    pub damped_frequency_hz: f64,
}

/// A small vibration about the rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Mode {
    /// Undamped.
    pub natural_frequency_hz: f64,
    /// Share of critical damping.
    pub damping_ratio: f64,
}

/// Where the tip was fastest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeakSpeed {
    /// When.
    pub time_s: f64,
    /// How fast.
    pub speed_m_s: f64,
}

/// How well kinetic, elastic, potential, dissipated and supplied energy add up to a constant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EnergyBalance {
    /// Largest change of potential energy: what there is to move with.
    #[serde(rename = "potential_released_J")]
    pub potential_released: f64,
    /// Largest distance of the total from its start, over the largest change of kinetic, elastic or potential energy.
    pub closure: f64,
    /// Total at the end minus total at the start.
    #[serde(rename = "drift_J")]
    pub drift: f64,
    /// Dissipated up to the end.
    #[serde(rename = "dissipated_J")]
    pub dissipated: f64,
}

/// How a model was run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunSettings {
    /// Integrator that made the run.
    pub method: Method,
    /// Error admitted in a step, relative.
    pub tolerance: f64,
    /// Step without error control.
    pub fixed_step_s: Option<f64>,
    /// Steps after which to give up.
    pub most_steps: usize,
    /// Number of nodes, clamp and end fitting included.
    pub nodes: usize,
    /// How the rod is made discrete: `consistent` or `paper`.
    pub scheme: String,
    /// From where it starts: `straight`, `equilibrium` or `posture`.
    pub initial: String,
    /// How long the rod hung, was raised and was held before its release; none where the memory of effects is
    /// relaxed in the posture of release.
    #[serde(default)]
    pub history_s: Option<[f64; 3]>,
    /// Requested time.
    pub duration_s: f64,
    /// Time between samples, if they are evenly spaced.
    pub sampling_s: Option<f64>,
    /// Effects of the model, the baseline included.
    pub effects: Vec<String>,
}

/// A parameter's value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunParameter {
    /// SI.
    pub value: f64,
    /// Empty if dimensionless.
    pub unit: String,
}

/// What wrote a summary.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Versions {
    /// This program.
    pub efam: String,
    /// The compiler that built it.
    pub rustc: String,
    /// Machine and system that it was built for.
    pub target: String,
}

impl Versions {
    /// Of the program that runs.
    pub fn here() -> Self {
        Self {
            efam: env!("CARGO_PKG_VERSION").to_owned(),
            rustc: env!("EFAM_RUSTC").to_owned(),
            target: format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS),
        }
    }
}

/// Swings of a run, kept for pictures.
#[derive(Clone, Debug, Default)]
pub struct Swings {
    /// Along the coordinate of the summary.
    pub coordinate: Option<OfCoordinate>,
    /// Of the height, as the paper has it.
    pub height: Option<OfCoordinate>,
    /// What drives the run.
    pub drive: Drive,
}

/// The swing of a run along a coordinate.
#[derive(Clone, Debug)]
pub struct OfCoordinate {
    /// Along which.
    pub coordinate: Coordinate,
    /// Its value at rest, m.
    pub rest: f64,
    /// When it begins, s: at the release, or at the first sample after a change. The clock of the swing counts from there.
    pub begin: f64,
    /// Frequency, peaks and decay.
    pub swing: swing::Swing,
}

impl Summary {
    /// Damped frequency, Hz, natural frequency, Hz, and damping ratio as the paper has them: of the height, or where that is
    /// not analysed, along the coordinate.
    pub fn as_paper(&self) -> [Option<f64>; 3] {
        match self.height {
            Some(of) => [of.damped_frequency_hz, of.natural_frequency_hz, of.damping_ratio].map(Some),
            None => [self.damped_frequency_hz, self.natural_frequency_hz, self.damping_ratio],
        }
    }
}

/// The numbers of a run and its swings; name, inputs, warnings and wall time are the caller's.
pub fn summarise(
    model: &Model,
    run: &Run,
    trajectory: &Trajectory,
    rest: &Result<Rest, impl Display>,
) -> (Summary, Swings) {
    let mut missing = Missing::default();
    let trace = &trajectory.trace;
    let simulated_s = trajectory.times.last().copied().unwrap_or(0.0);
    let slipping = slipping_modes(model, simulated_s, MODES);
    let drive = Drive::of(model, trajectory);
    let mut events = happened(model, trajectory, &drive, rest);
    events::measure(model, trajectory, &drive, &mut events);
    let main = main_swing(model, trajectory, &events, rest);
    let along = main.as_ref().map_err(Clone::clone).and_then(|main| {
        let coordinate = events::coordinate(main.path, &main.rest);
        main.along(trace.step, coordinate)
    });
    let height = main
        .as_ref()
        .map_err(Clone::clone)
        .and_then(|main| main.along(trace.step, Coordinate::HEIGHT).map(|(_, own)| own));
    // From the event to where its change is over.
    let change = main.as_ref().map_or(0.0, |main| main.begin - main.event);
    let swing = along.as_ref().map(|(_, own)| &own.swing).map_err(Clone::clone);
    let damped = and_then(&swing, |swing| swing.damped_frequency.clone());
    let upper = and_then(&swing, |swing| swing.peaks.clone());
    let decay = and_then(&swing, |swing| swing.decay.clone());
    let cycles = and_then(&swing, |swing| swing.cycles.clone());
    let of_height = and_then(&height, |own| of_height(&own.swing));
    let second = main.as_ref().ok().and_then(|main| main.second_mode(&swing.as_ref().ok()?.spectrum));
    let settling = |fraction| {
        and_then(&along, |(excursion, _)| {
            settling_time(excursion, fraction).map(|time| change + time).map_err(|error| error.to_string())
        })
    };
    let no_samples = || "no sample was reached".to_owned();
    let first_low = trace.first_low().ok_or_else(|| "the tip never turned upwards".to_owned());
    let lowest = trace.lowest().ok_or_else(no_samples);
    let least_angle = trace.angle.iter().copied().reduce(f64::min).ok_or_else(no_samples);
    let modes = match rest {
        Ok(rest) => rest.modes.as_ref().map_err(|error| error.to_string()),
        Err(error) => Err(format!("needs the rest: {error}")),
    };

    let decay_says = |what: fn(&Decay) -> f64| decay.as_ref().map(what).map_err(Clone::clone);
    let summary = Summary {
        name: String::new(),
        status: trajectory.status.clone(),
        simulated_s,
        samples: trajectory.times.len(),
        rest: missing.note("rest", rest.as_ref().map(at_rest)),
        event_s: main.as_ref().ok().map(|main| main.event),
        events,
        coordinate: missing.note("coordinate", along.as_ref().map(|(_, own)| own.coordinate)),
        peaks: missing
            .note("peaks", upper.as_ref().map(|peaks| peaks.iter().map(|own| peak(own, change)).collect())),
        first_low: missing.note("first_low", first_low.map(place)),
        lowest: missing.note("lowest", lowest.map(place)),
        beyond_straight_down: missing
            .note("beyond_straight_down", least_angle.as_ref().map(|angle| *angle < -FRAC_PI_2)),
        least_tip_angle_rad: missing.note("least_tip_angle_rad", least_angle.as_ref().copied()),
        damped_frequency_hz: missing.note("damped_frequency_hz", damped.as_ref().map(|omega| omega / TAU)),
        natural_frequency_hz: missing
            .note("natural_frequency_hz", decay_says(|decay| decay.natural_frequency / TAU)),
        damping_ratio: missing.note("damping_ratio", decay_says(|decay| decay.damping_ratio)),
        decay_amplitude_m: missing.note("decay_amplitude_m", decay_says(|decay| decay.initial_amplitude)),
        decay_residual_m: missing.note("decay_residual_m", decay_says(|decay| decay.rms_residual)),
        height: missing.note("height", of_height),
        cycles: missing.note(
            "cycles",
            cycles.map(|cycles| cycles.iter().map(|own| Cycle::after(own, change)).collect()),
        ),
        slipping_modes: slipping.as_ref().map(|modes| modes.iter().map(mode).collect()),
        modes: missing.note("modes", modes.map(|modes| modes.iter().map(mode).collect())),
        settling_2_percent_s: missing.note("settling_2_percent_s", settling(0.02)),
        settling_5_percent_s: missing.note("settling_5_percent_s", settling(0.05)),
        peak_speed: missing.note("peak_speed", peak_speed(trace).ok_or_else(no_samples)),
        energy: missing.note("energy", energy(run, trajectory)),
        errors: None,
        missing: BTreeMap::new(),
        warnings: second.into_iter().collect(),
        effort: trajectory.effort,
        wall_time_s: 0.0,
        real_time_factor: None,
        settings: settings(model, run),
        parameters: parameters(model),
        inputs_sha256: BTreeMap::new(),
        versions: Versions::here(),
        argv: Vec::new(),
        written_utc: String::new(),
    };
    let swings = Swings { coordinate: along.ok().map(|(_, own)| own), height: height.ok(), drive };
    (Summary { missing: missing.0, ..summary }, swings)
}

/// Why entries are null.
#[derive(Default)]
struct Missing(BTreeMap<String, String>);

impl Missing {
    fn note<T>(&mut self, entry: &str, found: Result<T, impl Display>) -> Option<T> {
        found.map_err(|why| self.0.insert(entry.to_owned(), why.to_string())).ok()
    }
}

/// The next step of an analysis, or why the one before failed.
fn and_then<A, B>(
    before: &Result<A, String>,
    next: impl FnOnce(&A) -> Result<B, String>,
) -> Result<B, String> {
    next(before.as_ref().map_err(Clone::clone)?)
}

/// What happened in a run. One that moves without a cause is let go off its rest by less than that is known.
fn happened(
    model: &Model,
    trajectory: &Trajectory,
    drive: &Drive,
    at_end: &Result<Rest, impl Display>,
) -> Vec<Event> {
    let at_release = if model.is_timed() { rest(model, 0.0, 1).ok() } else { None };
    let at_release = at_release.as_ref().or(at_end.as_ref().ok().filter(|_| !model.is_timed()));
    events::events(model, trajectory, drive, at_release)
}

/// The part of a run that its own numbers are of.
struct Main<'a> {
    /// Time of the event, s.
    event: f64,
    /// The first sample after its change, s.
    begin: f64,
    /// The tip from then on, up to the next event, m.
    path: &'a [[f64; 2]],
    /// Where it comes to rest.
    rest: Rest,
    /// Modes of the rod whose friction slips about that rest, where it has any.
    slipping: Option<Vec<(f64, f64)>>,
}

/// The swing after the release, or else after the first step or ramp.
fn main_swing<'a>(
    model: &Model,
    trajectory: &'a Trajectory,
    all: &[Event],
    at_end: &Result<Rest, impl Display>,
) -> Result<Main<'a>, String> {
    let trace = &trajectory.trace;
    let at_end = at_end.as_ref().map_err(|why| format!("needs the rest: {why}"))?;
    if trace.tip.is_empty() {
        return Err("no sample was reached".to_owned());
    }
    let forcing = all.iter().find(|event| event.kind == EventKind::SteadyForcing);
    let Some(event) = events::main_event(all) else {
        if let Some(hertz) = forcing.and_then(|event| event.forcing_hz) {
            return Err(format!(
                "a force of {} Hz acts all the time: see its gain and phase",
                significant(hertz, 3)
            ));
        }
        let off = |tip: &[f64; 2]| (tip[0] - at_end.tip[0]).hypot(tip[1] - at_end.tip[1]);
        let farthest = trace.tip.iter().map(off).fold(0.0, f64::max);
        return Err(format!("the rod is at rest: its tip moves by {} mm", short(1e3 * farthest)));
    };
    if let Some(forcing) = forcing.filter(|forcing| forcing.time_s < event.window_end_s) {
        let hertz = significant(forcing.forcing_hz.unwrap_or(0.0), 3);
        return Err(format!("a force of {hertz} Hz acts beside the swing: see its gain and phase"));
    }
    let is_last = all.iter().all(|other| other.window_end_s <= event.window_end_s);
    let rest = if is_last { at_end.clone() } else { events::rest_after(model, event, MODES)? };
    let (begin, path) = events::window(trajectory, event.until_s, event.window_end_s);
    let (event, end) = (event.time_s, event.window_end_s);
    Ok(Main { event, begin, path, rest, slipping: slipping_modes(model, end, MODES) })
}

/// Amplitude of the second mode over that of the first, in the spectrum, from which on the peaks are not those of the first alone:
/// the height of a peak is off by as much.
const SECOND_MODE: f64 = 0.1;

impl Main<'_> {
    /// Modes about the rest: of the rod whose friction slips, where it has any.
    fn modes(&self) -> Option<&[(f64, f64)]> {
        let slipping = self.slipping.as_deref().filter(|modes| !modes.is_empty());
        slipping.or(self.rest.modes.as_deref().ok())
    }

    /// A warning if the second mode is strong in a spectrum.
    fn second_mode(&self, spectrum: &Spectrum) -> Option<String> {
        let [first, second] = *self.modes()?.first_chunk()?;
        let near =
            |(hertz, _): (f64, f64)| spectrum.peak_between([0.9, 1.1].map(|share| share * TAU * hertz)).ok();
        let share = near(second)?.amplitude / near(first)?.amplitude;
        (share > SECOND_MODE).then(|| {
            format!(
                "the second mode, {} Hz, has {:.0} % of the amplitude of the first in the spectrum: peaks and damping ratio \
                 include it; the modes about the rest have ratios of their own",
                significant(second.0, 3),
                100.0 * share
            )
        })
    }

    /// The swing along a coordinate, near the frequency of the first mode: of the rod whose friction slips, where it has
    /// any.
    fn along(&self, step: f64, coordinate: Coordinate) -> Result<(Excursion, OfCoordinate), String> {
        let rest = &self.rest;
        let first = self.modes().and_then(|modes| modes.first());
        let damped = first.map(|(hertz, ratio)| TAU * hertz * (1.0 - ratio * ratio).sqrt());
        let known = Known {
            mode: damped.filter(|omega| *omega > 0.0),
            has_bumps: coordinate == Coordinate::HEIGHT,
            ..Known::default()
        };
        let (excursion, swing) = swing_along(self.path, step, rest.tip, coordinate, &known)
            .map_err(|error: AnalysisError| error.to_string())?;
        Ok((excursion, OfCoordinate { coordinate, rest: coordinate.of(rest.tip), begin: self.begin, swing }))
    }
}

fn of_height(swing: &swing::Swing) -> Result<OfHeight, String> {
    let decay = swing.decay.as_ref().map_err(Clone::clone)?;
    Ok(OfHeight {
        damped_frequency_hz: decay.damped_frequency / TAU,
        natural_frequency_hz: decay.natural_frequency / TAU,
        damping_ratio: decay.damping_ratio,
    })
}

/// Time between samples, s, if all are equally far apart and the first is the release.
fn sampling(samples: &[f64]) -> Option<f64> {
    let (first, last) = (*samples.first()?, *samples.last()?);
    let step = (last - first) / (samples.len().checked_sub(1).filter(|count| *count > 0)? as f64);
    let even = samples.iter().enumerate().all(|(k, time)| (time - step * k as f64).abs() < 1e-6 * step);
    even.then_some(step)
}

fn place(at: Instant) -> Place {
    Place { time_s: Some(at.time), tip_x_m: at.tip[0], tip_z_m: at.tip[1], tip_angle_rad: at.angle }
}

fn at_rest(rest: &Rest) -> Place {
    Place { time_s: None, tip_x_m: rest.tip[0], tip_z_m: rest.tip[1], tip_angle_rad: rest.tip_angle }
}

fn peak(peak: &peaks::Peak, change: f64) -> Peak {
    Peak { time_s: change + peak.time, excursion_m: peak.height }
}

impl Cycle {
    /// The same with its time counted from an event whose change took so long, s.
    fn after(cycle: &decay::Cycle, change: f64) -> Self {
        Self { time_s: change + cycle.time, ..cycle.into() }
    }
}

impl From<&decay::Cycle> for Cycle {
    fn from(cycle: &decay::Cycle) -> Self {
        Self {
            time_s: cycle.time,
            amplitude_m: cycle.amplitude,
            damping_ratio: cycle.damping_ratio,
            damping_ratio_error: cycle.ratio_error,
            damped_frequency_hz: cycle.damped_frequency / TAU,
        }
    }
}

fn mode(&(natural_frequency_hz, damping_ratio): &(f64, f64)) -> Mode {
    Mode { natural_frequency_hz, damping_ratio }
}

fn peak_speed(trace: &Trace) -> Option<PeakSpeed> {
    let speeds = trace.velocity.iter().map(|[x, z]| x.hypot(*z)).enumerate();
    let (point, speed_m_s) = speeds.max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(PeakSpeed { time_s: trace.time(point), speed_m_s })
}

fn energy(run: &Run, trajectory: &Trajectory) -> Result<EnergyBalance, String> {
    if !run.energy {
        return Err("the run did not follow its energy".to_owned());
    }
    let (Some(first), Some(last)) = (trajectory.energy.first(), trajectory.energy.last()) else {
        return Err("no sample was reached".to_owned());
    };
    let largest = |of: &dyn Fn(&models::snapshot::Energy) -> f64| {
        trajectory.energy.iter().map(|energy| (of(energy) - of(first)).abs()).fold(0.0, f64::max)
    };
    let potential_released = largest(&|energy| energy.potential);
    if potential_released == 0.0 {
        return Err("no potential energy was released".to_owned());
    }
    Ok(EnergyBalance {
        potential_released,
        closure: trajectory.closure().unwrap_or(0.0),
        drift: last.total() - first.total(),
        dissipated: last.dissipated,
    })
}

fn settings(model: &Model, run: &Run) -> RunSettings {
    let initial = match run.initial {
        Initial::Straight => "straight",
        Initial::Equilibrium { .. } => "equilibrium",
        Initial::Curve(_) | Initial::Posture(_) => "posture",
    };
    let scheme = match model.scheme {
        Scheme::Consistent => "consistent",
        Scheme::Paper => "paper",
    };
    RunSettings {
        method: run.method.of(model),
        tolerance: run.tolerance,
        fixed_step_s: run.steps.fixed(),
        most_steps: run.most_steps,
        nodes: model.edges + 1,
        scheme: scheme.to_owned(),
        initial: initial.to_owned(),
        history_s: run.history.map(|history| [history.hung, history.raised, history.held]),
        duration_s: run.duration,
        sampling_s: sampling(&run.samples),
        effects: model.effects.iter().map(|active| active.effect.about().name.to_owned()).collect(),
    }
}

fn parameters(model: &Model) -> BTreeMap<String, RunParameter> {
    let value = |(p, &value): (&models::model::ModelParameter, &f64)| {
        (p.path.clone(), RunParameter { value, unit: p.unit.to_owned() })
    };
    model.parameters.iter().zip(&model.theta).map(value).collect()
}

#[cfg(test)]
mod tests {
    use efam_core::example::{muscle_at_15_psi, released};

    use super::*;

    fn summary(duration: f64) -> Summary {
        let model = muscle_at_15_psi();
        let (run, trajectory) = released(&model, duration);
        summarise(&model, &run, &trajectory, &rest(&model, duration, MODES)).0
    }

    /// The paper's Figure 8: at 15 psi the tip passes beyond straight down. All numbers of the swing
    /// must then agree with one another and with statics.
    #[test]
    fn the_15_psi_release_has_its_bump_and_all_numbers_agree() {
        let summary = summary(20.0);
        assert!(summary.missing.is_empty(), "{:?}", summary.missing);
        assert_eq!(summary.beyond_straight_down, Some(true));
        let first_low = summary.first_low.unwrap();
        let peaks = summary.peaks.unwrap();
        let period = summary.damped_frequency_hz.unwrap().recip();
        // The bump makes no peak of its own: one a period, falling, the first after one period.
        assert!(first_low.time_s.unwrap() < peaks[0].time_s);
        assert!((peaks[0].time_s / period - 1.0).abs() < 0.15, "{peaks:?}, {period}");
        for pair in peaks.windows(2) {
            let between = pair[1].time_s - pair[0].time_s;
            assert!((between / period - 1.0).abs() < 0.1, "{pair:?}, {period}");
            assert!(pair[1].excursion_m < pair[0].excursion_m, "{pair:?}");
        }
        // Small swings are those of the first mode: alpha / (2 omega) of mass damping. Large ones are
        // slower, by some per cent.
        let mode = summary.modes.as_ref().unwrap()[0];
        let expected = 1.0 / (2.0 * TAU * mode.natural_frequency_hz);
        assert!((mode.damping_ratio / expected - 1.0).abs() < 1e-6, "{mode:?}");
        let last = summary.cycles.as_ref().unwrap().last().unwrap();
        assert!(
            (last.damped_frequency_hz / mode.natural_frequency_hz - 1.0).abs() < 0.01,
            "{last:?} {mode:?}"
        );
        assert!((summary.damping_ratio.unwrap() / mode.damping_ratio - 1.0).abs() < 0.2);
        // Mass damping alone: amplitude goes with exp(−alpha t / 2), alpha = 1/s.
        let [two, five] = [summary.settling_2_percent_s, summary.settling_5_percent_s].map(Option::unwrap);
        assert!((two - five - 2.0 * 2.5f64.ln()).abs() < period, "{two} {five}");
        let energy = summary.energy.unwrap();
        assert!(energy.closure < 1e-3 && energy.dissipated > 0.0, "{energy:?}");
        assert!(energy.potential_released > 0.05492 * 9.81 * 0.15, "{energy:?}");
    }

    #[test]
    fn too_short_a_run_has_nulls_with_reasons_and_still_a_rest() {
        let summary = summary(0.05);
        assert!(summary.rest.is_some() && summary.lowest.is_some() && summary.energy.is_some());
        let json = serde_json::to_value(&summary).unwrap();
        for entry in [
            "first_low",
            "damped_frequency_hz",
            "natural_frequency_hz",
            "damping_ratio",
            "peaks",
            "cycles",
            "settling_2_percent_s",
            "settling_5_percent_s",
        ] {
            assert!(json[entry].is_null(), "{entry}: {}", json[entry]);
            assert!(summary.missing[entry].len() > 10, "{entry}: {:?}", summary.missing);
        }
        assert_eq!(summary.missing.len(), 11, "{:?}", summary.missing);
        assert!(summary.missing["settling_2_percent_s"].starts_with("not settled"));
    }

    /// Between too short and long enough lies no length at which a wrong frequency is given: the bump's
    /// harmonic, or a side lobe of the window.
    #[test]
    fn a_frequency_is_right_or_not_given() {
        let model = muscle_at_15_psi();
        let expected = summary(20.0).damped_frequency_hz.unwrap();
        let mut given = 0;
        for fifth in 1..=20 {
            let (run, trajectory) = released(&model, 0.2 * f64::from(fifth) - 0.1);
            let (summary, _) = summarise(&model, &run, &trajectory, &rest(&model, 0.0, MODES));
            if let Some(hz) = summary.damped_frequency_hz {
                assert!((hz / expected - 1.0).abs() < 0.15, "{hz} Hz from {fifth} fifths of a second");
                given += 1;
            }
        }
        assert!(given >= 10, "{given} of 20");
    }

    /// A swing whose bump is higher in the spectrum than the swing itself.
    #[test]
    fn a_harmonic_is_not_taken_for_the_swing() {
        let z: Vec<f64> = (0..1000)
            .map(|k| 9.0 * 0.01 * f64::from(k))
            .map(|phase| (-0.02 * phase).exp() * (0.1 * phase.cos() + 0.15 * (2.0 * phase).cos() - 0.1))
            .collect();
        let excursion = Excursion::about(0.0, &z, 0.01).unwrap();
        let known = Known { has_bumps: true, ..Known::default() };
        let swing = swing::swing(&excursion, &known);
        let why = swing.damped_frequency.unwrap_err();
        assert!(why.ends_with("s apart; try a longer run"), "{why}");
        assert!(swing.peaks.is_err());
        // With the frequency of the mode it is found.
        let swing = swing::swing(&excursion, &Known { mode: Some(9.3), ..known });
        assert!((swing.damped_frequency.unwrap() / 9.0 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_run_that_failed_at_once_and_uneven_samples_are_no_panic() {
        let model = muscle_at_15_psi();
        let (mut run, _) = released(&model, 0.0);
        let failed = Status::Failed { time: 0.0, reason: "it broke".to_owned() };
        let mut nothing = Trajectory::default();
        nothing.status = failed.clone();
        let (summary, _) = summarise(&model, &run, &nothing, &Err::<Rest, _>("it does not hang"));
        assert_eq!(summary.status, failed);
        assert!(summary.rest.is_none() && summary.lowest.is_none() && summary.modes.is_none());
        assert_eq!(summary.missing["modes"], "needs the rest: it does not hang");

        run.samples = vec![0.0, 0.01, 0.03];
        let (summary, _) = summarise(&model, &run, &nothing, &rest(&model, 0.0, MODES));
        assert_eq!(summary.settings.sampling_s, None);
    }

    #[test]
    fn the_rest_is_that_of_the_last_cycle_and_of_the_tip_at_the_end() {
        let summary = summary(20.0);
        let model = muscle_at_15_psi();
        let (_, trajectory) = released(&model, 20.0);
        let [x, z] = trajectory.tip[trajectory.tip.len() - 1];
        let rest = summary.rest.unwrap();
        // exp(−10) of 0.2 m is left of the swing.
        assert!((rest.tip_x_m - x).hypot(rest.tip_z_m - z) < 1e-4, "{rest:?} {x} {z}");
    }

    #[test]
    fn json_reads_back() {
        let summary = summary(2.0);
        let text = serde_json::to_string_pretty(&summary).unwrap();
        assert!(text.contains("\"potential_released_J\"") && text.contains("\"kind\": \"complete\""));
        // Text holds the shortest digits of a number, which read back to within one bit.
        let again: Summary = serde_json::from_str(&text).unwrap();
        assert_eq!(again.peaks.map(|peaks| peaks.len()), summary.peaks.map(|peaks| peaks.len()));
        assert_eq!(again.settings, summary.settings);
    }
}

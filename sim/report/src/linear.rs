//! What a linear model leaves on disk, and its tables.
//!
//! ```text
//! outputs/<UTC>_<name>_<hash8>/
//!   report.html              poles, gains, Bode plot and step response, for people
//!   linear.json              the same with all matrices
//!   linear.mat               matrices for MATLAB: sys = ss(m.A, m.B, m.C, m.D)
//!   linear.h                 the reduced model with its sample time, for C
//!   scenario.resolved.toml   the rod, for `efam linearise`
//!   summary.json             what was requested, by which command
//! ```

mod header;
mod page;
mod responses;

use std::fmt::Debug;
use std::time::SystemTime;

use efam_core::linear::{DMatrix, Linear, LinearError, Modal, Pole, Signal, StateSpace, settling};
use efam_inference::predict::linear::{Ends, LinearIntervals};
use efam_store::StoreError;
use efam_store::folder::Folder;
use models::digits::short;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;

use crate::aligned::{Aligned, Side};
use crate::export::linear_mat;
use crate::interval::with_interval;
use crate::page::REPORT;
use crate::picture::{PASCAL_PER_PSI, linear_pictures};
use crate::report::readable;
use crate::{Request, SCENARIO, write_mark};

/// The numbers.
pub const LINEAR: &str = "linear.json";
/// Band of a controller, over the frequency of the first vibration.
const BAND: f64 = 10.0;
/// The matrices for MATLAB.
pub const LINEAR_MAT: &str = "linear.mat";
/// The reduced model for C.
pub const LINEAR_HEADER: &str = "linear.h";

/// A linear model in numbers; SI units, counted from the rest.
#[derive(Serialize, JsonSchema)]
pub struct LinearAnswer {
    /// Name of the case.
    pub name: String,
    /// Pressure above ambient.
    pub pressure_pa: Option<f64>,
    /// Whether the rod comes back when it is pushed.
    pub stable: bool,
    /// What moves the rod.
    pub inputs: Vec<SignalAnswer>,
    /// What is seen of it.
    pub outputs: Vec<SignalAnswer>,
    /// What the states of `continuous` and `discrete` are.
    pub states: Vec<SignalAnswer>,
    /// Poles, slowest first; a pair once.
    pub poles: Vec<PoleAnswer>,
    /// Time in which the first bending vibration decays to 5 %; none if it does not.
    pub settling_5_percent_s: Option<f64>,
    /// Outputs after long by inputs that stay, a row for each output.
    pub static_gain: Vec<Vec<f64>>,
    /// Their 95 % intervals, likewise; none without a calibration.
    pub static_gain_95: Option<Vec<Vec<[f64; 2]>>>,
    /// What a Bode plot and a step show of each output by each input.
    pub responses: Vec<ResponseAnswer>,
    /// Draws from the errors of the calibration that the intervals come from; none without a calibration.
    pub draws: usize,
    /// Time between samples, if it is given.
    pub sample_s: Option<f64>,
    /// `x' = A x + B u`, `y = C x + D u`.
    pub continuous: Matrices,
    /// The same with samples, inputs held between them.
    pub discrete: Option<Matrices>,
    /// With fewer states.
    pub reduced: Option<ReducedAnswer>,
    /// Caveats of the numbers.
    pub warnings: Vec<String>,
}

/// An input, an output or a state.
#[derive(Clone, Serialize, JsonSchema)]
pub struct SignalAnswer {
    /// Its name.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Its value at the rest.
    pub at_rest: f64,
}

/// A pole.
#[derive(Serialize, JsonSchema)]
pub struct PoleAnswer {
    /// Real part.
    pub real_per_s: f64,
    /// Imaginary part; zero if it does not swing.
    pub imaginary_per_s: f64,
    /// Undamped frequency.
    pub frequency_hz: f64,
    /// Its 95 % interval, of a bending vibration of a calibrated rod.
    pub frequency_hz_95: Option<[f64; 2]>,
    /// Share of critical damping.
    pub damping_ratio: f64,
    /// Its 95 % interval, likewise.
    pub damping_ratio_95: Option<[f64; 2]>,
    /// The same of the time in which it decays to 5 %.
    pub settling_5_percent_s_95: Option<[f64; 2]>,
    /// Whether it is a vibration along the rod.
    pub along_the_rod: bool,
}

/// One output by one input, in SI units; intervals hold 95 % at each frequency or time, and are empty without a calibration.
#[derive(Serialize, JsonSchema)]
pub struct ResponseAnswer {
    /// Name of the input.
    pub input: String,
    /// Name of the output.
    pub output: String,
    /// Frequencies of the input.
    pub frequency_hz: Vec<f64>,
    /// Amplitude of the output over that of the input.
    pub gain: Vec<f64>,
    /// Its intervals.
    pub gain_95: Vec<[f64; 2]>,
    /// Phase of the output before the input, without jumps by a turn.
    pub phase_rad: Vec<f64>,
    /// Its intervals.
    pub phase_rad_95: Vec<[f64; 2]>,
    /// Times after the input jumps by one unit.
    pub time_s: Vec<f64>,
    /// The output at these.
    pub step: Vec<f64>,
    /// Its intervals.
    pub step_95: Vec<[f64; 2]>,
}

/// Matrices of a linear model, row by row.
#[derive(Serialize, JsonSchema)]
pub struct Matrices {
    /// States by states.
    pub a: Vec<Vec<f64>>,
    /// By inputs.
    pub b: Vec<Vec<f64>>,
    /// Outputs by states.
    pub c: Vec<Vec<f64>>,
    /// By inputs.
    pub d: Vec<Vec<f64>>,
}

/// A linear model with fewer states.
#[derive(Serialize, JsonSchema)]
pub struct ReducedAnswer {
    /// Number of states.
    pub states: usize,
    /// Largest error at any frequency, a row for each output; in the units of the static gain.
    pub error_bound: Vec<Vec<f64>>,
    /// Frequency up to which `error_found` was looked for.
    pub band_hz: f64,
    /// Largest error that was found in the band, as `error_bound`.
    pub error_found: Vec<Vec<f64>>,
    /// Hankel singular values of the whole model, over the largest.
    pub hankel_singular_values: Vec<f64>,
    /// `x' = A x + B u`, `y = C x + D u`.
    pub continuous: Matrices,
    /// The same with samples.
    pub discrete: Option<Matrices>,
}

/// What was requested of a linear model beside its matrices.
#[derive(Clone, Copy, Default)]
pub struct Wanted {
    /// Time between samples, s.
    pub sample: Option<f64>,
    /// Number of states of a reduced model.
    pub order: Option<usize>,
}

impl LinearAnswer {
    /// The numbers of a linear model.
    /// # Errors
    /// [`LinearError`] of the reduction.
    pub fn new(
        name: &str,
        pressure_pa: Option<f64>,
        linear: &Linear,
        wanted: Wanted,
    ) -> Result<Self, LinearError> {
        let Wanted { sample, order } = wanted;
        let poles = linear.modal.poles();
        let vibrations = linear.modal.vibrations();
        let first = vibrations.first();
        let sampled = |modal: &Modal| sample.map(|sample| Matrices::of(&modal.discrete(sample)));
        let reduced = |order: usize| -> Result<ReducedAnswer, LinearError> {
            let reduced = linear.modal.reduced(order)?;
            let modal = reduced.matrices.modal()?;
            let band_hz = BAND * first.map_or(1.0, |pole| pole.frequency);
            Ok(ReducedAnswer {
                states: order,
                band_hz,
                error_found: rows(&linear.modal.farthest(&modal, band_hz)),
                error_bound: rows(&reduced.error_bound),
                hankel_singular_values: reduced.hankel.iter().map(|own| own / reduced.hankel[0]).collect(),
                discrete: sampled(&modal),
                continuous: Matrices::of(&reduced.matrices),
            })
        };
        Ok(Self {
            name: name.to_owned(),
            pressure_pa,
            stable: linear.is_stable,
            inputs: signals(&linear.inputs),
            outputs: signals(&linear.outputs),
            states: signals(&linear.states),
            settling_5_percent_s: first.map(Pole::settling).filter(|settling| settling.is_finite()),
            poles: poles
                .iter()
                .map(|pole| PoleAnswer {
                    real_per_s: pole.at.re,
                    imaginary_per_s: pole.at.im,
                    frequency_hz: pole.frequency,
                    frequency_hz_95: None,
                    damping_ratio: pole.damping_ratio,
                    damping_ratio_95: None,
                    settling_5_percent_s_95: None,
                    along_the_rod: pole.is_along,
                })
                .collect(),
            static_gain: rows(&linear.modal.static_gain()),
            static_gain_95: None,
            responses: responses::of(linear),
            draws: 0,
            sample_s: sample,
            continuous: Matrices::of(&linear.matrices),
            discrete: sampled(&linear.modal),
            reduced: order.map(reduced).transpose()?,
            warnings: Vec::new(),
        })
    }

    /// Frequencies, Hz, and times, s, of the responses.
    pub fn grid(&self) -> (&[f64], &[f64]) {
        self.responses.first().map_or((&[], &[]), |own| (&own.frequency_hz, &own.time_s))
    }

    /// Takes the intervals of a calibration.
    pub fn set_intervals(&mut self, intervals: &LinearIntervals) {
        if intervals.draws == 0 {
            return;
        }
        let is_vibration = |pole: &&mut PoleAnswer| pole.imaginary_per_s > 0.0 && !pole.along_the_rod;
        for (pole, own) in self.poles.iter_mut().filter(is_vibration).zip(&intervals.vibrations) {
            let is_finite = |ends: &[f64; 2]| ends.iter().all(|end| end.is_finite());
            [pole.frequency_hz_95, pole.damping_ratio_95, pole.settling_5_percent_s_95] =
                own.map(|ends| ends.filter(is_finite));
        }
        self.static_gain_95 = Some(rows(&intervals.static_gain));
        for (k, own) in self.responses.iter_mut().enumerate() {
            let at = (k / self.inputs.len(), k % self.inputs.len());
            let of = |all: &[Ends]| all.iter().map(|ends| ends[at]).collect::<Vec<_>>();
            (own.gain_95, own.step_95) = (of(&intervals.gain), of(&intervals.step));
            let phases = own.phase_rad.iter().zip(of(&intervals.phase));
            own.phase_rad_95 = phases.map(|(phase, ends)| ends.map(|end| phase + end)).collect();
        }
        self.draws = intervals.draws;
    }

    /// Bending vibrations, slowest first.
    fn vibrations(&self) -> impl Iterator<Item = &PoleAnswer> {
        self.poles.iter().filter(|pole| pole.imaginary_per_s > 0.0 && !pole.along_the_rod)
    }

    /// Poles that do not swing, in words; nothing without any.
    fn decays(&self) -> Option<String> {
        let real: Vec<f64> = self
            .poles
            .iter()
            .filter(|pole| pole.imaginary_per_s == 0.0)
            .map(|pole| pole.real_per_s)
            .collect();
        let (first, last) = (real.first()?, real.last()?);
        let count = real.len();
        Some(format!("{count} poles do not swing: {} to {} 1/s", short(*first), short(*last)))
    }

    /// Gains as cells, a row for each output: its name, then a number with unit for each input.
    fn gains(&self, gains: &[Vec<f64>], intervals: Option<&Vec<Vec<[f64; 2]>>>) -> Vec<Vec<String>> {
        let row = |(k, output): (usize, &SignalAnswer)| {
            let cell = |(l, input): (usize, &SignalAnswer)| {
                let (factor, unit) = gain_unit(output, input);
                with_interval(gains[k][l], intervals.map(|all| all[k][l]), factor, &unit)
            };
            let cells = self.inputs.iter().enumerate().map(cell);
            std::iter::once(output.name.clone()).chain(cells).collect()
        };
        self.outputs.iter().enumerate().map(row).collect()
    }
}

/// Factor and unit of a pressure for a reader; nothing for another unit.
fn in_psi(unit: &str) -> Option<(f64, &'static str)> {
    (unit == "Pa").then_some((PASCAL_PER_PSI.recip(), "psi"))
}

/// Factor and unit in which a gain is printed, such as mm/psi.
pub(crate) fn gain_unit(output: &SignalAnswer, input: &SignalAnswer) -> (f64, String) {
    let (factor, unit) = readable(&output.unit);
    let (per, by) = in_psi(&input.unit).unwrap_or((1.0, &input.unit));
    let by = if by.contains(['/', ' ']) { format!("({by})") } else { by.to_owned() };
    (factor / per, if by.is_empty() { unit.to_owned() } else { format!("{unit}/{by}") })
}

fn signals(all: &[Signal]) -> Vec<SignalAnswer> {
    let one =
        |own: &Signal| SignalAnswer { name: own.name.clone(), unit: own.unit.clone(), at_rest: own.at_rest };
    all.iter().map(one).collect()
}

fn rows<T: Copy + PartialEq + Debug + 'static>(matrix: &DMatrix<T>) -> Vec<Vec<T>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

impl Matrices {
    fn of(StateSpace { a, b, c, d }: &StateSpace) -> Self {
        Self { a: rows(a), b: rows(b), c: rows(c), d: rows(d) }
    }
}

/// Writes a linear model into an open folder.
/// # Errors
/// [`StoreError::Write`].
pub fn write_linear(folder: &Folder, request: &Request, answer: &LinearAnswer) -> Result<(), StoreError> {
    let text = serde_json::to_string(answer).expect("a linear model has nothing that JSON has not");
    folder.write(LINEAR, text.as_bytes())?;
    folder.write_with(LINEAR_MAT, |file| linear_mat(answer, file))?;
    if let Some(header) = header::of(answer) {
        folder.write(LINEAR_HEADER, header.as_bytes())?;
    }
    let (pictures, written) = (linear_pictures(answer), SystemTime::now());
    folder.write(REPORT, page::of(request, answer, &pictures, written).as_bytes())?;
    folder.write(SCENARIO, request.resolved_scenario.as_bytes())?;
    write_mark(folder, request, "linear model", written, json!({}))
}

/// The answer for a terminal: poles, static gains, errors of the reduction.
pub fn linear_table(answer: &LinearAnswer, count: usize) -> String {
    // Without their number, so that 80 columns hold the intervals.
    let heads = ["frequency, Hz", "damping ratio", "settling to 5 %, s"];
    let mut poles = Aligned::new(&heads.map(|head| (head, Side::Number)));
    for (k, pole) in answer.vibrations().take(count).enumerate() {
        let [_, frequency, ratio, settling] = pole_cells(k, pole, "", "");
        poles.row([frequency, ratio, settling]);
    }
    let table = |head: &str, gains: &[Vec<f64>], intervals| {
        let inputs = answer.inputs.iter().map(|input| (input.name.as_str(), Side::Number));
        let heads: Vec<_> = [(head, Side::Name)].into_iter().chain(inputs).collect();
        let mut table = Aligned::new(&heads);
        answer.gains(gains, intervals).into_iter().for_each(|row| table.row(row));
        table.to_string()
    };
    let mut text = poles.to_string();
    text.extend(answer.decays().map(|decays| decays + "\n"));
    text += &format!("\n{}", table("static gain", &answer.static_gain, answer.static_gain_95.as_ref()));
    if let Some(reduced) = &answer.reduced {
        let head = format!("error up to {} Hz", short(reduced.band_hz));
        let found = table(&head, &reduced.error_found, None);
        let bound = table("bound, any frequency", &reduced.error_bound, None);
        text += &format!("\nreduced to {} states\n{found}{bound}", reduced.states);
    }
    if answer.draws > 0 {
        text += &format!("\n95 % intervals: {} draws from the errors of the calibration\n", answer.draws);
    }
    text
}

/// Number, frequency, damping ratio and settling time of a vibration.
fn pole_cells(k: usize, pole: &PoleAnswer, hertz: &str, seconds: &str) -> [String; 4] {
    let settling = match settling(pole.real_per_s) {
        time if time.is_finite() => with_interval(time, pole.settling_5_percent_s_95, 1.0, seconds),
        _ => "never".to_owned(),
    };
    [
        (k + 1).to_string(),
        with_interval(pole.frequency_hz, pole.frequency_hz_95, 1.0, hertz),
        with_interval(pole.damping_ratio, pole.damping_ratio_95, 1.0, ""),
        settling,
    ]
}

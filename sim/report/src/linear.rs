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

use std::time::SystemTime;

use efam_core::linear::{DMatrix, Linear, LinearError, Modal, Signal, StateSpace};
use efam_store::StoreError;
use efam_store::folder::Folder;
use models::digits::short;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::json;

use crate::aligned::{Aligned, Side};
use crate::export::linear_mat;
use crate::page::REPORT;
use crate::picture::{PASCAL_PER_PSI, linear_pictures};
use crate::report::{readable, significant};
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
    /// Share of critical damping.
    pub damping_ratio: f64,
    /// Whether it is a vibration along the rod.
    pub along_the_rod: bool,
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
        let mut bending = poles.iter().filter(|pole| pole.at.im > 0.0 && !pole.is_along);
        let first = bending.next();
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
            settling_5_percent_s: first
                .filter(|pole| pole.at.re < 0.0)
                .map(|pole| 20.0_f64.ln() / -pole.at.re),
            poles: poles
                .iter()
                .map(|pole| PoleAnswer {
                    real_per_s: pole.at.re,
                    imaginary_per_s: pole.at.im,
                    frequency_hz: pole.frequency,
                    damping_ratio: pole.damping_ratio,
                    along_the_rod: pole.is_along,
                })
                .collect(),
            static_gain: rows(&linear.modal.static_gain()),
            sample_s: sample,
            continuous: Matrices::of(&linear.matrices),
            discrete: sampled(&linear.modal),
            reduced: order.map(reduced).transpose()?,
            warnings: Vec::new(),
        })
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
    fn gains(&self, gains: &[Vec<f64>]) -> Vec<Vec<String>> {
        let row = |(output, gains): (&SignalAnswer, &Vec<f64>)| {
            let cell = |(input, gain): (&SignalAnswer, &f64)| {
                let (factor, unit) = gain_unit(output, input);
                format!("{} {unit}", significant(factor * gain, 4))
            };
            let cells = self.inputs.iter().zip(gains).map(cell);
            std::iter::once(output.name.clone()).chain(cells).collect()
        };
        self.outputs.iter().zip(gains).map(row).collect()
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

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
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
pub fn write_linear(
    folder: &Folder,
    request: &Request,
    answer: &LinearAnswer,
    modal: &Modal,
) -> Result<(), StoreError> {
    let text = serde_json::to_string(answer).expect("a linear model has nothing that JSON has not");
    folder.write(LINEAR, text.as_bytes())?;
    folder.write_with(LINEAR_MAT, |file| linear_mat(answer, file))?;
    if let Some(header) = header::of(answer) {
        folder.write(LINEAR_HEADER, header.as_bytes())?;
    }
    let (pictures, written) = (linear_pictures(answer, modal), SystemTime::now());
    folder.write(REPORT, page::of(request, answer, &pictures, written).as_bytes())?;
    folder.write(SCENARIO, request.resolved_scenario.as_bytes())?;
    write_mark(folder, request, "linear model", written, json!({}))
}

/// The answer for a terminal: poles, static gains, errors of the reduction.
pub fn linear_table(answer: &LinearAnswer, count: usize) -> String {
    let mut poles = Aligned::new(&[
        ("pole", Side::Number),
        ("frequency", Side::Number),
        ("damping ratio", Side::Number),
        ("settling (5 %)", Side::Number),
    ]);
    for (k, pole) in answer.vibrations().take(count).enumerate() {
        poles.row(pole_cells(k, pole, " Hz", " s"));
    }
    let table = |head: &str, gains: &[Vec<f64>]| {
        let inputs = answer.inputs.iter().map(|input| (input.name.as_str(), Side::Number));
        let heads: Vec<_> = [(head, Side::Name)].into_iter().chain(inputs).collect();
        let mut table = Aligned::new(&heads);
        answer.gains(gains).into_iter().for_each(|row| table.row(row));
        table.to_string()
    };
    let mut text = poles.to_string();
    text.extend(answer.decays().map(|decays| decays + "\n"));
    text += &format!("\n{}", table("static gain", &answer.static_gain));
    if let Some(reduced) = &answer.reduced {
        let found = table(&format!("error up to {} Hz", short(reduced.band_hz)), &reduced.error_found);
        let bound = table("bound, any frequency", &reduced.error_bound);
        text += &format!("\nreduced to {} states\n{found}{bound}", reduced.states);
    }
    text
}

/// Number, frequency, damping ratio and settling time of a vibration.
fn pole_cells(k: usize, pole: &PoleAnswer, hertz: &str, seconds: &str) -> [String; 4] {
    let settling = -(20.0_f64.ln()) / pole.real_per_s;
    let settling =
        if pole.real_per_s < 0.0 { significant(settling, 3) + seconds } else { "never".to_owned() };
    [
        (k + 1).to_string(),
        significant(pole.frequency_hz, 5) + hertz,
        significant(pole.damping_ratio, 4),
        settling,
    ]
}

//! The pages of simulations: of one run, and of a set of runs over pressure.

mod events;

use std::fmt::Write;
use std::time::SystemTime;

use efam_core::trajectory::{Status, Trajectory};
use efam_experiments::events::{EventKind, main_event};
use efam_experiments::summary::{Cycle, Mode, Summary};
use efam_store::StoreError;
use efam_store::folder::Folder;
use models::digits::fixed;
use models::model::Model;
use models::quantity::format_si;
use serde_json::json;

use crate::page::{BeforeUse, Family, Page, REPORT, Table, extrapolated};
use crate::picture::{
    PASCAL_PER_PSI, Picture, PressureRow, Rod, Rods, Tip, of_family, over_pressure_and_amplitude, pressures,
    rod_of_run, tips,
};
use crate::quantities::quantities;
use crate::report::{short, significant};
use crate::{Request, assumed, write_mark};

/// The picture of a set of runs over pressure.
pub const PRESSURES: &str = "pressures.svg";

/// A run of a set.
#[derive(Clone, Debug)]
pub struct Member {
    /// Its numbers.
    pub summary: Summary,
    /// Its pressure above ambient, Pa.
    pub pressure: Option<f64>,
    /// Times of its samples, s.
    pub times: Vec<f64>,
    /// Positions of the tip, m.
    pub tip: Vec<[f64; 2]>,
    /// How it moves, on the page of its set.
    pub rod: Option<Rod>,
}

impl Member {
    /// What a set keeps of a run.
    pub fn new(summary: Summary, pressure: Option<f64>, trajectory: Trajectory) -> Self {
        Self { summary, pressure, times: trajectory.times, tip: trajectory.tip, rod: None }
    }

    /// The same of the `case`-th run of a set, with its motion.
    pub fn of_set(
        case: usize,
        summary: Summary,
        pressure: Option<f64>,
        model: &Model,
        trajectory: Trajectory,
    ) -> Self {
        let rod = rod_of_run(case, &summary.name, model, &trajectory);
        Self { rod, ..Self::new(summary, pressure, trajectory) }
    }

    /// Its name in pictures and tables over pressure.
    fn name(&self) -> String {
        self.pressure.map_or(self.summary.name.clone(), psi)
    }

    /// The path of its tip, as pictures over pressure show it; `case` is its place in the set.
    pub fn path(&self, case: usize) -> Tip<'_> {
        let rest = self.summary.rest.map(|rest| [rest.tip_x_m, rest.tip_z_m]);
        Tip { name: self.name(), times: &self.times, path: &self.tip, rest, case: Some(case) }
    }
}

/// A pressure as the tables of the paper have it.
pub fn psi(pascal: f64) -> String {
    format!("{} psi", (1e3 * pascal / PASCAL_PER_PSI).round() / 1e3)
}

/// Writes what a set of runs has in common into its folder: one summary, one page, pictures over pressure. `model` is
/// that of one of them.
/// # Errors
/// [`StoreError::Write`].
pub fn write_set(
    folder: &Folder,
    request: &Request,
    model: &Model,
    members: &[Member],
    remarks: Option<&str>,
) -> Result<(), StoreError> {
    let row = |member: &Member| member.pressure.map(|pressure| PressureRow::new(pressure, &member.summary));
    let rows: Vec<PressureRow> = members.iter().filter_map(row).collect();
    let over = pressures(&request.name, "simulated", &rows);
    folder.write(PRESSURES, over.svg.as_bytes())?;
    let mut pictures = vec![Picture {
        name: "pressures".to_owned(),
        title: "Frequency and damping over pressure".to_owned(),
        caption: "By the paper's method from each swing, and of the first mode. Of the paper's own curves only what its text says is written in.".to_owned(),
        drawing: over,
    }];
    let paths: Vec<Tip> = members.iter().enumerate().map(|(k, member)| member.path(k)).collect();
    pictures.extend(tips(&paths));
    let cycles: Vec<(String, &[Cycle])> = members
        .iter()
        .zip(&paths)
        .map(|(member, path)| (path.name.clone(), member.summary.cycles.as_deref().unwrap_or_default()))
        .collect();
    pictures.extend(over_pressure_and_amplitude(&cycles));
    for picture in &pictures[1..] {
        folder.write(&picture.file(), picture.svg().as_bytes())?;
    }
    let written = SystemTime::now();
    let rods = of_family(model, members.iter().filter_map(|member| member.rod.clone()).collect());
    let html = set_page(request, members, (rods, &pictures), remarks, written);
    folder.write(REPORT, html.as_bytes())?;
    let run = |member: &Member| json!({ "pressure_pa": member.pressure, "run": member.summary });
    let runs: Vec<_> = members.iter().map(run).collect();
    write_mark(folder, request, "set", written, json!({ "runs": runs }))
}

fn set_page(
    request: &Request,
    members: &[Member],
    (rods, pictures): (Option<Rods>, &[Picture]),
    remarks: Option<&str>,
    written: SystemTime,
) -> String {
    let broken = members.iter().filter(|member| member.summary.status != Status::Complete).count();
    let word = match broken {
        0 => format!("Simulated: {} runs", members.len()),
        broken => format!("Simulated: {} runs, {broken} of them not to their end", members.len()),
    };
    let range = |of: &dyn Fn(&Summary) -> Option<f64>| {
        let values: Vec<f64> = members.iter().filter_map(|member| of(&member.summary)).collect();
        let least = values.iter().copied().reduce(f64::min)?;
        Some((least, values.iter().copied().fold(least, f64::max)))
    };
    let hertz = range(&|summary| summary.natural_frequency_hz)
        .map(|(low, high)| format!(" The natural frequency lies between {low:.2} and {high:.2} Hz."));
    let ratio = range(&|summary| summary.damping_ratio)
        .map(|(low, high)| format!(" The damping ratio lies between {low:.3} and {high:.3}."));
    let ends = members.iter().filter_map(|member| member.pressure);
    let (first, last) = (ends.clone().reduce(f64::min), ends.reduce(f64::max));
    let over = match (first, last) {
        (Some(first), Some(last)) => format!("Releases from {} to {}.", psi(first), psi(last)),
        _ => "Releases.".to_owned(),
    };
    let lead = format!("{over}{}{}", hertz.unwrap_or_default(), ratio.unwrap_or_default());
    let mut page = Page::new(&request.name, &word, &lead);
    let mut warnings: Vec<String> = Vec::new();
    for member in members {
        let own = member.summary.warnings.iter().cloned().chain(not_complete(&member.summary));
        warnings.extend(own.map(|warning| format!("{}: {warning}", member.summary.name)));
    }
    page.section("Over pressure");
    let pressures: Vec<f64> = members.iter().filter_map(|member| member.pressure).collect();
    if pressures.len() == members.len() {
        let in_psi: Vec<f64> = pressures.iter().map(|pressure| pressure / PASCAL_PER_PSI).collect();
        page.family(&Family::default().by("pressure", "psi", &in_psi));
    }
    for picture in &pictures[..1] {
        page.figure(picture);
    }
    rods.iter().for_each(|rods| page.rods(rods));
    if let Some(remarks) = remarks {
        page.list(&remarks.lines().map(str::to_owned).collect::<Vec<_>>());
    }
    page.figures(&pictures[1..]);
    page.section("Numbers");
    page.table(&set_table(members));
    page.text("Each run has a folder of its own beside this page, with its trajectory, its scenario and its picture.");
    let runs = vec![("runs".to_owned(), members.len().to_string())];
    page.before_use(&before_use(members.first().map(|member| &member.summary), &warnings));
    page.facts_of(request, written, runs);
    page.finish()
}

fn set_table(members: &[Member]) -> Table<'static> {
    let row = |member: &Member| {
        let summary = &member.summary;
        let number = |value: Option<f64>, digits: i32| {
            value.map_or("-".to_owned(), |value| significant(value, digits))
        };
        let rest = summary.rest;
        vec![
            member.name(),
            number(rest.map(|rest| 1e3 * rest.tip_x_m), 4),
            number(rest.map(|rest| 1e3 * rest.tip_z_m), 4),
            number(summary.damped_frequency_hz, 4),
            number(summary.natural_frequency_hz, 4),
            number(summary.damping_ratio, 3),
            number(summary.modes.as_ref().and_then(|modes| modes.first()).map(|m| m.natural_frequency_hz), 4),
            number(summary.settling_2_percent_s, 3),
            if summary.beyond_straight_down == Some(true) { "yes" } else { "no" }.to_owned(),
            summary.effort.steps.to_string(),
        ]
    };
    Table {
        caption: "Each run; frequencies and damping ratio by the paper's method",
        heads: &[
            "pressure",
            "rest x, mm",
            "rest z, mm",
            "damped, Hz",
            "natural, Hz",
            "damping ratio",
            "first mode, Hz",
            "settled to 2 %, s",
            "beyond straight down",
            "steps",
        ],
        rows: members.iter().map(row).collect(),
    }
}

/// What should be known before a simulation is used.
fn before_use(first: Option<&Summary>, warnings: &[String]) -> BeforeUse {
    let (extrapolated, warnings) = extrapolated(warnings);
    BeforeUse {
        note: Some(
            "This is simulated, not measured: these numbers omit whatever the model omits.".to_owned(),
        ),
        warnings,
        extrapolated: Some(extrapolated),
        assumed: first.map(assumed::of_run).unwrap_or_default(),
        ..BeforeUse::default()
    }
}

/// What a run that did not come to its end must say first.
fn not_complete(summary: &Summary) -> Option<String> {
    match &summary.status {
        Status::Complete => None,
        Status::CutShort { time } => {
            let asked = summary.settings.duration_s;
            Some(format!("it was cut short at {time:.2} s of {asked:.2} s; all numbers are of that part"))
        }
        Status::Failed { time, reason } => {
            Some(format!("it failed at {time:.4} s ({reason}); all numbers are of what was before that"))
        }
    }
}

/// The page of one run.
pub(super) fn page(
    request: &Request,
    summary: &Summary,
    pictures: &[Picture],
    rods: Option<Rods>,
    written: SystemTime,
) -> String {
    let word = match &summary.status {
        Status::Complete => "Simulated: complete",
        Status::CutShort { .. } => "Simulated: cut short",
        Status::Failed { .. } => "Simulated: failed",
    };
    let mut page = Page::new(&summary.name, word, &lead(summary));
    let warnings: Vec<String> = not_complete(summary).into_iter().chain(summary.warnings.clone()).collect();
    let of = |names: &[&str]| -> Vec<&Picture> {
        pictures.iter().filter(|picture| names.contains(&picture.name.as_str())).collect()
    };
    page.section("The swing");
    if let Some(rods) = &rods {
        page.rods(rods);
    }
    page.figures(of(&["swing", "spectrum", "trajectory", "postures"]));
    if summary.events.len() > 1 || summary.events.iter().any(|event| event.kind != EventKind::Release) {
        page.section("What drives it");
        page.figures(of(&["drive-pressure", "drive-force", "response"]));
    }
    events::events(&mut page, summary);
    page.section("Energy and phase");
    page.figures(of(&["energy", "phase"]));
    page.section("Over the amplitude");
    page.figures(of(&["damping-over-amplitude", "frequency-over-amplitude"]));
    numbers(&mut page, summary);
    let settings = &summary.settings;
    let mut own = vec![
        ("integrator".to_owned(), format!("{:?}, tolerance {:e}", settings.method, settings.tolerance)),
        ("nodes".to_owned(), settings.nodes.to_string()),
        ("scheme".to_owned(), settings.scheme.clone()),
        ("starts from".to_owned(), settings.initial.clone()),
        (
            "before the release".to_owned(),
            settings.history_s.map_or("memory relaxed there".to_owned(), |[hung, raised, held]| {
                format!("hung for {hung} s, raised in {raised} s, held for {held} s")
            }),
        ),
        ("simulated".to_owned(), format!("{} s, {} samples", summary.simulated_s, summary.samples)),
        ("steps".to_owned(), format!("{}, {} rejected", summary.effort.steps, summary.effort.rejected)),
    ];
    own.extend(
        summary
            .real_time_factor
            .map(|factor| ("simulated over wall time".to_owned(), significant(factor, 2))),
    );
    let request = Request { input_hashes: summary.inputs_sha256.clone(), ..request.clone() };
    page.before_use(&before_use(Some(summary), &warnings));
    page.facts_of(&request, written, own);
    page.finish()
}

/// What the run comes to, in a few sentences.
fn lead(summary: &Summary) -> String {
    let mut text = String::new();
    match (summary.natural_frequency_hz, summary.damping_ratio) {
        (Some(hz), Some(ratio)) => {
            let event = match main_event(&summary.events) {
                Some(event) if event.kind != EventKind::Release => format!("After its {}", event.name()),
                _ => "Let go".to_owned(),
            };
            let [hz, ratio] = [fixed(hz, 3), significant(ratio, 3)];
            let _ = write!(
                text,
                "{event}, the tip swings with a natural frequency of {hz} Hz and a damping ratio of {ratio}."
            );
        }
        _ => {
            let why = summary.missing.get("damping_ratio").map_or("", String::as_str);
            let _ = write!(text, "Frequency and damping are not available: {why}.");
        }
    }
    if let Some(lowest) = summary.lowest {
        let beyond = match summary.beyond_straight_down {
            Some(true) => " and passes beyond straight down, which gives z(t) a second bump in each swing",
            _ => "",
        };
        let _ = write!(text, " It falls to z = {:.1} mm{beyond}.", 1e3 * lowest.tip_z_m);
    }
    if let Some(rest) = summary.rest {
        let [x, z] = [rest.tip_x_m, rest.tip_z_m].map(|at| 1e3 * at);
        let angle = rest.tip_angle_rad.to_degrees();
        let _ = write!(text, " At rest it is at x = {x:.1} mm, z = {z:.1} mm, at {angle:.1} degrees.");
    }
    if let Some(settled) = summary.settling_2_percent_s {
        let _ = write!(text, " After {settled:.2} s it stays within 2 % of its largest excursion.");
    }
    text
}

fn numbers(page: &mut Page, summary: &Summary) {
    page.section("Numbers");
    let row = |own: &crate::quantities::Quantity| {
        let why = own.value.as_ref().err().cloned().unwrap_or_default();
        vec![own.name.to_owned(), own.text(), own.unit.to_owned(), why]
    };
    page.table(&Table {
        caption: "Numbers of the run; summary.json has all digits",
        heads: &["quantity", "value", "unit", "reason if missing"],
        rows: quantities(summary).iter().map(row).collect(),
    });
    let cycles = summary.cycles.as_deref().unwrap_or_default();
    let cycle = |(k, cycle): (usize, &Cycle)| {
        vec![
            (k + 1).to_string(),
            format!("{:.3}", cycle.time_s),
            format!("{:.2}", 1e3 * cycle.amplitude_m),
            significant(cycle.damping_ratio, 3),
            format!("{:.4}", cycle.damped_frequency_hz),
        ]
    };
    page.folded(
        "Cycle by cycle",
        &Table {
            caption: "From each upper peak to the next",
            heads: &["cycle", "time, s", "amplitude, mm", "damping ratio", "damped frequency, Hz"],
            rows: cycles.iter().enumerate().map(cycle).collect(),
        },
    );
    let rows = |modes: &Option<Vec<Mode>>, friction: &str| -> Vec<Vec<String>> {
        let row = |(k, mode): (usize, &Mode)| {
            let hertz = format!("{:.4}", mode.natural_frequency_hz);
            vec![format!("{}{friction}", k + 1), hertz, significant(mode.damping_ratio, 3)]
        };
        modes.iter().flatten().enumerate().map(row).collect()
    };
    let slipping = rows(&summary.slipping_modes, ", friction slips");
    let sticks = if summary.slipping_modes.is_some() { ", friction sticks" } else { "" };
    page.folded(
        "Modes about the rest",
        &Table {
            caption: "Small vibrations about the rest, slowest first",
            heads: &["mode", "natural frequency, Hz", "damping ratio"],
            rows: [rows(&summary.modes, sticks), slipping].concat(),
        },
    );
    let parameter = |(path, own): (&String, &efam_experiments::summary::RunParameter)| {
        vec![path.clone(), short(own.value), own.unit.clone(), format_si(own.value, &own.unit)]
    };
    page.folded(
        "All parameters of the model",
        &Table {
            caption: "As they were run, in SI units and with a prefix",
            heads: &["parameter", "value", "unit", "told"],
            rows: summary.parameters.iter().map(parameter).collect(),
        },
    );
}

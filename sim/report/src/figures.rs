//! The paper's Figures 4 to 9 from our own runs or from recordings, on disk.
//!
//! ```text
//! outputs/<UTC>_figures_<hash8>/
//!   figure-4.svg … figure-9.svg   the figures
//!   figure-4.csv …                their numbers; figure-4-rest.csv, figure-8-spectrum.csv beside them
//!   report.html                   each figure, what the paper's shows, how ours differs
//!   figures.json                  the same words, and every run's summary
//!   scenario.toml                 what was simulated, for `efam simulate`; or experiment.toml, what was recorded
//!   summary.json                  by which command
//! ```

mod page;
mod summary_text;

use std::f64::consts::TAU;
use std::fmt::Write;
use std::time::SystemTime;

use efam_store::StoreError;
use efam_store::folder::Folder;
use serde_json::{Value, json};

use crate::calibrated::EXPERIMENT;
use crate::page::REPORT;
use crate::paper::{Origin, Pressure};
use crate::picture::{are_recorded, every_other, example, in_psi, model_name, models, paper};
use crate::{Request, write_mark};

pub use summary_text::{Words, words};

/// The words and numbers.
pub const FIGURES: &str = "figures.json";
/// What was simulated.
pub const SCENARIO: &str = "scenario.toml";

/// Writes the figures into an open folder; `request.resolved_scenario` is the text of the scenario or the experiment.
/// # Errors
/// [`StoreError::Write`].
pub fn write_figures(
    folder: &Folder,
    request: &Request,
    all: &[Pressure],
    words: &[Words],
) -> Result<(), StoreError> {
    let pictures = paper(all);
    for picture in &pictures {
        folder.write(&format!("{}.svg", picture.name), picture.svg().as_bytes())?;
    }
    for (name, text) in tables(all) {
        folder.write(&name, text.as_bytes())?;
    }
    let source = if are_recorded(all) { EXPERIMENT } else { SCENARIO };
    folder.write(source, request.resolved_scenario.as_bytes())?;
    let run = |of: &Pressure| match &of.origin {
        Origin::Simulated(own) => json!({ "pressure_pa": of.pressure, "run": own.summary }),
        Origin::Recorded(_) => json!({ "pressure_pa": of.pressure, "release": of.name }),
    };
    let runs: Vec<Value> = all.iter().map(run).collect();
    let text = json!({ "figures": words, "runs": runs });
    folder.write(FIGURES, format!("{text:#}\n").as_bytes())?;
    let written = SystemTime::now();
    folder.write(REPORT, page::page(request, all, &pictures, words, written).as_bytes())?;
    write_mark(folder, request, "figures", written, json!({ "figures": words }))
}

/// A line of names, then rows; a cell without a number is empty.
fn table(names: &[String], rows: impl Iterator<Item = Vec<Option<f64>>>) -> String {
    let mut text = names.join(",") + "\n";
    for row in rows {
        let cells: Vec<String> =
            row.into_iter().map(|cell| cell.map_or(String::new(), |value| format!("{value:?}"))).collect();
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

/// All numbers behind the figures, by file name.
fn tables(all: &[Pressure]) -> Vec<(String, String)> {
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let key = |nodes: Option<usize>| nodes.map_or("euler".to_owned(), |nodes| format!("pder_{nodes}"));
    let of_models = |what: &str, unit: &str| {
        models().map(|nodes| format!("{what}_{}_{unit}", key(nodes))).collect::<Vec<_>>()
    };
    let paths = every_other(all).into_iter().flat_map(|of| {
        let samples = of.times.iter().zip(&of.path);
        samples.map(|(time, tip)| vec![Some(in_psi(of)), Some(*time), Some(tip[0]), Some(tip[1])])
    });
    let rests = all.iter().filter_map(|of| {
        let [x, z] = of.tip_at_rest?;
        Some(vec![Some(in_psi(of)), Some(x), Some(z)])
    });
    let stiffness = all.iter().map(|of| {
        let fits = models().map(|nodes| of.fit(nodes).map(|fit| fit.bending_stiffness));
        [Some(in_psi(of))].into_iter().chain(of.published).chain(fits).collect()
    });
    let errors = all
        .iter()
        .map(|of| [Some(in_psi(of))].into_iter().chain(models().map(|nodes| of.tip_error(nodes))).collect());
    let swings = all.iter().map(|of| {
        let numbers = &of.numbers;
        vec![
            Some(in_psi(of)),
            numbers.damped_frequency_hz,
            numbers.natural_frequency_hz,
            numbers.damping_ratio,
            numbers.first_mode_hz,
        ]
    });
    let published = ["published_ei_axial_n_m2", "published_ei_euler_n_m2", "published_ei_pder_32_n_m2"];
    let mut tables = vec![
        ("figure-4.csv", table(&names(&["pressure_psi", "time_s", "tip_x_m", "tip_z_m"]), paths)),
        ("figure-4-rest.csv", table(&names(&["pressure_psi", "rest_x_m", "rest_z_m"]), rests)),
        (
            "figure-5.csv",
            table(
                &[names(&["pressure_psi"]), names(&published), of_models("ei", "n_m2")].concat(),
                stiffness,
            ),
        ),
        ("figure-6.csv", table(&[names(&["pressure_psi"]), of_models("tip_error", "m")].concat(), errors)),
        ("figure-7.csv", shapes(all)),
        (
            "figure-9.csv",
            table(
                &names(&[
                    "pressure_psi",
                    "damped_frequency_hz",
                    "natural_frequency_hz",
                    "damping_ratio",
                    "first_mode_hz",
                ]),
                swings,
            ),
        ),
    ];
    if let Some(of) = example(all) {
        let coordinate = of.coordinate();
        let letter = coordinate.letter();
        let (rest, decay) = (of.tip_at_rest.map(|tip| coordinate.of(tip)), of.decay());
        let places = of.times.iter().zip(&of.path).map(|(time, tip)| {
            let envelope = rest.zip(decay).map(|(rest, of)| rest + of.envelope(*time));
            vec![Some(*time), Some(coordinate.of(*tip)), envelope]
        });
        let heads = ["time_s".to_owned(), format!("tip_{letter}_m"), format!("envelope_{letter}_m")];
        tables.push(("figure-8.csv", table(&heads, places)));
        if let Some(spectrum) = of.spectrum() {
            let step = spectrum.frequency_step / TAU;
            let bins = spectrum.amplitude.iter().enumerate();
            let bins = bins.map(|(k, amplitude)| vec![Some(step * k as f64), Some(*amplitude)]);
            tables.push(("figure-8-spectrum.csv", table(&names(&["frequency_hz", "amplitude_m"]), bins)));
        }
    }
    tables.into_iter().map(|(name, text)| (name.to_owned(), text)).collect()
}

fn shapes(all: &[Pressure]) -> String {
    let mut text = String::from("pressure_psi,model,point,x_m,z_m\n");
    for of in all {
        let own = of.shapes.iter().map(|shape| (model_name(shape.nodes), shape.points.clone()));
        let body = of.body_at_rest.iter().map(|(_, at)| *at).chain(of.tip_at_rest).collect();
        let origin = if of.is_recorded() { "recorded" } else { "simulated" };
        for (model, points) in own.chain([(origin.to_owned(), body)]) {
            for (k, [x, z]) in points.iter().enumerate() {
                let _ = writeln!(text, "{:?},\"{model}\",{k},{x:?},{z:?}", in_psi(of));
            }
        }
    }
    text
}

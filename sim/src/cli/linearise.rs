//! `efam linearise`: a linear model of a scenario's rod about its rest, for a controller.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use efam_core::left_out;
use efam_inference::predict::PredictionSettings;
use efam_inference::predict::linear::Calibrated;
use efam_report::Request;
use efam_report::linear::{LinearAnswer, Wanted, linear_table, write_linear};
use efam_store::Folder;
use models::quantity::format_si;
use schemars::JsonSchema;
use serde::Serialize;

use super::answer;
use super::arguments::{Output, Source, argv, quantity};
use super::console::Console;
use super::failure::Failure;
use super::interrupt;
use super::rest::{cases, load};

const HELP: &str = "Examples:
  efam linearise scenarios/release-15psi.toml
  efam linearise scenarios/payload-80g.toml --pressure 40psi --output tip_z
  efam linearise scenarios/release-15psi.toml --input pressure,force_z
    --sample 10ms --reduce 6 --out outputs/controller
  efam linearise scenarios/steel-ruler.toml --input base_acceleration_z --json
  efam linearise outputs/beam/rod.toml --payload 80g --draws 400

Inputs: pressure, force_x, force_z, moment (at the end of the rod),
base_acceleration_x, base_acceleration_z, or a parameter such as
effects.set_curvature.natural_curvature. Outputs: tip_x, tip_z, tip_angle, or
points such as point_0.5_z. All count from the rest. The rod or muscle of a
calibration has 95 % intervals.

Exit codes: 4 if no rest posture is found.";

const STICKS: &str = "friction holds as a spring in motions this small, and slips in larger ones: --slipping is a \
    model of these";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Linearise {
    #[command(flatten)]
    source: Source,
    /// Mass at the tip, such as 80g [default: the scenario's, or none].
    #[arg(long, value_name = "MASS", allow_hyphen_values = true)]
    payload: Option<String>,
    /// What moves the rod; several, as pressure,force_z [default: pressure, or force_z of a rod that is no muscle].
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    input: Vec<String>,
    /// What is seen of it; several, as tip_z,tip_angle.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_value = "tip_x,tip_z")]
    output: Vec<String>,
    /// Also a model with samples so far apart, such as 10ms, inputs held between them.
    #[arg(long, value_name = "TIME")]
    sample: Option<String>,
    /// Also a model with so many states, by balancing, with the bound of its error.
    #[arg(long, value_name = "STATES")]
    reduce: Option<usize>,
    /// Without friction, as in motions that are large against it.
    #[arg(long)]
    slipping: bool,
    /// Number of poles to print, slowest first.
    #[arg(long, default_value_t = 3, value_name = "N")]
    count: usize,
    /// Number of draws from the errors of the calibration, if the rod has one.
    #[arg(long, value_name = "COUNT", default_value_t = PredictionSettings::default().draws)]
    draws: usize,
    /// Of the random numbers.
    #[arg(long, default_value_t = PredictionSettings::default().seed)]
    seed: u64,
    #[command(flatten)]
    results: Output,
}

/// The JSON output.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// Where the results are.
    folder: &'a Path,
    /// The linear model.
    linear: &'a LinearAnswer,
}

pub fn run(args: &Linearise, console: &Console) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    let sample = quantity("--sample", args.sample.as_ref(), "s")?;
    if let Some(sample) = sample.filter(|sample| !(*sample > 0.0 && sample.is_finite())) {
        return Err(Failure::Usage(format!("--sample {sample} s: must be longer than zero")));
    }
    let scenario = load(&args.source, args.payload.as_ref())?;
    let mut all = cases(&scenario, console)?;
    if all.len() > 1 {
        let message = "a linear model is of one pressure; choose it, such as --pressure 40psi";
        return Err(Failure::Usage(message.to_owned()));
    }
    let read = all.swap_remove(0);
    let read = if args.slipping { read.slipping() } else { read };
    let calibrated = scenario.known().map(|known| Calibrated::of(&read, known));
    let case = calibrated.as_ref().map_or(&read, |own| &own.case);
    let mut more = calibrated.as_ref().map_or(Vec::new(), |own| own.warnings.clone());
    let linear = case.linearise(&args.input, &args.output)?;
    let wanted = Wanted { sample, order: args.reduce };
    let mut answer = LinearAnswer::new(&case.name, case.pressure, &linear, wanted)?;
    more.extend(left_out::warnings(&case.model, case.muscle().is_some(), args.count));
    if case.model.slipping().is_some() {
        more.push(STICKS.to_owned());
    }
    if linear.dead_time > 0.0 {
        let time = format_si(linear.dead_time, "s");
        more.push(format!(
            "the dead time of the pressure line, {time}, is not in the matrices: add it to the input"
        ));
    }
    if !linear.is_stable {
        more.push("the rest is not stable: a motion about it grows".to_owned());
    }
    console.warn(&more);
    answer.warnings = case.warnings.iter().cloned().chain(more).collect();
    let hash = |(file, text): (&str, &str)| (file.to_owned(), efam_store::sha::sha256(text.as_bytes()));
    let request = Request {
        name: case.name.clone(),
        out: args.results.out.clone(),
        overwrite: args.results.overwrite,
        resolved_scenario: case.resolved(),
        input_hashes: scenario.files().map(hash).collect(),
        warnings: answer.warnings.clone(),
        argv: argv(),
        wall_time_s: begin.elapsed().as_secs_f64(),
        ..Request::default()
    };
    super::signals::listen();
    let mut folder = efam_report::begin(&request)?;
    if let Some(calibrated) = &calibrated {
        let settings = PredictionSettings { draws: args.draws, seed: args.seed };
        let stages = console.steps(args.draws, "draws");
        let step = || stages.step();
        let work = || calibrated.intervals(&linear, answer.grid(), &settings, &step);
        let intervals;
        (folder, intervals) = interrupt::during(folder, &stages, work);
        stages.clear();
        answer.set_intervals(&intervals);
    }
    let written = |folder: &Folder| write_linear(folder, &request, &answer);
    let folder = interrupt::finished(folder, &console.stages(), written)?;
    let printed = Printed { folder: &folder, linear: &answer };
    answer::answer(&args.results, console, &folder, &printed, || linear_table(&answer, args.count))?;
    Ok(ExitCode::SUCCESS)
}

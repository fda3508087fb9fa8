//! `efam export`: a finished run in the formats of other programs.

use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use efam_report::aligned::{Aligned, Side};
use efam_report::export::{ExportError, Format, Stored, export, has_letters, read};
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::Form;
use super::console::{Console, print};
use super::failure::Failure;
use super::terminal::stdout;

const HELP: &str = "Examples:
  efam export outputs/beam --to mat
  efam export outputs/beam --to mat5 --out beam5.mat
  efam export outputs/beam --to mcap --out beam.mcap --overwrite
  efam export outputs/swing --to gif
  efam export outputs/swing --to png --out slide.png

In MATLAB:
  run = load(\"beam.mat\");
  plot(run.trajectory.time_s, run.trajectory.tip_z_m)

A model as a functional mock-up unit (FMI 3.0, co-simulation), by the Python
package, which brings the code that the unit runs:
  python -c 'import efam; efam.to_fmu(\"model.toml\", \"rod.fmu\")'

Exit codes: 1 if the file cannot be written, 2 if the folder is no run or has
no table of that kind, 3 if a table cannot be read.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Export {
    /// Folder of a run: of simulate, analyse, calibrate, predict with several cases.
    run: PathBuf,
    /// Format of the file.
    #[arg(long, value_name = "FORMAT")]
    to: To,
    /// The file [default: beside the run's folder, with its name].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace an existing file.
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    form: Form,
}

#[derive(Clone, Copy, ValueEnum)]
enum To {
    /// MAT of version 7.3, which is HDF5: for MATLAB, Octave, h5py.
    Mat,
    /// MAT of version 5: for scipy.io.loadmat, MATLAB, Octave.
    Mat5,
    /// MCAP with messages in JSON: for Foxglove, ROS 2, Rerun.
    Mcap,
    /// The rod of a simulation in motion, 640 pixels wide: for slides.
    Gif,
    /// The picture of a simulation, 2400 pixels wide: for slides.
    Png,
    /// A functional mock-up unit, which the Python package writes.
    #[value(hide = true)]
    Fmu,
}

/// The JSON output.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    /// The file.
    file: &'a Path,
    /// Its format.
    format: Format,
    /// What is in it.
    tables: Vec<Row<'a>>,
}

/// A table that was exported.
#[derive(Serialize, JsonSchema)]
struct Row<'a> {
    /// Its name.
    name: &'a str,
    /// Rows.
    rows: usize,
    /// Columns; those that differ in one number only count as one.
    columns: usize,
}

pub fn run(args: &Export, console: &Console) -> Result<ExitCode, Failure> {
    let format = match args.to {
        To::Mat => Format::Mat,
        To::Mat5 => Format::Mat5,
        To::Mcap => Format::Mcap,
        To::Gif => Format::Gif,
        To::Png => Format::Png,
        To::Fmu => {
            let message = format!(
                "--to fmu: the program writes no functional mock-up unit, because no kept Rust library does one with its \
                 states; the Python package does: python -c 'import efam; efam.to_fmu(\"{}\", \"rod.fmu\")'",
                efam_store::escape::escaped(&args.run.display().to_string())
            );
            return Err(Failure::Usage(message));
        }
    };
    let stored = read(&args.run).map_err(ExportError::from)?;
    let file = args.out.clone().unwrap_or_else(|| beside(&args.run, format));
    export(&stored, format, &file, args.overwrite)?;
    if matches!(format, Format::Gif | Format::Png) && !has_letters() {
        console.warn([format!(
            "{}: has no letters, because no font was found; install DejaVu Sans, Liberation Sans or Arial",
            file.display()
        )]);
    }
    let tables = rows(&stored);
    if args.form.json {
        print(&Printed { file: &file, format, tables })?;
    } else if !console.quiet {
        let mut out = stdout();
        let mut all = Aligned::new(&[("", Side::Words), ("rows", Side::Number), ("columns", Side::Number)]);
        tables.iter().for_each(|own| all.row([own.name, &own.rows.to_string(), &own.columns.to_string()]));
        write!(out, "{all}")?;
        writeln!(out, "\nwritten to {}", file.display())?;
    }
    Ok(ExitCode::SUCCESS)
}

fn rows(stored: &Stored) -> Vec<Row<'_>> {
    let row = |(name, rows, columns)| Row { name, rows, columns };
    stored.tables.iter().map(|of| row((&of.name, of.rows, of.series.len()))).collect()
}

/// `outputs/beam.mat` of `outputs/beam/`: what a run's folder holds stays what the run wrote.
fn beside(run: &Path, format: Format) -> PathBuf {
    // `.` and `..` have no name of their own.
    let whole = run.canonicalize().unwrap_or_else(|_| run.to_path_buf());
    let named = if run.file_name().is_some() { run } else { &whole };
    let mut name = named.file_name().map_or_else(|| OsString::from("run"), OsString::from);
    name.push(format!(".{}", format.ending()));
    named.with_file_name(name)
}

impl From<ExportError> for Failure {
    fn from(error: ExportError) -> Self {
        match error {
            ExportError::Run(error) => error.into(),
            ExportError::Results(error) => error.into(),
            error => Failure::Usage(error.to_string()),
        }
    }
}

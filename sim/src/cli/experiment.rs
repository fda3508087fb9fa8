//! `efam experiment init` and `check`: from recordings to releases.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use serde_json::{Value, json};
use sim::cleaning::{Cleaned, clean};
use sim::experiment::{Experiment, init};
use sim::recording::{ReadOptions, read};
use sim::results::experiment::{row, write};
use sim::results::{self, Folder, Request, ResultsError};

use super::calibrate::input_hashes;
use super::failure::Failure;
use super::{Cleaning, Init, OfExperiment};

/// Writes a first experiment file.
pub fn init(args: &Init) -> Result<ExitCode, Failure> {
    let out = &args.out;
    if out.exists() && !args.overwrite {
        return Err(ResultsError::Exists { folder: out.clone() }.into());
    }
    let mut recordings = Vec::new();
    for file in &args.files {
        recordings.push((relative(file, out), read(file, &ReadOptions::default())?));
    }
    let name = out.file_stem().map_or("".into(), |name| name.to_string_lossy());
    let text = init::draft(&name, &recordings);
    // Beside it first, so that no half of it is ever left.
    let partial = out.with_extension("toml.partial");
    fs::write(&partial, &text).and_then(|()| fs::rename(&partial, out)).map_err(|source| {
        let _ = fs::remove_file(&partial);
        ResultsError::Write { path: out.clone(), source }
    })?;
    let guesses = text.lines().filter(|line| line.contains("GUESS")).count();
    let unknown = text.lines().filter(|line| line.contains("FILL IN")).count();
    writeln!(
        io::stdout(),
        "{}: {} recording{}; look at {guesses} lines with GUESS and {unknown} with FILL IN, then\n  efam experiment check {}",
        out.display(),
        recordings.len(),
        if recordings.len() == 1 { "" } else { "s" },
        out.display()
    )?;
    Ok(ExitCode::SUCCESS)
}

/// A recording's path as the experiment file names it: relative to that file where one is below the other.
fn relative(file: &Path, out: &Path) -> String {
    let folder = match out.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let whole = |path: &Path| fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let (file_whole, folder) = (whole(file), whole(folder));
    for (up, above) in folder.ancestors().enumerate() {
        // The root alone is no common ground.
        if above.parent().is_none() {
            break;
        }
        if let Ok(below) = file_whole.strip_prefix(above) {
            let path: PathBuf = std::iter::repeat_n(Path::new(".."), up).collect::<PathBuf>().join(below);
            return path.to_string_lossy().replace('\\', "/");
        }
    }
    file_whole.to_string_lossy().into_owned()
}

/// Cleans the recordings and shows what came of it.
pub fn check(args: &Cleaning) -> Result<ExitCode, Failure> {
    let begin = Instant::now();
    let (experiment, folder) = open(&args.of)?;
    let cleaned = clean(&experiment)?;
    write(&folder, &request(&experiment, begin), &experiment, &cleaned, None)?;
    let folder = folder.finish()?;
    let mut out = io::stdout().lock();
    if args.of.json {
        writeln!(out, "{}", json(&cleaned, &folder))?;
        return Ok(ExitCode::SUCCESS);
    }
    table(&mut out, &cleaned)?;
    if args.decisions {
        decisions(&mut out, &cleaned)?;
    } else {
        writeln!(
            out,
            "{} decisions; --decisions lists them, with the keys that decide otherwise",
            cleaned.decisions.len()
        )?;
    }
    writeln!(out, "{}", folder.display())?;
    Ok(ExitCode::SUCCESS)
}

/// By which command an experiment was read, and what it stands on.
pub fn request(experiment: &Experiment, begin: Instant) -> Request {
    Request {
        name: experiment.name.clone(),
        resolved_scenario: experiment.text().to_owned(),
        input_hashes: input_hashes(experiment),
        argv: std::env::args().collect(),
        wall_time_s: begin.elapsed().as_secs_f64(),
        ..Request::default()
    }
}

/// Reads the experiment and opens the folder before the work, so that what stands in the way is said first.
pub fn open(args: &OfExperiment) -> Result<(Experiment, Folder), Failure> {
    let experiment = Experiment::load(&args.experiment, &args.set)?;
    let folder = results::open(args.out.as_deref(), args.overwrite, &experiment.name, experiment.text())?;
    Ok((experiment, folder))
}

/// Releases and decisions as one JSON object.
pub fn json(cleaned: &Cleaned, folder: &Path) -> Value {
    let releases: Vec<Value> = cleaned.releases.iter().map(row).collect();
    json!({ "releases": releases, "decisions": cleaned.decisions, "folder": folder.display().to_string() })
}

/// A line for each release.
pub fn table(out: &mut impl Write, cleaned: &Cleaned) -> io::Result<()> {
    let wide = cleaned.releases.iter().map(|of| of.release.name.chars().count()).max().unwrap_or(0).max(8);
    writeln!(
        out,
        "{:wide$}{:>10}{:>20}{:>9}{:>9}{:>9}{:>10}{:>14}{:>10}  ",
        "release",
        "pressure",
        "instant s",
        "hold deg",
        "drop mm",
        "samples",
        "masked %",
        "out mm (%)",
        "noise mm"
    )?;
    for of in &cleaned.releases {
        let s = &of.statistics;
        let pressure = of.release.pressure.map_or("-".to_owned(), |p| format!("{:.1} kPa", 1e-3 * p));
        let instant = format!("{:.4} ± {:.4}", of.instant, of.release.release_uncertainty);
        let out_of_plane = format!("{:.2} ({:.1})", 1e3 * s.out_of_plane, 1e2 * s.out_of_plane_share);
        let kept = match (&of.dropped, of.release.held_out, of.representative) {
            (Some(why), _, _) => format!("dropped: {why}"),
            (None, true, _) => "held out".to_owned(),
            (None, false, true) if cleaned.releases.len() > 1 => "kept, representative".to_owned(),
            (None, false, _) => "kept".to_owned(),
        };
        writeln!(
            out,
            "{:wide$}{pressure:>10}{instant:>20}{:>9.1}{:>9.2}{:>9}{:>10.2}{out_of_plane:>14}{:>10.4}  {kept}",
            of.release.name,
            s.hold_angle.to_degrees(),
            1e3 * s.static_drop,
            s.samples,
            1e2 * s.masked_share,
            1e3 * s.noise
        )?;
    }
    Ok(())
}

/// Every decision with the key that decides otherwise.
pub fn decisions(out: &mut impl Write, cleaned: &Cleaned) -> io::Result<()> {
    for decision in &cleaned.decisions {
        writeln!(out, "{}: {} [{}]", decision.about, decision.what, decision.key)?;
    }
    Ok(())
}

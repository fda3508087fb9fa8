//! `efam analyse`: the paper's analysis of every release of an experiment.

use std::f64::consts::TAU;
use std::io::{self, Write};
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use models::quantity::format_si;
use serde::Serialize;
use sim::analysis::bending_stiffness::StiffnessFit;
use sim::analysis::{AnalysisError, static_stiffness};
use sim::experiment::analyse::{Analysed, Said, analyse};
use sim::results::experiment::write;
use sim::schema::JsonSchema;

use super::arguments::Cleaning;
use super::experiment::{CheckPrinted, decisions, open, read, request, table};
use super::failure::Failure;
use super::interrupt;
use super::terminal::stdout;
use super::voice::{Voice, print};

const HELP: &str = "Examples:
  efam analyse beam.toml
  efam analyse beam.toml --nodes 16,32,64 --decisions
  efam analyse beam.toml --out outputs/analysed --json

Exit codes: 2 for the experiment file, 3 for its recordings, 130 if it is
interrupted, which saves nothing.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Analyse {
    #[command(flatten)]
    cleaning: Cleaning,
    /// Numbers of nodes with which to fit the tip at rest.
    #[arg(long, value_delimiter = ',', value_name = "N,…", default_values_t = static_stiffness::NODES)]
    nodes: Vec<usize>,
}

/// What is printed for programs.
#[derive(Serialize, JsonSchema)]
pub struct Printed<'a> {
    #[serde(flatten)]
    cleaned: CheckPrinted<'a>,
    /// Each release that is used.
    analysis: Vec<Said<'a>>,
}

pub fn run(args: &Analyse, voice: &Voice) -> Result<ExitCode, Failure> {
    let (args, nodes) = (&args.cleaning, &args.nodes);
    if let Some(wrong) = nodes.iter().find(|nodes| !(4..=2000).contains(*nodes)) {
        return Err(Failure::Usage(format!("--nodes {wrong}: must lie in 4..=2000")));
    }
    let begin = Instant::now();
    let (experiment, folder) = open(&args.of, voice)?;
    let stages = voice.stages();
    let (folder, cleaned) = interrupt::during(folder, &stages, || read(&experiment, &stages));
    let cleaned = cleaned?;
    stages.tell("frequency, damping and stiffness of each release");
    let (folder, analysed) = interrupt::during(folder, &stages, || analyse(&experiment, &cleaned, nodes));
    let analysed = analysed?;
    stages.tell("writing");
    write(&folder, &request(&experiment, begin), &experiment, &cleaned, Some(&analysed))?;
    interrupt::check()?;
    let folder = folder.finish()?;
    stages.clear();
    if args.of.output.form.json {
        let analysis = analysed.iter().map(Analysed::said).collect();
        print(&Printed { cleaned: CheckPrinted::of(&cleaned, &folder), analysis })?;
    }
    if args.of.output.form.json || voice.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    let mut out = stdout();
    table(&mut out, &cleaned)?;
    if args.decisions {
        decisions(&mut out, &cleaned)?;
    }
    for one in &analysed {
        tell(&mut out, one)?;
    }
    if !experiment.has_model() {
        writeln!(out, "\nno [rod] or [muscle] in the experiment: no stiffness is claimed")?;
    }
    writeln!(out, "\n{}", folder.display())?;
    Ok(ExitCode::SUCCESS)
}

fn tell(out: &mut impl Write, one: &Analysed) -> io::Result<()> {
    writeln!(out, "\n{}", one.of.release.name)?;
    let line = |out: &mut dyn Write, name: &str, text: String| writeln!(out, "  {name:<22}{text}");
    let error = one.rest.map_or(String::new(), |rest| format!(" ± {:.2}", 1e3 * rest.error[1]));
    line(out, "static drop", format!("{:.2}{error} mm", 1e3 * one.static_drop()))?;
    if let Some(warning) = one.rest_warning() {
        line(out, "  warning", warning)?;
    }
    match &one.measured {
        Err(error) => line(out, "frequency", error.to_string())?,
        Ok(measured) => {
            match &measured.damped_frequency {
                Ok(omega) => {
                    let error = measured
                        .frequency_error()
                        .map_or(String::new(), |error| format!(", cycles agree to {:.2} %", 1e2 * error));
                    let letter = measured.coordinate.name();
                    line(
                        out,
                        "damped frequency",
                        format!("{:.3} Hz, spectrum of {letter}(t){error}", omega / TAU),
                    )?;
                }
                Err(why) => line(out, "damped frequency", why.clone())?,
            }
            if let Ok(decay) = &measured.decay {
                let (natural, ratio) = (decay.natural_frequency / TAU, decay.damping_ratio);
                let count = measured.peaks.len();
                line(out, "natural frequency", format!("{natural:.3} Hz by eq. 7"))?;
                let residual = 1e3 * decay.rms_residual;
                line(
                    out,
                    "damping ratio",
                    format!("{ratio:.4} by eq. 6 on {count} upper peaks, which leave {residual:.3} mm rms"),
                )?;
            }
            if let Ok([first, .., last]) = measured.cycles.as_deref() {
                let at = |cycle: &sim::analysis::decay::Cycle| {
                    format!("{:.4} at {:.2} mm", cycle.damping_ratio, 1e3 * cycle.amplitude)
                };
                line(out, "  cycle by cycle", format!("{} to {}", at(first), at(last)))?;
            }
            if measured.since > 0.0 {
                let text = "the first, large swings have another frequency";
                line(out, "  counted from", format!("{:.2} s on: {text}", measured.since))?;
            }
            let bridged = &measured.bridged;
            if bridged.filled > 0 {
                let longest = 1e3 * bridged.longest;
                line(
                    out,
                    "bridged",
                    format!(
                        "{} samples, gaps of up to {longest:.0} ms, for the spectrum and peaks only",
                        bridged.filled
                    ),
                )?;
            }
            if let Some(at) = bridged.cut_at {
                line(out, "left out", format!("all after {at:.2} s, where a gap is too long to be bridged"))?;
            }
        }
    }
    match &one.in_motion {
        None => {}
        Some(Ok(found)) => line(
            out,
            "EI from the frequency",
            format!(
                "{} ({:.2} % for each % of frequency; a swing of this size is {:.2} % slower than the mode)",
                format_si(found.bending_stiffness, "N m^2"),
                found.sensitivity,
                100.0 * (1.0 - found.swing_over_mode)
            ),
        )?,
        Some(Err(error)) => line(out, "EI from the frequency", error.to_string())?,
    }
    if one.at_rest.is_empty() {
        return Ok(());
    }
    writeln!(
        out,
        "  {:<22}{:>14}{:>14}{:>10}{:>12}{:>14}",
        "EI from the tip, N m^2", "Nelder-Mead", "Gauss-Newton", "± %", "off mm", "evaluations"
    )?;
    if let Some(why) = &one.no_beam {
        line(out, "  Euler-Bernoulli", why.clone())?;
    }
    let ei = |fit: &Result<StiffnessFit, AnalysisError>| {
        fit.as_ref().map_or("-".to_owned(), |fit| format_si(fit.bending_stiffness, ""))
    };
    for row in &one.at_rest {
        let name = row.nodes.map_or("  Euler-Bernoulli".to_owned(), |nodes| format!("  PDER, {nodes} nodes"));
        let fits = (&row.nelder_mead, &row.gauss_newton);
        let off = fits
            .1
            .as_ref()
            .or(fits.0.as_ref())
            .map_or("-".to_owned(), |fit| format!("{:.2}", 1e3 * fit.residual[0].hypot(fit.residual[1])));
        let count = |fit: &Result<StiffnessFit, AnalysisError>| {
            fit.as_ref().map_or("-".to_owned(), |fit| fit.evaluations.to_string())
        };
        let counts = format!("{} / {}", count(fits.0), count(fits.1));
        let error = one.rest.and_then(|rest| row.relative_error(rest.error));
        let error = error.map_or("-".to_owned(), |error| format!("{:.2}", 100.0 * error));
        writeln!(out, "  {name:<22}{:>14}{:>14}{error:>10}{off:>12}{counts:>14}", ei(fits.0), ei(fits.1))?;
        if let (Err(error), Err(_)) = fits {
            writeln!(out, "    {error}")?;
        }
    }
    Ok(())
}

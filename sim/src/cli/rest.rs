//! `efam statics` and `efam modes`: what a scenario's rod does without being let go.

use std::f64::consts::TAU;
use std::io::{self, Write};
use std::process::ExitCode;

use clap::Args;
use models::quantity::format_si;
use models::statics::{self, equilibrium};
use models::system::System;
use serde_json::json;
use sim::forward::tip;
use sim::results::rest::root_moment;
use sim::scenario::{Case, Scenario};

use super::arguments::{Form, Source};
use super::failure::Failure;
use super::voice::{Voice, print};

const STATICS_HELP: &str = "Examples:
  efam statics scenarios/payload-80g.toml
  efam statics scenarios/all-rows.toml --json

Exit codes: 4 if no rest posture is found.";

#[derive(Args)]
#[command(after_help = STATICS_HELP)]
pub struct Statics {
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    form: Form,
}

const MODES_HELP: &str = "Examples:
  efam modes scenarios/payload-80g.toml --count 5
  efam modes scenarios/steel-ruler.toml --json

Exit codes: 4 if no rest posture is found.";

#[derive(Args)]
#[command(after_help = MODES_HELP)]
pub struct Modes {
    #[command(flatten)]
    source: Source,
    /// How many, from the slowest.
    #[arg(long, default_value_t = 3, value_name = "N")]
    count: usize,
    #[command(flatten)]
    form: Form,
}

/// Shows the rest posture.
pub fn statics(args: &Statics, voice: &Voice) -> Result<ExitCode, Failure> {
    let mut rows = Vec::new();
    for case in cases(&args.source, voice)? {
        let rest = equilibrium(&case.model, None)?;
        let mut system = System::new(&case.model);
        let at_rest = vec![0.0; rest.q.len()];
        let root_moment = root_moment(&mut system, &rest);
        let angle = rest.q[rest.q.len() - 1];
        let tip = tip(&system, &rest.q, &at_rest).0;
        rows.push(json!({
            "name": case.name, "pressure_pa": case.pressure, "tip_x_m": tip[0], "tip_z_m": tip[1],
            "tip_angle_rad": angle, "root_moment_n_m": root_moment, "imbalance_n": rest.imbalance,
            "iterations": rest.iterations, "stable": rest.stable, "warnings": case.warnings,
        }));
    }
    if args.form.json {
        print(&json!({ "statics": rows }))?;
    }
    if args.form.json || voice.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    let mut out = io::stdout().lock();
    writeln!(out, "{:24}{:>12}{:>12}{:>14}{:>16}", "", "tip x", "tip z", "end angle", "root moment")?;
    for row in rows {
        let number = |key: &str| row[key].as_f64().unwrap_or(f64::NAN);
        let angle = format!("{:.2} deg", number("tip_angle_rad").to_degrees());
        writeln!(
            out,
            "{:24}{:>12}{:>12}{angle:>14}{:>16}{}",
            row["name"].as_str().unwrap_or_default(),
            format_si(number("tip_x_m"), "m"),
            format_si(number("tip_z_m"), "m"),
            format_si(number("root_moment_n_m"), "N m"),
            if row["stable"] == true { "" } else { "  not stable" }
        )?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Shows the slowest vibrations about the rest posture.
pub fn modes(args: &Modes, voice: &Voice) -> Result<ExitCode, Failure> {
    let mut rows = Vec::new();
    for case in cases(&args.source, voice)? {
        let rest = equilibrium(&case.model, None)?;
        for (index, mode) in statics::modes(&case.model, &rest, args.count)?.iter().enumerate() {
            rows.push(json!({
                "name": case.name, "pressure_pa": case.pressure, "mode": index + 1,
                "frequency_hz": mode.angular_frequency / TAU, "damping_ratio": mode.damping_ratio,
            }));
        }
    }
    if args.form.json {
        print(&json!({ "modes": rows }))?;
    }
    if args.form.json || voice.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    let mut out = io::stdout().lock();
    writeln!(out, "{:24}{:>6}{:>14}{:>16}", "", "mode", "frequency", "damping ratio")?;
    for row in rows {
        let number = |key: &str| row[key].as_f64().unwrap_or(f64::NAN);
        writeln!(
            out,
            "{:24}{:>6}{:>14}{:>16.4}",
            row["name"].as_str().unwrap_or_default(),
            row["mode"].to_string(),
            format_si(number("frequency_hz"), "Hz"),
            number("damping_ratio")
        )?;
    }
    Ok(ExitCode::SUCCESS)
}

fn cases(source: &Source, voice: &Voice) -> Result<Vec<Case>, Failure> {
    let cases = Scenario::load(&source.scenario, &source.overrides())?.cases()?;
    voice.warn(cases.iter().flat_map(|case| &case.warnings));
    Ok(cases)
}

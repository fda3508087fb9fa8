//! `efam statics` and `efam modes`: what a scenario's rod does without being let go.

use std::io::Write;
use std::process::ExitCode;

use clap::Args;
use efam_core::left_out;
use efam_core::rest::{rest, root_moment, slipping_modes};
use efam_experiments::kind::FileKind;
use efam_experiments::scenario::{Case, ReleaseOptions, Scenario};
use efam_report::aligned::{Aligned, Side};
use models::muscle::Muscle;
use models::quantity::format_si;
use models::statics::equilibrium;
use models::system::System;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::{Form, Source, payload};
use super::console::{Console, print};
use super::failure::{Failure, of_kind};
use super::terminal::stdout;

const STATICS_HELP: &str = "Examples:
  efam statics scenarios/payload-80g.toml
  efam statics scenarios/release-15psi.toml --payload 80g
  efam statics scenarios/all-rows.toml --json

Exit codes: 4 if no rest posture is found.";

#[derive(Args)]
#[command(after_help = STATICS_HELP)]
pub struct Statics {
    #[command(flatten)]
    source: Source,
    /// Mass at the tip, such as 80g [default: the scenario's, or none].
    #[arg(long, value_name = "MASS", allow_hyphen_values = true)]
    payload: Option<String>,
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
    /// Mass at the tip, such as 80g [default: the scenario's, or none].
    #[arg(long, value_name = "MASS", allow_hyphen_values = true)]
    payload: Option<String>,
    /// Number of modes, slowest first.
    #[arg(long, default_value_t = 3, value_name = "N")]
    count: usize,
    #[command(flatten)]
    form: Form,
}

/// The JSON output: rest postures.
#[derive(Serialize, JsonSchema)]
pub struct StaticsPrinted {
    /// One for each case of the scenario.
    statics: Vec<Resting>,
}

/// A rest posture; in W, SI.
#[derive(Serialize, JsonSchema)]
struct Resting {
    /// Name of the case.
    name: String,
    /// Pressure above ambient.
    pressure_pa: Option<f64>,
    /// Tip along the undeformed rod.
    tip_x_m: f64,
    /// Tip upwards.
    tip_z_m: f64,
    /// Angle of the end body from x towards z.
    tip_angle_rad: f64,
    /// Bending moment at the root.
    root_moment_n_m: f64,
    /// What is left of the forces.
    imbalance_n: f64,
    /// Iterations of the search.
    iterations: usize,
    /// Whether the posture is stable.
    stable: bool,
    /// Caveats of the numbers.
    warnings: Vec<String>,
}

/// The JSON output: vibrations about the rest.
#[derive(Serialize, JsonSchema)]
pub struct ModesPrinted {
    /// All modes of all cases of the scenario, slowest first.
    modes: Vec<Vibration>,
}

/// A small vibration about the rest.
#[derive(Serialize, JsonSchema)]
struct Vibration {
    /// Name of the case.
    name: String,
    /// Pressure above ambient.
    pressure_pa: Option<f64>,
    /// Its number, the slowest being 1.
    mode: usize,
    /// Undamped frequency.
    frequency_hz: f64,
    /// Share of critical damping.
    damping_ratio: f64,
    /// What friction does in it, if there is any: it sticks in the smallest vibrations, and slips in a swing.
    friction: Option<Friction>,
}

/// What friction does in a vibration.
#[derive(Clone, Copy, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Friction {
    /// It holds as a spring.
    Sticks,
    /// It holds nothing.
    Slips,
}

/// Shows the rest posture.
pub fn statics(args: &Statics, console: &Console) -> Result<ExitCode, Failure> {
    let mut rows = Vec::new();
    let cases = cases(&load(&args.source, args.payload.as_ref())?, console)?;
    let muscle = cases.first().and_then(Case::muscle).map(Muscle::described);
    for case in cases {
        let rest = equilibrium(&case.model, None)?;
        let mut system = System::at_rest(&case.model);
        let at_rest = vec![0.0; rest.q.len()];
        let root_moment = root_moment(&mut system, &rest);
        let tip = system.observed_tip(&rest.q, &at_rest).0;
        rows.push(Resting {
            name: case.name,
            pressure_pa: case.pressure,
            tip_x_m: tip[0],
            tip_z_m: tip[1],
            tip_angle_rad: rest.q[rest.q.len() - 1],
            root_moment_n_m: root_moment,
            imbalance_n: rest.imbalance,
            iterations: rest.iterations,
            stable: rest.stable,
            warnings: case.warnings,
        });
    }
    if args.form.json {
        print(&StaticsPrinted { statics: rows })?;
        return Ok(ExitCode::SUCCESS);
    }
    if console.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    let numbers = ["tip x", "tip z", "end angle", "root moment"].map(|head| (head, Side::Number));
    let mut table = Aligned::new(&[&[("", Side::Words)], &numbers[..], &[("", Side::Name)]].concat());
    for row in rows {
        table.row([
            row.name,
            format_si(row.tip_x_m, "m"),
            format_si(row.tip_z_m, "m"),
            format!("{:.2} deg", row.tip_angle_rad.to_degrees()),
            format_si(row.root_moment_n_m, "N m"),
            if row.stable { "" } else { "not stable" }.to_owned(),
        ]);
    }
    write!(stdout(), "{table}")?;
    if let Some(muscle) = muscle {
        writeln!(stdout(), "muscle: {muscle}")?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Shows the slowest vibrations about the rest posture.
pub fn modes(args: &Modes, console: &Console) -> Result<ExitCode, Failure> {
    let mut rows = Vec::new();
    for case in cases(&load(&args.source, args.payload.as_ref())?, console)? {
        let modes = rest(&case.model, 0.0, args.count)?.modes?;
        console.warn(left_out::warnings(&case.model, case.muscle().is_some(), args.count));
        let slipping = slipping_modes(&case.model, 0.0, args.count);
        let sticks = slipping.as_ref().map(|_| Friction::Sticks);
        for (modes, friction) in [(modes, sticks), (slipping.unwrap_or_default(), Some(Friction::Slips))] {
            for (index, (frequency_hz, damping_ratio)) in modes.into_iter().enumerate() {
                rows.push(Vibration {
                    name: case.name.clone(),
                    pressure_pa: case.pressure,
                    mode: index + 1,
                    frequency_hz,
                    damping_ratio,
                    friction,
                });
            }
        }
    }
    if args.form.json {
        print(&ModesPrinted { modes: rows })?;
        return Ok(ExitCode::SUCCESS);
    }
    if console.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    let numbers = ["mode", "frequency", "damping ratio"].map(|head| (head, Side::Number));
    let mut table = Aligned::new(&[&[("", Side::Words)], &numbers[..], &[("", Side::Name)]].concat());
    for row in rows {
        let friction = match row.friction {
            Some(Friction::Sticks) => "friction sticks",
            Some(Friction::Slips) => "friction slips",
            None => "",
        };
        table.row([
            row.name,
            row.mode.to_string(),
            format_si(row.frequency_hz, "Hz"),
            format!("{:.4}", row.damping_ratio),
            friction.to_owned(),
        ]);
    }
    write!(stdout(), "{table}")?;
    Ok(ExitCode::SUCCESS)
}

/// The scenario with the command's options over it.
pub fn load(source: &Source, mass: Option<&String>) -> Result<Scenario, Failure> {
    let load = ReleaseOptions { payload: payload(mass, &source.set)?, ..ReleaseOptions::default() };
    let overrides = [load.overrides(), source.overrides()?].concat();
    let scenario = Scenario::load_with(&source.scenario, &overrides, &source.law);
    of_kind(FileKind::Scenario, &source.scenario, scenario)
}

/// Its cases, their warnings said.
pub fn cases(scenario: &Scenario, console: &Console) -> Result<Vec<Case>, Failure> {
    let cases = scenario.cases()?;
    console.detail(format!("{}: {} to show", scenario.path.display(), cases.len()));
    console.warn(cases.iter().flat_map(|case| &case.warnings));
    Ok(cases)
}

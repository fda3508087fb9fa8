//! `efam statics` and `efam modes`: what a scenario's rod does without being let go.

use std::io::Write;
use std::process::ExitCode;

use clap::Args;
use efam_core::left_out;
use efam_experiments::kind::FileKind;
use efam_experiments::scenario::{Case, ReleaseOptions, Scenario};
use models::muscle::Muscle;

use super::arguments::{Form, Source, payload};
use super::console::{Console, print};
use super::failure::{Failure, of_kind};
use super::terminal::stdout;
use crate::rest::{ModesPrinted, StaticsPrinted, resting, vibrations};

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

/// Shows the rest posture.
pub fn statics(args: &Statics, console: &Console) -> Result<ExitCode, Failure> {
    let cases = cases(&load(&args.source, args.payload.as_ref())?, console)?;
    let muscle = cases.first().and_then(Case::muscle).map(Muscle::described);
    let statics = cases.iter().map(resting).collect::<Result<_, _>>()?;
    let printed = StaticsPrinted { statics };
    if args.form.json {
        print(&printed)?;
    } else if !console.quiet {
        write!(stdout(), "{}", printed.table())?;
        if let Some(muscle) = muscle {
            writeln!(stdout(), "muscle: {muscle}")?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Shows the slowest vibrations about the rest posture.
pub fn modes(args: &Modes, console: &Console) -> Result<ExitCode, Failure> {
    let mut modes = Vec::new();
    for case in cases(&load(&args.source, args.payload.as_ref())?, console)? {
        modes.extend(vibrations(&case, args.count)?);
        console.warn(left_out::warnings(&case.model, case.muscle().is_some(), args.count));
    }
    let printed = ModesPrinted { modes };
    if args.form.json {
        print(&printed)?;
    } else if !console.quiet {
        write!(stdout(), "{}", printed.table())?;
    }
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

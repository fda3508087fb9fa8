//! `efam init`: a first scenario, or a muscle file, with comments.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use efam_store::atomic::write_new;
use efam_store::escape::shell_word;
use models::muscle::BUILT_IN;

use super::console::Console;
use super::failure::Failure;
use super::terminal::stdout;

const HELP: &str = "Examples:
  efam init
  efam init --out heavy.toml
  efam init --muscle

The files run as they stand. An experiment file comes from recordings: see
`efam experiment init`.

Exit codes: 2 if the file exists already.";

/// The scenario.
const SCENARIO: &str = include_str!("init/scenario.toml");
/// The text above the tables of a muscle.
const HEAD: &str = "# A muscle, to be changed: the numbers below are those of a published one. Try it with
#   efam simulate scenario.toml --muscle muscle.toml --open
# Replace name, source, the geometry at rest, and the rows of the table by your own; further rows of pressure
# may be added, and columns of bending stiffness left out.
";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Init {
    /// A muscle file instead of a scenario.
    #[arg(long)]
    muscle: bool,
    /// The file to write, which must not exist [default: scenario.toml or muscle.toml].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub fn run(args: &Init, console: &Console) -> Result<ExitCode, Failure> {
    let usual = Path::new(if args.muscle { "muscle.toml" } else { "scenario.toml" });
    let file = args.out.as_deref().unwrap_or(usual);
    let text = if args.muscle { muscle() } else { SCENARIO.to_owned() };
    write_new(file, |to| to.write_all(text.as_bytes()))?;
    if console.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    let word = shell_word(file);
    let next = if args.muscle {
        format!("efam predict --muscle {word} --pressure 15psi")
    } else {
        format!("efam simulate {word} --open")
    };
    writeln!(stdout(), "{}: written; try\n  {next}", file.display())?;
    Ok(ExitCode::SUCCESS)
}

/// The first built-in muscle under another name.
fn muscle() -> String {
    let (name, text) = BUILT_IN[0];
    // Its own head describes the paper; the tables begin at its name.
    let tables = text.find("name = ").map_or(text, |begin| &text[begin..]);
    let named = |name: &str| format!("name = \"{name}\"");
    HEAD.to_owned() + &tables.replacen(&named(name), &named("my-muscle"), 1)
}

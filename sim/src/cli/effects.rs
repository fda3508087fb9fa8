//! `efam effects`: the catalogue as a table, and the page of an effect.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use efam_experiments::scenario::read_laws;
use models::check::{Outcome, TESTS, is_mirrored};
use models::written::Definition;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::Form;
use super::console::{Console, print};
use super::failure::Failure;
use super::terminal::stdout;
use crate::catalogue::{Effect, all, listed, named};

const HELP: &str = "Examples:
  efam effects
  efam effects viscoelastic
  efam effects --json
  efam effects --check my_law.toml
  efam effects --rust my_law.toml

Exit codes: 1 if a law fails a test, 2 for a file that has no such law.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Effects {
    /// An effect.
    name: Option<String>,
    /// Run the catalogue's tests on the laws of a file, [laws.NAME], and show their pages.
    #[arg(long, value_name = "FILE", conflicts_with = "name")]
    check: Option<PathBuf>,
    /// Print the laws of a file as the Rust files that the catalogue takes.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["name", "check", "json"])]
    rust: Option<PathBuf>,
    #[command(flatten)]
    form: Form,
}

/// The JSON output: all effects, or one.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Printed {
    /// Without a name.
    Catalogue {
        /// All effects.
        effects: Vec<Effect>,
    },
    /// With a name.
    Page {
        /// The effect.
        #[serde(flatten)]
        effect: Effect,
        /// Its page.
        page: String,
    },
    /// With `--check`.
    Checked {
        /// Each law of the file.
        laws: Vec<Checked>,
    },
}

/// A law as text that was tested.
#[derive(Serialize, JsonSchema)]
pub struct Checked {
    /// The law.
    #[serde(flatten)]
    effect: Effect,
    /// Its page.
    page: String,
    /// Whether it is the same bent up and bent down.
    mirrored: bool,
    /// The tests of the catalogue.
    tests: Vec<Tested>,
}

/// A test of a law.
#[derive(Serialize, JsonSchema)]
struct Tested {
    /// What it makes sure of.
    test: &'static str,
    /// What is wrong; none if it holds, or does not apply.
    error: Option<String>,
    /// Why it does not apply to this law; none if it was tested.
    not_tested: Option<&'static str>,
}

impl Tested {
    fn of(test: &'static str, found: Result<Outcome, String>) -> Self {
        let (error, not_tested) = match found {
            Ok(Outcome::Holds) => (None, None),
            Ok(Outcome::NotTested(reason)) => (None, Some(reason)),
            Err(error) => (Some(error), None),
        };
        Self { test, error, not_tested }
    }
}

pub fn run(args: &Effects, console: &Console) -> Result<ExitCode, Failure> {
    if let Some(file) = &args.rust {
        return rust(file);
    }
    if let Some(file) = &args.check {
        return check(file, args.form.json, console);
    }
    match &args.name {
        Some(name) => page(name, args.form.json, console),
        None => list(args.form.json, console),
    }
}

/// Lists all effects, kind by kind.
fn list(json: bool, console: &Console) -> Result<ExitCode, Failure> {
    if json {
        print(&Printed::Catalogue { effects: all() })?;
    } else if !console.quiet {
        let mut out = stdout();
        write!(out, "{}", listed())?;
        writeln!(
            out,
            "A scenario switches an effect on by [effects.NAME]; `efam effects NAME` shows its page."
        )?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Shows the page of an effect.
fn page(name: &str, json: bool, console: &Console) -> Result<ExitCode, Failure> {
    let effect = named(name)?;
    if json {
        print(&Printed::Page { effect: Effect::of(effect.about()), page: effect.page() })?;
    } else if !console.quiet {
        writeln!(stdout(), "{}", effect.page())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The effects of a file of laws; all of them are sound.
fn laws(file: &Path) -> Result<Vec<Definition>, Failure> {
    Ok(read_laws(file)?)
}

/// Tests the laws of a file.
fn check(file: &Path, json: bool, console: &Console) -> Result<ExitCode, Failure> {
    let mut checked = Vec::new();
    for law in laws(file)? {
        let effect = law.effect().map_err(|error| Failure::Usage(format!("laws.{}: {error}", law.name)))?;
        let tests = TESTS.map(|(test, run)| Tested::of(test, run(effect)));
        checked.push(Checked {
            effect: Effect::of(effect.about()),
            page: effect.page(),
            mirrored: is_mirrored(effect).map_err(Failure::Usage)?,
            tests: tests.into(),
        });
    }
    let fails = checked.iter().flat_map(|law| &law.tests).any(|test| test.error.is_some());
    if json {
        print(&Printed::Checked { laws: checked })?;
    } else if !console.quiet || fails {
        let mut out = stdout();
        for law in &checked {
            writeln!(out, "{}\n", law.page)?;
            for Tested { test, error, not_tested } in &law.tests {
                match (error, not_tested) {
                    (Some(error), _) => writeln!(out, "  FAILS  {test}: laws.{}: {error}", law.effect.name)?,
                    (None, Some(reason)) => writeln!(out, "  -      {test}: not tested: {reason}")?,
                    (None, None) => writeln!(out, "  holds  {test}")?,
                }
            }
            let words = if law.mirrored {
                "the same bent up and bent down"
            } else {
                "not the same bent up and bent down"
            };
            writeln!(out, "  note   {}, {words}\n", law.effect.kind)?;
        }
    }
    Ok(if fails { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Prints the laws of a file as Rust.
fn rust(file: &Path) -> Result<ExitCode, Failure> {
    let mut out = stdout();
    for law in laws(file)? {
        let text = law.rust().map_err(|error| Failure::Usage(format!("laws.{}: {error}", law.name)))?;
        write!(out, "{text}")?;
    }
    Ok(ExitCode::SUCCESS)
}

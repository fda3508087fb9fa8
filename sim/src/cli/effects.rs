//! `efam effects`: the catalogue as a table, and the page of an effect.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use efam_experiments::scenario::read_laws;
use efam_report::aligned::{Aligned, Side};
use models::check::{Outcome, TESTS, is_mirrored};
use models::effects::{About, CATALOGUE, Kind, Parameter, by_name};
use models::nearest::{alike, offer};
use models::quantity::format_si;
use models::written::Definition;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::Form;
use super::console::{Console, print};
use super::failure::Failure;
use super::terminal::stdout;

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

/// A physical effect.
#[derive(Serialize, JsonSchema)]
pub struct Effect {
    /// Its stable name.
    name: &'static str,
    /// What it is, in words.
    meaning: &'static str,
    /// elastic, dissipative, inertial, load, measurement or description.
    kind: String,
    /// Its parameters.
    parameters: Vec<OfEffect>,
    /// What one sees of it in a release.
    signature: &'static str,
    /// Effects that are easily taken for it.
    confounded_with: &'static [&'static str],
}

/// A parameter of an effect; SI.
#[derive(Serialize, JsonSchema)]
struct OfEffect {
    /// Scenario key.
    name: &'static str,
    /// What it is, in words.
    meaning: &'static str,
    /// SI unit; empty if dimensionless.
    unit: &'static str,
    /// Its value where a scenario is silent.
    default: f64,
    /// Smallest and largest admissible value.
    range: [f64; 2],
    /// Value at which it does nothing, if there is one.
    null_value: Option<f64>,
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

/// Letters in a line of the list.
const WIDTH: u16 = 120;
/// Blanks between columns.
const GAP: u16 = 2;
/// The column that is broken into lines.
const MEANING: usize = 1;

const KINDS: [(Kind, &str); 6] = [
    (Kind::Elastic, "elastic: gives back what it stores"),
    (Kind::Dissipative, "dissipative: never feeds energy"),
    (Kind::Inertial, "inertial: adds mass"),
    (Kind::Load, "load: acts from outside"),
    (Kind::Measurement, "measurement: changes what is observed"),
    (Kind::Description, "description: a force of unknown cause; no diagnosis names it"),
];

/// Lists all effects, kind by kind.
fn list(json: bool, console: &Console) -> Result<ExitCode, Failure> {
    let abouts = || CATALOGUE.iter().map(|effect| effect.about());
    if json {
        let effects = abouts().map(of_about).collect();
        print(&Printed::Catalogue { effects })?;
        return Ok(ExitCode::SUCCESS);
    }
    if console.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    let mut out = stdout();
    let widths = widths(abouts().flat_map(|about| about.parameters));
    let longest = abouts().map(|about| about.name.len()).max().unwrap_or(0);
    for (kind, title) in KINDS {
        if abouts().all(|about| about.kind != kind) {
            continue;
        }
        writeln!(out, "{title}")?;
        for about in abouts().filter(|about| about.kind == kind) {
            writeln!(out, "  {:longest$}  {}", about.name, about.meaning)?;
            if !about.parameters.is_empty() {
                write!(out, "{}", table(about.parameters, widths))?;
            }
        }
        writeln!(out)?;
    }
    writeln!(out, "A scenario switches an effect on by [effects.NAME]; `efam effects NAME` shows its page.")?;
    Ok(ExitCode::SUCCESS)
}

/// Shows the page of an effect.
fn page(name: &str, json: bool, console: &Console) -> Result<ExitCode, Failure> {
    let Some(effect) = by_name(name) else {
        let names: Vec<_> = CATALOGUE.iter().map(|effect| effect.about().name).collect();
        let meant = offer(alike(name, names.iter().copied()));
        return Err(Failure::Usage(format!("no effect `{name}`{meant}; there are {}", names.join(", "))));
    };
    if json {
        print(&Printed::Page { effect: of_about(effect.about()), page: effect.page() })?;
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
            effect: of_about(effect.about()),
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

/// The parameters of an effect; all effects have columns of the same widths.
fn table(parameters: &[Parameter], widths: [u16; 5]) -> Aligned {
    let mut table = Aligned::new(&[("", Side::Words); 5]).with_widths(&widths);
    parameters.iter().for_each(|own| table.row(of_parameter(own)));
    table
}

/// Widths of the columns: as much as each takes, and the rest for the meaning.
fn widths<'a>(parameters: impl Iterator<Item = &'a Parameter>) -> [u16; 5] {
    let mut widths = [0; 5];
    for cells in parameters.map(of_parameter) {
        let own = cells.map(|cell| cell.chars().count() as u16 + GAP);
        widths = std::array::from_fn(|k| own[k].max(widths[k]));
    }
    widths[MEANING] = 0;
    widths[MEANING] = WIDTH.saturating_sub(widths.iter().sum());
    widths
}

/// Name, meaning, default, range, and where it is off.
fn of_parameter(p: &Parameter) -> [String; 5] {
    let bare = |value: f64| format_si(value, "");
    let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
    let range = format!("{} to {}{unit}", bare(p.range.0), bare(p.range.1));
    let off = p.null_value.map_or(String::new(), |off| format!("off at {}", bare(off)));
    [format!("    {}", p.name), p.meaning.to_owned(), format_si(p.default, p.unit), range, off]
}

fn of_about(about: &'static About) -> Effect {
    let parameter = |p: &'static Parameter| OfEffect {
        name: p.name,
        meaning: p.meaning,
        unit: p.unit,
        default: p.default,
        range: [p.range.0, p.range.1],
        null_value: p.null_value,
    };
    Effect {
        name: about.name,
        meaning: about.meaning,
        kind: format!("{:?}", about.kind).to_lowercase(),
        parameters: about.parameters.iter().map(parameter).collect(),
        signature: about.signature,
        confounded_with: about.confounded_with,
    }
}

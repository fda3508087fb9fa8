//! `efam effects`: the catalogue as a table, and the page of an effect.

use std::io::Write;
use std::process::ExitCode;

use clap::Args;
use comfy_table::{ColumnConstraint, ContentArrangement, Table, Width, presets};
use models::effects::{About, CATALOGUE, Kind, Parameter, by_name};
use models::nearest::nearest;
use models::quantity::format_si;
use serde::Serialize;
use sim::schema::JsonSchema;

use super::arguments::Form;
use super::failure::Failure;
use super::terminal::stdout;
use super::voice::{Voice, print};

const HELP: &str = "Examples:
  efam effects
  efam effects viscoelastic
  efam effects --json";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Effects {
    /// An effect.
    name: Option<String>,
    #[command(flatten)]
    form: Form,
}

/// What is printed for programs: of all effects, or of one.
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
    looks_like: &'static str,
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
    off: Option<f64>,
}

pub fn run(args: &Effects, voice: &Voice) -> Result<ExitCode, Failure> {
    match &args.name {
        Some(name) => page(name, args.form.json, voice),
        None => list(args.form.json, voice),
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
fn list(json: bool, voice: &Voice) -> Result<ExitCode, Failure> {
    let abouts = || CATALOGUE.iter().map(|effect| effect.about());
    if json {
        let effects = abouts().map(of_about).collect();
        print(&Printed::Catalogue { effects })?;
        return Ok(ExitCode::SUCCESS);
    }
    if voice.quiet {
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
                writeln!(out, "{}", table(about.parameters, widths).trim_fmt())?;
            }
        }
        writeln!(out)?;
    }
    writeln!(out, "A scenario switches an effect on by [effects.NAME]; `efam effects NAME` shows its page.")?;
    Ok(ExitCode::SUCCESS)
}

/// Shows the page of an effect.
fn page(name: &str, json: bool, voice: &Voice) -> Result<ExitCode, Failure> {
    let Some(effect) = by_name(name) else {
        let names: Vec<_> = CATALOGUE.iter().map(|effect| effect.about().name).collect();
        let meant = nearest(name, names.iter().copied())
            .map_or(String::new(), |nearest| format!("; did you mean `{nearest}`?"));
        return Err(Failure::Usage(format!("no effect `{name}`{meant}; there are {}", names.join(", "))));
    };
    if json {
        print(&Printed::Page { effect: of_about(effect.about()), page: effect.page() })?;
    } else if !voice.quiet {
        writeln!(stdout(), "{}", effect.page())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The parameters of an effect; all effects have columns of the same widths.
fn table(parameters: &[Parameter], widths: [u16; 5]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_content_arrangement(ContentArrangement::Dynamic).set_width(WIDTH);
    table.add_rows(parameters.iter().map(of_parameter));
    for (column, width) in table.column_iter_mut().zip(widths) {
        column.set_constraint(ColumnConstraint::Absolute(Width::Fixed(width))).set_padding((0, GAP));
    }
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
    let off = p.off.map_or(String::new(), |off| format!("off at {}", bare(off)));
    [format!("    {}", p.name), p.meaning.to_owned(), format_si(p.default, p.unit), range, off]
}

fn of_about(about: &'static About) -> Effect {
    let parameter = |p: &'static Parameter| OfEffect {
        name: p.name,
        meaning: p.meaning,
        unit: p.unit,
        default: p.default,
        range: [p.range.0, p.range.1],
        off: p.off,
    };
    Effect {
        name: about.name,
        meaning: about.meaning,
        kind: format!("{:?}", about.kind).to_lowercase(),
        parameters: about.parameters.iter().map(parameter).collect(),
        looks_like: about.looks_like,
        confounded_with: about.confounded_with,
    }
}

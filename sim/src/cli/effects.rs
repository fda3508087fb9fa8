//! `efam effects`: the catalogue as a table, and the page of an effect.

use std::io::Write;
use std::process::ExitCode;

use clap::Args;
use comfy_table::{ColumnConstraint, ContentArrangement, Table, presets};
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
    for (kind, title) in KINDS {
        let mut table = Table::new();
        table.load_preset(presets::NOTHING).set_content_arrangement(ContentArrangement::Dynamic);
        table.set_width(WIDTH).set_header(["", "", "default", "range", "off at"]);
        for about in abouts().filter(|about| about.kind == kind) {
            table.add_row([about.name, about.meaning]);
            about.parameters.iter().for_each(|own| {
                table.add_row(of_parameter(own));
            });
        }
        if table.row_count() == 0 {
            continue;
        }
        for whole in [0, 2, 3, 4] {
            table.column_mut(whole).expect("there are five").set_constraint(ColumnConstraint::ContentWidth);
        }
        writeln!(out, "{title}\n{}\n", table.trim_fmt())?;
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

/// Name, meaning, default, range, and where it is off.
fn of_parameter(p: &Parameter) -> [String; 5] {
    let si = |value: f64| format_si(value, p.unit);
    let range = format!("{} to {}", si(p.range.0), si(p.range.1));
    let off = p.off.map_or(String::new(), |off| off.to_string());
    [format!("  {}", p.name), p.meaning.to_owned(), si(p.default), range, off]
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

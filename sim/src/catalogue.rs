//! The catalogue of effects as it is listed.

use std::fmt::Write;

use efam_report::aligned::{Aligned, Side};
use models::effects::{self, About, CATALOGUE, Kind, Parameter, by_name};
use models::nearest::{alike, offer};
use models::quantity::format_si;
use schemars::JsonSchema;
use serde::Serialize;

use crate::failure::Failure;

/// A physical effect.
#[derive(Serialize, JsonSchema)]
pub struct Effect {
    /// Its stable name.
    pub name: &'static str,
    /// What it is, in words.
    meaning: &'static str,
    /// elastic, dissipative, inertial, load, measurement or description.
    pub kind: String,
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

impl Effect {
    /// By what an effect says of itself.
    pub fn of(about: &'static About) -> Self {
        let parameter = |p: &'static Parameter| OfEffect {
            name: p.name,
            meaning: p.meaning,
            unit: p.unit,
            default: p.default,
            range: [p.range.0, p.range.1],
            null_value: p.null_value,
        };
        Self {
            name: about.name,
            meaning: about.meaning,
            kind: format!("{:?}", about.kind).to_lowercase(),
            parameters: about.parameters.iter().map(parameter).collect(),
            signature: about.signature,
            confounded_with: about.confounded_with,
        }
    }
}

fn abouts() -> impl Iterator<Item = &'static About> {
    CATALOGUE.iter().map(|effect| effect.about())
}

/// All effects.
pub fn all() -> Vec<Effect> {
    abouts().map(Effect::of).collect()
}

/// The effect of a name.
/// # Errors
/// There is none; the message offers those that may be meant.
pub fn named(name: &str) -> Result<&'static dyn effects::Effect, Failure> {
    by_name(name).ok_or_else(|| {
        let names: Vec<_> = abouts().map(|about| about.name).collect();
        let meant = offer(alike(name, names.iter().copied()));
        Failure::Usage(format!("no effect `{name}`{meant}; there are {}", names.join(", ")))
    })
}

/// All effects with their parameters, kind by kind, as people read them.
pub fn listed() -> String {
    let mut out = String::new();
    let widths = widths(abouts().flat_map(|about| about.parameters));
    let longest = abouts().map(|about| about.name.len()).max().unwrap_or(0);
    for (kind, title) in KINDS {
        if abouts().all(|about| about.kind != kind) {
            continue;
        }
        out += title;
        out += "\n";
        for about in abouts().filter(|about| about.kind == kind) {
            writeln!(out, "  {:longest$}  {}", about.name, about.meaning).expect("a string");
            out += &table(about.parameters, widths).to_string();
        }
        out += "\n";
    }
    out
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

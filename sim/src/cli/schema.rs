//! `efam schema`: the content of the JSON that a command prints.

use std::process::ExitCode;

use clap::Args;
use models::nearest::{nearest, offer};
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

use super::console::print;
use super::failure::Failure;
use super::{
    analyse, calibrate, diagnose, doctor, effects, experiment, export, figures, inspect, linearise, predict,
    report, simulate, sweep,
};
use crate::rest;

const HELP: &str = "Examples:
  efam schema simulate
  efam schema experiment check > check.schema.json
  efam schema > all.json

The schemas are JSON Schema 2020-12. Without a command: one object, with a
schema for each. Entries may be added from version to version.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Schema {
    /// The command, such as simulate or experiment check [default: all of them].
    command: Vec<String>,
}

/// Makes a schema.
type Make = fn() -> Value;

/// Commands that print JSON, and the schema of it.
pub const SCHEMAS: [(&str, Make); 22] = [
    ("simulate", of::<simulate::Printed>),
    ("calibrate", of::<calibrate::Printed>),
    ("diagnose", of::<diagnose::Printed>),
    ("predict", of::<predict::Printed>),
    ("sweep", of::<sweep::MergedPrinted>),
    ("sweep plan", of::<sweep::plan::Printed>),
    ("sweep run", of::<sweep::run::Printed>),
    ("sweep submit", of::<sweep::submit::Printed>),
    ("sweep status", of::<sweep::status::Printed>),
    ("sweep merge", of::<sweep::MergedPrinted>),
    ("report", of::<report::Printed>),
    ("export", of::<export::Printed>),
    ("figures", of::<figures::Printed>),
    ("effects", of::<effects::Printed>),
    ("experiment init", of::<experiment::InitPrinted>),
    ("experiment check", of::<experiment::CheckPrinted>),
    ("analyse", of::<analyse::Printed>),
    ("inspect", of::<inspect::Printed>),
    ("statics", of::<rest::StaticsPrinted>),
    ("modes", of::<rest::ModesPrinted>),
    ("linearise", of::<linearise::Printed>),
    ("doctor", of::<doctor::Printed>),
];

/// Prints the schema of a command, or all.
pub fn run(args: &Schema) -> Result<ExitCode, Failure> {
    let name = args.command.join(" ");
    let with_title = |(command, schema): &(&str, Make)| {
        let mut schema = schema();
        schema["title"] = json!(format!("efam {command} --json, version {}", env!("CARGO_PKG_VERSION")));
        schema
    };
    if name.is_empty() {
        let all: Map<String, Value> = SCHEMAS.iter().map(|of| (of.0.to_owned(), with_title(of))).collect();
        print(&all)?;
        return Ok(ExitCode::SUCCESS);
    }
    let own = SCHEMAS.iter().find(|(command, _)| *command == name);
    let names = SCHEMAS.iter().map(|(command, _)| (*command).to_owned());
    let own = own.ok_or_else(|| lacking("JSON printed by", &name, names))?;
    print(&with_title(own))?;
    Ok(ExitCode::SUCCESS)
}

/// There is no such thing of a command, and which there are.
pub fn lacking(what: &str, name: &str, names: impl Iterator<Item = String>) -> Failure {
    let names: Vec<String> = names.collect();
    let meant = offer(nearest(name, names.iter().map(String::as_str)));
    Failure::Usage(format!("no {what} `{name}`{meant}; there are {}", names.join(", ")))
}

/// The schema of a type as it is written, JSON Schema 2020-12; descriptions are the doc comments.
fn of<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    settings.into_generator().into_root_schema_for::<T>().to_value()
}

//! JSON schemas of what is printed and written, from the types themselves. The only file that names schemars.

pub use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Value;

/// The schema of a type as it is written, JSON Schema 2020-12; descriptions are the doc comments.
pub fn of<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    settings.into_generator().into_root_schema_for::<T>().to_value()
}

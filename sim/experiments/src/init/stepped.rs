//! A pressure in the recording's own table, whose steps begin swings of a rod at rest.

use std::fmt::Write;
use std::path::PathBuf;

use efam_recordings::{Recording, quantities};
use efam_store::escape::toml_string;
use models::quantity::Quantity;

/// Where a pressure is.
#[derive(Clone, Debug)]
pub(super) struct Steps {
    /// The name of its column.
    column: String,
    /// The recording's file, where the draft is not beside it.
    pub file: Option<PathBuf>,
}

impl Steps {
    /// The first column of a recording's file that states a unit of pressure.
    pub fn of(recording: &Recording) -> Option<Self> {
        let is_pressure =
            |unit: &str| Quantity::parse(&format!("1 {unit}")).is_ok_and(|one| one.to("Pa").is_ok());
        let all = quantities(&recording.source).ok()?;
        let (column, _) = all.into_iter().find(|(_, unit)| unit.as_deref().is_some_and(is_pressure))?;
        Some(Self { column, file: Some(std::path::absolute(&recording.source).ok()?) })
    }

    /// The keys that name it.
    pub fn write(&self, out: &mut String) {
        let file =
            self.file.as_ref().map(|file| format!("file = {}, ", toml_string(&file.to_string_lossy())));
        let (file, column) = (file.unwrap_or_default(), toml_string(&self.column));
        let _ = writeln!(
            out,
            "pressure = {{ {file}column = {column} }}   # GUESS: swings begin where this column steps"
        );
    }
}

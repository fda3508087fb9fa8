//! A setup and a dropped recording as an experiment for `efam calibrate`, which begins at the setup's values.

use serde::Deserialize;
use serde_json::Value;

use crate::error::PlaygroundError;
use crate::scenario::{effects, line, pressure, rod};
use crate::setup::Setup;

/// What a reader said of a recording.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recording {
    /// Name of its file, beside which the experiment is to lie.
    pub file: String,
    /// Markers whose centroid is the tip.
    pub tip: Vec<String>,
    /// Axis of the file from the clamp along the rod, such as `+x`.
    pub along: String,
    /// Axis of the file against gravity.
    pub up: String,
    /// Unit of the file's lengths, where the file is silent and the page assumed one.
    pub unit: Option<String>,
    /// Instant of release on the recording's clock, s, if a reader chose it or a fit found it.
    pub instant: Option<f64>,
    /// Whether the tip before the release was placed at the start of the simulation.
    pub is_placed: bool,
    /// Parameters that were fitted, by their paths.
    pub fitted: Vec<String>,
}

/// The text of an experiment. Mesh and tolerance are left to the program, which removes their errors.
pub fn toml(setup: &Setup, recording: &Recording) -> Result<String, PlaygroundError> {
    // It says what the setup lacks.
    setup.model()?;
    let mut lines = vec![
        "# Purpose: a recording from the playground: efam calibrate on this file, which lies beside the recording."
            .to_owned(),
        match &recording.fitted[..] {
            [] => "# Expected: nothing was fitted there; the model has the values of the sliders.".to_owned(),
            fitted => format!("# Expected: values near those fitted there: {}.", fitted.join(", ")),
        },
    ];
    if let Some(muscle) = &setup.muscle {
        lines.extend(["[muscle]".to_owned(), format!("name = {}", text(muscle)), String::new()]);
    }
    let rod = rod(setup);
    if !rod.is_empty() {
        lines.extend(["[rod]".to_owned()].into_iter().chain(rod).chain([String::new()]));
    }
    lines.push("[[recording]]".to_owned());
    lines.push(format!("file = {}", text(&recording.file)));
    if setup.muscle.is_some() || setup.pressure != 0.0 {
        lines.push(format!("pressure = \"{}\"", pressure(setup.pressure)));
    }
    let tip: Vec<String> = recording.tip.iter().map(|name| text(name)).collect();
    lines.push(format!("tip = [{}]", tip.join(", ")));
    lines.extend(recording.unit.as_ref().map(|unit| format!("unit = {}", text(unit))));
    lines.push(format!("along = {}", text(&recording.along)));
    lines.push(format!("up = {}", text(&recording.up)));
    lines.push(line("base_angle", setup.base_angle, "rad"));
    if setup.is_held() {
        lines.push("start = \"held\"".to_owned());
    } else {
        lines.push(line("angle", setup.release_angle(), "rad"));
        lines.push(format!("offset = \"{}\"", if recording.is_placed { "hold" } else { "none" }));
    }
    lines.extend(recording.instant.map(|instant| format!("instants = [\"{instant:?} s\"]")));
    lines.extend(effects(setup)?);
    Ok(lines.join("\n") + "\n")
}

/// A text of TOML, which reads what JSON writes but for the escape of a slash, and that is never written.
fn text(words: &str) -> String {
    // DEL is the one letter that JSON leaves and TOML forbids.
    Value::from(words).to_string().replace('\u{7f}', "\\u007f")
}

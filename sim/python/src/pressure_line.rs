//! The fit of a pressure line.

use std::fmt::Write;

use efam::failure::Failure;
use efam_inference::pressure_line::{Estimate, PressureRecord, fit};
use models::digits::significant;
use pyo3::prelude::*;
use serde_json::json;

use crate::answer::AnswerData;
use crate::failure::exception;
use crate::watch::watched;

/// Time constant, dead time and rate limit of a pressure line, from its command and a reading, s and Pa.
#[pyfunction]
pub fn fit_pressure_line(
    py: Python<'_>,
    time: Vec<f64>,
    command: Vec<f64>,
    reading: Vec<f64>,
) -> PyResult<AnswerData> {
    let work = |_| -> Result<AnswerData, Failure> {
        let found = fit(&PressureRecord { time, command, reading })
            .map_err(|error| Failure::Data(format!("fit_pressure_line: {error}")))?;
        let mut options = json!({
            "effects.pressure_line.time_constant": found.time_constant_s.value,
            "effects.pressure_line.dead_time": found.dead_time_s.value,
        });
        let mut text = String::new();
        let mut line = |name: &str, own: Estimate, unit: &str| {
            let [value, error] =
                [(own.value, 4), (own.standard_error, 2)].map(|(own, digits)| significant(own, digits));
            let _ = writeln!(text, "{name:14} {value} ± {error} {unit}");
        };
        line("time constant", found.time_constant_s, "s");
        line("dead time", found.dead_time_s, "s");
        match found.rate_limit_pa_per_s {
            Some(limit) => {
                options["effects.pressure_line.rate_limit"] = json!(limit.value);
                line("rate limit", limit, "Pa/s");
            }
            None => {
                let fastest = significant(found.fastest_pa_per_s, 2);
                let _ = writeln!(
                    text,
                    "{:14} none up to {fastest} Pa/s, the fastest of this record",
                    "rate limit"
                );
            }
        }
        let _ = write!(text, "{} samples, {} Pa left", found.samples, significant(found.rms_pa, 3));
        for warning in &found.warnings {
            let _ = write!(text, "\n! {warning}");
        }
        let mut entries = json!(found);
        entries["options"] = options;
        Ok(AnswerData::printed(&entries, text))
    };
    watched(py, work)?.map_err(exception)
}

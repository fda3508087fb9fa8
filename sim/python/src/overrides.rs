//! Keyword arguments as what `--set` and the options of the program say: texts with units, or numbers in SI.

use efam_experiments::scenario::{ReleaseOptions, unit_of};
use efam_store::escape::toml_string;
use models::quantity::Quantity;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use sim::failure::Failure;

use crate::failure::exception;

/// Tables within one another; the deepest key of a scenario has five parts.
const DEEPEST: usize = 8;

/// Options of the program that are one key of a scenario.
const KEYS: [(&str, &str); 2] = [("muscle", "muscle.file"), ("pressure", "muscle.pressure")];

/// All keyword arguments as `path=value`: the options of the program by their names, keys of a scenario by their
/// paths.
pub fn overrides(given: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<String>> {
    let Some(given) = given else { return Ok(Vec::new()) };
    let mut release = ReleaseOptions::default();
    let mut set = Vec::new();
    for (key, value) in given.iter() {
        let key: String = key.extract()?;
        let slot = match key.as_str() {
            "payload" => Some((&mut release.payload, "kg")),
            "payload_center" => Some((&mut release.payload_center, "m")),
            "payload_inertia" => Some((&mut release.payload_inertia, "kg m^2")),
            "frontal_area" => Some((&mut release.frontal_area, "m^2")),
            "angle" => Some((&mut release.angle, "rad")),
            "duration" => Some((&mut release.duration, "s")),
            _ => None,
        };
        match (slot, KEYS.iter().find(|(name, _)| *name == key)) {
            (Some((slot, unit)), _) => *slot = Some(quantity(&key, &value, unit)?),
            (None, Some((_, path))) => flatten(path, &value, DEEPEST, &mut set)?,
            (None, None) => flatten(&key, &value, DEEPEST, &mut set)?,
        }
    }
    if release.payload.is_some_and(|mass| mass < 0.0) {
        return Err(exception(Failure::Usage("payload: it must not be negative".to_owned())));
    }
    Ok([release.overrides(), set].concat())
}

/// A scenario as tables of Python.
pub fn tables(of: &Bound<'_, PyDict>) -> PyResult<Vec<String>> {
    let mut set = Vec::new();
    for (key, value) in of.iter() {
        flatten(&key.extract::<String>()?, &value, DEEPEST, &mut set)?;
    }
    Ok(set)
}

/// A quantity as text with its unit, or as a number in SI.
pub fn quantity(name: &str, value: &Bound<'_, PyAny>, unit: &str) -> PyResult<f64> {
    if let Ok(text) = value.cast::<PyString>() {
        let text = text.to_string();
        let parsed = Quantity::parse(&text).and_then(|quantity| quantity.to(unit));
        return parsed.map_err(|error| exception(Failure::Usage(format!("{name} {text}: {error}"))));
    }
    value.extract::<f64>().map_err(|_| wrong(name, value))
}

fn flatten(path: &str, value: &Bound<'_, PyAny>, deepest: usize, set: &mut Vec<String>) -> PyResult<()> {
    let Ok(table) = value.cast::<PyDict>() else {
        set.push(format!("{path}={}", written(path, value, deepest)?));
        return Ok(());
    };
    if deepest == 0 {
        return Err(PyTypeError::new_err(format!("{path}: tables within one another, too deep")));
    }
    for (key, value) in table.iter() {
        flatten(&format!("{path}.{}", key.extract::<String>()?), &value, deepest - 1, set)?;
    }
    Ok(())
}

/// A value as TOML has it.
fn written(path: &str, value: &Bound<'_, PyAny>, deepest: usize) -> PyResult<String> {
    // Arrays and numbers of numpy.
    if value.hasattr("tolist")? {
        return written(path, &value.call_method0("tolist")?, deepest.saturating_sub(1));
    }
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(flag.is_true().to_string());
    }
    if value.is_instance_of::<PyString>() || value.hasattr("__fspath__")? {
        return Ok(toml_string(&value.str()?.to_string_lossy()));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        if deepest == 0 {
            return Err(PyTypeError::new_err(format!("{path}: lists within one another, too deep")));
        }
        let mut items = Vec::new();
        for (k, item) in value.try_iter()?.enumerate() {
            let item = item?;
            // A pressure over time has rows of a time and a pressure.
            let own = match (path, k) {
                ("muscle.pressure", _)
                    if item.is_instance_of::<PyString>() || !item.hasattr("__len__")? =>
                {
                    if k == 0 {
                        "run.duration"
                    } else {
                        path
                    }
                }
                _ => path,
            };
            items.push(written(own, &item, deepest - 1)?);
        }
        return Ok(format!("[{}]", items.join(", ")));
    }
    if let Ok(table) = value.cast::<PyDict>() {
        if deepest == 0 {
            return Err(PyTypeError::new_err(format!("{path}: tables within one another, too deep")));
        }
        let mut entries = Vec::new();
        for (key, value) in table.iter() {
            let key: String = key.extract()?;
            let value = written(&format!("{path}.{key}"), &value, deepest - 1)?;
            entries.push(format!("{} = {value}", toml_string(&key)));
        }
        return Ok(format!("{{ {} }}", entries.join(", ")));
    }
    match unit_of(path) {
        None if value.is_instance_of::<PyInt>() => Ok(value.str()?.to_string_lossy().into_owned()),
        unit => {
            let is_number = value.is_instance_of::<PyFloat>() || value.hasattr("__float__")?;
            let number: f64 = value.extract().ok().filter(|_| is_number).ok_or_else(|| wrong(path, value))?;
            Ok(match unit {
                Some(unit) => format!("\"{number:?} {unit}\""),
                None if number.is_finite() => format!("{number:?}"),
                None => format!("\"{number}\""),
            })
        }
    }
}

fn wrong(name: &str, value: &Bound<'_, PyAny>) -> PyErr {
    let kind = value.get_type().name().map_or_else(|_| "?".to_owned(), |name| name.to_string());
    PyTypeError::new_err(format!("{name}: a text with its unit or a number in SI is due, not {kind}"))
}

//! Keyword arguments as what `--set` and the options of the program say: texts with units, or numbers in SI.

use std::cell::OnceCell;
use std::path::Path;

use efam::failure::Failure;
use efam_experiments::scenario::units::{EXPERIMENT, SCENARIO, keys};
use efam_experiments::scenario::{ReleaseOptions, effects_of, unit_of};
use efam_store::escape::toml_string;
use models::effects::Catalogue;
use models::nearest::nearest;
use models::quantity::Quantity;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};

use crate::failure::exception;

/// Tables within one another; the deepest key of a scenario has five parts.
const DEEPEST: usize = 8;

/// Options of the program that are quantities of the release: name, place, SI unit.
type OfRelease = (&'static str, fn(&mut ReleaseOptions) -> &mut Option<f64>, &'static str);
const RELEASE: [OfRelease; 6] = [
    ("payload", |own| &mut own.payload, "kg"),
    ("payload_center", |own| &mut own.payload_center, "m"),
    ("payload_inertia", |own| &mut own.payload_inertia, "kg m^2"),
    ("frontal_area", |own| &mut own.frontal_area, "m^2"),
    ("angle", |own| &mut own.angle, "rad"),
    ("duration", |own| &mut own.duration, "s"),
];

/// Options of the program that are one key of a scenario.
const KEYS: [(&str, &str); 2] = [("muscle", "muscle.file"), ("pressure", "muscle.pressure")];

/// The laws as text of the scenario or experiment that arguments are for: their parameters have units, too.
#[derive(Default)]
pub struct Laws<'a> {
    path: Option<&'a Path>,
    text: &'a str,
    /// What is set over the text, of the laws alone.
    set: Vec<String>,
    /// Read where a number needs them.
    catalogue: OnceCell<Catalogue>,
}

impl<'a> Laws<'a> {
    /// Those of a text and of what is set over it.
    pub fn of(path: &'a Path, text: &'a str, set: &[String]) -> Self {
        let is_law = |own: &&String| is_law(own);
        let set = set.iter().filter(is_law).cloned().collect();
        Self { path: Some(path), text, set, catalogue: OnceCell::new() }
    }

    /// The same with those that are among the arguments.
    fn and(&self, given: &Bound<'_, PyDict>) -> PyResult<Laws<'a>> {
        let mut set = self.set.clone();
        for (key, value) in given.iter() {
            let key: String = key.extract()?;
            if is_law(&key) {
                flatten(&key, &value, DEEPEST, &Laws::default(), &mut set)?;
            }
        }
        Ok(Laws { path: self.path, text: self.text, set, catalogue: OnceCell::new() })
    }

    /// The SI unit of a key.
    fn unit_of(&self, key: &str) -> Option<&'static str> {
        let read = || {
            let path = self.path.unwrap_or(Path::new("scenario"));
            // What is wrong with a law is said where the whole is read.
            effects_of(path, self.text, &self.set).unwrap_or_default()
        };
        unit_of(key, &Catalogue::default()).or_else(|| {
            let may_have_one = key.contains("effects.") && (self.text.contains(LAWS) || !self.set.is_empty());
            may_have_one.then(|| unit_of(key, self.catalogue.get_or_init(read))).flatten()
        })
    }
}

/// The table of laws.
const LAWS: &str = "laws";

/// Whether a key is of a law.
fn is_law(key: &str) -> bool {
    key.strip_prefix(LAWS).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// All keyword arguments as `path=value`: the options of the program by their names, keys of a scenario by their
/// paths.
pub fn overrides(given: Option<&Bound<'_, PyDict>>, laws: &Laws) -> PyResult<Vec<String>> {
    let Some(given) = given else { return Ok(Vec::new()) };
    let laws = &laws.and(given)?;
    let mut release = ReleaseOptions::default();
    let mut set = Vec::new();
    for (key, value) in given.iter() {
        let key: String = key.extract()?;
        let release_option = RELEASE.iter().find(|(name, ..)| *name == key);
        match (release_option, KEYS.iter().find(|(name, _)| *name == key)) {
            (Some((_, slot, unit)), _) => *slot(&mut release) = Some(quantity(&key, &value, unit)?),
            (None, Some((_, path))) => flatten(path, &value, DEEPEST, laws, &mut set)?,
            (None, None) => {
                if let Some(meant) = misspelt(&key) {
                    let message = format!("{key}: no option is called so; did you mean `{meant}`?");
                    return Err(exception(Failure::Usage(message)));
                }
                flatten(&key, &value, DEEPEST, laws, &mut set)?;
            }
        }
    }
    if release.payload.is_some_and(|mass| mass < 0.0) {
        return Err(exception(Failure::Usage("payload: it must not be negative".to_owned())));
    }
    Ok([release.overrides(), set].concat())
}

fn options() -> impl Iterator<Item = &'static str> {
    RELEASE.iter().map(|own| own.0).chain(KEYS.iter().map(|own| own.0))
}

/// The option that a word which is no section of a scenario most likely means; a path is read with the scenario.
fn misspelt(key: &str) -> Option<&'static str> {
    let known = || options().chain(SCENARIO);
    let is_word = !key.contains('.') && known().all(|own| own != key);
    nearest(key, known()).filter(|meant| is_word && options().any(|own| own == *meant))
}

/// All options and keys: those of a scenario, each with its unit if it is a quantity, and the sections of an experiment.
#[pyfunction]
pub fn option_keys() -> (Vec<(String, Option<&'static str>)>, Vec<&'static str>) {
    let of_release = RELEASE.iter().map(|(name, _, unit)| ((*name).to_owned(), Some(*unit)));
    let words = KEYS.iter().map(|own| own.0).chain(SCENARIO).map(|word| (word.to_owned(), None));
    let mut all: Vec<_> = of_release.collect();
    // A pressure may be one over time.
    let is_quantity = |name: &str| name != "muscle.pressure";
    let keys = keys().into_iter().map(|(name, unit)| (name.clone(), unit.filter(|_| is_quantity(&name))));
    words.chain(keys).for_each(|own| {
        if all.iter().all(|(name, _)| *name != own.0) {
            all.push(own);
        }
    });
    (all, EXPERIMENT.to_vec())
}

/// A scenario or an experiment as tables of Python, or what is set over one.
pub fn tables(of: &Bound<'_, PyDict>, laws: &Laws) -> PyResult<Vec<String>> {
    let laws = &laws.and(of)?;
    let mut set = Vec::new();
    for (key, value) in of.iter() {
        flatten(&key.extract::<String>()?, &value, DEEPEST, laws, &mut set)?;
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

fn flatten(
    path: &str,
    value: &Bound<'_, PyAny>,
    deepest: usize,
    laws: &Laws,
    set: &mut Vec<String>,
) -> PyResult<()> {
    let Ok(table) = value.cast::<PyDict>() else {
        set.push(format!("{path}={}", written(path, value, deepest, laws)?));
        return Ok(());
    };
    if deepest == 0 {
        return Err(PyTypeError::new_err(format!("{path}: tables within one another, too deep")));
    }
    for (key, value) in table.iter() {
        flatten(&format!("{path}.{}", key.extract::<String>()?), &value, deepest - 1, laws, set)?;
    }
    Ok(())
}

/// A value as TOML has it.
fn written(path: &str, value: &Bound<'_, PyAny>, deepest: usize, laws: &Laws) -> PyResult<String> {
    // Arrays and numbers of numpy.
    if value.hasattr("tolist")? {
        return written(path, &value.call_method0("tolist")?, deepest.saturating_sub(1), laws);
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
            items.push(written(own, &item, deepest - 1, laws)?);
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
            let value = written(&format!("{path}.{key}"), &value, deepest - 1, laws)?;
            entries.push(format!("{} = {value}", toml_string(&key)));
        }
        return Ok(format!("{{ {} }}", entries.join(", ")));
    }
    match laws.unit_of(path) {
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

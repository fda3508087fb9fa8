//! Laws as text: the tables `[laws.NAME]` of a scenario, an experiment, or a file of their own.

use std::path::Path;

use models::effects::{Catalogue, Effect, MOST_PARAMETERS, Per, Reach};
use models::written::names::{OUTPUTS, PLACES};
use models::written::{
    Definition, KINDS, LawError, LawProblem, NOTES, OwnParameter, PER, REACHES, SEPARATORS,
};

use super::document::{Document, Keys};
use super::error::{ScenarioError, ScenarioProblem};

/// The table of laws.
pub(crate) const LAWS: &str = "laws";

/// Keys of a law beside its formulas and notes.
const OWN: [&str; 9] = [
    "meaning",
    "place",
    "parameters",
    "memory_unit",
    "kind",
    "reach",
    "signature",
    "confounded_with",
    "separated_by",
];

/// The laws of a file that has nothing else, in its order.
/// # Errors
/// [`ScenarioError`], with file, line and column where there is one.
pub fn read_laws(path: &Path) -> Result<Vec<Definition>, ScenarioError> {
    laws_of(&Document::load(path, &[])?)
}

/// The same of a text; `path` names it.
/// # Errors
/// As [`read_laws`].
pub fn parse_laws(path: &Path, text: &str) -> Result<Vec<Definition>, ScenarioError> {
    laws_of(&Document::parse(path, text, &[])?)
}

/// The effects that there are for a scenario or an experiment: those of the catalogue, and its own laws.
/// # Errors
/// As [`read_laws`].
pub fn effects_of(path: &Path, text: &str, overrides: &[String]) -> Result<Catalogue, ScenarioError> {
    catalogue(&Document::parse(path, text, overrides)?)
}

fn laws_of(document: &Document) -> Result<Vec<Definition>, ScenarioError> {
    document.keys().only(&[LAWS])?;
    let definitions = definitions(document)?;
    if definitions.is_empty() {
        Err(document.keys().missing(LAWS, "[laws.NAME] with place = \"flow\" and its formula under it"))
    } else {
        catalogue(document)?;
        Ok(definitions)
    }
}

/// The effects that there are for a document: those of the catalogue, and its own laws.
pub(super) fn catalogue(document: &Document) -> Result<Catalogue, ScenarioError> {
    let mut catalogue = Catalogue::default();
    for definition in definitions(document)? {
        let key = format!("{LAWS}.{}", definition.name);
        let effect = effect(document, &definition)?;
        catalogue = catalogue.with(effect).map_err(|error| {
            document.error_of(&key, ScenarioProblem::Other { message: error.to_string() })
        })?;
    }
    Ok(catalogue)
}

fn effect(document: &Document, definition: &Definition) -> Result<&'static dyn Effect, ScenarioError> {
    definition.effect().map_err(|LawError { key, span, problem }| {
        let law = format!("{LAWS}.{}", definition.name);
        let path = if key.is_empty() { law.clone() } else { format!("{law}.{key}") };
        let formula = definition.formulas.iter().find(|(k, _)| OUTPUTS[*k].key == key).map(|(_, text)| text);
        // A key that is not written is missing in its table.
        let path = [path, law].into_iter().find(|path| document.has(path)).unwrap_or_default();
        match span.zip(formula) {
            Some((span, text)) => document.error_within(&path, text, span, ScenarioProblem::Law(problem)),
            None => document.error_of(&path, ScenarioProblem::Law(problem)),
        }
    })
}

/// Laws of one file or scenario, at most: the time to read them grows with the square of their number.
const MOST_LAWS: usize = 1000;

fn definitions(document: &Document) -> Result<Vec<Definition>, ScenarioError> {
    let laws = document.keys().table(LAWS)?;
    let found = laws.children().len();
    if found > MOST_LAWS {
        let message = format!("{found} laws; there may be {MOST_LAWS}: keep those that are used");
        return Err(document.keys().wrong(LAWS, ScenarioProblem::Other { message }));
    }
    laws.children().into_iter().map(|name| definition(&name, &laws.table(&name)?)).collect()
}

fn definition(name: &str, keys: &Keys) -> Result<Definition, ScenarioError> {
    let formulas = OUTPUTS.map(|output| output.key);
    keys.only(&[&OWN[..], &formulas, &NOTES].concat())?;
    let text = |key: &str| Ok::<_, ScenarioError>(keys.text(key)?.map(|(text, _)| text.to_owned()));
    let Some(places) = keys.words("place", &PLACES)? else {
        return Err(keys.missing(
            "place",
            "place = \"flow\", or one of bend, edge, mass, tip, clamp, or a list of them",
        ));
    };
    let mut given = Vec::new();
    for (k, key) in formulas.into_iter().enumerate() {
        if let Some(formula) = text(key)? {
            given.push((k, formula));
        }
    }
    let parameters = keys.table("parameters")?;
    let found = parameters.children().len();
    // Before they are read, which takes a time that grows with the square of their number.
    if found > MOST_PARAMETERS {
        return Err(keys.wrong("parameters", ScenarioProblem::Law(LawProblem::TooMany { found })));
    }
    let parameters: Vec<OwnParameter> = (parameters.children().into_iter())
        .map(|name| parameter(&name, &parameters.table(&name)?))
        .collect::<Result<_, _>>()?;
    let mut notes = [None, None, None];
    for (note, key) in notes.iter_mut().zip(NOTES) {
        *note = text(key)?;
    }
    let confounded = keys.texts("confounded_with")?.unwrap_or_default();
    Ok(Definition {
        name: name.to_owned(),
        meaning: text("meaning")?.unwrap_or_else(|| "a law as text".to_owned()),
        kind: keys.word("kind", &KINDS)?,
        places,
        parameters,
        memory_unit: text("memory_unit")?.unwrap_or_default(),
        formulas: given,
        signature: text("signature")?.unwrap_or_default(),
        confounded_with: confounded.into_iter().map(str::to_owned).collect(),
        separated_by: keys.words("separated_by", &SEPARATORS)?.unwrap_or_default(),
        reach: keys.word("reach", &REACHES)?.unwrap_or(Reach::Muscle),
        notes,
    })
}

fn parameter(name: &str, keys: &Keys) -> Result<OwnParameter, ScenarioError> {
    keys.only(&[
        "meaning",
        "unit",
        "default",
        "range",
        "scale",
        "off",
        "part",
        "friction",
        "plausible",
        "per",
        "tries",
    ])?;
    let unit = keys.text("unit")?.map_or("", |(unit, _)| unit);
    // Beside its unit a number needs none.
    let value = |key: &str| keys.quantity(key, if keys.is_text(key) { unit } else { "" });
    let pair = |key: &str| -> Result<Option<(f64, f64)>, ScenarioError> {
        match keys.quantities(key, "")?.as_deref() {
            None => Ok(None),
            Some([low, high]) => Ok(Some((*low, *high))),
            Some(_) => Err(keys
                .wrong(key, ScenarioProblem::WrongType { due: "a list of two numbers, such as [0, 10]," })),
        }
    };
    let Some(default) = value("default")? else { return Err(keys.missing("default", "default = 0.6")) };
    let Some(range) = pair("range")? else { return Err(keys.missing("range", "range = [0, 10]")) };
    Ok(OwnParameter {
        name: name.to_owned(),
        meaning: keys.text("meaning")?.map_or("", |(text, _)| text).to_owned(),
        unit: unit.to_owned(),
        default,
        range,
        scale: value("scale")?,
        null_value: value("off")?,
        is_part: keys.flag("part")?.unwrap_or_default(),
        is_friction: keys.flag("friction")?.unwrap_or_default(),
        plausible: pair("plausible")?,
        per: keys.word("per", &PER)?.unwrap_or(Per::Unit),
        tries: keys.quantities("tries", "")?.unwrap_or_default(),
    })
}

//! What the catalogue knows of a law as text: checked, and the rest read from its formulas.

use super::names::{MEAN_SQUARE, MEMORY, OUTPUTS, PLACES, names, out};
use super::{Definition, LawError, LawProblem, OwnParameter};
use crate::effects::{About, Kind, MOST_PARAMETERS, Parameter, Per, Place};
use crate::formula::{
    FormulaError, FormulaProblem, Function, Measure, Node, Operator, Program, Source, Term, exponent,
    measure, parse,
};
use crate::nearest::nearest;
use crate::quantity::Unit;

/// A definition that was checked.
pub(super) struct Read {
    pub about: &'static About,
    pub programs: [Option<Program>; OUTPUTS.len()],
    /// Whether the energies of bends and edges follow from their moment and tension.
    pub integrated: [bool; 2],
    /// Whether a formula names the diameter.
    pub needs_diameter: bool,
}

type Terms = [Option<Term>; OUTPUTS.len()];

/// An error of a key.
fn wrong(key: &str, problem: LawProblem) -> LawError {
    LawError { key: key.to_owned(), span: None, problem }
}

pub(super) fn read(definition: &Definition) -> Result<Read, LawError> {
    check_names(definition)?;
    check_places(definition)?;
    for parameter in &definition.parameters {
        check_parameter(parameter)?;
    }
    let memory_unit = unit("memory_unit", &definition.memory_unit)?;
    let mut terms: Terms = [const { None }; OUTPUTS.len()];
    let mut programs = [const { None }; OUTPUTS.len()];
    for (k, text) in &definition.formulas {
        let key = OUTPUTS[*k].key;
        let at = |error: FormulaError| LawError {
            key: key.to_owned(),
            span: Some(error.span),
            problem: error.problem.into(),
        };
        let term = parse(text).map_err(at)?;
        let source = |name: &str| named(definition, *k, name).map(|(source, _)| source);
        programs[*k] = Some(Program::compile(&term, &source).map_err(at)?);
        check_unit(definition, *k, &term, memory_unit).map_err(at)?;
        terms[*k] = Some(term);
    }
    check_memory(definition, &terms)?;
    for own in &definition.parameters {
        if !terms.iter().flatten().any(|term| has(term, &|name| name == own.name)) {
            return Err(wrong(&format!("parameters.{}", own.name), LawProblem::Unused));
        }
    }
    let remembers = terms[out::MEMORY].is_some();
    let integrated =
        [(out::MOMENT, out::ENERGY, "kappa_rate"), (out::TENSION, out::EDGE_ENERGY, "stretch_rate")].map(
            |(stress, energy, rate)| {
                let stores = terms[stress].as_ref().is_some_and(|term| !vanishes(term, rate));
                stores && terms[energy].is_none() && !(remembers && stress == out::MOMENT)
            },
        );
    let needs_diameter = terms.iter().flatten().any(|term| has(term, &|name| name == "diameter"));
    Ok(Read { about: about(definition, &terms), programs, integrated, needs_diameter })
}

fn is_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

fn check_names(definition: &Definition) -> Result<(), LawError> {
    let name = definition.name.clone();
    if !is_name(&name) {
        return Err(wrong("", LawProblem::Name { name }));
    }
    let found = definition.parameters.len();
    if found > MOST_PARAMETERS {
        return Err(wrong("parameters", LawProblem::TooMany { found }));
    }
    for own in &definition.parameters {
        let key = format!("parameters.{}", own.name);
        let name = own.name.clone();
        if !is_name(&name) || name == "pi" {
            return Err(wrong(&key, LawProblem::Name { name }));
        }
        let seen =
            definition.places.iter().flat_map(|place| names(*place)).find(|(_, seen)| seen.name == name);
        if let Some((_, seen)) = seen {
            return Err(wrong(&key, LawProblem::Shadows { name, meaning: seen.meaning }));
        }
    }
    Ok(())
}

fn word(place: Place) -> &'static str {
    PLACES.iter().find(|(_, known)| *known == place).map_or("", |(word, _)| word)
}

/// Every place has a formula, every formula its place.
fn check_places(definition: &Definition) -> Result<(), LawError> {
    let given = |k: usize| definition.formulas.iter().any(|(given, _)| *given == k);
    for place in &definition.places {
        let energies = [out::ENERGY, out::EDGE_ENERGY, out::TIP_ENERGY, out::MEMORY];
        let acts: Vec<usize> =
            (0..OUTPUTS.len()).filter(|k| OUTPUTS[*k].place == *place && !energies.contains(k)).collect();
        if !acts.iter().any(|k| given(*k)) {
            let keys = acts.iter().map(|k| OUTPUTS[*k].key).collect::<Vec<_>>().join(", ");
            return Err(wrong("place", LawProblem::NoFormula { place: word(*place), keys }));
        }
    }
    for (k, _) in &definition.formulas {
        let output = OUTPUTS[*k];
        if !definition.places.contains(&output.place) {
            return Err(wrong(output.key, LawProblem::OtherPlace { place: word(output.place) }));
        }
    }
    Ok(())
}

/// The measure of a unit that has to be the SI unit.
fn unit(key: &str, text: &str) -> Result<Measure, LawError> {
    let of = |message: String| wrong(key, LawProblem::Unit { message });
    let unit = Unit::parse(text).map_err(|error| of(error.to_string()))?;
    if unit.scale != 1.0 {
        return Err(of(format!("`{text}` is {} of the SI unit; laws compute in SI units", unit.scale)));
    }
    Ok(unit.dimension.into())
}

fn check_parameter(own: &OwnParameter) -> Result<(), LawError> {
    let key = |key: &str| format!("parameters.{}.{key}", own.name);
    unit(&key("unit"), &own.unit)?;
    let (low, high) = own.range;
    if !(low.is_finite() && high.is_finite() && low < high) {
        return Err(wrong(&key("range"), LawProblem::NoRange));
    }
    for (name, value) in [("default", Some(own.default)), ("off", own.null_value)] {
        if let Some(value) = value.filter(|value| !(low..=high).contains(value)) {
            return Err(wrong(&key(name), LawProblem::Range { value, low, high }));
        }
    }
    if own.plausible.is_some_and(|(low, high)| !(low.is_finite() && high.is_finite() && low < high)) {
        return Err(wrong(&key("plausible"), LawProblem::NoRange));
    }
    if own.scale.is_some_and(|scale| !(scale.is_finite() && scale > 0.0)) {
        let (value, low, high) = (own.scale.unwrap_or_default(), f64::MIN_POSITIVE, f64::MAX);
        return Err(wrong(&key("scale"), LawProblem::Range { value, low, high }));
    }
    // A range over a property of the rod needs a rod.
    let is_outside = |value: &&f64| own.per == Per::Unit && !(low..=high).contains(*value);
    if let Some(value) = own.tries.iter().find(is_outside) {
        return Err(wrong(&key("tries"), LawProblem::Range { value: *value, low, high }));
    }
    Ok(())
}

/// Source and unit of a name in the formula of an output; no unit for the memory, which has the law's own.
fn named<'a>(
    definition: &'a Definition,
    output: usize,
    name: &str,
) -> Result<(Source, Option<&'a str>), FormulaProblem> {
    let place = OUTPUTS[output].place;
    if let Some(k) = definition.parameters.iter().position(|own| own.name == name) {
        return Ok((Source::Parameter(k as u8), Some(&definition.parameters[k].unit)));
    }
    if let Some((k, seen)) = names(place).find(|(_, seen)| seen.name == name) {
        return Ok((Source::Seen(k), (name != MEMORY).then_some(seen.unit)));
    }
    let parameters = definition.parameters.iter().map(|own| own.name.as_str());
    let known: Vec<&str> = parameters.chain(names(place).map(|(_, seen)| seen.name)).collect();
    Err(FormulaProblem::Name {
        name: name.to_owned(),
        nearest: nearest(name, known.iter().copied()).map(str::to_owned),
        known: known.into_iter().map(str::to_owned).collect(),
    })
}

fn check_unit(
    definition: &Definition,
    output: usize,
    term: &Term,
    memory_unit: Measure,
) -> Result<(), FormulaError> {
    let parsed = |unit: &str| Unit::parse(unit).map_or(Measure::NONE, |unit| unit.dimension.into());
    let of = |name: &str| {
        let (_, unit) = named(definition, output, name)?;
        Ok(unit.map_or(memory_unit, parsed))
    };
    let (due, words) = match output {
        out::MEMORY => {
            let due = memory_unit.over(parsed("s"));
            (due, due.to_string())
        }
        _ => (parsed(OUTPUTS[output].unit), OUTPUTS[output].unit.to_owned()),
    };
    match measure(term, &of)? {
        Some(found) if !found.is(due) => {
            let problem = FormulaProblem::Unit { found: found.to_string(), due: words };
            Err(FormulaError { span: term.span.clone(), problem })
        }
        _ => Ok(()),
    }
}

fn check_memory(definition: &Definition, terms: &Terms) -> Result<(), LawError> {
    let names = |k: usize, name: &str| terms[k].as_ref().is_some_and(|term| has(term, &|own| own == name));
    let refuse = |key: &str, message| Err(wrong(key, LawProblem::Memory { message }));
    let remembers = terms[out::MEMORY].is_some();
    match [out::MOMENT, out::ENERGY].into_iter().find(|k| names(*k, MEMORY)) {
        Some(k) if !remembers => {
            return refuse(
                OUTPUTS[k].key,
                "it names the memory, whose rate is not given; write memory = \"…\"",
            );
        }
        None if remembers => {
            return refuse("memory", "nothing names the memory; name it in the moment, or strike its rate");
        }
        _ => {}
    }
    if !remembers && !definition.memory_unit.is_empty() {
        return refuse(
            "memory_unit",
            "there is no memory; write its rate, memory = \"…\", or strike its unit",
        );
    }
    match [out::MEMORY, out::ENERGY].into_iter().find(|k| names(*k, MEAN_SQUARE)) {
        Some(k) => {
            refuse(OUTPUTS[k].key, "only a moment may name the mean square curvature of the whole rod")
        }
        None => Ok(()),
    }
}

/// Whether a formula has a name that is meant.
fn has(term: &Term, is_meant: &dyn Fn(&str) -> bool) -> bool {
    match &term.node {
        Node::Number(_) => false,
        Node::Name(name) => is_meant(name),
        Node::Negative(inner) => has(inner, is_meant),
        Node::Binary(_, sides) => sides.iter().any(|side| has(side, is_meant)),
        Node::Call(_, arguments) => arguments.iter().any(|argument| has(argument, is_meant)),
    }
}

/// Whether a formula is exactly zero where a name is, by its form.
fn vanishes(term: &Term, name: &str) -> bool {
    match &term.node {
        Node::Number(number) => *number == 0.0,
        Node::Name(own) => own == name,
        Node::Negative(inner) => vanishes(inner, name),
        Node::Binary(operator, sides) => {
            let [left, right] = &**sides;
            match operator {
                Operator::Add | Operator::Subtract => vanishes(left, name) && vanishes(right, name),
                Operator::Multiply => vanishes(left, name) || vanishes(right, name),
                Operator::Divide => vanishes(left, name),
                Operator::Power => {
                    vanishes(left, name) && exponent(right).is_some_and(|exponent| exponent > 0.0)
                }
            }
        }
        Node::Call(function, arguments) => match function {
            Function::Min | Function::Max => arguments.iter().all(|argument| vanishes(argument, name)),
            Function::Exp | Function::Log | Function::Cos | Function::Acos | Function::Cosh => false,
            _ => vanishes(&arguments[0], name),
        },
    }
}

fn leak(text: &str) -> &'static str {
    Box::leak(text.to_owned().into_boxed_str())
}

fn about(definition: &Definition, terms: &Terms) -> &'static About {
    let acts =
        || terms.iter().enumerate().filter(|(k, _)| *k != out::MEMORY).filter_map(|(_, term)| term.as_ref());
    let parameter = |own: &OwnParameter| Parameter {
        name: leak(&own.name),
        meaning: leak(&own.meaning),
        unit: leak(&own.unit),
        default: own.default,
        range: own.range,
        scale: own.scale.unwrap_or(if own.default == 0.0 { 1.0 } else { own.default.abs() }),
        null_value: own.null_value.or_else(|| {
            let can_be = own.range.0 <= 0.0 && 0.0 <= own.range.1;
            (can_be && acts().all(|term| vanishes(term, &own.name))).then_some(0.0)
        }),
        is_part: own.is_part,
        is_friction: own.is_friction,
        plausible: own.plausible,
        per: own.per,
        tries: Box::leak(own.tries.clone().into_boxed_slice()),
        tries_beside: None,
    };
    let parameters: Vec<Parameter> = definition.parameters.iter().map(parameter).collect();
    let mut places = definition.places.clone();
    let all = |is_meant: &dyn Fn(&str) -> bool| terms.iter().flatten().any(|term| has(term, is_meant));
    if all(&|name| name == MEAN_SQUARE) {
        places.push(Place::Whole);
    }
    let confounded: Vec<&'static str> = definition.confounded_with.iter().map(|name| leak(name)).collect();
    Box::leak(Box::new(About {
        name: leak(&definition.name),
        meaning: leak(&definition.meaning),
        kind: definition.kind.unwrap_or_else(|| kind(definition, terms)),
        places: Box::leak(places.into_boxed_slice()),
        memory: usize::from(terms[out::MEMORY].is_some()),
        timed: all(&|name| name == "time"),
        parameters: Box::leak(parameters.into_boxed_slice()),
        signature: leak(&definition.signature),
        confounded_with: Box::leak(confounded.into_boxed_slice()),
        separated_by: Box::leak(definition.separated_by.clone().into_boxed_slice()),
        reach: definition.reach,
    }))
}

/// What a law that does not say it does to the energy: what names a rate or remembers loses it, what acts from outside
/// is a load, and the rest gives back.
fn kind(definition: &Definition, terms: &Terms) -> Kind {
    let rates = ["kappa_rate", "stretch_rate", "v_t", "v_n", "v_x", "v_z", "angular_velocity"];
    let moves = terms.iter().flatten().any(|term| has(term, &|name| rates.contains(&name)));
    if moves || terms[out::MEMORY].is_some() || terms[out::DECAY].is_some() {
        return Kind::Dissipative;
    }
    let acts_from_outside = |place: &Place| matches!(place, Place::Flow | Place::Mass | Place::Tip);
    if definition.places.iter().any(acts_from_outside) { Kind::Load } else { Kind::Elastic }
}

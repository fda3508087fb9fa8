//! A law as the Rust file that the catalogue wants.

use std::fmt::Write;

use super::names::{OUTPUTS, Output, names, out};
use super::{Definition, LawError, about};
use crate::effects::{About, Parameter, Per, Place};
use crate::formula::{Function, Node, Operator, Term, exponent, parse, whole};

impl Definition {
    /// The text of `models/src/effects/NAME.rs`; `rustfmt` breaks its lines.
    /// # Errors
    /// [`LawError`] for a law that cannot be.
    pub fn rust(&self) -> Result<String, LawError> {
        let read = about::read(self)?;
        let page: Vec<String> =
            self.page(read.about).lines().map(|line| format!("//! {line}").trim_end().to_owned()).collect();
        let mut functions = String::new();
        for place in &self.places {
            functions += &self.functions(*place, read.integrated);
        }
        let helpers = ["max", "min", "power", "root", "sign"];
        let used: Vec<&str> = helpers.into_iter().filter(|name| calls(&functions, name)).collect();
        let helpers = if used.is_empty() {
            String::new()
        } else {
            format!("use crate::formula::{{{}}};\n", used.join(", "))
        };
        let integral = if calls(&functions, "integral") { "use crate::written::integral;\n" } else { "" };
        let of_law = [
            "Bend",
            "Edge",
            "Flow",
            "Mass",
            "MassLoad",
            "Moment",
            "Per",
            "Separator",
            "Tip",
            "TipLoad",
            "named",
        ];
        let about = about_of(read.about);
        let has = |word: &str| format!("{about}{functions}").contains(word);
        let has_word =
            |word: &str| [":", "<", "(", " {", " ="].iter().any(|end| has(&format!("{word}{end}")));
        let mut words: Vec<&str> = of_law.into_iter().filter(|word| has_word(word)).collect();
        words.extend(["About", "Kind", "Law", "Parameter", "Place", "Reach", "Real"]);
        words.sort_unstable();
        let law = self.name.split('_').map(capital).collect::<String>();
        let meaning = capital(self.meaning.trim_end_matches('.'));
        Ok(format!(
            "{}\n\nuse super::{{{}}};\n{helpers}{integral}\n/// {meaning}.\npub struct {law};\n\nimpl Law for {law} {{\n    \
             const ABOUT: About = {about};\n{functions}}}\n",
            page.join("\n"),
            words.join(", "),
        ))
    }

    /// The methods of a place.
    fn functions(&self, place: Place, integrated: [bool; 2]) -> String {
        let see = |name: &str| format!("at: &{name}<T>, ");
        let all = |keys: &[usize]| keys.iter().map(|k| self.value(*k)).collect::<Vec<_>>();
        let body =
            |name: &str, at: &str, gives: &str, keys: &[usize], result: &dyn Fn(&[String]) -> String| {
                let mut text = result(&all(keys));
                // What a method does not see has an underscore.
                let at = if text.contains("at.") { at.to_owned() } else { at.replacen("at", "_at", 1) };
                let lets = self.lets(keys);
                let theta = if lets.is_empty() { "_theta" } else { "theta" };
                text = format!("{lets}        {text}");
                format!("\n    fn {name}<T: Real>(&self, {at}{theta}: &[T]) -> {gives} {{\n{text}\n    }}\n")
            };
        let whole = |of: &[String]| of[0].clone();
        let integral = |name: &str, see: &str, strain: &str, rate: &str, of: &str, part: &str| {
            format!(
                "\n    fn {name}<T: Real>(&self, at: &{see}<T>, theta: &[T]) -> T {{\n        // What it takes to bend or stretch it to \
                 there at rest.\n        integral(at.{strain}, |{strain}| self.{of}(&{see} {{ {strain}, {rate}: T::from(0.0), \
                 ..*at }}, theta){part})\n    }}\n"
            )
        };
        let has = |k: usize| self.formulas.iter().any(|(given, _)| *given == k);
        let mut text = String::new();
        match place {
            Place::Bend => {
                text += &body("bend", &see("Bend"), "Moment<T>", &[out::MOMENT, out::MEMORY], &|of| {
                    if has(out::MEMORY) {
                        format!("Moment {{ moment: {}, memory_rate: {} }}", of[0], of[1])
                    } else {
                        format!("Moment::of({})", of[0])
                    }
                });
                if has(out::ENERGY) {
                    text += &body("bend_energy", &see("Bend"), "T", &[out::ENERGY], &whole);
                } else if integrated[0] {
                    text += &integral("bend_energy", "Bend", "kappa", "kappa_rate", "bend", ".moment");
                }
            }
            Place::Edge => {
                text += &body("edge", &see("Edge"), "T", &[out::TENSION], &whole);
                if has(out::EDGE_ENERGY) {
                    text += &body("edge_energy", &see("Edge"), "T", &[out::EDGE_ENERGY], &whole);
                } else if integrated[1] {
                    text += &integral("edge_energy", "Edge", "stretch", "stretch_rate", "edge", "");
                }
            }
            Place::Flow => {
                let keys = [out::FORCE_ALONG, out::FORCE];
                text += &body("flow", &see("Flow"), "[T; 2]", &keys, &|of| format!("[{}, {}]", of[0], of[1]));
            }
            Place::Mass => {
                let keys = [out::ACCELERATION_X, out::ACCELERATION_Z, out::DECAY];
                text += &body("mass", &see("Mass"), "MassLoad<T>", &keys, &|of| {
                    format!("MassLoad {{ acceleration: [{}, {}], rate: {} }}", of[0], of[1], of[2])
                });
            }
            Place::Tip => {
                let keys = [out::FORCE_X, out::FORCE_Z, out::TIP_MOMENT];
                text += &body("tip", &see("Tip"), "TipLoad<T>", &keys, &|of| {
                    format!("TipLoad {{ force: [{}, {}], moment: {} }}", of[0], of[1], of[2])
                });
                if has(out::TIP_ENERGY) {
                    text += &body("tip_energy", &see("Tip"), "T", &[out::TIP_ENERGY], &whole);
                }
            }
            _ => text += &body("clamp", "", "T", &[out::COMPLIANCE], &whole),
        }
        text
    }

    fn term(&self, output: usize) -> Option<Term> {
        let (_, text) = self.formulas.iter().find(|(k, _)| *k == output)?;
        parse(text).ok()
    }

    /// A formula as an expression; zero where there is none.
    fn value(&self, output: usize) -> String {
        self.term(output).map_or("T::from(0.0)".to_owned(), |term| self.expression(&term, &OUTPUTS[output]).0)
    }

    /// Parameters that formulas name, bound to their names.
    fn lets(&self, outputs: &[usize]) -> String {
        let texts: Vec<&str> = self
            .formulas
            .iter()
            .filter(|(k, _)| outputs.contains(k))
            .map(|(_, text)| text.as_str())
            .collect();
        let is_part = |c: char| c == '_' || c.is_alphanumeric();
        let is_named =
            |name: &str| texts.iter().any(|text| text.split(|c| !is_part(c)).any(|word| word == name));
        let last = self.parameters.iter().rposition(|own| is_named(&own.name));
        let upto = &self.parameters[..last.map_or(0, |last| last + 1)];
        let names = upto.iter().map(|own| if is_named(&own.name) { own.name.as_str() } else { "_" });
        let names = names.collect::<Vec<_>>().join(", ");
        if names.is_empty() { names } else { format!("        let [{names}] = named(theta);\n") }
    }

    /// An expression, and how tightly it holds together: 0 a sum, 1 a product, 2 a sign, 3 one thing.
    fn expression(&self, term: &Term, output: &Output) -> (String, u8) {
        let at_least = |term: &Term, least: u8| {
            let (text, own) = self.expression(term, output);
            if own < least { format!("({text})") } else { text }
        };
        // To the right of an operator a plain number needs no parentheses.
        let right = |term: &Term, least: u8| match term.node {
            Node::Number(number) => format!("{number:?}"),
            _ => at_least(term, least),
        };
        match &term.node {
            Node::Number(number) => (format!("T::from({number:?})"), 3),
            Node::Name(name) if self.parameters.iter().any(|own| own.name == *name) => (name.clone(), 3),
            Node::Name(name) => {
                let seen = names(output.place).find(|(_, seen)| seen.name == name);
                (seen.map_or(name.clone(), |(_, seen)| seen.rust.to_owned()), 3)
            }
            Node::Negative(inner) => (format!("-{}", at_least(inner, 2)), 2),
            Node::Binary(operator, sides) => {
                let [a, b] = &**sides;
                match operator {
                    Operator::Add => (format!("{} + {}", at_least(a, 0), right(b, 1)), 0),
                    Operator::Subtract => (format!("{} - {}", at_least(a, 0), right(b, 1)), 0),
                    Operator::Multiply => (format!("{} * {}", at_least(a, 1), right(b, 2)), 1),
                    Operator::Divide => (format!("{} / {}", at_least(a, 1), right(b, 2)), 1),
                    Operator::Power => match exponent(b).and_then(whole) {
                        Some(whole) => (format!("{}.powi({whole})", at_least(a, 3)), 3),
                        None => (format!("power({}, {})", at_least(a, 0), at_least(b, 0)), 3),
                    },
                }
            }
            Node::Call(function, arguments) => {
                let [first, .., last] = &arguments[..] else {
                    return (
                        self.call(*function, &at_least(&arguments[0], 0), &at_least(&arguments[0], 3)),
                        3,
                    );
                };
                (format!("{}({}, {})", function.name(), at_least(first, 0), at_least(last, 0)), 3)
            }
        }
    }

    fn call(&self, function: Function, inner: &str, receiver: &str) -> String {
        match function {
            Function::Sign => format!("sign({inner})"),
            Function::Sqrt => format!("root({inner})"),
            Function::Log => format!("{receiver}.ln()"),
            _ => format!("{receiver}.{}()", function.name()),
        }
    }
}

/// Whether a text calls a function of that name, and no method.
fn calls(text: &str, name: &str) -> bool {
    let call = format!("{name}(");
    text.match_indices(&call)
        .any(|(at, _)| !text[..at].ends_with(|c: char| c == '.' || c == '_' || c.is_alphanumeric()))
}

/// With a capital, as types and sentences begin.
fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

fn about_of(about: &About) -> String {
    let parameters: String = about.parameters.iter().map(parameter).collect();
    let list = |all: Vec<String>| format!("&[{}]", all.join(", "));
    let separators = about.separated_by.iter().map(|own| format!("Separator::{own:?}")).collect();
    let confounded = about.confounded_with.iter().map(|name| format!("{name:?}")).collect();
    format!(
        "About {{\n        name: {:?},\n        meaning: {:?},\n        kind: Kind::{:?},\n        places: {},\n        \
         memory: {},\n        timed: {},\n        parameters: &[\n{parameters}        ],\n        signature: {:?},\n        \
         confounded_with: {},\n        separated_by: {},\n        reach: Reach::{:?},\n    }}",
        about.name,
        about.meaning,
        about.kind,
        list(about.places.iter().map(|place| format!("Place::{place:?}")).collect()),
        about.memory,
        about.timed,
        about.signature,
        list(confounded),
        list(separators),
        about.reach,
    )
}

fn parameter(own: &Parameter) -> String {
    let mut out = String::from("            Parameter {\n");
    let mut put = |key: &str, value: String| {
        let _ = writeln!(out, "                {key}: {value},");
    };
    let pair = |(low, high): (f64, f64)| format!("({low:?}, {high:?})");
    put("name", format!("{:?}", own.name));
    put("meaning", format!("{:?}", own.meaning));
    put("unit", format!("{:?}", own.unit));
    put("default", format!("{:?}", own.default));
    put("range", pair(own.range));
    put("scale", format!("{:?}", own.scale));
    if let Some(off) = own.null_value {
        put("null_value", format!("Some({off:?})"));
    }
    if own.is_part {
        put("is_part", "true".to_owned());
    }
    if own.is_friction {
        put("is_friction", "true".to_owned());
    }
    if let Some(plausible) = own.plausible {
        put("plausible", format!("Some({})", pair(plausible)));
    }
    if own.per != Per::Unit {
        put("per", format!("Per::{:?}", own.per));
    }
    if !own.tries.is_empty() {
        put("tries", format!("&{:?}", own.tries));
    }
    out + "                ..Parameter::PLAIN\n            },\n"
}

//! Comments of the code use plain words: an engineer reads each sentence once.

use std::collections::BTreeSet;
use std::fs;

use super::pages::{below, name, root};

/// Words that comments do not use: each has a plainer one.
const UNUSED_IN_CODE: [(&str, &str); 33] = [
    ("ask", "request, need"),
    ("asked", "requested, evaluated"),
    ("asking", "requesting"),
    ("asks", "requests, requires"),
    ("belief", "prior"),
    ("beliefs", "priors"),
    ("believe", "accept"),
    ("believed", "plausible, accepted"),
    ("believes", "finds plausible"),
    ("foretell", "predict"),
    ("foretells", "predicts"),
    ("foretold", "predicted"),
    ("hear", "receive"),
    ("heard", "detected"),
    ("hears", "receives"),
    ("judge", "check, compare"),
    ("judged", "checked, compared"),
    ("judges", "checks, compares"),
    ("loud", "significant"),
    ("nought", "zero"),
    ("robbed", "removed from the catalogue"),
    ("speak", "show, support"),
    ("speaks", "shows, supports"),
    ("spoken", "shown"),
    ("stand", "are, are given, replace"),
    ("standing", "at rest, present"),
    ("stands", "is, is at, equals, contains"),
    ("stood", "was"),
    ("tell", "show, determine, distinguish"),
    ("telling", "showing"),
    ("tells", "shows, determines, gives"),
    ("told", "given, reported"),
    ("unheard", "not significant"),
];

/// Words of the comment of a line, without code between backticks; none where it has no comment.
fn words(line: &str) -> BTreeSet<String> {
    let line = line.trim_start();
    // A quote that no other one closes before it: the marks are part of a string.
    let is_in_string = |at: usize| line[..at].replace("\\\"", "").matches('"').count() % 2 == 1;
    let behind = || line.match_indices(" // ").map(|(at, _)| at).find(|at| !is_in_string(*at));
    let begin = line.starts_with("//").then_some(0).or_else(behind);
    let prose = begin.map_or("", |at| &line[at..]).split('`').step_by(2);
    let parts = prose.flat_map(|part| part.split(|c: char| !c.is_alphanumeric() && c != '_'));
    parts.map(str::to_lowercase).collect()
}

#[test]
fn comments_use_plain_words() {
    let mut wrong = Vec::new();
    for folder in ["models", "sim", "tests"] {
        below(&root().join(folder), &mut |path| {
            if path.extension().is_none_or(|own| own != "rs") {
                return;
            }
            let text = fs::read_to_string(path).expect("text");
            for (number, line) in (1..).zip(text.lines()) {
                let words = words(line);
                let used = UNUSED_IN_CODE.iter().filter(|(unused, _)| words.contains(*unused));
                wrong.extend(
                    used.map(|(unused, say)| format!("{}:{number}: `{unused}`, say {say}", name(path))),
                );
            }
        });
    }
    assert!(wrong.is_empty(), "{} comments:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn unused_words_are_found_in_comments_alone() {
    let is_found = |line: &str| words(line).contains("stands");
    for line in ["/// It stands.", "    // Stands", "let a = \"b\"; // it stands", "//! (stands)"] {
        assert!(is_found(line), "{line}");
    }
    for line in
        ["let stands = 1;", "(\"a // stands\", 1)", "/// `stands` and stands_alone", "\"\\\" // stands\""]
    {
        assert!(!is_found(line), "{line}");
    }
}

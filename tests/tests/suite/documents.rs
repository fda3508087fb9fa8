//! Goal: what the documents show can be used without changes, and reads easily.
//!
//! Documents are README, ARCHITECTURE, the book in `docs/src` and the pages in `docs/decisions`. Expected: every block of
//! TOML is read without an error; every file, link and test of a promise that they name is there; the book lists all of
//! its pages; README and ARCHITECTURE stay short; no sentence has more than 35 words, and none has a word of [`UNUSED`].
//! Tutorials and README are run by `sim/tests/program/tutorials.rs`, generated pages compared by
//! `sim/tests/program/reference.rs`.

mod comments;
mod pages;
mod prose;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use efam_experiments::cleaning::clean;
use efam_experiments::experiment::Experiment;
use efam_experiments::scenario::Scenario;
use efam_inference::diagnose::DiagnosisSettings;
use efam_sweeps::request::SweepRequest;

use pages::{Page, headings, links, pages, root};

/// Characters that a document may have.
const MOST_CHARACTERS: [(&str, usize); 2] = [("README.md", 9_000), ("ARCHITECTURE.md", 10_000)];
/// Bytes that a picture of the book and a notebook may have.
const MOST_BYTES: u64 = 150_000;

#[test]
fn the_two_at_the_root_are_short() {
    for (name, most) in MOST_CHARACTERS {
        let text = fs::read_to_string(root().join(name)).expect("it is there");
        let count = text.chars().count();
        assert!(count <= most, "{name} has {count} characters, and may have {most}; move some into the book");
    }
}

#[test]
fn their_toml_is_read() {
    let mut read = 0;
    for page in pages() {
        for block in page.blocks().filter(|block| block.language == "toml") {
            let wrong = match (block.word, page.name.contains("/tutorials/")) {
                (None, _) => scenario(block.text),
                (Some("experiment"), _) => experiment(block.text),
                (Some("calibrate"), _) => calibrate(block.text),
                (Some("diagnose"), _) => diagnose(block.text),
                (Some("sweep"), _) => sweep(block.text, read),
                // Saved under that name and used by the page's own test.
                (Some(_), true) => continue,
                (Some(word), _) if word.ends_with(".toml") => continue,
                (Some(word), false) => Some(format!("what is a block of `toml {word}`?")),
            };
            assert_eq!(wrong, None, "{}:\n{}", page.name, block.text);
            read += 1;
        }
    }
    assert!(read >= 8, "{read} blocks");
}

fn scenario(text: &str) -> Option<String> {
    let scenario = Scenario::parse(&root().join("page.toml"), text, &[]);
    scenario.and_then(|scenario| scenario.cases()).err().map(|error| error.to_string())
}

fn experiment(text: &str) -> Option<String> {
    Experiment::parse(&root().join("page.toml"), text, &[]).err().map(|error| error.to_string())
}

/// What is said of a diagnosis, at the end of a worked example.
fn diagnose(text: &str) -> Option<String> {
    let path = root().join("scenarios/diagnosis/nothing/experiment.toml");
    let whole = fs::read_to_string(&path).expect("a worked example");
    let experiment = match Experiment::parse(&path, &format!("{whole}\n{text}"), &[]) {
        Err(error) => return Some(error.to_string()),
        Ok(experiment) => experiment,
    };
    DiagnosisSettings::default().stated(&experiment).err().map(|error| error.to_string())
}

/// What is to be calibrated, at the end of a worked example in place of its own.
fn calibrate(text: &str) -> Option<String> {
    let path = root().join("scenarios/diagnosis/nothing/experiment.toml");
    let whole = fs::read_to_string(&path).expect("a worked example");
    let (head, _) = whole.split_once("[calibrate]").expect("it calibrates");
    let experiment = match Experiment::parse(&path, &format!("{head}{text}"), &[]) {
        Err(error) => return Some(error.to_string()),
        Ok(experiment) => experiment,
    };
    let cleaned = clean(&experiment).expect("a worked example is clean");
    efam_inference::calibrate::problem(&experiment, &cleaned).err().map(|error| error.to_string())
}

/// A sweep, as if it lay in the root of the project.
fn sweep(text: &str, number: usize) -> Option<String> {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("documents-sweep-{number}.toml"));
    let from_root = text.replace("\"scenarios/", &format!("\"{}/scenarios/", root().display()));
    fs::write(&path, from_root).expect("the target folder can be written");
    SweepRequest::load(&path, &[]).err().map(|error| error.to_string())
}

#[test]
fn their_files_are_there() {
    let mut sources = Vec::new();
    for folder in ["models", "sim", "tests"] {
        pages::below(&root().join(folder), &mut |path| sources.push(format!("/{}", pages::name(path))));
    }
    for page in pages() {
        for word in page.text.split(['`', '(', ')', ' ', '\n', ',', ';', '"', '|']) {
            let word = word.trim_end_matches(['.', ':']);
            let ending = word.rsplit('.').next().unwrap_or_default();
            let folders = ["scenarios/", "models/", "sim/", "tests/", "docs/"];
            // What a tutorial lets its reader write, and patterns.
            if word.contains(['*', '…', '<']) || word.ends_with("bend_hardening.rs") {
                continue;
            }
            if folders.iter().any(|own| word.starts_with(own))
                && ["rs", "toml", "md", "csv"].contains(&ending)
            {
                assert!(root().join(word).is_file(), "{} names {word}", page.name);
            } else if ending == "rs" && word.contains('.') && word.len() > 4 {
                let is_there = sources.iter().any(|own| own.ends_with(&format!("/{word}")));
                assert!(is_there, "{} names {word}, and no file ends so", page.name);
            }
        }
    }
}

#[test]
fn their_links_lead_somewhere() {
    let all = pages();
    let mut followed = 0;
    for page in &all {
        let folder = root().join(&page.name).parent().expect("a folder").to_path_buf();
        for link in links(&page.text).filter(|link| !link.contains("://")) {
            let (file, anchor) = link.split_once('#').map_or((link, None), |(file, own)| (file, Some(own)));
            let target = if file.is_empty() { root().join(&page.name) } else { folder.join(file) };
            assert!(target.exists(), "{}: {link}", page.name);
            if let Some(anchor) = anchor {
                let text = fs::read_to_string(&target).expect("a page");
                assert!(headings(&text).contains(anchor), "{}: {link} has no such heading", page.name);
            }
            followed += 1;
        }
    }
    assert!(followed > 100, "{followed}");
}

#[test]
fn each_page_of_the_book_and_each_decision_is_listed() {
    let all = pages();
    let linked = |name: &str| -> BTreeSet<String> {
        let text = &all.iter().find(|page| page.name == name).expect("a page").text;
        links(text).map(|link| link.split('#').next().unwrap_or_default().to_owned()).collect()
    };
    let (summary, map) = (linked("docs/src/SUMMARY.md"), linked("docs/decisions/README.md"));
    for page in &all {
        if let Some(own) = page.name.strip_prefix("docs/src/").filter(|own| *own != "SUMMARY.md") {
            assert!(summary.contains(own), "docs/src/SUMMARY.md does not list {own}");
        }
        if let Some(own) = page.name.strip_prefix("docs/decisions/").filter(|own| *own != "README.md") {
            assert!(map.contains(own), "docs/decisions/README.md does not list {own}");
            let date = page.text.lines().nth(2).unwrap_or_default();
            assert!(date.starts_with("20") && date.contains("commit"), "{}: its date is missing", page.name);
        }
    }
}

/// Tests as a page names them: `` `file.rs::function` ``, or `` `::function` `` of the file before.
fn named_tests(text: &str) -> Vec<(String, String)> {
    let mut file = String::new();
    let words = text.split('`').skip(1).step_by(2).filter_map(|word| word.split_once("::"));
    let is_name =
        |name: &str| !name.is_empty() && name.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'_');
    words
        .filter(|(of, name)| (of.is_empty() || of.ends_with(".rs")) && is_name(name))
        .map(|(of, name)| {
            if !of.is_empty() {
                file = of.to_owned();
            }
            (file.clone(), name.to_owned())
        })
        .collect()
}

#[test]
fn tests_of_promises_are_there() {
    let page = fs::read_to_string(root().join("docs/src/validation/trust.md")).expect("a page");
    let all = named_tests(&page);
    assert!(all.len() > 80, "{} are named", all.len());
    for (file, name) in all {
        let folder = match file.split('/').next().unwrap_or_default() {
            "models" | "sim" => "",
            "program" => "sim/tests",
            _ => "tests/tests/suite",
        };
        let text = fs::read_to_string(root().join(folder).join(&file)).unwrap_or_default();
        assert!(text.contains(&format!("fn {name}(")), "trust.md: {file}::{name} is not there");
    }
}

/// CI does not run the tests that `.ci/long` lists.
#[test]
fn promises_say_where_their_tests_run() {
    let listed = fs::read_to_string(root().join(".ci/long")).expect("a list");
    let listed: Vec<&str> = listed.lines().filter_map(|line| line.rsplit("::").next()).collect();
    let page = fs::read_to_string(root().join("docs/src/validation/trust.md")).expect("a page");
    let mut rows = 0;
    for row in page.lines().filter(|line| line.starts_with("| ")) {
        let cells: Vec<&str> = row.split(" | ").collect();
        let [promise, tests, place, _] = cells[..] else { continue };
        let names = tests.split("::").skip(1).filter_map(|rest| rest.split('`').next());
        let names: Vec<&str> = names.filter_map(|name| name.rsplit("::").next()).collect();
        let long = names.iter().filter(|name| listed.contains(name)).count();
        let stages = ["(`long`)", "(`strikes`)"];
        assert!(
            long == 0 || stages.iter().any(|stage| place.contains(stage)),
            "{promise}: long tests run in {place}"
        );
        let is_in_ci = place.starts_with("CI");
        assert!(!is_in_ci || long < names.len().max(1), "{promise}: no test of it runs in CI");
        rows += usize::from(long > 0);
    }
    assert!(rows > 20, "{rows} promises have long tests");
}

#[test]
fn measurements_have_date_and_commit() {
    for page in pages().iter().filter(|page| page.name.starts_with("docs/src/validation/")) {
        assert!(is_dated(&page.text), "{}: a measurement needs its date and commit", page.name);
    }
    let dated = "40 of 40 (2026-11-25,\ncommit 2bf66e9)";
    assert!(is_dated(dated));
    for other in ["2bf66e9", "2026-11", "commit of yesterday", "2026-13-25, commit 2bf66e9"] {
        assert!(!is_dated(other), "{other}");
    }
    assert!(!is_dated(&dated.replace("2bf66e9", "to come")) && !is_dated(&dated.replace("-25", "")));
}

/// Whether a text has a date, and the hash of a commit soon after or before it.
fn is_dated(text: &str) -> bool {
    let words: Vec<&str> = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '-').collect();
    let is_date = |word: &str| {
        let parts: Vec<&str> = word.split('-').collect();
        let number = |k: usize| parts[k].parse::<u32>().unwrap_or(0);
        parts.len() == 3
            && parts[0].len() == 4
            && (2026..2100).contains(&number(0))
            && (1..=12).contains(&number(1))
            && (1..=31).contains(&number(2))
    };
    let is_hash = |word: &&str| {
        (7..=40).contains(&word.len())
            && word.bytes().all(|byte| byte.is_ascii_hexdigit())
            && word.bytes().any(|byte| byte.is_ascii_digit())
    };
    let is_near = |k: usize| words[k.saturating_sub(12)..(k + 12).min(words.len())].iter().any(is_hash);
    (0..words.len()).any(|k| is_date(words[k]) && is_near(k))
}

#[test]
fn tables_of_peers_are_those_that_were_measured() {
    let measured = fs::read_to_string(root().join("tests/peers/results.md")).expect("it is there");
    let page = fs::read_to_string(root().join("docs/src/validation/peers.md")).expect("a page");
    let stale = measured.lines().find(|line| !page.contains(line));
    assert_eq!(stale, None, "docs/src/validation/peers.md differs from tests/peers/results.md");
}

#[test]
fn pictures_are_small_and_shown() {
    let all = pages();
    let shown: String = all.iter().map(|page| page.text.as_str()).collect();
    pages::below(&root().join("docs/src/pictures"), &mut |path| {
        let file = path.file_name().expect("a name").to_string_lossy();
        let bytes = fs::metadata(path).expect("it is there").len();
        assert!(bytes <= MOST_BYTES || file.ends_with(".png"), "{file} has {bytes} bytes");
        assert!(shown.contains(&format!("pictures/{file}")), "{file} stands on no page");
    });
}

#[test]
fn notebooks_are_small_and_listed() {
    let all = pages();
    let text = |name: &str| &all.iter().find(|page| page.name == name).expect("a page").text;
    let (readme, guide) = (text("README.md"), text("docs/src/guide/python.md"));
    let mut readers = 0;
    pages::below(&root().join("docs/notebooks"), &mut |path| {
        if path.extension().is_none_or(|own| own != "ipynb") {
            return;
        }
        let file = path.file_name().expect("a name").to_string_lossy();
        let bytes = fs::metadata(path).expect("it is there").len();
        assert!(bytes <= MOST_BYTES, "{file} has {bytes} bytes");
        assert!(guide.contains(&format!("`{file}`")), "docs/src/guide/python.md does not list {file}");
        readers += usize::from(readme.contains(&format!("docs/notebooks/{file}")));
    });
    assert_eq!(readers, 3, "README names a notebook for each of three readers");
}

/// Words that the documents do not use: each has a plainer one.
const UNUSED: [(&str, &str); 42] = [
    ("locked away", "held out"),
    ("locked release", "held-out release"),
    ("locked pressure", "held-out pressure"),
    ("locked gap", "held-out gap"),
    ("foretell", "predict"),
    ("foretells", "predicts"),
    ("foretold", "predicted"),
    ("nought", "zero"),
    ("judge", "validate, compare"),
    ("judges", "validates, compares"),
    ("judged", "validated, compared"),
    ("judged by", "validated on"),
    ("asked again", "repeated"),
    ("robbed", "removed from the catalogue"),
    ("stands above", "overrides"),
    ("stands on the command line", "is an option"),
    ("ends without a trace", "saves nothing"),
    ("made once more", "repeated"),
    ("speaks against", "caveats"),
    ("having to be worth", "must lower chi squared by"),
    ("bend to it", "absorb it"),
    ("from one end to the other", "throughout"),
    ("who was asked", "candidate effects"),
    ("for its unknowns", "after the penalty for parameters"),
    ("stands on its bound", "hit its bound"),
    ("one of several", "ambiguous, a class"),
    ("lends", "reuses"),
    ("lent", "reused"),
    ("became idle", "unnecessary"),
    ("hats", "basis"),
    ("cousin", "similar effect"),
    ("cousins", "similar effects"),
    ("foretelling", "prediction"),
    ("lock away", "hold out"),
    ("locks away", "holds out"),
    ("told apart", "separated"),
    ("hard to tell apart", "strongly correlated"),
    ("off what was believed", "from its prior"),
    ("of no interest", "nuisance parameters"),
    ("would have it beyond", "hit its bound"),
    ("next to nothing", "almost nothing"),
    ("in what they differ", "differences"),
];

/// Words in a sentence.
const MOST_WORDS: usize = 35;
/// Pages whose words are those of the program: its help, its pages of effects and its doc comments.
const GENERATED: [&str; 3] =
    ["docs/src/reference/commands.md", "docs/src/reference/effects.md", "docs/src/reference/schemas.md"];

#[test]
fn sentences_are_short_and_plain() {
    let mut wrong = Vec::new();
    let changelog = fs::read_to_string(root().join("CHANGELOG.md")).expect("it is there");
    let changelog = Page { name: "CHANGELOG.md".to_owned(), text: changelog };
    for page in pages().iter().chain([&changelog]).filter(|page| !GENERATED.contains(&page.name.as_str())) {
        wrong.extend(complaints(page));
    }
    assert!(wrong.is_empty(), "{} sentences:\n{}", wrong.len(), wrong.join("\n"));
}

/// Help texts and descriptions of JSON entries come from the code, and have none of these words either.
#[test]
fn generated_pages_have_no_unused_word() {
    let mut wrong = Vec::new();
    for page in pages().iter().filter(|page| GENERATED.contains(&page.name.as_str())) {
        let letters = |c: char| if c.is_alphanumeric() { c.to_ascii_lowercase() } else { ' ' };
        let text: String = page.text.chars().map(letters).collect();
        let plain = format!(" {} ", text.split_whitespace().collect::<Vec<_>>().join(" "));
        let used = UNUSED.iter().filter(|(unused, _)| plain.contains(&format!(" {unused} ")));
        wrong.extend(used.map(|(unused, instead)| format!("{}: `{unused}`, say {instead}", page.name)));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn complaints(page: &Page) -> Vec<String> {
    let mut wrong = Vec::new();
    for sentence in prose::sentences(&page.text) {
        let words = prose::words(&sentence);
        if words.len() > MOST_WORDS {
            wrong.push(format!("{}: {} words: {sentence}", page.name, words.len()));
        }
        let plain = format!(" {} ", words.join(" ").to_lowercase());
        for (unused, instead) in UNUSED {
            if plain.contains(&format!(" {unused} ")) {
                wrong.push(format!("{}: `{unused}`, say {instead}: {sentence}", page.name));
            }
        }
    }
    wrong
}

#[test]
fn a_long_sentence_and_an_unused_word_are_found() {
    let page = |text: &str| Page { name: "page.md".to_owned(), text: text.to_owned() };
    let long = "word ".repeat(36);
    assert_eq!(complaints(&page(&format!("Short. {long}\n{}.\n", "more ".repeat(2)))).len(), 1);
    assert_eq!(
        complaints(&page(&format!("```text\n{long}\n```\n\n    {long}\n"))),
        Vec::<String>::new(),
        "code"
    );
    assert_eq!(
        complaints(&page(&format!("| a | b |\n|---|---|\n| {} | {0} |\n", "word ".repeat(20)))).len(),
        0
    );
    assert_eq!(complaints(&page("- one\n- what was Locked\n  away, too\n")).len(), 1);
    assert_eq!(complaints(&page("A `judge` in code, a *judge* in prose.")).len(), 1);
}

//! Sentences of a page: without code, link targets and marks. Cells of tables and members of lists are sentences of
//! their own, and semicolons divide them.

/// What ends with a full stop, and no sentence.
const ABBREVIATIONS: [&str; 5] = ["eq.", "e.g.", "i.e.", "al.", "ch."];

/// All sentences of a page.
pub fn sentences(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for paragraph in paragraphs(text) {
        split(&plain(&paragraph.text), paragraph.is_listed, &mut found);
    }
    found
}

/// Words of a sentence, without what surrounds them.
pub fn words(sentence: &str) -> Vec<&str> {
    sentence
        .split_whitespace()
        .map(|word| word.trim_matches(|c: char| !c.is_alphanumeric()))
        .filter(|word| !word.is_empty())
        .collect()
}

struct Paragraph {
    text: String,
    /// A cell of a table or a member of a list.
    is_listed: bool,
}

fn paragraphs(text: &str) -> Vec<Paragraph> {
    let mut all: Vec<Paragraph> = Vec::new();
    let (mut is_open, mut in_list, mut in_comment) = (false, false, false);
    for line in text.split("\n```").step_by(2).flat_map(|part| part.lines().chain([""])) {
        let bare = line.trim_start();
        in_comment |= bare.starts_with("<!--");
        if in_comment {
            in_comment = !bare.contains("-->");
            is_open = false;
            continue;
        }
        let digits = bare.trim_start_matches(|c: char| c.is_ascii_digit());
        let is_member = ["- ", "* "].iter().any(|mark| bare.starts_with(mark))
            || (digits.len() < bare.len() && digits.starts_with(". "));
        if bare.is_empty() {
            is_open = false;
        } else if bare.starts_with('|') {
            let cells = bare.trim_matches('|').replace("\\|", "/");
            for cell in cells.split('|').filter(|cell| cell.contains(char::is_alphanumeric)) {
                all.push(Paragraph { text: cell.to_owned(), is_listed: true });
            }
            is_open = false;
        } else if bare.starts_with('#') {
            all.push(Paragraph { text: bare.trim_start_matches('#').to_owned(), is_listed: false });
            (is_open, in_list) = (false, false);
        } else if is_member {
            let text = bare.trim_start_matches(|c: char| c.is_ascii_digit() || "-*.".contains(c));
            all.push(Paragraph { text: text.to_owned(), is_listed: true });
            (is_open, in_list) = (true, true);
        } else if is_open {
            let last = all.last_mut().expect("it is open");
            last.text.push(' ');
            last.text.push_str(bare.trim_start_matches("> "));
        } else if line.starts_with("    ") && !in_list {
            // Code.
        } else {
            in_list &= line.starts_with("  ");
            all.push(Paragraph { text: bare.trim_start_matches("> ").to_owned(), is_listed: false });
            is_open = true;
        }
    }
    all
}

/// Text without code, targets of links, pictures and marks of emphasis.
fn plain(text: &str) -> String {
    let mut out = String::new();
    for (k, part) in text.split('`').enumerate() {
        out.push_str(if k % 2 == 1 { "CODE" } else { part });
    }
    while let Some(start) = out.find("](") {
        let end = out[start..].find(')').map_or(out.len(), |own| start + own + 1);
        out.replace_range(start..end, "");
    }
    out.replace(['*', '[', '!'], "")
}

/// Cuts text at full stops and question marks that end sentences.
fn split(text: &str, is_listed: bool, found: &mut Vec<String>) {
    let mut sentence = String::new();
    let mut words = text.split_whitespace().peekable();
    while let Some(word) = words.next() {
        sentence.push_str(word);
        sentence.push(' ');
        let bare = word.trim_end_matches(['"', ')']);
        let is_abbreviation = ABBREVIATIONS.iter().any(|own| word.to_lowercase().trim_matches('(') == *own);
        let stops = bare.ends_with(['.', '?']) && !is_abbreviation;
        let divides = is_listed && bare.ends_with(';');
        if stops || divides || words.peek().is_none() {
            found.push(std::mem::take(&mut sentence).trim().to_owned());
        }
    }
}

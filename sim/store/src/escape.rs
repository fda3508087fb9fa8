//! Characters that a reader would not see, or that a terminal would obey, made visible.
//!
//! A name in a recording, a key in a file or a file's own name may hold an escape sequence, a line break or an
//! override of the writing direction. Each such character is shown as `\u{1b}`.

use std::borrow::Cow;
use std::fmt::Write;
use std::path::Path;

use os_display::Quotable;

/// Whether a character acts on a terminal or on the lines around it instead of showing itself: control characters
/// (C0, DEL, C1), line and paragraph separators, and the controls of writing direction.
///
/// Source: Unicode 16, general category Cc; UAX #9, table 4, explicit formatting characters.
pub fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{2028}' | '\u{2029}')
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// The text on one line, with every hidden character shown as `\u{…}`.
pub fn escaped(text: &str) -> Cow<'_, str> {
    replaced(text, is_hidden, |c, to| write!(to, "{}", c.escape_unicode()))
}

/// The same, but line breaks and tabs stay: for texts of several lines.
pub fn escaped_lines(text: &str) -> Cow<'_, str> {
    replaced(
        text,
        |c| !matches!(c, '\n' | '\t') && is_hidden(c),
        |c, to| write!(to, "{}", c.escape_unicode()),
    )
}

/// JSON on one line with the same meaning, with every hidden character escaped.
pub fn escaped_json(json: &str) -> Cow<'_, str> {
    replaced(json, is_hidden, |c, to| write!(to, "\\u{:04x}", u32::from(c)))
}

/// A text as a basic string of TOML, on one line.
///
/// Source: TOML 1.0, section "String"; all hidden characters lie below U+10000, so `\uXXXX` holds each.
pub fn toml_string(text: &str) -> String {
    let plain = text.replace('\\', "\\\\").replace('"', "\\\"");
    format!("\"{}\"", replaced(&plain, is_hidden, |c, to| write!(to, "\\u{:04X}", u32::from(c))))
}

/// Signs with which spreadsheets begin a formula, wide forms among them, and blanks before which they look for one.
///
/// Source: OWASP, CSV Injection.
const FORMULA: [char; 10] = ['=', '+', '-', '@', '\t', '\r', '＝', '＋', '－', '＠'];

/// A word as a cell of CSV that no spreadsheet takes for a formula: an apostrophe precedes what begins like one.
/// Numbers must not go through this.
pub fn cell(word: &str) -> Cow<'_, str> {
    if word.trim_start_matches('\'').starts_with(FORMULA) {
        Cow::Owned(format!("'{word}"))
    } else {
        Cow::Borrowed(word)
    }
}

/// The word that [`cell`] was given.
pub fn from_cell(cell: &str) -> &str {
    let bare = cell.strip_prefix('\'').filter(|bare| bare.trim_start_matches('\'').starts_with(FORMULA));
    bare.unwrap_or(cell)
}

/// A path as one word of a shell (bash, zsh), to be copied into a command; all of it can be seen.
pub fn shell_word(path: &Path) -> String {
    let is_safe = |c: char| c.is_ascii_alphanumeric() || "_@%+=:,./-".contains(c);
    match path.to_str() {
        Some(text) if !text.is_empty() && text.chars().all(is_safe) => text.to_owned(),
        _ => path.quote().to_string(),
    }
}

fn replaced(
    text: &str,
    is_wrong: impl Fn(char) -> bool,
    write: impl Fn(char, &mut String) -> std::fmt::Result,
) -> Cow<'_, str> {
    let Some(first) = text.find(&is_wrong) else { return Cow::Borrowed(text) };
    let mut to = text[..first].to_owned();
    for c in text[first..].chars() {
        if is_wrong(c) {
            write(c, &mut to).expect("a string takes all");
        } else {
            to.push(c);
        }
    }
    Cow::Owned(to)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every character there is: what is shown is printable, JSON and TOML read it back.
    #[test]
    #[ignore = "long; .ci/thorough runs it"]
    fn every_character_is_shown_or_reads_back() {
        for c in (0..=0x10_ffff).filter_map(char::from_u32) {
            let text = format!("a{c}b");
            assert!(!escaped(&text).chars().any(is_hidden), "{c:?}");
            assert!(!escaped_lines(&text).chars().any(|c| !"\n\t".contains(c) && is_hidden(c)), "{c:?}");
            assert_eq!(escaped(&text) == text, !is_hidden(c), "{c:?}");
            let json = serde_json::to_string(&text).unwrap();
            let shown = escaped_json(&json);
            assert!(!shown.chars().any(is_hidden), "{c:?}");
            assert_eq!(serde_json::from_str::<String>(&shown).unwrap(), text, "{c:?}");
            let table: toml::Table = format!("key = {}", toml_string(&text)).parse().unwrap();
            assert_eq!(table["key"].as_str(), Some(text.as_str()), "{c:?}");
        }
        assert_eq!(escaped("\u{1b}[31mred\u{202e}\n"), "\\u{1b}[31mred\\u{202e}\\u{a}");
        assert_eq!(escaped_lines("a\nb\u{9b}"), "a\nb\\u{9b}");
        assert_eq!(toml_string("a\"\\\nb"), r#""a\"\\\u000Ab""#);
    }

    #[test]
    fn no_word_is_a_formula_and_each_reads_back() {
        for word in [
            "=1+1", "+1", "-x", "@SUM(A1)", "\t=1", "＝1", "'=1", "''-", "'", "'a", "a=b", "", "'", "ä",
            "' =",
        ] {
            let cell = cell(word);
            assert!(!cell.starts_with(FORMULA), "{word:?}");
            assert_eq!(from_cell(&cell), word);
            assert_eq!(cell != word, word.trim_start_matches('\'').starts_with(FORMULA), "{word:?}");
        }
    }

    /// A shell reads back what was quoted, byte for byte.
    #[cfg(unix)]
    #[test]
    fn a_shell_reads_a_quoted_path_back() {
        use std::ffi::OsStr;
        use std::os::unix::ffi::OsStrExt;
        use std::process::Command;

        for name in [
            &b"outputs/map"[..],
            b"my sweep",
            b"o'neil \"x\" $HOME `id`",
            b"a\nb\t\x1b[31m",
            b"caf\xe9\x01f",
            b"#50%;rm -rf *",
            b"~",
            b"",
        ] {
            let quoted = shell_word(Path::new(OsStr::from_bytes(name))).to_string();
            assert!(!quoted.contains(|c: char| c.is_control()), "{quoted:?}");
            let script = format!("printf %s {quoted}");
            let printed = Command::new("bash").args(["-c", &script]).output().expect("bash runs").stdout;
            assert_eq!(printed, name, "{quoted}");
        }
    }
}

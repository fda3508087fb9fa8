//! What moves on a page: uPlot, our own script, and their data. The policy of a page admits these two scripts by
//! their hashes and nothing else; data is JSON in which no markup can begin.

use std::fmt::Write;
use std::sync::LazyLock;

use efam_store::sha::sha256_in_base64;
use serde_json::Value;

use crate::page::Family;
use crate::picture::Rods;
use crate::picture::chart::{self, Chart};

/// uPlot 1.6.32 as npm has it; its licence goes in with it.
const UPLOT: &str = include_str!("uplot/uPlot.iife.min.js");
const LICENCE: &str = include_str!("uplot/LICENSE");
/// How its charts look.
pub const STYLE: &str = include_str!("uplot/uPlot.min.css");
/// Our own, from all files.
const OWN: &str = concat!(
    "(() => {\n'use strict';\n",
    include_str!("script/marks.js"),
    include_str!("script/charts.js"),
    include_str!("script/figures.js"),
    include_str!("script/rods.js"),
    include_str!("script/family.js"),
    "})();\n"
);

/// What a browser may load without a script: nothing.
const CLOSED: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";
/// With both scripts: them, by their hashes.
static OPEN: LazyLock<String> = LazyLock::new(|| {
    let [uplot, own] = [UPLOT, OWN].map(sha256_in_base64);
    format!("{CLOSED}; script-src 'sha256-{uplot}' 'sha256-{own}'")
});

/// The policy of a page.
pub fn policy(is_live: bool) -> &'static str {
    if is_live { &OPEN } else { CLOSED }
}

/// The scripts of a page, at its end.
pub fn scripts(is_live: bool) -> String {
    if is_live {
        format!("<!-- uPlot:\n{LICENCE}-->\n<script>{UPLOT}</script>\n<script>{OWN}</script>\n")
    } else {
        String::new()
    }
}

/// Data of charts that can be read off, and whether they are to be chosen from: they have the same axes. Nothing of a
/// picture that is no chart over axes.
pub fn charts(charts: &[Chart]) -> (String, bool) {
    let is_plain = charts.iter().all(|chart| chart.rows.is_none());
    if charts.iter().all(|chart| chart.why.is_some()) || !is_plain {
        return (String::new(), false);
    }
    let all: Value = charts.iter().map(chart::json).collect();
    let has_same_axes = |pair: &[Chart]| pair[0].x == pair[1].x && pair[0].y == pair[1].y;
    let is_choice = charts.len() > 1 && charts.windows(2).all(has_same_axes);
    (data("charts", &all), is_choice)
}

/// Data of the cases of a page.
pub fn family(family: &Family) -> String {
    data("family", &family.json())
}

/// Data of rods in motion.
pub fn rods(rods: &Rods) -> String {
    data("rods", &rods.json())
}

fn data(class: &str, value: &Value) -> String {
    let mut text = String::new();
    let _ = writeln!(text, "<script type=\"application/json\" class=\"{class}\">{}</script>", quiet(value));
    text
}

/// JSON without a letter with which markup begins or a line ends: they can only be in its strings, and there an escape
/// means the same.
fn quiet(value: &Value) -> String {
    let text = value.to_string();
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '<' | '>' | '&' | '\'' | '\u{2028}' | '\u{2029}' => {
                let _ = write!(out, "\\u{:04x}", u32::from(letter));
            }
            letter => out.push(letter),
        }
    }
    out
}

/// What a page has beside our scripts and their data, which have no tag in them.
#[cfg(test)]
pub fn stripped(page: &str) -> String {
    let text = page.replace(&scripts(true), "");
    let mut parts = text.split("<script type=\"application/json\" class=\"");
    let first = parts.next().unwrap_or_default().to_owned();
    let rest = parts.map(|part| part.split_once("</script>").expect("data ends").1);
    first + &rest.collect::<String>()
}

#[cfg(test)]
mod tests {
    use efam_store::sha::sha256;
    use serde_json::json;

    use super::*;

    /// What was looked at is what goes into pages: the files of npm's uplot-1.6.32.tgz, whose sha512 is
    /// `KIMVnG68zvu5XXUbC4LQEPnhwOxBuLyW1AHtpm6IKTXImkbLgkMy+jabjLgSLMasNuGGzQm/ep3tOkyTxpiQIw==`.
    #[test]
    fn uplot_is_the_one_that_was_published() {
        let hashes = [UPLOT, STYLE, LICENCE].map(|text| sha256(text.as_bytes()));
        assert_eq!(hashes, PUBLISHED);
    }

    const PUBLISHED: [&str; 3] = [
        "19c8d4c6ad88929a79f4ae49d6f7161566dfd0ba3d15cc495e974f787eb78f1f",
        "df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04",
        "8f989229699b4fe2f1a0432d0e9edc338a8a911e250e2d1b01ecd770a5f5b1bd",
    ];

    #[test]
    fn data_begins_no_markup_and_reads_back_as_it_was() {
        let value = json!({ "</script><script>alert(1)//": ["<!--", "a & 'b'\u{2028}\"c\""] });
        let text = quiet(&value);
        assert!(!text.contains(['<', '>', '&', '\'', '\u{2028}']), "{text}");
        assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), value);
    }

    /// A script ends where its element ends, and a comment where it should.
    #[test]
    fn no_script_ends_early() {
        assert!([UPLOT, OWN].iter().all(|text| !text.contains("</script") && !text.contains("<!--")));
        assert!(!LICENCE.contains("--"));
    }
}

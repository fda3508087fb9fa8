//! What surrounds the results on every page: after them what should be known before they are used, last the
//! facts of the run.

use std::time::SystemTime;

use efam_experiments::summary::Versions;
use efam_store::folder;

use crate::Request;
use crate::page::{Page, Table};

/// What should be known before a result is used. A part that is `None` is one that such a result never has;
/// an empty one is said to be empty.
#[derive(Clone, Debug, Default)]
pub struct BeforeUse {
    /// What holds of all results of this kind.
    pub note: Option<String>,
    /// What the run itself warns of.
    pub warnings: Vec<String>,
    /// Releases that took no part in the fit, and validate it.
    pub held_out: Option<Vec<String>>,
    /// What lies outside the data that it rests on.
    pub extrapolated: Option<Vec<String>>,
    /// Samples that do not count.
    pub masked: Option<Masked>,
    /// What is taken to be so, and was not measured.
    pub assumed: Vec<String>,
}

impl BeforeUse {
    /// How many caveats there are, of those that a reader must know of.
    fn in_a_line(&self) -> String {
        let count = |count: usize, what: &str| match count {
            0 => None,
            1 => Some(format!("1 {what}")),
            count => Some(format!("{count} {what}s")),
        };
        let extrapolated = self.extrapolated.as_ref().map_or(0, Vec::len);
        let counts = [
            count(self.warnings.len(), "warning"),
            count(extrapolated, "extrapolation"),
            count(self.assumed.len(), "assumption"),
        ];
        match counts.into_iter().flatten().collect::<Vec<_>>() {
            none if none.is_empty() => "no warnings".to_owned(),
            some => some.join(", "),
        }
    }
}

/// Samples that do not count, a row each release or marker.
#[derive(Clone, Debug, Default)]
pub struct Masked {
    /// What the numbers are.
    pub caption: &'static str,
    /// Heads of the columns.
    pub heads: &'static [&'static str],
    /// Cells.
    pub rows: Vec<Vec<String>>,
}

impl Page {
    /// The caveats of a page, below what they are of; the first lines say how many there are.
    pub fn before_use(&mut self, of: &BeforeUse) {
        self.section("Before you use this");
        self.caveats = Some((of.in_a_line(), self.sections.len()));
        if let Some(note) = &of.note {
            self.text(note);
        }
        // "None." above a caveat would be read as the all-clear.
        let is_extrapolated = of.extrapolated.as_ref().is_some_and(|all| !all.is_empty());
        let none = if is_extrapolated { "None except the extrapolations below." } else { "None." };
        self.part("Warnings", none, &of.warnings);
        if let Some(held_out) = &of.held_out {
            self.heading("Held-out releases");
            if held_out.is_empty() {
                self.text("No data were held out: not validated.")
            } else {
                self.text("These releases took no part in the fit, and validate it:")
            }
            self.list(held_out);
        }
        if let Some(extrapolated) = &of.extrapolated {
            self.part("Extrapolated", "Nothing.", extrapolated);
        }
        if let Some(masked) = &of.masked {
            self.heading("Lost, masked or held back");
            if masked.rows.is_empty() {
                self.text("No sample.");
            }
            self.table(&Table { caption: masked.caption, heads: masked.heads, rows: masked.rows.clone() });
        }
        self.part("Assumed", "Nothing.", &of.assumed);
    }

    fn part(&mut self, title: &str, nothing: &str, items: &[String]) {
        self.heading(title);
        match items {
            [] => self.text(nothing),
            items => self.list(items),
        }
    }

    /// The last section of every page: by which command, from what, when; with `own` before the hashes.
    pub fn facts_of(&mut self, request: &Request, written: SystemTime, own: Vec<(String, String)>) {
        self.section("Facts of this run");
        let Versions { efam, rustc, target } = Versions::here();
        let mut facts = vec![
            ("command".to_owned(), request.argv.join(" ")),
            ("program".to_owned(), format!("efam {efam}, {rustc}, {target}")),
            ("written, UTC".to_owned(), folder::utc(written)),
            ("wall time".to_owned(), format!("{:.1} s", request.wall_time_s)),
        ];
        facts.extend(own);
        let hash = |(file, hash): (&String, &String)| (format!("SHA-256 of {file}"), hash.clone());
        facts.extend(request.input_hashes.iter().map(hash));
        self.facts(&facts);
    }
}

/// Warnings of extrapolation, and the others.
pub fn extrapolated(warnings: &[String]) -> (Vec<String>, Vec<String>) {
    warnings.iter().cloned().partition(|warning| warning.contains("extrapolated"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each part says what it holds, or that it holds nothing; what does not apply is not there.
    #[test]
    fn nothing_is_said_where_nothing_is_and_what_does_not_apply_is_left_out() {
        let page = |of: &BeforeUse| {
            let mut page = Page::new("a", "b", "c");
            page.before_use(of);
            page.finish()
        };
        let empty = page(&BeforeUse::default());
        assert!(empty.contains("<h3>Warnings</h3>\n<p>None.</p>") && empty.contains("<p>Nothing.</p>"));
        assert!(!empty.contains("Extrapolated") && !empty.contains("Held-out") && !empty.contains("masked"));
        let full = page(&BeforeUse {
            warnings: vec!["hot".to_owned()],
            extrapolated: Some(vec!["far".to_owned()]),
            held_out: Some(vec!["kept".to_owned()]),
            masked: Some(Masked { caption: "lost", heads: &["a"], rows: vec![vec!["gone".to_owned()]] }),
            assumed: vec!["level".to_owned()],
            note: Some("mind".to_owned()),
        });
        let extrapolated = Some(vec!["far".to_owned()]);
        let caveat = page(&BeforeUse { extrapolated, ..BeforeUse::default() });
        assert!(!caveat.contains("None.") && caveat.contains("None except the extrapolations"), "{caveat}");
        assert!(full.contains("<a href=\"#s1\">1 warning, 1 extrapolation, 1 assumption</a>"), "{full}");
        assert!(empty.contains("<a href=\"#s1\">no warnings</a>"), "{empty}");
        for word in ["hot", "far", "kept", "gone", "level", "mind"] {
            assert!(full.contains(&format!(">{word}<")), "{word}: {full}");
        }
        assert!(!full.contains("None.") && !full.contains("Nothing."));
    }
}

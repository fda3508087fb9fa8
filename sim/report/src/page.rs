//! One page for people: HTML that needs nothing beside it and no network, and says all without a script. All text is
//! escaped here; only pictures go in as they are.

mod around;
mod family;
mod script;

use std::fmt::Write;

use crate::picture::{Picture, Rods, dotted};

#[cfg(test)]
pub(crate) use script::stripped;

pub use around::{BeforeUse, Masked, extrapolated};
pub use family::Family;

/// The page of a folder.
pub const REPORT: &str = "report.html";

/// How it looks, light and dark, wide and narrow.
const STYLE: &str = include_str!("page.css");

/// A page in the making.
#[derive(Debug)]
pub struct Page {
    title: String,
    sections: Vec<String>,
    /// What the section of caveats holds, in a line, and its number.
    caveats: Option<(String, usize)>,
    lead: String,
    body: String,
    /// Whether charts or rods need the scripts.
    is_live: bool,
}

/// A table: what it holds, the heads of its columns, its rows, each led by what it is about.
pub struct Table<'a> {
    /// What it holds.
    pub caption: &'a str,
    /// Heads of the columns.
    pub heads: &'a [&'a str],
    /// Cells, row by row.
    pub rows: Vec<Vec<String>>,
}

impl Page {
    /// A page that says first what matters most: a word, and a paragraph.
    pub fn new(title: &str, word: &str, lead: &str) -> Self {
        let (word, lead) = (escaped(word), escaped(lead));
        let lead = format!("<p class=\"lead\"><strong>{word}</strong> {lead}</p>\n");
        Self {
            title: title.to_owned(),
            sections: Vec::new(),
            caveats: None,
            lead,
            body: String::new(),
            is_live: false,
        }
    }

    /// Begins a section.
    pub fn section(&mut self, title: &str) {
        if !self.sections.is_empty() {
            self.body += "</section>\n";
        }
        self.sections.push(title.to_owned());
        let n = self.sections.len();
        let title = escaped(title);
        let _ = writeln!(self.body, "<section aria-labelledby=\"s{n}\">\n<h2 id=\"s{n}\">{title}</h2>");
    }

    /// A heading within a section.
    pub fn heading(&mut self, title: &str) {
        let _ = writeln!(self.body, "<h3>{}</h3>", escaped(title));
    }

    /// A paragraph.
    pub fn text(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p>{}</p>", escaped(text));
    }

    /// A list; nothing without items.
    pub fn list(&mut self, items: &[String]) {
        if items.is_empty() {
            return;
        }
        let items: String = items.iter().map(|item| format!("<li>{}</li>\n", escaped(item))).collect();
        let _ = writeln!(self.body, "<ul>\n{items}</ul>");
    }

    /// Names with their meanings.
    pub fn facts(&mut self, facts: &[(String, String)]) {
        let row = |(name, value): &(String, String)| {
            format!("<dt>{}</dt><dd>{}</dd>\n", escaped(name), escaped(value))
        };
        let _ = writeln!(self.body, "<dl>\n{}</dl>", facts.iter().map(row).collect::<String>());
    }

    /// Paragraphs, each led by what it is about.
    pub fn remarks(&mut self, facts: &[(&str, &str)]) {
        for (name, text) in facts {
            let _ = writeln!(self.body, "<p><strong>{}:</strong> {}</p>", escaped(name), escaped(text));
        }
    }

    /// A table; nothing without rows.
    pub fn table(&mut self, table: &Table) {
        if table.rows.is_empty() {
            return;
        }
        let caption = escaped(table.caption);
        let _ = write!(
            self.body,
            "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\n<table>\n<caption>{caption}</caption>\n<thead><tr>"
        );
        for head in table.heads {
            let _ = write!(self.body, "<th scope=\"col\">{}</th>", escaped(head));
        }
        self.body += "</tr></thead>\n<tbody>\n";
        for row in &table.rows {
            self.body += "<tr>";
            for (k, cell) in row.iter().enumerate() {
                let text = escaped(cell);
                // A number, or the two ends of an interval.
                let is_number = cell.split(" to ").all(|part| part.parse::<f64>().is_ok());
                self.body += &match (k, is_number) {
                    (0, _) => format!("<th scope=\"row\">{text}</th>"),
                    (_, true) => format!("<td class=\"number\">{text}</td>"),
                    (_, false) => format!("<td>{text}</td>"),
                };
            }
            self.body += "</tr>\n";
        }
        self.body += "</tbody>\n</table>\n</div>\n";
    }

    /// A table that is folded away under some words.
    pub fn folded(&mut self, words: &str, table: &Table) {
        let _ = writeln!(self.body, "<details>\n<summary>{}</summary>", escaped(words));
        self.table(table);
        self.body += "</details>\n";
    }

    /// Pictures beside one another, as far as there is room.
    pub fn figures<'a>(&mut self, pictures: impl IntoIterator<Item = &'a Picture>) {
        self.body += "<div class=\"figures\">\n";
        pictures.into_iter().for_each(|picture| self.figure(picture));
        self.body += "</div>\n";
    }

    /// A picture.
    pub fn figure(&mut self, picture: &Picture) {
        let (title, caption) = (escaped(&picture.title), escaped(&picture.caption));
        let svg = dotted(picture.svg().trim()).replacen(
            "<svg ",
            &format!("<svg role=\"img\" aria-label=\"{title}\" "),
            1,
        );
        let (data, choice) = script::charts(&picture.drawing.charts);
        self.is_live |= !data.is_empty();
        let choice = if choice { " data-choice" } else { "" };
        let _ = writeln!(
            self.body,
            "<figure{choice}>\n<figcaption><strong>{title}</strong> {caption}</figcaption>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Picture: {title}\">{svg}</div>\n{data}</figure>"
        );
    }

    /// Rods in motion of several releases, beside one another as far as there is room.
    pub fn all_rods(&mut self, all: &[Rods]) {
        self.body += "<div class=\"figures\">\n";
        all.iter().for_each(|rods| self.rods(rods));
        self.body += "</div>\n";
    }

    /// Rods in motion, which only a script can show.
    pub fn rods(&mut self, rods: &Rods) {
        self.is_live = true;
        let (title, caption) = (escaped(&rods.title), escaped(&rods.caption));
        let data = script::rods(rods);
        let _ = writeln!(
            self.body,
            "<figure class=\"motion\" hidden>\n<figcaption><strong>{title}</strong> {caption}</figcaption>\n{data}</figure>"
        );
    }

    /// Sliders that choose among the cases of the page, for all charts and rods below them; nothing without a choice.
    pub fn family(&mut self, family: &Family) {
        if family.is_empty() {
            return;
        }
        self.is_live = true;
        let data = script::family(family);
        let _ = writeln!(
            self.body,
            "<div class=\"family\" role=\"group\" aria-label=\"Cases of this page\" hidden>\n{data}</div>"
        );
    }

    /// The page.
    pub fn finish(mut self) -> String {
        if !self.sections.is_empty() {
            self.body += "</section>\n";
        }
        let title = escaped(&self.title);
        let entry = |(k, section): (usize, &String)| {
            format!("<li><a href=\"#s{}\">{}</a></li>\n", k + 1, escaped(section))
        };
        // Caveats are below what they concern: the first lines say how many there are, and lead to them.
        let caveats = self.caveats.map_or(String::new(), |(words, section)| {
            format!("<p>Before you use this: <a href=\"#s{section}\">{}</a>.</p>\n", escaped(&words))
        });
        let (policy, scripts) = (script::policy(self.is_live), script::scripts(self.is_live));
        let style = if self.is_live { [script::STYLE, STYLE].concat() } else { STYLE.to_owned() };
        let contents: String = self.sections.iter().enumerate().map(entry).collect();
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
             <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n<style>\n{style}</style>\n</head>\n\
             <body>\n<header>\n<h1>{title}</h1>\n</header>\n\
             <nav aria-label=\"Sections\">\n<ul>\n{contents}</ul>\n</nav>\n<main>\n{}{caveats}{}</main>\n{scripts}</body>\n</html>\n",
            self.lead, self.body
        )
    }
}

/// Text as it may be between tags and in quoted attributes.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            letter => out.push(letter),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{self, Drawing};

    /// Titles, labels, keys and words of a chart are data, and data begins no tag.
    #[test]
    fn no_name_ends_the_data_of_a_chart() {
        let page = |text: &str| {
            let drawing = picture::tests::chart(text);
            let picture =
                Picture { name: String::new(), title: String::new(), caption: String::new(), drawing };
            let mut page = Page::new("a", "b", "c");
            page.figure(&picture);
            page.family(
                &Family::default()
                    .by(text, text, &[1.0, 2.0])
                    .by_words(text, &[text.to_owned(), String::new()]),
            );
            page.finish()
        };
        let (evil, plain) = (page("</script><script>alert('&')</script>"), page("plain"));
        for sign in ["<", ">", "<script"] {
            assert_eq!(evil.matches(sign).count(), plain.matches(sign).count(), "{sign}");
        }
        assert!(plain.matches("<script").count() == 4 && plain.contains("script-src 'sha256-"));
        let without = Page::new("a", "b", "c").finish();
        assert!(!without.contains("<script") && !without.contains("script-src"));
    }

    /// Whatever a name holds, it adds no tag to the page.
    #[test]
    fn no_text_becomes_markup() {
        let evil = "\"><script>alert('&')</script>";
        let page = |text: &str| {
            let mut page = Page::new(text, text, text);
            page.section(text);
            page.heading(text);
            page.text(text);
            page.list(&[text.to_owned()]);
            page.facts(&[(text.to_owned(), text.to_owned())]);
            page.remarks(&[(text, text)]);
            let rows = || vec![vec![text.to_owned(), text.to_owned()]];
            page.table(&Table { caption: text, heads: &[text], rows: rows() });
            page.folded(text, &Table { caption: text, heads: &[text], rows: rows() });
            let (title, caption) = (text.to_owned(), text.to_owned());
            page.figures(&[Picture {
                name: String::new(),
                title,
                caption,
                drawing: Drawing { svg: "<svg ></svg>".to_owned(), charts: Vec::new() },
            }]);
            page.finish()
        };
        let (evil, plain) = (page(evil), page("plain"));
        for sign in ['<', '>', '"', '\''] {
            assert_eq!(evil.matches(sign).count(), plain.matches(sign).count(), "{sign}");
        }
        assert_eq!(plain.matches("<section").count(), plain.matches("</section>").count());
    }
}

//! The documents, their blocks, headings and links.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// A document.
pub struct Page {
    /// Its path from the root.
    pub name: String,
    pub text: String,
}

/// A fenced block.
pub struct Block<'a> {
    pub language: &'a str,
    /// The word after the language.
    pub word: Option<&'a str>,
    pub text: &'a str,
}

impl Page {
    pub fn blocks(&self) -> impl Iterator<Item = Block<'_>> {
        let parts: Vec<_> = self.text.split("\n```").collect();
        assert!(parts.len() % 2 == 1, "{}: a block does not end", self.name);
        parts.into_iter().skip(1).step_by(2).map(|part| {
            let (head, text) = part.split_once('\n').unwrap_or((part, ""));
            let (language, word) = head.split_once(' ').map_or((head, None), |(own, word)| (own, Some(word)));
            Block { language, word, text }
        })
    }
}

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// A path from the root, with slashes.
pub fn name(path: &Path) -> String {
    path.strip_prefix(root()).expect("below the root").to_string_lossy().replace('\\', "/")
}

/// Every file below a folder.
pub fn below(folder: &Path, see: &mut dyn FnMut(&Path)) {
    for entry in fs::read_dir(folder).expect("a folder of the project") {
        let path = entry.expect("an entry").path();
        // Packages that the peers and the fuzzer bring.
        let is_foreign = path.file_name().is_some_and(|own| own == "target" || own == "node_modules");
        match path.is_dir() {
            true if is_foreign => {}
            true => below(&path, see),
            false => see(&path),
        }
    }
}

pub fn pages() -> Vec<Page> {
    let mut paths =
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"].map(|name| root().join(name)).to_vec();
    for folder in ["docs/src", "docs/decisions"] {
        below(&root().join(folder), &mut |path| {
            if path.extension().is_some_and(|own| own == "md") {
                paths.push(path.to_owned());
            }
        });
    }
    paths.sort();
    paths
        .iter()
        .map(|path| Page { name: name(path), text: fs::read_to_string(path).expect("text") })
        .collect()
}

/// Targets of links and pictures, outside of fenced blocks.
pub fn links(text: &str) -> impl Iterator<Item = &str> {
    let prose = text.split("\n```").step_by(2);
    prose.flat_map(|part| part.split("](").skip(1).filter_map(|own| own.split(')').next()))
}

/// The anchors of a page, as mdBook and code hosts make them from headings.
pub fn headings(text: &str) -> BTreeSet<String> {
    let lines = text.split("\n```").step_by(2).flat_map(str::lines).filter(|line| line.starts_with('#'));
    lines
        .map(|line| {
            let title = line.trim_start_matches('#').trim().to_lowercase();
            let kept = title.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
            kept.map(|c| if c == ' ' { '-' } else { c }).collect()
        })
        .collect()
}

//! Letters as outlines, from a font of the system. The door to ab_glyph.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use ab_glyph::{Font as _, FontVec, OutlineCurve};
use efam_store::input;

/// Fonts by the beginning of their files' names, the first that is there.
const FONTS: [&str; 5] = ["Helvetica.", "Arial.", "arial.", "DejaVuSans.", "LiberationSans-Regular."];
/// Folders of fonts: of Linux, macOS and Windows.
const FOLDERS: [&str; 5] = [
    "/usr/share/fonts",
    "/usr/local/share/fonts",
    "/System/Library/Fonts",
    "/Library/Fonts",
    "C:\\Windows\\Fonts",
];
/// How deep fonts lie below these.
const DEPTH: usize = 4;
/// Longest file of a font that is read, bytes.
const MOST_BYTES: u64 = 64 << 20;

/// A font.
pub struct Font(FontVec);

/// A part of an outline, in pixels from the beginning of the line of text, downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// A new contour.
    Move([f32; 2]),
    /// A straight line.
    Line([f32; 2]),
    /// A curve with one handle.
    Quad([f32; 2], [f32; 2]),
    /// A curve with two handles.
    Cubic([f32; 2], [f32; 2], [f32; 2]),
}

impl Font {
    /// The font of the system that pictures are drawn with, which is looked for once; none if none of them is there.
    pub fn of_system() -> Option<&'static Font> {
        static FONT: LazyLock<Option<Font>> = LazyLock::new(Font::found);
        FONT.as_ref()
    }

    fn found() -> Option<Font> {
        let files: Vec<PathBuf> =
            FOLDERS.iter().flat_map(|folder| fonts_below(Path::new(folder), DEPTH)).collect();
        FONTS.iter().find_map(|name| {
            let is_own =
                |file: &&PathBuf| file.file_name().is_some_and(|own| own.to_string_lossy().starts_with(name));
            let file = files.iter().find(is_own)?;
            let (mut open, length) = input::whole(file).ok().filter(|(_, length)| *length <= MOST_BYTES)?;
            let mut bytes = Vec::with_capacity(length as usize);
            open.read_to_end(&mut bytes).ok()?;
            // Of a collection the first.
            FontVec::try_from_vec_and_index(bytes, 0).ok().map(Font)
        })
    }

    /// Outlines of a line of text whose letters are `size` pixels high, and its length.
    pub fn outlines(&self, text: &str, size: f32) -> (Vec<Part>, f32) {
        let scale = size / self.0.units_per_em().unwrap_or(1000.0);
        let mut parts = Vec::new();
        let mut at = 0.0;
        for letter in text.chars() {
            let glyph = self.0.glyph_id(letter);
            let place = |point: ab_glyph::Point| [at + scale * point.x, -scale * point.y];
            let mut last = None;
            for curve in self.0.outline(glyph).map(|outline| outline.curves).unwrap_or_default() {
                let (begin, part, end) = match curve {
                    OutlineCurve::Line(begin, end) => (begin, Part::Line(place(end)), end),
                    OutlineCurve::Quad(begin, handle, end) => {
                        (begin, Part::Quad(place(handle), place(end)), end)
                    }
                    OutlineCurve::Cubic(begin, first, second, end) => {
                        (begin, Part::Cubic(place(first), place(second), place(end)), end)
                    }
                };
                if last != Some(begin) {
                    parts.push(Part::Move(place(begin)));
                }
                parts.push(part);
                last = Some(end);
            }
            at += scale * self.0.h_advance_unscaled(glyph);
        }
        (parts, at)
    }
}

fn fonts_below(folder: &Path, depth: usize) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        if matches!(ending.as_deref(), Some("ttf" | "ttc" | "otf")) {
            found.push(path);
        } else if depth > 0 && path.is_dir() {
            found.extend(fonts_below(&path, depth - 1));
        }
    }
    found
}

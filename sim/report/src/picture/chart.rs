//! What a chart shows, as data: axes, keys and marks. Both the SVG and the interactive chart of a page are drawn
//! from it, and from nothing else.

mod json;

use std::collections::BTreeMap;
use std::ops::Range;

use plotters::prelude::*;

use crate::picture::pixels::px;

pub use json::{column, column_in, json, look};

/// One chart.
#[derive(Clone, Debug)]
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// What lies along it.
    pub x: Scale,
    /// What it shows of that.
    pub y: Scale,
    /// Whether a millimetre is as long on one axis as on the other.
    pub is_equal: bool,
    /// Width of the axes over their height.
    pub aspect: f64,
    /// What lines and dots mean.
    pub keys: Vec<Key>,
    /// Rows from top to bottom, the `k`-th at y = -k, instead of an axis.
    pub rows: Option<Rows>,
    /// What is drawn, in this order.
    pub marks: Vec<Mark>,
    /// The cases of the page's family that marks belong to, by the marks' places.
    pub cases: BTreeMap<usize, Cases>,
    /// Why it shows nothing.
    pub why: Option<String>,
}

/// Range and label of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// From its left or lower end to the other.
    pub range: Range<f64>,
    /// What it is, with its unit.
    pub label: String,
}

/// Rows of a chart, and width of their names' margin, pixels; without names it is zero.
#[derive(Clone, Debug)]
pub struct Rows {
    /// From top to bottom.
    pub rows: Vec<Row>,
    /// Width, pixels.
    pub names: f64,
}

/// The cases that a mark belongs to.
#[derive(Clone, Debug, PartialEq)]
pub enum Cases {
    /// One.
    One(usize),
    /// One, and the mark is only there while a reader chooses it: a picture that is not interactive omits it.
    Chosen(usize),
    /// One for each of its points.
    Each(Vec<usize>),
}

/// A point of a chart.
pub type Point = (f64, f64);

/// Something drawn; widths and radii are in pixels.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "each variant says what its fields are")]
pub enum Mark {
    /// A line through points; at these times, s, if it is a path.
    Line { points: Vec<Point>, stroke: Stroke, times: Option<Vec<f64>> },
    /// Filled dots of a radius in pixels.
    Dots { points: Vec<Point>, stroke: Stroke, radius: f64 },
    /// Rings of a radius in pixels.
    Rings { points: Vec<Point>, stroke: Stroke, radius: f64 },
    /// A filled band: x, lower and upper end.
    Band { points: Vec<(f64, [f64; 2])>, stroke: Stroke },
    /// A shaded strip.
    Strip { x: Range<f64>, y: Range<f64> },
    /// A cell of a map, and the number that it represents.
    Cell { x: Range<f64>, y: Range<f64>, color: RGBColor, value: f64 },
    /// A small number about a point.
    Number { at: Point, text: String, color: RGBColor },
    /// Text that begins at a point.
    Text { at: Point, text: String },
}

/// How a line looks; widths and dashes in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Colour.
    pub color: RGBColor,
    /// Opacity.
    pub alpha: f64,
    /// Width.
    pub width: f64,
    /// Length of dashes and of gaps.
    pub dash: Option<(f64, f64)>,
}

impl Stroke {
    /// A solid line.
    pub fn new(color: RGBColor, width: f64) -> Self {
        Self { color, alpha: 1.0, width, dash: None }
    }

    /// A dashed line.
    pub fn dashed(color: RGBColor, width: f64, dash: f64, gap: f64) -> Self {
        Self { dash: Some((dash, gap)), ..Self::new(color, width) }
    }

    /// As plotters has it.
    pub fn style(&self) -> ShapeStyle {
        self.color.mix(self.alpha).stroke_width(px(self.width) as u32)
    }
}

/// What a line or dot means.
#[derive(Clone, Debug)]
pub struct Key {
    /// Its look.
    pub stroke: Stroke,
    /// Its shape.
    pub shape: Shape,
    /// Its meaning.
    pub text: String,
}

/// How the subject of a key is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A line.
    Line,
    /// A dot.
    Dot,
    /// A ring.
    Ring,
    /// A filled band.
    Band,
}

/// One row of a chart of rows: its name, and a smaller line below it.
#[derive(Clone, Debug)]
pub struct Row {
    /// What the row is about.
    pub name: String,
    /// What should be known of it; may be empty.
    pub note: String,
}

impl Key {
    /// Of a line.
    pub fn line(stroke: Stroke, text: impl Into<String>) -> Self {
        Self { stroke, shape: Shape::Line, text: text.into() }
    }

    /// Of dots.
    pub fn dot(stroke: Stroke, text: impl Into<String>) -> Self {
        Self { stroke, shape: Shape::Dot, text: text.into() }
    }

    /// Of rings.
    pub fn ring(stroke: Stroke, text: impl Into<String>) -> Self {
        Self { stroke, shape: Shape::Ring, text: text.into() }
    }

    /// Of a filled band.
    pub fn band(stroke: Stroke, text: impl Into<String>) -> Self {
        Self { stroke, shape: Shape::Band, text: text.into() }
    }
}

//! Lines, areas and letters as pixels. The door to tiny-skia.

use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform};

use super::font::{Font, Part};

/// A colour: red, green, blue, and how opaque it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ink {
    /// Red, green, blue.
    pub color: [u8; 3],
    /// From 0, which is invisible, to 1.
    pub opacity: f32,
}

impl Ink {
    /// Opaque.
    pub const fn new(color: [u8; 3]) -> Ink {
        Ink { color, opacity: 1.0 }
    }

    fn paint(self) -> Paint<'static> {
        let [red, green, blue] = self.color;
        let alpha = (255.0 * self.opacity.clamp(0.0, 1.0)).round() as u8;
        let mut paint = Paint { anti_alias: true, ..Paint::default() };
        paint.set_color_rgba8(red, green, blue, alpha);
        paint
    }
}

/// A white sheet that is drawn on.
pub struct Canvas {
    pixels: Pixmap,
    /// From units of the drawing to pixels.
    scale: f32,
}

/// Where a line of text begins, and which way it runs.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The point that is given.
    pub at: [f32; 2],
    /// Share of the text that lies before it: 0, a half, or 1.
    pub anchor: f32,
    /// Downwards from there to the baseline of the letters.
    pub below: f32,
    /// Degrees about the point, clockwise.
    pub turned: f32,
}

impl Canvas {
    /// So many pixels wide and high; none if there are none, or too many.
    pub fn new(width: u32, height: u32, scale: f32) -> Option<Canvas> {
        let mut pixels = Pixmap::new(width, height)?;
        pixels.fill(Color::WHITE);
        Some(Canvas { pixels, scale })
    }

    /// Lines from point to point.
    pub fn lines(&mut self, lines: &[Vec<[f32; 2]>], ink: Ink, width: f32, is_round: bool) {
        let mut path = PathBuilder::new();
        for line in lines.iter().filter(|line| line.iter().flatten().all(|at| at.is_finite())) {
            let Some(([x, y], rest)) = line.split_first() else { continue };
            path.move_to(*x, *y);
            rest.iter().for_each(|[x, y]| path.line_to(*x, *y));
        }
        let Some(path) = path.finish() else { return };
        let (line_cap, line_join) =
            if is_round { (LineCap::Round, LineJoin::Round) } else { (LineCap::Butt, LineJoin::Miter) };
        let stroke = Stroke { width, line_cap, line_join, ..Stroke::default() };
        let to_pixels = Transform::from_scale(self.scale, self.scale);
        self.pixels.stroke_path(&path, &ink.paint(), &stroke, to_pixels, None);
    }

    /// The area within points.
    pub fn area(&mut self, points: &[[f32; 2]], ink: Ink) {
        let mut path = PathBuilder::new();
        let Some(([x, y], rest)) = points.split_first() else { return };
        path.move_to(*x, *y);
        rest.iter().for_each(|[x, y]| path.line_to(*x, *y));
        path.close();
        self.fill(path.finish(), ink, Transform::identity());
    }

    /// A disc.
    pub fn disc(&mut self, [x, y]: [f32; 2], radius: f32, ink: Ink) {
        self.fill(PathBuilder::from_circle(x, y, radius), ink, Transform::identity());
    }

    /// A circle.
    pub fn circle(&mut self, [x, y]: [f32; 2], radius: f32, ink: Ink, width: f32) {
        let Some(path) = PathBuilder::from_circle(x, y, radius) else { return };
        let stroke = Stroke { width, ..Stroke::default() };
        let to_pixels = Transform::from_scale(self.scale, self.scale);
        self.pixels.stroke_path(&path, &ink.paint(), &stroke, to_pixels, None);
    }

    /// A line of text.
    pub fn text(&mut self, font: &Font, text: &str, size: f32, ink: Ink, place: Place) {
        let (parts, length) = font.outlines(text, size);
        let mut path = PathBuilder::new();
        for part in parts {
            match part {
                Part::Move([x, y]) => path.move_to(x, y),
                Part::Line([x, y]) => path.line_to(x, y),
                Part::Quad([a, b], [x, y]) => path.quad_to(a, b, x, y),
                Part::Cubic([a, b], [c, d], [x, y]) => path.cubic_to(a, b, c, d, x, y),
            }
        }
        let [x, y] = place.at;
        let to_place = Transform::from_translate(-place.anchor * length, place.below)
            .post_concat(Transform::from_rotate(place.turned))
            .post_translate(x, y);
        self.fill(path.finish(), ink, to_place);
    }

    fn fill(&mut self, path: Option<Path>, ink: Ink, to_place: Transform) {
        let Some(path) = path else { return };
        let to_pixels = to_place.post_scale(self.scale, self.scale);
        self.pixels.fill_path(&path, &ink.paint(), FillRule::Winding, to_pixels, None);
    }

    /// Red, green, blue and opacity of each pixel, row by row.
    pub fn pixels(&self) -> &[u8] {
        self.pixels.data()
    }

    /// As PNG; nothing if that cannot be made.
    pub fn png(&self) -> Option<Vec<u8>> {
        self.pixels.encode_png().ok()
    }
}

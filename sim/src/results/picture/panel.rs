//! One panel: title, key, axes with units, lines and dots. The door to plotters' charts.

use std::ops::Range;

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::words::{shortened, wrapped};
use super::{Area, BLACK, GREY};

/// What drawing returns.
pub type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<std::io::Error>>;

/// Fine pixels in one of the picture.
pub const SCALE: i32 = 4;
/// Fonts, the first that is there.
pub const FONT: &str = "Helvetica, Arial, DejaVu Sans, sans-serif";
const TITLE_SIZE: f64 = 19.0;
const TEXT_SIZE: f64 = 16.0;
const NOTE_SIZE: f64 = 13.0;
/// Width of a character of text, roughly.
const CHARACTER: f64 = 7.6;
const MARGIN: f64 = 14.0;
const LEFT: f64 = 66.0;
const BELOW: f64 = 48.0;
const TITLE_HEIGHT: f64 = 26.0;
const KEY_HEIGHT: f64 = 20.0;
const KEY_SAMPLE: f64 = 27.0;
const KEY_GAP: f64 = 12.0;

/// Fine pixels of a length in pixels.
pub fn px(length: f64) -> i32 {
    (length * f64::from(SCALE)).round() as i32
}

/// Range and label of an axis.
pub struct Axis<'a>(pub Range<f64>, pub &'a str);

/// How a line looks; widths and dashes in pixels.
#[derive(Clone, Copy)]
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

    fn style(&self) -> ShapeStyle {
        self.color.mix(self.alpha).stroke_width(px(self.width) as u32)
    }
}

/// What a line or dot means.
pub struct Key {
    stroke: Stroke,
    mark: Mark,
    text: String,
}

/// How what a key stands for is drawn.
#[derive(Clone, Copy, PartialEq)]
enum Mark {
    Line,
    Dot,
    Ring,
}

/// One row of a panel of rows: its name, and a smaller line below it.
pub struct Row {
    /// What the row is about.
    pub name: String,
    /// What should be known of it; may be empty.
    pub note: String,
}

impl Key {
    /// Of a line.
    pub fn line(stroke: Stroke, text: impl Into<String>) -> Self {
        Self { stroke, mark: Mark::Line, text: text.into() }
    }

    /// Of dots.
    pub fn dot(stroke: Stroke, text: impl Into<String>) -> Self {
        Self { stroke, mark: Mark::Dot, text: text.into() }
    }

    /// Of rings.
    pub fn ring(stroke: Stroke, text: impl Into<String>) -> Self {
        Self { stroke, mark: Mark::Ring, text: text.into() }
    }

    fn width(&self) -> f64 {
        KEY_SAMPLE + 6.0 + CHARACTER * self.text.chars().count() as f64 + KEY_GAP
    }
}

/// Axes to draw on.
pub struct Panel<'a> {
    chart: ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>,
}

impl<'a> Panel<'a> {
    /// Axes with a title and a key above them.
    pub fn new(area: &Area<'a>, title: &str, x: &Axis, y: &Axis, keys: &[Key]) -> Drawn<Self> {
        head(area, title, keys)?;
        let mut chart = ChartBuilder::on(area)
            .margin_top(px(above(area, keys)))
            .margin_right(px(MARGIN))
            .margin_left(px(MARGIN))
            .y_label_area_size(px(LEFT))
            .x_label_area_size(px(BELOW))
            .build_cartesian_2d(x.0.clone(), y.0.clone())?;
        chart
            .configure_mesh()
            .x_labels(9)
            .y_labels(8)
            .max_light_lines(0)
            .bold_line_style(hair(225, 0.8))
            .axis_style(hair(0, 1.0))
            .set_all_tick_mark_size(px(4.0))
            .label_style((FONT, f64::from(px(TEXT_SIZE))).into_font())
            .axis_desc_style((FONT, f64::from(px(TEXT_SIZE))).into_font())
            .x_label_formatter(&|value| tick(*value))
            .y_label_formatter(&|value| tick(*value))
            .x_desc(x.1)
            .y_desc(y.1)
            .draw()?;
        Ok(Self { chart })
    }

    /// Rows from top to bottom, the `k`-th at y = -k, with their names in a margin of that width; without
    /// names in none.
    pub fn rows(
        area: &Area<'a>,
        title: &str,
        x: &Axis,
        rows: &[Row],
        names: f64,
        keys: &[Key],
    ) -> Drawn<Self> {
        head(area, title, keys)?;
        let y = 0.5 - rows.len() as f64..0.5;
        let mut chart = ChartBuilder::on(area)
            .margin_top(px(above(area, keys)))
            .margin_right(px(MARGIN + 8.0))
            .margin_left(px(MARGIN + names))
            .x_label_area_size(px(BELOW))
            .build_cartesian_2d(x.0.clone(), y.clone())?;
        chart
            .configure_mesh()
            .x_labels(7)
            .max_light_lines(0)
            .disable_y_mesh()
            .disable_y_axis()
            .bold_line_style(hair(225, 0.8))
            .axis_style(hair(0, 1.0))
            .set_all_tick_mark_size(px(4.0))
            .label_style((FONT, f64::from(px(TEXT_SIZE))).into_font())
            .axis_desc_style((FONT, f64::from(px(TEXT_SIZE))).into_font())
            .x_label_formatter(&|value| tick(*value))
            .x_desc(x.1)
            .draw()?;
        let mut panel = Self { chart };
        panel.line([(x.0.start, y.start), (x.0.start, y.end)].into_iter(), &Stroke::new(BLACK, 1.0))?;
        for (k, row) in rows.iter().enumerate().filter(|_| names > 0.0) {
            let at = (x.0.start, -(k as f64));
            let has_note = !row.note.is_empty();
            panel.margin(at, if has_note { -8.0 } else { 0.0 }, TEXT_SIZE, &BLACK, &row.name)?;
            panel.margin(at, 8.0, NOTE_SIZE, &GREY, &row.note)?;
        }
        Ok(panel)
    }

    /// Text that ends left of a point, so far below it.
    fn margin(&mut self, at: (f64, f64), down: f64, size: f64, color: &RGBColor, text: &str) -> Drawn {
        let style = (FONT, f64::from(px(size))).into_font().color(color);
        let style = style.pos(Pos::new(HPos::Right, VPos::Center));
        let text = Text::new(text.to_owned(), (-px(8.0), px(down)), style);
        self.chart.draw_series([EmptyElement::at(at) + text])?;
        Ok(())
    }

    /// A panel that says why it shows nothing.
    pub fn without_data(area: &Area<'a>, title: &str, why: &str) -> Drawn {
        write(area, title, (LEFT + MARGIN, MARGIN), TITLE_SIZE, true, Pos::new(HPos::Left, VPos::Top))?;
        let (width, height) = size(area);
        let middle = Pos::new(HPos::Center, VPos::Center);
        let per_line = ((width - 2.0 * LEFT) / CHARACTER) as usize;
        let lines = wrapped(why, per_line);
        for (k, line) in lines.iter().enumerate() {
            let down = (k as f64 - 0.5 * (lines.len() - 1) as f64) * KEY_HEIGHT;
            write(area, line, (0.5 * width, 0.5 * height + down), TEXT_SIZE, false, middle)?;
        }
        Ok(())
    }

    /// A line through points.
    pub fn line(&mut self, points: impl Iterator<Item = (f64, f64)>, stroke: &Stroke) -> Drawn {
        let points: Vec<_> = points.collect();
        if points.len() < 2 {
            return Ok(());
        }
        match stroke.dash {
            None => self.chart.draw_series(LineSeries::new(points, stroke.style()))?,
            Some((dash, gap)) => {
                let series = DashedLineSeries::new(points, px(dash), px(gap), stroke.style());
                self.chart.draw_series(series)?
            }
        };
        Ok(())
    }

    /// Filled dots of a radius in pixels, with a white rim, which keeps them apart from lines.
    pub fn dots(
        &mut self,
        points: impl IntoIterator<Item = (f64, f64)>,
        stroke: &Stroke,
        radius: f64,
    ) -> Drawn {
        let color = stroke.color.mix(stroke.alpha);
        let points: Vec<_> = points.into_iter().collect();
        let rim = |at: &(f64, f64)| Circle::new(*at, px(radius + 1.0), WHITE.mix(stroke.alpha).filled());
        self.chart.draw_series(points.iter().map(rim))?;
        self.chart.draw_series(points.iter().map(|at| Circle::new(*at, px(radius), color.filled())))?;
        Ok(())
    }

    /// Rings of a radius in pixels.
    pub fn rings(
        &mut self,
        points: impl IntoIterator<Item = (f64, f64)>,
        stroke: &Stroke,
        radius: f64,
    ) -> Drawn {
        let ring = |at| Circle::new(at, px(radius), stroke.style());
        self.chart.draw_series(points.into_iter().map(ring))?;
        Ok(())
    }

    /// A shaded strip between two x.
    pub fn strip(&mut self, x: Range<f64>, y: Range<f64>) -> Drawn {
        let shade = GREY.mix(0.18).filled();
        self.chart.draw_series([Rectangle::new([(x.start, y.start), (x.end, y.end)], shade)])?;
        Ok(())
    }

    /// A cell of a map, with hardly a rim.
    pub fn cell(&mut self, x: Range<f64>, y: Range<f64>, color: RGBColor) -> Drawn {
        let ends = [(x.start, y.start), (x.end, y.end)];
        self.chart.draw_series([Rectangle::new(ends, color.filled())])?;
        self.chart.draw_series([Rectangle::new(ends, hair(255, 0.5))])?;
        Ok(())
    }

    /// A small number about a point.
    pub fn number(&mut self, at: (f64, f64), text: &str, color: &RGBColor) -> Drawn {
        let style = (FONT, f64::from(px(NOTE_SIZE))).into_font().color(color);
        let style = style.pos(Pos::new(HPos::Center, VPos::Center));
        self.chart.draw_series([Text::new(text.to_owned(), at, style)])?;
        Ok(())
    }

    /// Text that begins at a point.
    pub fn text(&mut self, at: (f64, f64), text: &str) -> Drawn {
        let style = (FONT, f64::from(px(TEXT_SIZE - 2.0))).into_font().color(&BLACK);
        let style = style.pos(Pos::new(HPos::Left, VPos::Center));
        self.chart.draw_series([Text::new(text.to_owned(), at, style)])?;
        Ok(())
    }
}

/// The first line of a page.
pub fn heading(page: &Area, text: &str) -> Drawn {
    let (width, _) = size(page);
    let most = ((width - 2.0 * MARGIN) / (CHARACTER * TITLE_SIZE / TEXT_SIZE)) as usize;
    let text = shortened(text, most);
    write(page, &text, (LEFT + MARGIN, 12.0), TITLE_SIZE, true, Pos::new(HPos::Left, VPos::Top))
}

/// Width and height of the axes in an area, in pixels.
pub fn plot_size(area: &Area, keys: &[Key]) -> (f64, f64) {
    let (width, height) = size(area);
    (width - LEFT - 2.0 * MARGIN, height - above(area, keys) - BELOW)
}

/// Widens one of two ranges so that both have the same scale.
pub fn equal_scale(x: Range<f64>, y: Range<f64>, (width, height): (f64, f64)) -> (Range<f64>, Range<f64>) {
    let scale = ((x.end - x.start) / width).max((y.end - y.start) / height);
    let widened = |range: Range<f64>, length: f64| {
        let (middle, half) = (0.5 * (range.start + range.end), 0.5 * scale * length);
        middle - half..middle + half
    };
    (widened(x, width), widened(y, height))
}

/// The range of some values with a share of it to spare on either side; never empty.
pub fn padded(values: impl Iterator<Item = f64>, share: f64) -> Range<f64> {
    let (low, high) = values
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let spare = share * (high - low);
    let least = 1e-6 * low.abs().max(high.abs()).max(1e-3);
    low - spare.max(least)..high + spare.max(least)
}

/// A tick's number: no more digits than it has, a true minus, no sign on zero.
pub fn tick(value: f64) -> String {
    let text = format!("{:.6}", value);
    match text.trim_end_matches('0').trim_end_matches('.') {
        "-0" => "0".to_owned(),
        text => text.replace('-', "\u{2212}"),
    }
}

fn size(area: &Area) -> (f64, f64) {
    let (width, height) = area.dim_in_pixel();
    (f64::from(width) / f64::from(SCALE), f64::from(height) / f64::from(SCALE))
}

/// A grey line.
fn hair(gray: u8, width: f64) -> ShapeStyle {
    RGBColor(gray, gray, gray).stroke_width(px(width) as u32)
}

/// Title and key of a panel.
fn head(area: &Area, title: &str, keys: &[Key]) -> Drawn {
    write(area, title, (LEFT + MARGIN, MARGIN), TITLE_SIZE, true, Pos::new(HPos::Left, VPos::Top))?;
    for (key, (left, row)) in keys.iter().zip(places(area, keys)) {
        let middle = MARGIN + TITLE_HEIGHT + KEY_HEIGHT * (row as f64 + 0.5);
        draw_key(area, key, (left, middle))?;
    }
    Ok(())
}

/// Height of title and key, pixels.
fn above(area: &Area, keys: &[Key]) -> f64 {
    let rows = places(area, keys).last().map_or(0, |place| place.1 + 1);
    MARGIN + TITLE_HEIGHT + KEY_HEIGHT * rows as f64 + 6.0
}

/// Left edge and row of each key.
fn places(area: &Area, keys: &[Key]) -> Vec<(f64, usize)> {
    let (first, last) = (LEFT + MARGIN, size(area).0 - MARGIN);
    let (mut left, mut row) = (first, 0);
    let mut places = Vec::with_capacity(keys.len());
    for key in keys {
        if left > first && left + key.width() - KEY_GAP > last {
            (left, row) = (first, row + 1);
        }
        places.push((left, row));
        left += key.width();
    }
    places
}

fn draw_key(area: &Area, key: &Key, (left, middle): (f64, f64)) -> Drawn {
    let y = px(middle);
    let piece =
        |from: f64, to: f64| PathElement::new([(px(left + from), y), (px(left + to), y)], key.stroke.style());
    let middle_of_sample = (px(left + 0.5 * KEY_SAMPLE), y);
    match (key.mark, key.stroke.dash) {
        (Mark::Dot, _) => {
            area.draw(&Circle::new(middle_of_sample, px(4.0), key.stroke.color.filled()))?;
        }
        (Mark::Ring, _) => area.draw(&Circle::new(middle_of_sample, px(4.0), key.stroke.style()))?,
        (Mark::Line, None) => area.draw(&piece(0.0, KEY_SAMPLE))?,
        (Mark::Line, Some((dash, gap))) => {
            let mut from = 0.0;
            while from < KEY_SAMPLE {
                area.draw(&piece(from, (from + dash).min(KEY_SAMPLE)))?;
                from += dash + gap;
            }
        }
    }
    write(
        area,
        &key.text,
        (left + KEY_SAMPLE + 6.0, middle),
        TEXT_SIZE,
        false,
        Pos::new(HPos::Left, VPos::Center),
    )
}

fn write(area: &Area, text: &str, (x, y): (f64, f64), size: f64, bold: bool, pos: Pos) -> Drawn {
    let weight = if bold { FontStyle::Bold } else { FontStyle::Normal };
    let style = FontDesc::new(FontFamily::Name(FONT), f64::from(px(size)), weight).color(&BLACK).pos(pos);
    area.draw(&Text::new(text.to_owned(), (px(x), px(y)), style))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_have_a_true_minus_and_no_signed_zero() {
        for (value, text) in
            [(-0.0, "0"), (-1e-12, "0"), (-150.0, "−150"), (0.30000000000000004, "0.3"), (20.0, "20")]
        {
            assert_eq!(tick(value), text);
        }
    }

    #[test]
    fn axes_of_one_scale_still_hold_both_ranges() {
        let (x, y) = equal_scale(-10.0..200.0, -180.0..20.0, (500.0, 300.0));
        let scale = |range: &Range<f64>, length: f64| (range.end - range.start) / length;
        assert!((scale(&x, 500.0) / scale(&y, 300.0) - 1.0).abs() < 1e-12);
        assert!(x.start <= -10.0 && x.end >= 200.0 && y.start <= -180.0 && y.end >= 20.0, "{x:?} {y:?}");
    }

    #[test]
    fn a_constant_still_has_a_range() {
        let range = padded([0.0, 0.0].into_iter(), 0.05);
        assert!(range.start < 0.0 && range.end > 0.0);
    }
}

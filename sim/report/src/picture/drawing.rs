//! Charts on a page of SVG. The door to plotters' charts.

use std::cell::RefCell;
use std::ops::Deref;
use std::rc::Rc;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::picture::chart::{Cases, Chart, Key, Mark, Row, Shape, Stroke};
use crate::picture::compact::compact;
use crate::picture::pixels::{FONT, SCALE, px};
use crate::picture::text::{shortened, tick, wrapped};
use crate::picture::{BLACK, GREY};

/// What drawing returns.
pub type Drawn<T = ()> = Result<T, DrawingAreaErrorKind<std::io::Error>>;

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

/// A picture: as SVG, and the charts that it was drawn from.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    /// As SVG.
    pub svg: String,
    /// Its charts, from the first to the last.
    pub charts: Vec<Chart>,
}

/// A part of a page, and what was placed on the page so far.
pub struct Sheet<'a> {
    pub(super) area: DrawingArea<SVGBackend<'a>, Shift>,
    pub(super) placed: Rc<RefCell<Vec<Placed<'a>>>>,
}

/// A chart and its place.
pub struct Placed<'a> {
    pub(super) area: DrawingArea<SVGBackend<'a>, Shift>,
    pub(super) chart: Chart,
}

impl<'a> Deref for Sheet<'a> {
    type Target = DrawingArea<SVGBackend<'a>, Shift>;

    fn deref(&self) -> &Self::Target {
        &self.area
    }
}

impl<'a> Sheet<'a> {
    fn part(&self, area: DrawingArea<SVGBackend<'a>, Shift>) -> Self {
        Self { area, placed: Rc::clone(&self.placed) }
    }

    /// Without a margin at the top, fine pixels.
    pub fn below(&self, top: i32) -> Self {
        self.part(self.area.margin(top, 0, 0, 0))
    }

    /// In rows and columns.
    pub fn split_evenly(&self, rows_and_columns: (usize, usize)) -> Vec<Self> {
        self.area.split_evenly(rows_and_columns).into_iter().map(|area| self.part(area)).collect()
    }

    /// One above the other.
    pub fn split_vertically(&self, y: u32) -> (Self, Self) {
        let (above, below) = self.area.split_vertically(y);
        (self.part(above), self.part(below))
    }
}

/// Draws on a page of that size.
pub fn drawn(size: (u32, u32), draw: impl FnOnce(&Sheet) -> Drawn) -> Drawing {
    let mut text = String::new();
    let fine = (size.0 * SCALE as u32, size.1 * SCALE as u32);
    let area = SVGBackend::with_string(&mut text, fine).into_drawing_area();
    let page = Sheet { area, placed: Rc::default() };
    let done = page.area.fill(&WHITE).and_then(|()| draw(&page));
    let done =
        done.and_then(|()| page.placed.borrow().iter().try_for_each(|own| chart(&own.area, &own.chart)));
    done.and_then(|()| page.area.present()).expect("writing to memory does not fail");
    let charts = page.placed.take().into_iter().map(|own| own.chart).collect();
    drop(page);
    // Plotters places in whole pixels: it draws on a finer page, shown at the size that was requested.
    let shown = |(width, height): (u32, u32)| format!("width=\"{width}\" height=\"{height}\" viewBox");
    Drawing { svg: compact(&text.replacen(&shown(fine), &shown(size), 1)), charts }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Axes<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn chart(area: &Area, of: &Chart) -> Drawn {
    if let Some(why) = &of.why {
        return without_data(area, &of.title, why);
    }
    let mut axes = if of.rows.is_some() { rows(area, of)? } else { axes(area, of)? };
    let is_always = |k: &usize| !matches!(of.cases.get(k), Some(Cases::Chosen(_)));
    let all = of.marks.iter().enumerate().filter(|(k, _)| is_always(k));
    all.map(|(_, own)| own).try_for_each(|own| mark(&mut axes, own))
}

fn axes<'a>(area: &Area<'a>, of: &Chart) -> Drawn<Axes<'a>> {
    head(area, &of.title, &of.keys)?;
    let mut chart = ChartBuilder::on(area)
        .margin_top(px(above(area, &of.keys)))
        .margin_right(px(MARGIN))
        .margin_left(px(MARGIN))
        .y_label_area_size(px(LEFT))
        .x_label_area_size(px(BELOW))
        .build_cartesian_2d(of.x.range.clone(), of.y.range.clone())?;
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
        .x_desc(&of.x.label)
        .y_desc(&of.y.label)
        .draw()?;
    Ok(chart)
}

fn rows<'a>(area: &Area<'a>, of: &Chart) -> Drawn<Axes<'a>> {
    let (rows, names): (&[Row], f64) = of.rows.as_ref().map_or((&[], 0.0), |of| (&of.rows, of.names));
    head(area, &of.title, &of.keys)?;
    let (x, y) = (&of.x.range, &of.y.range);
    let mut chart = ChartBuilder::on(area)
        .margin_top(px(above(area, &of.keys)))
        .margin_right(px(MARGIN + 8.0))
        .margin_left(px(MARGIN + names))
        .x_label_area_size(px(BELOW))
        .build_cartesian_2d(x.clone(), y.clone())?;
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
        .x_desc(&of.x.label)
        .draw()?;
    line(&mut chart, &[(x.start, y.start), (x.start, y.end)], &Stroke::new(BLACK, 1.0))?;
    for (k, row) in rows.iter().enumerate().filter(|_| names > 0.0) {
        let at = (x.start, -(k as f64));
        let has_note = !row.note.is_empty();
        margin(&mut chart, at, if has_note { -8.0 } else { 0.0 }, TEXT_SIZE, &BLACK, &row.name)?;
        margin(&mut chart, at, 8.0, NOTE_SIZE, &GREY, &row.note)?;
    }
    Ok(chart)
}

/// Text that ends left of a point, so far below it.
fn margin(axes: &mut Axes, at: (f64, f64), down: f64, size: f64, color: &RGBColor, text: &str) -> Drawn {
    let style = (FONT, f64::from(px(size))).into_font().color(color);
    let style = style.pos(Pos::new(HPos::Right, VPos::Center));
    let text = Text::new(text.to_owned(), (-px(8.0), px(down)), style);
    axes.draw_series([EmptyElement::at(at) + text])?;
    Ok(())
}

fn without_data(area: &Area, title: &str, why: &str) -> Drawn {
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

fn line(axes: &mut Axes, points: &[(f64, f64)], stroke: &Stroke) -> Drawn {
    let points = points.to_vec();
    match stroke.dash {
        None => axes.draw_series(LineSeries::new(points, stroke.style()))?,
        Some((dash, gap)) => {
            axes.draw_series(DashedLineSeries::new(points, px(dash), px(gap), stroke.style()))?
        }
    };
    Ok(())
}

fn mark(axes: &mut Axes, of: &Mark) -> Drawn {
    match of {
        Mark::Line { points, stroke, .. } => line(axes, points, stroke),
        Mark::Dots { points, stroke, radius } => {
            let color = stroke.color.mix(stroke.alpha);
            let rim = |at: &(f64, f64)| Circle::new(*at, px(radius + 1.0), WHITE.mix(stroke.alpha).filled());
            axes.draw_series(points.iter().map(rim))?;
            axes.draw_series(points.iter().map(|at| Circle::new(*at, px(*radius), color.filled())))?;
            Ok(())
        }
        Mark::Rings { points, stroke, radius } => {
            let ring = |at: &(f64, f64)| Circle::new(*at, px(*radius), stroke.style());
            axes.draw_series(points.iter().map(ring))?;
            Ok(())
        }
        Mark::Band { points, stroke } => {
            let lower = points.iter().map(|(x, ends)| (*x, ends[0]));
            let upper = points.iter().rev().map(|(x, ends)| (*x, ends[1]));
            let shade = stroke.color.mix(stroke.alpha).filled();
            axes.draw_series([Polygon::new(lower.chain(upper).collect::<Vec<_>>(), shade)])?;
            Ok(())
        }
        Mark::Strip { x, y } => {
            let shade = GREY.mix(0.18).filled();
            axes.draw_series([Rectangle::new([(x.start, y.start), (x.end, y.end)], shade)])?;
            Ok(())
        }
        Mark::Cell { x, y, color, .. } => {
            let ends = [(x.start, y.start), (x.end, y.end)];
            axes.draw_series([Rectangle::new(ends, color.filled())])?;
            axes.draw_series([Rectangle::new(ends, hair(255, 0.5))])?;
            Ok(())
        }
        Mark::Number { at, text, color } => words(axes, *at, text, (NOTE_SIZE, color), HPos::Center),
        Mark::Text { at, text } => words(axes, *at, text, (TEXT_SIZE - 2.0, &BLACK), HPos::Left),
    }
}

fn words(axes: &mut Axes, at: (f64, f64), text: &str, (size, color): (f64, &RGBColor), side: HPos) -> Drawn {
    let style = (FONT, f64::from(px(size))).into_font().color(color).pos(Pos::new(side, VPos::Center));
    axes.draw_series([Text::new(text.to_owned(), at, style)])?;
    Ok(())
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

fn size(area: &Area) -> (f64, f64) {
    let (width, height) = area.dim_in_pixel();
    (f64::from(width) / f64::from(SCALE), f64::from(height) / f64::from(SCALE))
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
        if left > first && left + width(key) - KEY_GAP > last {
            (left, row) = (first, row + 1);
        }
        places.push((left, row));
        left += width(key);
    }
    places
}

fn draw_key(area: &Area, key: &Key, (left, middle): (f64, f64)) -> Drawn {
    let y = px(middle);
    let piece =
        |from: f64, to: f64| PathElement::new([(px(left + from), y), (px(left + to), y)], key.stroke.style());
    let middle_of_sample = (px(left + 0.5 * KEY_SAMPLE), y);
    match (key.shape, key.stroke.dash) {
        (Shape::Dot, _) => {
            area.draw(&Circle::new(middle_of_sample, px(4.0), key.stroke.color.filled()))?;
        }
        (Shape::Band, _) => {
            let shade = key.stroke.color.mix(key.stroke.alpha).filled();
            area.draw(&Rectangle::new(
                [(px(left), y - px(6.0)), (px(left + KEY_SAMPLE), y + px(6.0))],
                shade,
            ))?;
        }
        (Shape::Ring, _) => area.draw(&Circle::new(middle_of_sample, px(4.0), key.stroke.style()))?,
        (Shape::Line, None) => area.draw(&piece(0.0, KEY_SAMPLE))?,
        (Shape::Line, Some((dash, gap))) => {
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

fn width(key: &Key) -> f64 {
    KEY_SAMPLE + 6.0 + CHARACTER * key.text.chars().count() as f64 + KEY_GAP
}

fn write(area: &Area, text: &str, (x, y): (f64, f64), size: f64, bold: bool, pos: Pos) -> Drawn {
    let weight = if bold { FontStyle::Bold } else { FontStyle::Normal };
    let style = FontDesc::new(FontFamily::Name(FONT), f64::from(px(size)), weight).color(&BLACK).pos(pos);
    area.draw(&Text::new(text.to_owned(), (px(x), px(y)), style))
}

/// A grey line.
fn hair(gray: u8, width: f64) -> ShapeStyle {
    RGBColor(gray, gray, gray).stroke_width(px(width) as u32)
}

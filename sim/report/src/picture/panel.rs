//! One panel in the making: title, key, axes with units, then lines and dots. It only describes a chart, which is
//! drawn when the page is full.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::Range;
use std::rc::Rc;

use plotters::prelude::RGBColor;

use crate::picture::chart::{Cases, Chart, Mark, Point, Rows, Scale};
pub use crate::picture::chart::{Key, Row, Stroke};
pub use crate::picture::drawing::{Drawn, heading, plot_size};
use crate::picture::drawing::{Placed, Sheet};
pub use crate::picture::pixels::{FONT, px};

/// Range and label of an axis.
pub struct Axis<'a>(pub Range<f64>, pub &'a str);

impl Axis<'_> {
    fn scale(&self) -> Scale {
        Scale { range: self.0.clone(), label: self.1.to_owned() }
    }
}

/// Axes to draw on.
pub struct Panel<'a> {
    placed: Rc<RefCell<Vec<Placed<'a>>>>,
    place: usize,
    cases: Option<Cases>,
}

impl<'a> Panel<'a> {
    /// Axes with a title and a key above them.
    pub fn new(area: &Sheet<'a>, title: &str, x: &Axis, y: &Axis, keys: &[Key]) -> Drawn<Self> {
        let (width, height) = plot_size(area, keys);
        let scale = |range: &Range<f64>, length: f64| (range.end - range.start) / length;
        let chart = Chart {
            title: title.to_owned(),
            x: x.scale(),
            y: y.scale(),
            is_equal: (scale(&x.0, width) / scale(&y.0, height) - 1.0).abs() < 1e-9,
            aspect: width / height,
            keys: keys.to_vec(),
            rows: None,
            marks: Vec::new(),
            cases: BTreeMap::new(),
            why: None,
        };
        Ok(Self::of(area, chart))
    }

    /// Rows from top to bottom, the `k`-th at y = -k, with their names in a margin of that width; without
    /// names in none.
    pub fn rows(
        area: &Sheet<'a>,
        title: &str,
        x: &Axis,
        rows: &[Row],
        names: f64,
        keys: &[Key],
    ) -> Drawn<Self> {
        let y = Axis(0.5 - rows.len() as f64..0.5, "");
        let panel = Self::new(area, title, x, &y, keys)?;
        panel.chart(|chart| chart.rows = Some(Rows { rows: rows.to_vec(), names }));
        Ok(panel)
    }

    /// A panel that says why it shows nothing.
    pub fn without_data(area: &Sheet<'a>, title: &str, why: &str) -> Drawn {
        let panel = Self::new(area, title, &Axis(0.0..1.0, ""), &Axis(0.0..1.0, ""), &[])?;
        panel.chart(|chart| chart.why = Some(why.to_owned()));
        Ok(())
    }

    fn of(area: &Sheet<'a>, chart: Chart) -> Self {
        let placed = Rc::clone(&area.placed);
        let place = placed.borrow().len();
        placed.borrow_mut().push(Placed { area: area.area.clone(), chart });
        Self { placed, place, cases: None }
    }

    fn chart(&self, change: impl FnOnce(&mut Chart)) {
        change(&mut self.placed.borrow_mut()[self.place].chart);
    }

    fn mark(&mut self, mark: Mark) -> Drawn {
        let cases = self.cases.clone();
        self.chart(|chart| {
            chart.cases.extend(cases.map(|cases| (chart.marks.len(), cases)));
            chart.marks.push(mark);
        });
        Ok(())
    }

    /// What is drawn from here on belongs to these cases.
    pub fn of_cases(&mut self, cases: Option<Cases>) -> &mut Self {
        self.cases = cases;
        self
    }

    /// A line through points.
    pub fn line(&mut self, points: impl Iterator<Item = Point>, stroke: &Stroke) -> Drawn {
        let points: Vec<_> = points.collect();
        if points.len() < 2 {
            return Ok(());
        }
        self.mark(Mark::Line { points, stroke: *stroke, times: None })
    }

    /// A line through points at times, s, of which one is at the present time of the page.
    pub fn path(&mut self, points: impl Iterator<Item = (f64, Point)>, stroke: &Stroke) -> Drawn {
        let (times, points): (Vec<f64>, Vec<Point>) = points.unzip();
        if points.len() < 2 {
            return Ok(());
        }
        self.mark(Mark::Line { points, stroke: *stroke, times: Some(times) })
    }

    /// Filled dots of a radius in pixels, with a white rim, which keeps them apart from lines.
    pub fn dots(&mut self, points: impl IntoIterator<Item = Point>, stroke: &Stroke, radius: f64) -> Drawn {
        self.mark(Mark::Dots { points: points.into_iter().collect(), stroke: *stroke, radius })
    }

    /// Rings of a radius in pixels.
    pub fn rings(&mut self, points: impl IntoIterator<Item = Point>, stroke: &Stroke, radius: f64) -> Drawn {
        self.mark(Mark::Rings { points: points.into_iter().collect(), stroke: *stroke, radius })
    }

    /// A filled band between two ends over x.
    pub fn band(&mut self, points: impl Iterator<Item = (f64, [f64; 2])>, stroke: &Stroke) -> Drawn {
        let points: Vec<_> = points.collect();
        if points.len() < 2 {
            return Ok(());
        }
        self.mark(Mark::Band { points, stroke: *stroke })
    }

    /// A shaded strip between two x.
    pub fn strip(&mut self, x: Range<f64>, y: Range<f64>) -> Drawn {
        self.mark(Mark::Strip { x, y })
    }

    /// A cell of a map that represents a number, with hardly a rim.
    pub fn cell(&mut self, x: Range<f64>, y: Range<f64>, color: RGBColor, value: f64) -> Drawn {
        self.mark(Mark::Cell { x, y, color, value })
    }

    /// A small number about a point.
    pub fn number(&mut self, at: Point, text: &str, color: &RGBColor) -> Drawn {
        self.mark(Mark::Number { at, text: text.to_owned(), color: *color })
    }

    /// Text that begins at a point.
    pub fn text(&mut self, at: Point, text: &str) -> Drawn {
        self.mark(Mark::Text { at, text: text.to_owned() })
    }
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

#[cfg(test)]
mod tests {
    use super::*;

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

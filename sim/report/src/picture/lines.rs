//! Several lines in one panel, distinguished without colour: by dash, width and mark.

use crate::picture::chart::Cases;
use crate::picture::panel::{Axis, Key, Panel, Stroke, padded};
use crate::picture::{Area, BLACK, BLUE, CHOSEN, Drawn, GREEN, GREY, ORANGE, VERMILION};

/// Lines of a picture, at most: more cannot be distinguished.
pub(super) const MOST_LINES: usize = 8;

/// A line with its name.
pub type Named = (String, Vec<(f64, f64)>);

/// A band about a line: x, lower and upper end.
pub type Band = Vec<(f64, [f64; 2])>;

/// Looks of lines that are distinguished by dash and width alone.
pub(super) fn looks() -> [Stroke; MOST_LINES] {
    [
        Stroke::new(BLUE, 1.6),
        Stroke::dashed(VERMILION, 1.8, 9.0, 4.0),
        Stroke::dashed(GREEN, 2.0, 2.5, 3.0),
        Stroke::new(BLACK, 2.8),
        Stroke::dashed(ORANGE, 2.4, 14.0, 3.0),
        Stroke::dashed(GREY, 2.0, 5.0, 2.5),
        Stroke::dashed(BLACK, 1.2, 12.0, 5.0),
        Stroke::dashed(BLUE, 3.0, 3.0, 3.0),
    ]
}

/// So many of them, evenly spread, with the first and the last.
pub(super) fn spread<T: Clone>(all: &[T], most: usize) -> Vec<T> {
    let count = all.len().min(most);
    let place = |k: usize| if count > 1 { k * (all.len() - 1) / (count - 1) } else { 0 };
    (0..count).map(|k| all[place(k)].clone()).collect()
}

/// Points with the mean of those that have one abscissa: where several were measured, a line goes through
/// their middle.
fn means(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let same = points.chunk_by(|a, b| a.0 == b.0);
    same.map(|own| (own[0].0, own.iter().map(|point| point.1).sum::<f64>() / own.len() as f64)).collect()
}

/// What a panel of lines shows.
pub(super) struct Lines<'a> {
    pub title: &'a str,
    /// Labels of the axes, with units.
    pub x: &'a str,
    pub y: &'a str,
    /// Whether points are marked: every other line by rings.
    pub marks: bool,
    /// Whether the axis of y begins at zero.
    pub from_zero: bool,
    /// What to say where there is none.
    pub why: &'a str,
}

impl Lines<'_> {
    /// The first [`MOST_LINES`] lines that have points.
    pub fn draw(&self, area: &Area, lines: &[Named]) -> Drawn {
        self.draw_in(area, lines, &[])
    }

    /// The same, each in its band.
    pub fn draw_in(&self, area: &Area, lines: &[Named], bands: &[Band]) -> Drawn {
        let lines: Vec<_> = lines.iter().map(|line| (None, line.clone())).collect();
        self.draw_all(area, &lines, &[], bands)
    }

    /// The same, each with the case of the page's family that it represents; `others` only while they are chosen.
    pub fn draw_cases(
        &self,
        area: &Area,
        lines: &[(Option<usize>, Named)],
        others: &[(usize, Named)],
    ) -> Drawn {
        self.draw_all(area, lines, others, &[])
    }

    fn draw_all(
        &self,
        area: &Area,
        lines: &[(Option<usize>, Named)],
        others: &[(usize, Named)],
        bands: &[Band],
    ) -> Drawn {
        let (cases, lines): (Vec<Option<usize>>, Vec<&Named>) = (lines.iter())
            .filter(|(_, line)| !line.1.is_empty())
            .take(MOST_LINES)
            .map(|(case, line)| (*case, line))
            .unzip();
        if lines.is_empty() {
            return Panel::without_data(area, self.title, self.why);
        }
        let is_ringed = |k: usize| k % 2 == 1;
        let looks = looks();
        let keys: Vec<Key> =
            (lines.iter().zip(looks)).map(|(line, look)| Key::line(look, line.0.clone())).collect();
        let all = || lines.iter().flat_map(|line| &line.1).chain(others.iter().flat_map(|(_, line)| &line.1));
        let x = padded(all().map(|point| point.0), 0.04);
        let ends = bands.iter().flatten().flat_map(|(_, ends)| *ends).filter(|end| end.is_finite());
        let y = padded(all().map(|point| point.1).chain(ends), 0.08);
        let y = if self.from_zero && y.end > 0.0 { y.start.min(0.0).max(-0.02 * y.end)..y.end } else { y };
        let mut panel = Panel::new(area, self.title, &Axis(x, self.x), &Axis(y, self.y), &keys)?;
        for (band, look) in bands.iter().zip(looks) {
            panel.band(band.iter().copied(), &Stroke { alpha: 0.25, dash: None, ..look })?;
        }
        for (k, (line, look)) in lines.iter().zip(looks).enumerate() {
            panel.of_cases(cases[k].map(Cases::One)).line(means(&line.1).into_iter(), &look)?;
            match (self.marks, is_ringed(k)) {
                (false, _) => {}
                (true, true) => panel.rings(line.1.iter().copied(), &Stroke { dash: None, ..look }, 4.0)?,
                (true, false) => panel.dots(line.1.iter().copied(), &look, 2.8)?,
            }
        }
        let look = Stroke::new(CHOSEN, 2.2);
        for (case, line) in others {
            panel.of_cases(Some(Cases::Chosen(*case))).line(means(&line.1).into_iter(), &look)?;
            if self.marks {
                panel.dots(line.1.iter().copied(), &look, 2.8)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No two lines have the same dash at nearly the same width: without colour they would be one.
    #[test]
    fn lines_differ_without_colour() {
        let looks = looks();
        for (k, one) in looks.iter().enumerate() {
            for other in &looks[k + 1..] {
                let is_alike = one.dash == other.dash && (one.width - other.width).abs() < 1.0;
                assert!(!is_alike, "{:?} {}", one.dash, one.width);
            }
        }
    }

    #[test]
    fn a_line_goes_through_the_middle_of_what_stands_at_one_place() {
        assert_eq!(means(&[(1.0, 2.0), (1.0, 4.0), (2.0, 5.0)]), [(1.0, 3.0), (2.0, 5.0)]);
    }

    #[test]
    fn a_spread_has_both_ends() {
        assert_eq!(spread(&[1, 2, 3, 4, 5, 6, 7], 3), [1, 4, 7]);
        assert_eq!(spread(&[1, 2], 6), [1, 2]);
        assert_eq!(spread(&[1, 2], 1), [1]);
    }
}

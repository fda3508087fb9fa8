//! The SVG of plotters in fewer letters: lines that follow one another with one look become one path, and points go
//! that lie on the line of their neighbours. Dashes are such lines, so most of a picture is.

use std::fmt::Write;

use crate::picture::pixels::FONT;

/// By how much a line may be off for a point that is left out, fine pixels: an eighth of a pixel.
const OFF: f64 = 0.5;

type Point = (i32, i32);

/// The same picture.
pub fn compact(svg: &str) -> String {
    let mut out = String::with_capacity(svg.len());
    let mut open: Option<(&str, String)> = None;
    for line in svg.lines() {
        match parsed(line) {
            Some((look, points)) => {
                if open.as_ref().is_some_and(|(own, _)| *own != look) {
                    close(&mut out, open.take());
                }
                open.get_or_insert_with(|| (look, String::new())).1 += &path(&points);
            }
            None => {
                close(&mut out, open.take());
                if line.starts_with('<') {
                    out += &shorter(line)
                } else {
                    out += line
                }
                out.push('\n');
            }
        }
    }
    close(&mut out, open);
    out
}

/// The same picture for a page, which may have thousands of dots: filled circles that follow one another with one look
/// become the round ends of a path without length.
pub fn dotted(svg: &str) -> String {
    let mut out = String::with_capacity(svg.len());
    let mut lines = svg.lines().peekable();
    while let Some(line) = lines.next() {
        let Some((look, at)) = dot(line) else {
            out += line;
            out.push('\n');
            continue;
        };
        let mut all = vec![at];
        while let Some((_, at)) = lines.peek().and_then(|line| dot(line)).filter(|(next, _)| *next == look) {
            all.push(at);
            lines.next();
        }
        let (width, color) = look;
        let data: String = all.iter().map(|[x, y]| format!("M{x} {y}h0")).collect();
        let _ = writeln!(
            out,
            "<path fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\" stroke-linecap=\"round\" d=\"{data}\"/>"
        );
    }
    out
}

/// Diameter and colour, and the place, of a filled circle that hides what is below it.
fn dot(line: &str) -> Option<((u32, &str), [i32; 2])> {
    let rest = line.strip_prefix("<circle cx=\"")?.strip_suffix("\" stroke=\"none\" stroke-width=\"1\"/>")?;
    let (x, rest) = rest.split_once("\" cy=\"")?;
    let (y, rest) = rest.split_once("\" r=\"")?;
    let (radius, color) = rest.split_once("\" fill=\"")?;
    let radius: u32 = radius.parse().ok()?;
    Some(((2 * radius, color), [x.parse().ok()?, y.parse().ok()?]))
}

/// A tag without what goes without saying, and with the font once for the whole picture.
fn shorter(tag: &str) -> String {
    let font = format!(" font-family=\"{FONT}\"");
    if tag.starts_with("<svg ") {
        tag.replacen(" xmlns=", &format!("{font} xmlns="), 1)
    } else {
        tag.replace(&font, "").replace(" opacity=\"1\"", "")
    }
}

fn close(out: &mut String, path: Option<(&str, String)>) {
    if let Some((look, data)) = path {
        let _ = writeln!(out, "<path {} d=\"{data}\"/>", look.replace(" opacity=\"1\"", ""));
    }
}

/// Attributes and points of a line of plotters'; nothing of another element.
fn parsed(line: &str) -> Option<(&str, Vec<Point>)> {
    let (look, points) = line.strip_prefix("<polyline ")?.split_once(" points=\"")?;
    let points = points.strip_suffix("\"/>")?;
    let point = |pair: &str| {
        let (x, y) = pair.split_once(',')?;
        Some((x.parse().ok()?, y.parse().ok()?))
    };
    Some((look, points.split_whitespace().map(point).collect::<Option<_>>()?))
}

fn path(points: &[Point]) -> String {
    let kept = simplified(points);
    let Some(first) = kept.first() else { return String::new() };
    let mut text = format!("M{} {}l", first.0, first.1);
    for pair in kept.windows(2) {
        let (x, y) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        // A minus parts numbers, too.
        let gap = |value: i32| if value < 0 || text.ends_with('l') { "" } else { " " };
        let (before, between) = (gap(x), if y < 0 { "" } else { " " });
        let _ = write!(text, "{before}{x}{between}{y}");
    }
    text
}

fn simplified(points: &[Point]) -> Vec<Point> {
    points.iter().zip(kept(points)).filter(|(_, is_kept)| *is_kept).map(|(point, _)| *point).collect()
}

/// Which points are needed, in fine pixels: the others lie within an eighth of a pixel of the line through these.
///
/// Source: Douglas and Peucker (1973), Algorithms for the reduction of the number of points.
pub fn kept(points: &[Point]) -> Vec<bool> {
    let mut is_kept = vec![false; points.len()];
    let mut parts = vec![(0, points.len().saturating_sub(1))];
    while let Some((first, last)) = parts.pop() {
        for end in [first, last] {
            is_kept.get_mut(end).into_iter().for_each(|own| *own = true);
        }
        let distance = |k: usize| off(points[k], points[first], points[last]);
        let far = (first + 1..last).max_by(|a, b| distance(*a).total_cmp(&distance(*b)));
        if let Some(far) = far.filter(|far| distance(*far) > OFF) {
            parts.extend([(first, far), (far, last)]);
        }
    }
    is_kept
}

/// Distance of a point from a piece of a line.
fn off(point: Point, from: Point, to: Point) -> f64 {
    let less = |a: Point, b: Point| (f64::from(a.0 - b.0), f64::from(a.1 - b.1));
    let (along, own) = (less(to, from), less(point, from));
    let square = along.0 * along.0 + along.1 * along.1;
    let share = if square > 0.0 { (own.0 * along.0 + own.1 * along.1) / square } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    (own.0 - share * along.0).hypot(own.1 - share * along.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_one_look_become_one_path_and_all_else_stays() {
        let line = |points: &str, color: &str| {
            format!("<polyline fill=\"none\" opacity=\"1\" stroke=\"{color}\" points=\"{points}\"/>\n")
        };
        let svg = [
            "<svg>\n",
            &line("0,0 4,0 8,-4 ", "#1"),
            &line("9,9 7,8 ", "#1"),
            "<circle/>\n",
            &line("1,1 2,2 ", "#1"),
        ];
        let expected = "<svg>\n<path fill=\"none\" stroke=\"#1\" d=\"M0 0l4 0 4-4M9 9l-2-1\"/>\n<circle/>\n\
                        <path fill=\"none\" stroke=\"#1\" d=\"M1 1l1 1\"/>\n";
        assert_eq!(compact(&svg.concat()), expected);
    }

    #[test]
    fn dots_of_one_look_become_one_path() {
        let dot = |x: i32, color: &str| {
            format!(
                "<circle cx=\"{x}\" cy=\"7\" r=\"9\" fill=\"{color}\" stroke=\"none\" stroke-width=\"1\"/>\n"
            )
        };
        let ring = "<circle cx=\"1\" cy=\"7\" r=\"9\" fill=\"none\" stroke=\"#1\" stroke-width=\"4\"/>\n";
        let path = |color: &str, data: &str| {
            format!(
                "<path fill=\"none\" stroke=\"{color}\" stroke-width=\"18\" stroke-linecap=\"round\" d=\"{data}\"/>\n"
            )
        };
        let svg = [dot(1, "#1"), dot(-2, "#1"), dot(3, "#2"), ring.to_owned(), dot(4, "#2")].concat();
        let due = [path("#1", "M1 7h0M-2 7h0"), path("#2", "M3 7h0"), ring.to_owned(), path("#2", "M4 7h0")];
        assert_eq!(dotted(&svg), due.concat());
    }

    /// A turn stays, a point on the way goes, and so does one that was there already.
    #[test]
    fn points_on_the_line_of_their_neighbours_go() {
        assert_eq!(
            simplified(&[(0, 0), (5, 0), (10, 0), (10, 3), (10, 0)]),
            [(0, 0), (10, 0), (10, 3), (10, 0)]
        );
        assert_eq!(simplified(&[(0, 0)]), [(0, 0)]);
        assert!(simplified(&[]).is_empty());
    }
}

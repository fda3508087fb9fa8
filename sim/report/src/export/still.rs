//! PNG: the picture of a run as pixels.
//!
//! It reads what efam's own pictures consist of, a tag a line: rectangles, lines, paths of straight lines, circles, and
//! text between two tags. What else a file holds is passed over.

use super::font::Font;
use super::raster::{Canvas, Ink, Place};

/// Pixels of the PNG in one of the picture: sharp on a projector.
const SCALE: f32 = 2.0;
/// Width and height of a picture, at most.
const MOST_PIXELS: f32 = 6000.0;
/// Height of a small letter, in heights of the font.
const EX: f32 = 0.53;

/// A picture as PNG; none where the text is no picture of efam's.
pub fn png(svg: &str, font: Option<&Font>) -> Option<Vec<u8>> {
    let mut lines = svg.lines();
    let head = lines.find(|line| line.starts_with("<svg "))?;
    let [width, height] = [number(head, "width")?, number(head, "height")?];
    let view: Vec<f32> =
        attribute(head, "viewBox")?.split(' ').map(str::parse).collect::<Result<_, _>>().ok()?;
    let is_size = |size: f32| (1.0..=MOST_PIXELS).contains(&size);
    let fine = view.get(2).copied().filter(|fine| *fine >= 1.0)?;
    if !is_size(width) || !is_size(height) {
        return None;
    }
    let scale = SCALE * width / fine;
    let mut canvas = Canvas::new((SCALE * width) as u32, (SCALE * height) as u32, scale)?;
    while let Some(line) = lines.next() {
        let tag = line.trim_start_matches('<').split([' ', '>', '/']).next().unwrap_or_default();
        if tag == "text" {
            let words: Vec<&str> = lines.by_ref().take_while(|line| !line.starts_with("</text")).collect();
            if let Some(font) = font {
                let _ = text(&mut canvas, font, line, &unescaped(words.join(" ").trim()));
            }
        } else {
            let _ = shape(&mut canvas, tag, line);
        }
    }
    canvas.png()
}

/// Draws a shape; nothing where it lacks what its kind has.
fn shape(canvas: &mut Canvas, tag: &str, line: &str) -> Option<()> {
    let of = |name: &str| number(line, name);
    let opacity = of("opacity").unwrap_or(1.0);
    let ink = |name: &str| Some(Ink { color: color(attribute(line, name)?)?, opacity });
    let width = of("stroke-width").unwrap_or(1.0);
    let (fill, stroke) = (ink("fill"), ink("stroke"));
    if tag == "circle" {
        let (center, radius) = ([of("cx")?, of("cy")?], of("r")?);
        fill.into_iter().for_each(|fill| canvas.disc(center, radius, fill));
        stroke.into_iter().for_each(|stroke| canvas.circle(center, radius, stroke, width));
        return Some(());
    }
    let lines = match tag {
        "rect" => {
            let [x, y, wide, high] = [of("x")?, of("y")?, of("width")?, of("height")?];
            vec![vec![[x, y], [x + wide, y], [x + wide, y + high], [x, y + high], [x, y]]]
        }
        "line" => vec![vec![[of("x1")?, of("y1")?], [of("x2")?, of("y2")?]]],
        "path" => straight(attribute(line, "d")?)?,
        "polygon" | "polyline" => {
            let numbers = numbers(attribute(line, "points")?)?;
            vec![numbers.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()]
        }
        _ => return None,
    };
    fill.into_iter().for_each(|fill| lines.iter().for_each(|points| canvas.area(points, fill)));
    stroke.into_iter().for_each(|stroke| canvas.lines(&lines, stroke, width, false));
    Some(())
}

fn text(canvas: &mut Canvas, font: &Font, line: &str, words: &str) -> Option<()> {
    let size = number(line, "font-size")?;
    let anchor = match attribute(line, "text-anchor") {
        Some("middle") => 0.5,
        Some("end") => 1.0,
        _ => 0.0,
    };
    let below = attribute(line, "dy").map_or(Some(0.0), |dy| match dy.strip_suffix("ex") {
        Some(ex) => Some(EX * size * ex.parse::<f32>().ok()?),
        None => Some(size * dy.strip_suffix("em")?.parse::<f32>().ok()?),
    })?;
    // All turns are about the point of the text.
    let turned = attribute(line, "transform")
        .and_then(|turn| turn.strip_prefix("rotate(")?.split(',').next()?.trim().parse().ok());
    let at = [number(line, "x")?, number(line, "y")?];
    let ink = Ink::new(color(attribute(line, "fill")?)?);
    let place = Place { at, anchor, below, turned: turned.unwrap_or(0.0) };
    canvas.text(font, words, size, ink, place);
    Some(())
}

/// The value of an attribute.
fn attribute<'a>(line: &'a str, name: &str) -> Option<&'a str> {
    let begin = line.find(&format!(" {name}=\""))? + name.len() + 3;
    line[begin..].split('"').next()
}

fn number(line: &str, name: &str) -> Option<f32> {
    attribute(line, name)?.parse().ok().filter(|number: &f32| number.is_finite())
}

fn numbers(text: &str) -> Option<Vec<f32>> {
    let words = text.split([' ', ',']).filter(|word| !word.is_empty());
    words.map(|word| word.parse().ok().filter(|number: &f32| number.is_finite())).collect()
}

/// `#RRGGBB`; none is no colour.
fn color(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii())?;
    let part = |k: usize| u8::from_str_radix(&digits[2 * k..2 * k + 2], 16).ok();
    Some([part(0)?, part(1)?, part(2)?])
}

/// The lines of a path such as `M320 336l108 0 5 6M…`: from a point, on by steps.
fn straight(path: &str) -> Option<Vec<Vec<[f32; 2]>>> {
    let mut lines = Vec::new();
    for own in path.split('M').filter(|own| !own.trim().is_empty()) {
        let (begin, steps) = own.split_once('l').unwrap_or((own, ""));
        let spaced = |text: &str| numbers(&text.replace('-', " -"));
        let [x, y] = spaced(begin)?[..] else { return None };
        let mut line = vec![[x, y]];
        for step in spaced(steps)?.chunks(2) {
            let [dx, dy] = step else { return None };
            let [x, y] = line[line.len() - 1];
            line.push([x + dx, y + dy]);
        }
        lines.push(line);
    }
    Some(lines)
}

fn unescaped(text: &str) -> String {
    let text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"");
    text.replace("&apos;", "'").replace("&#39;", "'").replace("&amp;", "&")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_followed_step_by_step() {
        assert_eq!(
            straight("M3 4l1 0 0-2M5 6"),
            Some(vec![vec![[3.0, 4.0], [4.0, 4.0], [4.0, 2.0]], vec![[5.0, 6.0]]])
        );
        assert_eq!(straight("M3l1 0"), None);
        assert_eq!(color("#0072B2"), Some([0, 114, 178]));
        assert_eq!([color("none"), color("#12"), color("#ééé")], [None; 3]);
        assert_eq!(unescaped("a &lt; b &amp;lt;"), "a < b &lt;");
    }

    #[test]
    fn no_picture_and_one_too_large_are_none() {
        assert_eq!(png("", None), None);
        assert_eq!(png("<svg width=\"1e9\" height=\"10\" viewBox=\"0 0 40 40\">", None), None);
        assert_eq!(png("<svg width=\"10\" height=\"10\" viewBox=\"0 0 0 0\">", None), None);
        assert!(
            png("<svg width=\"10\" height=\"10\" viewBox=\"0 0 40 40\">\n<path d=\"M\"/>", None).is_some()
        );
    }
}

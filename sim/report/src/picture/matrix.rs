//! A matrix of correlations: a square each, its size by how strong, its sign in the number and in how it is
//! filled. Nothing in it needs colour.

use efam_inference::calibrate::calibration::Correlations;
use plotters::prelude::Text;
use plotters::prelude::{Circle, Rectangle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontDesc, FontFamily, FontStyle, ShapeStyle};

use crate::picture::panel::{FONT, px};
use crate::picture::text::shortened;
use crate::picture::{Area, BLACK, BLUE, Drawn, GREY, Picture, VERMILION, drawn, heading};

/// Side of a cell, height above the cells, width of the names' margin, pixels.
const CELL: f64 = 54.0;
const TOP: f64 = 86.0;
const NAMES: f64 = 380.0;
/// Names that a picture has room for.
const MOST: usize = 14;

/// The `number`-th matrix; nothing of a single parameter, or of more than can be read.
pub(super) fn correlations(number: usize, of: &Correlations) -> Option<Picture> {
    let count = of.names.len();
    if !(2..=MOST).contains(&count) {
        return None;
    }
    let (width, height) = (NAMES + CELL * count as f64 + 24.0, TOP + CELL * count as f64 + 20.0);
    let title = "Correlations of what was found together";
    let drawing = drawn((width as u32, height as u32), |page| {
        heading(page, title)?;
        for (row, name) in of.names.iter().enumerate() {
            let y = TOP + CELL * (row as f64 + 0.5);
            let name = format!("{}  {}", shortened(name, ((NAMES - 70.0) / 8.0) as usize), row + 1);
            write(page, &name, (NAMES - 10.0, y), 15.0, HPos::Right)?;
            let head = (NAMES + CELL * (row as f64 + 0.5), TOP - 16.0);
            write(page, &(row + 1).to_string(), head, 15.0, HPos::Center)?;
            for (column, value) in of.matrix[row].iter().enumerate() {
                cell(page, (row, column), *value)?;
            }
        }
        Ok(())
    });
    Some(Picture {
        name: format!("correlations-{number}"),
        title: title.to_owned(),
        caption: "Larger discs: stronger correlation; filled: positive, ring: negative. Above 0.95 the data fix only a combination.".to_owned(),
        drawing,
    })
}

fn cell(page: &Area, (row, column): (usize, usize), value: f64) -> Drawn {
    let corner = (NAMES + CELL * column as f64, TOP + CELL * row as f64);
    let at = |x: f64, y: f64| (px(corner.0 + x), px(corner.1 + y));
    let frame: ShapeStyle = GREY.stroke_width(px(0.8) as u32);
    page.draw(&Rectangle::new([at(0.0, 0.0), at(CELL, CELL)], frame))?;
    if row == column {
        return Ok(());
    }
    let radius = px(0.5 * (CELL - 24.0) * value.abs().min(1.0).sqrt());
    let style = if value >= 0.0 { BLUE.filled() } else { VERMILION.stroke_width(px(2.0) as u32) };
    page.draw(&Circle::new(at(0.5 * CELL, 0.5 * CELL - 8.0), radius, style))?;
    let text = format!("{}{:.2}", if value < 0.0 { "−" } else { "+" }, value.abs());
    write(page, &text, (corner.0 + 0.5 * CELL, corner.1 + CELL - 8.0), 12.0, HPos::Center)
}

fn write(page: &Area, text: &str, (x, y): (f64, f64), size: f64, side: HPos) -> Drawn {
    let font = FontDesc::new(FontFamily::Name(FONT), f64::from(px(size)), FontStyle::Normal);
    let style = font.color(&BLACK).pos(Pos::new(side, VPos::Center));
    page.draw(&Text::new(text.to_owned(), (px(x), px(y)), style))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_is_in_the_number_and_in_the_fill() {
        let names = vec!["a".to_owned(), "b".to_owned()];
        let svg = |r: f64| {
            let of = Correlations { names: names.clone(), matrix: vec![vec![1.0, r], vec![r, 1.0]] };
            correlations(1, &of).unwrap().drawing.svg
        };
        assert!(svg(-0.98).contains("−0.98") && svg(0.5).contains("+0.50"));
        assert_eq!(svg(0.5).matches("<circle").count(), 2);
        let alone = Correlations { names: vec!["a".to_owned()], matrix: vec![vec![1.0]] };
        assert!(correlations(1, &alone).is_none());
    }
}

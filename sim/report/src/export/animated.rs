//! GIF: the rod in motion, at the pace of the simulated time. The door to gif.
//!
//! It has at most 20 images a second, each as long on the screen as it lasts, and goes on for ever. An image after the
//! first holds the pixels that changed.

use std::borrow::Cow;
use std::io::{self, Write};

use ::gif::{DisposalMethod, Encoder, Frame, Repeat};
use models::quantity::Quantity;
use toml::Table as Toml;

use super::font::Font;
use super::raster::{Canvas, Ink, Place};
use super::stored::{Cells, Stored, Table};
use crate::SCENARIO;

/// Pixels.
const WIDTH: u32 = 640;
/// The same from the least to the most.
const HEIGHT: [f32; 2] = [240.0, 800.0];
const MARGIN: f32 = 32.0;
/// Hundredths of a second that an image lasts at least, in which GIF counts.
const LEAST_DELAY: u64 = 5;
/// Images, at most; those of a longer run last longer.
const MOST_IMAGES: u64 = 1200;
/// How long the tip is followed by its path, s.
const TRAIL: f64 = 1.0;
/// Points of that.
const TRAIL_POINTS: usize = 60;
/// Length of the clamp, as a share of the extent of the motion.
const CLAMP_LENGTH: f64 = 0.06;
/// Shades between white and a colour.
const SHADES: usize = 24;

// Source: Okabe and Ito (2008), Color universal design.
const ROD: [u8; 3] = [0, 114, 178];
const TIP: [u8; 3] = [213, 94, 0];
const PATH: [u8; 3] = [230, 159, 0];
const CLAMP: [u8; 3] = [0, 0, 0];
const COLORS: [[u8; 3]; 4] = [CLAMP, ROD, TIP, PATH];
/// The index of a pixel that stays as it was.
const SAME: u8 = 255;

/// A rod over time.
pub struct Motion<'a> {
    time: &'a [f64],
    /// Nodes in a row.
    width: usize,
    x: &'a [f64],
    z: &'a [f64],
    tip: [&'a [f64]; 2],
    /// Of the clamp above the level, rad.
    angle: f64,
}

impl<'a> Motion<'a> {
    /// The rod of a simulation; none of a run without one.
    pub fn of(run: &'a Stored) -> Option<Motion<'a>> {
        let table = run.tables.iter().find(|table| table.name == "trajectory" && table.rows > 0)?;
        let (x, z) = (numbers(table, "x_m")?, numbers(table, "z_m")?);
        let tip = [numbers(table, "tip_x_m")?, numbers(table, "tip_z_m")?];
        let time = table.time()?;
        let fits = x.0 == z.0 && x.0 > 1 && tip.iter().all(|own| own.0 == 1);
        let all = [x.1, z.1, tip[0].1, tip[1].1, time];
        let is_finite = all.iter().all(|own| own.iter().all(|value| value.is_finite()));
        (fits && is_finite && time.is_sorted()).then_some(Motion {
            time,
            width: x.0,
            x: x.1,
            z: z.1,
            tip: [tip[0].1, tip[1].1],
            angle: base_angle(run).unwrap_or(0.0),
        })
    }

    /// The row before an instant, and the share of the way to the next one.
    fn at(&self, time: f64) -> (usize, usize, f64) {
        let next = self.time.partition_point(|own| *own <= time).min(self.time.len() - 1);
        let row = next.saturating_sub(1);
        let step = self.time[next] - self.time[row];
        let share = if step > 0.0 { ((time - self.time[row]) / step).clamp(0.0, 1.0) } else { 0.0 };
        (row, next, share)
    }

    /// The tip at an instant, m.
    fn tip(&self, time: f64) -> [f64; 2] {
        let (row, next, share) = self.at(time);
        self.tip.map(|own| own[row] + share * (own[next] - own[row]))
    }

    /// The nodes at an instant, m.
    fn nodes(&self, time: f64) -> Vec<[f64; 2]> {
        let (row, next, share) = self.at(time);
        let mix = |own: &[f64], node: usize| {
            let [before, after] = [row, next].map(|row| own[row * self.width + node]);
            before + share * (after - before)
        };
        (0..self.width).map(|node| [mix(self.x, node), mix(self.z, node)]).collect()
    }

    /// Lowest and highest place of anything, m, by coordinate.
    fn extent(&self) -> [[f64; 2]; 2] {
        let of = |all: [&[f64]; 2]| {
            let values = || all.into_iter().flatten().copied();
            [values().fold(0.0, f64::min), values().fold(0.0, f64::max)]
        };
        [of([self.x, self.tip[0]]), of([self.z, self.tip[1]])]
    }
}

fn numbers<'a>(table: &'a Table, name: &str) -> Option<(usize, &'a [f64])> {
    let series = table.series.iter().find(|series| series.name == name)?;
    match &series.cells {
        Cells::Numbers { width, values } => Some((*width, values)),
        Cells::Words(_) => None,
    }
}

/// `rod.base_angle` of the run's scenario, rad.
fn base_angle(run: &Stored) -> Option<f64> {
    let (_, text) = run.files.iter().find(|(name, _)| *name == SCENARIO)?;
    let scenario: Toml = text.parse().ok()?;
    let angle = scenario.get("rod")?.get("base_angle")?.as_str()?;
    Quantity::parse(angle).ok()?.to("rad").ok()
}

/// From metres to pixels.
struct View {
    scale: f64,
    /// The pixel of the clamp.
    origin: [f64; 2],
    height: u32,
    /// Length of the clamp, m; it reaches to the left of the origin.
    clamp: f64,
}

impl View {
    fn of(motion: &Motion) -> View {
        let [[left, right], [low, high]] = motion.extent();
        let inside = f64::from(WIDTH as f32 - 2.0 * MARGIN);
        let most = f64::from(HEIGHT[1] - 2.0 * MARGIN);
        let clamp = CLAMP_LENGTH * (right - left).max(high - low).max(f64::MIN_POSITIVE);
        let (wide, high_by) = (right - left.min(-clamp), high - low);
        let scale = (inside / wide).min(most / high_by.max(f64::MIN_POSITIVE));
        let height = (scale * high_by) as f32 + 2.0 * MARGIN;
        let height = height.clamp(HEIGHT[0], HEIGHT[1]);
        let free = [inside - scale * wide, f64::from(height - 2.0 * MARGIN) - scale * high_by];
        let origin = [
            f64::from(MARGIN) + 0.5 * free[0] - scale * left.min(-clamp),
            f64::from(MARGIN) + 0.5 * free[1] + scale * high,
        ];
        View { scale, origin, height: height.round() as u32, clamp }
    }

    fn place(&self, [x, z]: [f64; 2]) -> [f32; 2] {
        [(self.origin[0] + self.scale * x) as f32, (self.origin[1] - self.scale * z) as f32]
    }
}

/// Writes the motion.
/// # Errors
/// What the file says.
pub(super) fn write(motion: &Motion, font: Option<&Font>, to: impl Write) -> io::Result<()> {
    let view = View::of(motion);
    let [first, last] = [0, motion.time.len() - 1].map(|row| motion.time[row]);
    // A run of more than a year is none that anyone would look at.
    let hundredths = (100.0 * (last - first)).round().clamp(0.0, 4e9) as u64;
    let delay = hundredths.div_ceil(MOST_IMAGES).clamp(LEAST_DELAY, u64::from(u16::MAX));
    let images = hundredths.div_ceil(delay).max(1);
    let height = view.height as u16;
    let palette = palette();
    let bytes: Vec<u8> = palette.iter().flatten().copied().collect();
    let mut file = Encoder::new(to, WIDTH as u16, height, &bytes).map_err(io::Error::other)?;
    file.set_repeat(Repeat::Infinite).map_err(io::Error::other)?;
    let mut film = Film::new(palette);
    for image in 0..images {
        let begin = image * delay;
        let time = first + begin as f64 / 100.0;
        let canvas = drawn(motion, &view, font, first, time);
        let canvas = canvas.ok_or_else(|| io::Error::other("no memory for an image"))?;
        let delay = delay.min(hundredths - begin) as u16;
        let frame = Frame { delay, dispose: DisposalMethod::Keep, ..film.next(canvas.pixels()) };
        file.write_frame(&frame).map_err(io::Error::other)?;
    }
    file.into_inner().map_err(io::Error::other)?.flush()
}

/// The rod at an instant.
fn drawn(motion: &Motion, view: &View, font: Option<&Font>, first: f64, time: f64) -> Option<Canvas> {
    let mut canvas = Canvas::new(WIDTH, view.height, 1.0)?;
    let begin = (time - TRAIL).max(first);
    let trail = (0..=TRAIL_POINTS).map(|k| begin + (time - begin) * k as f64 / TRAIL_POINTS as f64);
    let trail: Vec<[f32; 2]> = trail.map(|time| view.place(motion.tip(time))).collect();
    canvas.lines(&[trail], Ink { color: PATH, opacity: 0.6 }, 2.5, true);
    let size = view.clamp;
    let (sine, cosine) = motion.angle.sin_cos();
    let corners = [[-size, -0.6 * size], [0.0, -0.6 * size], [0.0, 0.6 * size], [-size, 0.6 * size]];
    let turned = corners.map(|[x, z]| view.place([cosine * x - sine * z, sine * x + cosine * z]));
    canvas.area(&turned, Ink::new(CLAMP));
    let tip = view.place(motion.tip(time));
    let rod: Vec<[f32; 2]> = motion.nodes(time).into_iter().map(|node| view.place(node)).collect();
    let end = rod[rod.len() - 1];
    canvas.lines(&[vec![end, tip]], Ink::new(TIP), 5.0, true);
    canvas.lines(&[rod], Ink::new(ROD), 5.0, true);
    canvas.disc(tip, 7.0, Ink::new(TIP));
    if let Some(font) = font {
        let place = Place { at: [WIDTH as f32 - 12.0, 12.0], anchor: 1.0, below: 14.0, turned: 0.0 };
        canvas.text(font, &format!("{time:.2} s"), 18.0, Ink::new(CLAMP), place);
    }
    Some(canvas)
}

/// White, and shades from white to each colour.
fn palette() -> Vec<[u8; 3]> {
    let shade = |color: [u8; 3], k: usize| {
        color.map(|part| (255.0 - (255.0 - f64::from(part)) * k as f64 / SHADES as f64).round() as u8)
    };
    let shades = COLORS.iter().flat_map(|color| (1..=SHADES).map(move |k| shade(*color, k)));
    let mut all: Vec<[u8; 3]> = std::iter::once([255; 3]).chain(shades).collect();
    // The last one is for pixels that stay.
    all.resize(usize::from(SAME) + 1, [255; 3]);
    all
}

/// The index of the colour that is most like another one; the last one is no colour.
fn nearest(palette: &[[u8; 3]], color: [u8; 3]) -> u8 {
    let distance = |own: &[u8; 3]| -> i32 {
        own.iter().zip(color).map(|(a, b)| (i32::from(*a) - i32::from(b)).pow(2)).sum()
    };
    let used = 1 + SHADES * COLORS.len();
    let best = palette[..used].iter().enumerate().min_by_key(|(_, own)| distance(own));
    best.map_or(0, |(index, _)| index as u8)
}

/// The image before, and the colours found so far.
struct Film {
    palette: Vec<[u8; 3]>,
    /// The index of each colour by its 24 bits, [`SAME`] where it was not found yet.
    known: Vec<u8>,
    /// Red, green, blue and opacity of each pixel; none before the first image.
    pixels: Vec<u8>,
    /// The index of each pixel.
    indices: Vec<u8>,
}

/// Bytes of a pixel.
const PIXEL: usize = 4;
/// Pixels that are compared at once, of which a row has a whole number: most stay as they were.
const AT_ONCE: usize = 32;

impl Film {
    fn new(palette: Vec<[u8; 3]>) -> Self {
        Self { palette, known: vec![SAME; 1 << 24], pixels: Vec::new(), indices: Vec::new() }
    }

    /// The index of a pixel's colour.
    fn index(&mut self, pixel: &[u8]) -> u8 {
        let color = [pixel[0], pixel[1], pixel[2]];
        let [red, green, blue] = color.map(usize::from);
        let place = red << 16 | green << 8 | blue;
        if self.known[place] == SAME {
            self.known[place] = nearest(&self.palette, color);
        }
        self.known[place]
    }

    /// The next image: what differs from the one before, within the smallest rectangle.
    fn next(&mut self, pixels: &[u8]) -> Frame<'static> {
        let width = WIDTH as usize;
        let count = pixels.len() / PIXEL;
        let is_first = self.pixels.is_empty();
        if is_first {
            // Of a colour that none has.
            self.pixels = vec![0; pixels.len()];
            self.indices = vec![SAME; count];
        }
        let mut fresh = vec![SAME; count];
        // Left, top, right and bottom of what differs.
        let mut box_of: Option<[usize; 4]> = None;
        for (part, now) in pixels.chunks(AT_ONCE * PIXEL).enumerate() {
            let first = part * AT_ONCE;
            if *now == self.pixels[PIXEL * first..][..now.len()] {
                continue;
            }
            for (k, pixel) in (first..).zip(now.chunks_exact(PIXEL)) {
                if *pixel == self.pixels[PIXEL * k..][..PIXEL] {
                    continue;
                }
                let index = self.index(pixel);
                if index != self.indices[k] {
                    (fresh[k], self.indices[k]) = (index, index);
                    let (x, y) = (k % width, k / width);
                    let [left, top, right, bottom] = box_of.unwrap_or([x, y, x, y]);
                    box_of = Some([left.min(x), top.min(y), right.max(x), bottom.max(y)]);
                }
            }
        }
        self.pixels.copy_from_slice(pixels);
        let [left, top, right, bottom] = box_of.unwrap_or_default();
        let rows = (top..=bottom).map(|row| &fresh[row * width + left..=row * width + right]);
        Frame {
            left: left as u16,
            top: top as u16,
            width: (right - left + 1) as u16,
            height: (bottom - top + 1) as u16,
            transparent: (!is_first).then_some(SAME),
            buffer: Cow::Owned(rows.collect::<Vec<_>>().concat()),
            ..Frame::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_holds_what_changed_and_every_colour_is_in_the_palette() {
        let mut film = Film::new(palette());
        let mut now = [255; PIXEL].repeat(4 * WIDTH as usize);
        let whole = film.next(&now);
        assert_eq!((whole.width, whole.height, whole.transparent), (640, 4, None));
        assert!(whole.buffer.iter().all(|own| *own == 0), "white");
        let mut put = |x: usize, y: usize, color: [u8; 3]| {
            let k = PIXEL * (y * WIDTH as usize + x);
            now[k..k + 3].copy_from_slice(&color);
            film.next(&now)
        };
        // Colours with the same index do not differ.
        let same = put(300, 3, [255, 255, 254]);
        assert_eq!((same.width, same.height, &same.buffer[..]), (1, 1, &[SAME][..]));
        let one = put(7, 1, ROD);
        let rod = 2 * SHADES as u8;
        assert_eq!((one.left, one.top, &one.buffer[..]), (7, 1, &[rod][..]));
        assert_eq!(one.transparent, Some(SAME));
        now[PIXEL * (WIDTH as usize + 7)..][..3].copy_from_slice(&[255; 3]);
        now[PIXEL * (2 * WIDTH as usize + 9)..][..3].copy_from_slice(&ROD);
        let part = film.next(&now);
        assert_eq!((part.left, part.top, part.width, part.height), (7, 1, 3, 2));
        assert_eq!(&part.buffer[..], [0, SAME, SAME, SAME, SAME, rod]);
        let palette = palette();
        assert_eq!(palette.len(), 256);
        for color in COLORS {
            assert_eq!(palette[usize::from(nearest(&palette, color))], color);
        }
    }
}

//! `efam export --to gif` and `--to png`: pixels against the run's own numbers.
//!
//! Goal: a GIF lasts as long as the run, and its tip is where the table has it at that instant; a PNG is the picture of
//! the run. Expected: positions to a pixel, by a scale that follows from the first and the lowest image.

use std::fs::{self, File};

use gif::{ColorOutput, DecodeOptions, Repeat};
use tiny_skia::Pixmap;

use crate::bench::Bench;

const SCENARIO: &str = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n[rod]\nnodes = 12\n\
    [run]\nduration = \"1.23 s\"\naccuracy = \"1 mm\"\n";
/// Of the tip.
const VERMILION: [u8; 3] = [213, 94, 0];

fn simulated(name: &str) -> Bench {
    let bench = Bench::new(name);
    bench.file("s.toml", SCENARIO);
    bench.json(&["simulate", "s.toml", "--csv", "--json", "--out", "run"]);
    bench
}

/// Time and tip of each sample, s and m.
fn tips(bench: &Bench) -> Vec<[f64; 3]> {
    let text = bench.text("run/trajectory.csv");
    let names: Vec<&str> = text.lines().next().expect("names").split(',').collect();
    let columns = ["time_s", "tip_x_m", "tip_z_m"]
        .map(|name| names.iter().position(|own| *own == name).expect("a column"));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        columns.map(|column| cells[column].parse().expect("a number"))
    };
    text.lines().skip(1).map(row).collect()
}

/// Where the tip is at an instant, m.
fn tip(tips: &[[f64; 3]], time: f64) -> [f64; 2] {
    let next = tips.iter().position(|own| own[0] >= time).unwrap_or(tips.len() - 1).max(1);
    let [before, after] = [tips[next - 1], tips[next]];
    let share = (time - before[0]) / (after[0] - before[0]);
    [1, 2].map(|k| before[k] + share * (after[k] - before[k]))
}

/// Mean place of the pixels of the tip's disc, x and y downwards: those with their colour all around.
fn disc(pixels: &[[u8; 3]], width: usize) -> [f64; 2] {
    let is_tip = |k: usize| pixels.get(k) == Some(&VERMILION);
    let around =
        |k: usize| (1..=4).all(|d| [k - d, k + d, k - d * width, k + d * width].into_iter().all(is_tip));
    let places: Vec<usize> =
        (4 * width..pixels.len() - 4 * width).filter(|k| is_tip(*k) && around(*k)).collect();
    assert!(!places.is_empty(), "no tip");
    let mean =
        |of: &dyn Fn(usize) -> usize| places.iter().map(|k| of(*k) as f64).sum::<f64>() / places.len() as f64;
    [mean(&|k| k % width), mean(&|k| k / width)]
}

#[test]
fn a_gif_lasts_as_long_as_the_run_and_its_tip_is_where_the_table_has_it() {
    let bench = simulated("slides-gif");
    let printed = bench.json(&["export", "run", "--to", "gif", "--json"]);
    assert_eq!((&printed["file"], &printed["format"]), (&"run.gif".into(), &"gif".into()));
    let mut options = DecodeOptions::new();
    options.set_color_output(ColorOutput::RGBA);
    let file = File::open(bench.0.join("run.gif")).expect("it was written");
    let mut decoder = options.read_info(file).expect("a GIF");
    let (width, height) = (usize::from(decoder.width()), usize::from(decoder.height()));
    assert_eq!(width, 640);
    let mut pixels = vec![[0; 3]; width * height];
    let (mut delays, mut discs) = (Vec::new(), Vec::new());
    while let Some(frame) = decoder.read_next_frame().expect("an image") {
        let across = usize::from(frame.width);
        for (k, pixel) in frame.buffer.chunks_exact(4).enumerate().filter(|(_, pixel)| pixel[3] > 0) {
            let (x, y) = (usize::from(frame.left) + k % across, usize::from(frame.top) + k / across);
            pixels[y * width + x] = [pixel[0], pixel[1], pixel[2]];
        }
        delays.push(u64::from(frame.delay));
        discs.push(disc(&pixels, width));
    }
    assert_eq!(decoder.repeat(), Repeat::Infinite);
    // 1.23 s by images of 50 ms, the last of 30 ms.
    assert_eq!(delays.iter().sum::<u64>(), 123);
    assert_eq!((delays.len(), delays[0], delays[24]), (25, 5, 3));
    let tips = tips(&bench);
    let due: Vec<[f64; 2]> = (0..25).map(|k| tip(&tips, 0.05 * f64::from(k))).collect();
    // The lowest image and the first one give scale and origin.
    let low = (0..25).min_by(|a, b| due[*a][1].total_cmp(&due[*b][1])).expect("images");
    let scale = (discs[low][1] - discs[0][1]) / (due[0][1] - due[low][1]);
    assert!(scale > 500.0, "{scale} pixels a metre");
    for (k, (seen, due_at)) in discs.iter().zip(&due).enumerate() {
        let x = discs[0][0] + scale * (due_at[0] - due[0][0]);
        let z = discs[0][1] - scale * (due_at[1] - due[0][1]);
        let off = (seen[0] - x).hypot(seen[1] - z);
        assert!(off < 1.5, "image {k}: the tip is {off} pixels off, at {seen:?}");
    }
    let bytes = fs::metadata(bench.0.join("run.gif")).expect("it was written").len();
    assert!(bytes < 200_000, "{bytes} bytes");
}

#[test]
fn a_png_is_the_picture_of_the_run() {
    let bench = simulated("slides-png");
    bench.json(&["export", "run", "--to", "png", "--json", "--out", "slide.png"]);
    let png = fs::read(bench.0.join("slide.png")).expect("it was written");
    let pixels = Pixmap::decode_png(&png).expect("a PNG");
    assert_eq!((pixels.width(), pixels.height()), (2400, 1640));
    let at = |x: u32, y: u32| {
        let pixel = pixels.pixel(x, y).expect("inside");
        [pixel.red(), pixel.green(), pixel.blue()]
    };
    assert_eq!(at(1, 1), [255; 3]);
    // A circle of the SVG has its colour at its centre.
    let svg = bench.text("run/release.svg");
    let of = |line: &str, name: &str| -> String {
        let begin = line.find(&format!(" {name}=\"")).expect(name) + name.len() + 3;
        line[begin..].split('"').next().expect("a value").to_owned()
    };
    let circle = svg.lines().rfind(|line| line.starts_with("<circle") && line.contains("fill=\"#D55E00\""));
    let circle = circle.expect("a picture has a mark");
    let place = ["cx", "cy"].map(|name| of(circle, name).parse::<f64>().expect("a number"));
    let seen = at((place[0] / 2.0) as u32, (place[1] / 2.0) as u32);
    // It may be a little transparent.
    let off = seen.iter().zip(VERMILION).map(|(a, b)| a.abs_diff(b)).max();
    assert!(off < Some(60), "{seen:?} at {circle}");
    let dark = pixels.pixels().iter().filter(|pixel| pixel.red() < 80 && pixel.green() < 80).count();
    assert!(dark > 5_000, "{dark} pixels of axes and letters");
}

#[test]
fn what_is_no_swing_or_no_picture_is_said_and_leaves_nothing() {
    let bench = Bench::new("slides-none");
    fs::create_dir_all(bench.0.join("run")).expect("the target folder can be written");
    bench.file("run/summary.json", "{ \"name\": \"a\", \"kind\": \"calibration\" }");
    bench.file("run/residuals.csv", "t_s,x_m\n0,1\n1,2\n");
    let (code, _, stderr) = bench.run(&["export", "run", "--to", "gif"]);
    let due = "error: run: holds no trajectory of a rod, which GIF needs; give the folder of `efam simulate`, of one run\n";
    assert_eq!((code, stderr.as_str()), (2, due));
    let (code, _, stderr) = bench.run(&["export", "run", "--to", "png"]);
    assert_eq!(code, 2);
    assert!(stderr.starts_with("error: run/release.svg: is no picture that efam drew ("), "{stderr}");
    bench.file("run/release.svg", "<svg width=\"1e30\" height=\"1\" viewBox=\"0 0 1 1\">\n");
    assert_eq!(bench.run(&["export", "run", "--to", "png"]).0, 2);
    bench.file("run/trajectory.csv", "time_s,x_00_m,x_01_m,z_00_m,z_01_m,tip_x_m,tip_z_m\n0,0,nan,0,0,1,0\n");
    assert_eq!(bench.run(&["export", "run", "--to", "gif"]).0, 2);
    assert_eq!(bench.left(), ["run"]);
}

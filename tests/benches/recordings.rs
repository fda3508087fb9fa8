//! Cost of reading a recording: 20 minutes of 30 markers at 100 Hz.

use std::path::Path;

use divan::Bencher;
use efam_recordings::{ReadOptions, parse};
use tests::recordings::C3d;

fn main() {
    divan::main();
}

const FRAMES: usize = 120_000;
const MARKERS: usize = 30;

fn position(marker: usize, frame: usize) -> Option<[f64; 3]> {
    let angle = frame as f64 * 0.08 + marker as f64;
    let is_lost = (frame + 100 * marker) % 1000 < 30;
    (!is_lost).then(|| [300.0 * angle.cos(), 2.0 * angle.sin(), 300.0 * angle.sin()])
}

fn read(bencher: Bencher, file: Vec<u8>, name: &str) {
    let input = || file.clone();
    let read = |file| parse(file, Path::new(name), &ReadOptions::default()).expect("it is read");
    bencher.with_inputs(input).bench_local_values(read);
}

/// C3D by processor (84 Intel, 85 DEC, 86 MIPS), as floats or integers.
#[divan::bench(args = [(84, true), (84, false), (85, true), (86, true)], sample_count = 5)]
fn c3d(bencher: Bencher, (processor, floats): (u8, bool)) {
    let labels = (0..MARKERS).map(|k| format!("M{k}")).collect();
    let file = C3d { labels, frames: FRAMES, ..C3d::small(processor, floats) };
    read(bencher, file.bytes(position), "a.c3d");
}

/// The same as a tidy table.
#[divan::bench(sample_count = 5)]
fn tidy(bencher: Bencher) {
    let mut text = "t_s".to_owned();
    (0..MARKERS).for_each(|k| text += &format!(",m{k}_x_mm,m{k}_y_mm,m{k}_z_mm"));
    for frame in 0..FRAMES {
        text += &format!("\n{:.2}", 0.01 * frame as f64);
        for marker in 0..MARKERS {
            match position(marker, frame) {
                Some([x, y, z]) => text += &format!(",{x:.3},{y:.3},{z:.3}"),
                None => text += ",,,",
            }
        }
    }
    read(bencher, text.into(), "a.csv");
}

//! Whether a run is as accurate as requested: `cargo run --release -p efam-tests --bin accuracy_study -- FIRST COUNT`.
//!
//! Draws scenarios, requests three accuracies, and compares the tip with a much finer run. Prints how often the true
//! error was within 1, 1.5 and 3 times the requested one, and each miss; with EFAM_ALL every run.

use rayon::prelude::*;
use tests::accuracy::{Found, found};

const ASKED: [f64; 3] = [5e-4, 5e-5, 5e-6];

fn main() {
    let mut words = std::env::args().skip(1).filter_map(|word| word.parse::<u64>().ok());
    let (first, count) = (words.next().unwrap_or(1), words.next().unwrap_or(20));
    let mut all: Vec<Found> =
        (first..first + count).into_par_iter().flat_map_iter(|seed| found(seed, &ASKED)).collect();
    all.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    let share = |limit: f64| {
        let within = all.iter().filter(|found| found.ratio <= limit).count();
        format!("{:.1} %", 100.0 * within as f64 / all.len() as f64)
    };
    let [asked, half, thrice] = [1.0, 1.5, 3.0].map(share);
    println!("{} runs: within what was asked {asked}, 1.5 times {half}, 3 times {thrice}", all.len());
    let tells_all = std::env::var("EFAM_ALL").is_ok();
    for found in all.iter().filter(|found| tells_all || found.ratio > 1.0) {
        println!("{:.2}{} {}", found.ratio, if found.warned { " warned" } else { " SILENT" }, found.text);
    }
}

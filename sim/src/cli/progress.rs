//! Progress on a terminal. The only file that names indicatif.

use std::time::{Duration, Instant};

pub use indicatif::ProgressBar;
use indicatif::ProgressStyle;

/// A bar over so many samples of simulated time.
pub fn bar(samples: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {percent} % of simulated time, {eta} left");
    let bar = ProgressBar::new(samples as u64);
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// A bar over so many steps of a kind.
pub fn steps(count: usize, kind: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {pos} of {len} {msg}, {eta} left");
    let bar = ProgressBar::new(count as u64).with_message(kind.to_owned());
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// A line that says what is being done; `has_thread` if it may have one that keeps it moving.
pub fn line(has_thread: bool) -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    if has_thread {
        bar.enable_steady_tick(Duration::from_millis(200));
    }
    bar
}

/// A run is looked at for so long before its end is foretold: most have ended by then.
const LOOK: Duration = Duration::from_secs(2);
/// What takes longer is worth a line.
const LONG: Duration = Duration::from_secs(60);

/// How long a run will take.
pub struct Cost {
    begin: Instant,
    duration: f64,
    is_told: bool,
}

impl Cost {
    /// Of a run of so many simulated seconds that begins now.
    pub fn new(duration: f64) -> Self {
        Self { begin: Instant::now(), duration, is_told: false }
    }

    /// Once, seconds after the begin: the time that a long run takes in all; from the simulated time that is
    /// reached, s.
    pub fn foretold(&mut self, time: f64) -> Option<Duration> {
        let so_far = self.begin.elapsed();
        if self.is_told || so_far < LOOK || time <= 0.0 {
            return None;
        }
        self.is_told = true;
        let whole = so_far.as_secs_f64() * self.duration / time;
        Duration::try_from_secs_f64(whole).ok().filter(|whole| *whole > LONG)
    }
}

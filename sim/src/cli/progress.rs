//! Progress on a terminal. The only file that names indicatif.

use std::time::Duration;

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

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

/// A run is watched for so long before its end is estimated: most have ended by then.
const LOOK: Duration = Duration::from_secs(2);
/// What takes longer is worth a line.
const LONG: Duration = Duration::from_secs(60);

/// How long a run will take.
pub struct Cost {
    begin: Instant,
    /// Simulated time of the last look, s.
    last: f64,
    duration: f64,
    is_told: bool,
}

impl Cost {
    /// Of a run of so many simulated seconds that begins now.
    pub fn new(duration: f64) -> Self {
        Self { begin: Instant::now(), last: 0.0, duration, is_told: false }
    }

    /// Once, seconds after the begin: the time that a long run takes in all; from the simulated time that is
    /// reached, s. Where that goes back, the run has begun anew, on another mesh.
    pub fn estimated(&mut self, time: f64) -> Option<Duration> {
        if time < self.last {
            self.begin = Instant::now();
        }
        self.last = time;
        let so_far = self.begin.elapsed();
        if self.is_told || so_far < LOOK || time <= 0.0 {
            return None;
        }
        self.is_told = true;
        let whole = so_far.as_secs_f64() * self.duration / time;
        Duration::try_from_secs_f64(whole).ok().filter(|whole| *whole > LONG)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_run_is_estimated_once_and_by_its_own_pace() {
        let begun = |ago: u64| Cost { begin: Instant::now() - Duration::from_secs(ago), ..Cost::new(20.0) };
        let whole =
            |cost: &mut Cost, time: f64| cost.estimated(time).map(|whole| whole.as_secs_f64().round());
        let mut slow = begun(4);
        assert_eq!([0.1, 0.2].map(|time| whole(&mut slow, time)), [Some(800.0), None]);
        assert_eq!(whole(&mut begun(4), 10.0), None, "of seconds nothing is said");
        // The first attempt took four seconds; the second has just begun.
        let mut again = Cost { last: 20.0, ..begun(4) };
        assert_eq!(whole(&mut again, 0.01), None);
    }
}

//! What is said on stderr while a command works, and on stdout when it is done.

use std::fmt::Display;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use efam_store::escape::escaped;
use serde::Serialize;

use super::progress::{self, ProgressBar};
use super::terminal::{is_watched, print_json, say};
use super::threads;
use crate::failure::Failure;

/// The verbosity of a command.
pub struct Console {
    /// No progress, no tables.
    pub quiet: bool,
    /// Stages, files and times, each on a line.
    pub verbose: bool,
    begin: Instant,
}

impl Console {
    pub fn new(quiet: bool, verbose: bool) -> Self {
        Self { quiet, verbose, begin: Instant::now() }
    }

    /// What one should know before trusting the results.
    pub fn warn(&self, warnings: impl IntoIterator<Item = impl Display>) {
        for warning in warnings {
            say(format_args!("warning: {warning}"));
        }
    }

    /// How long something will take that takes long.
    pub fn expect(&self, what: &str, whole: Duration) {
        if !self.quiet {
            let time = match whole.as_secs_f64() {
                whole if whole < 7200.0 => format!("{:.0} min", (whole / 60.0).ceil()),
                whole => format!("{:.0} h", (whole / 3600.0).ceil()),
            };
            say(format_args!(
                "{what}: about {time} at this pace; Ctrl-C ends it and keeps the results so far"
            ));
        }
    }

    /// A line for those who want to know more, after the time since the program began.
    pub fn detail(&self, text: impl Display) {
        if self.verbose {
            say(format_args!("[{:8.3} s] {text}", self.begin.elapsed().as_secs_f64()));
        }
    }

    /// Stages of something long.
    pub fn stages(&self) -> Stages<'_> {
        let line = || progress::line(!threads::is_alone());
        Stages { line: self.shows_progress().then(line), ..Stages::silent(self) }
    }

    /// Steps of a kind, so many.
    pub fn steps(&self, count: usize, kind: &str) -> Stages<'_> {
        let line = self.shows_progress().then(|| progress::steps(count, kind));
        Stages { line, count, kind: kind.to_owned(), ..Stages::silent(self) }
    }

    /// A bar over samples of simulated time.
    pub fn bar(&self, samples: usize) -> ProgressBar {
        if self.shows_progress() { progress::bar(samples) } else { ProgressBar::hidden() }
    }

    /// Lines of details and a line that moves would overwrite one another.
    fn shows_progress(&self) -> bool {
        !self.quiet && !self.verbose && is_watched()
    }
}

/// What is being done: on a line that moves, or each stage on a line of its own.
pub struct Stages<'a> {
    console: &'a Console,
    line: Option<ProgressBar>,
    /// Steps in all, of which kind, and how many are done.
    count: usize,
    kind: String,
    done: AtomicUsize,
}

impl<'a> Stages<'a> {
    fn silent(console: &'a Console) -> Self {
        Self { console, line: None, count: 0, kind: String::new(), done: AtomicUsize::new(0) }
    }

    /// Says what begins now; from any thread.
    pub fn tell(&self, what: &str) {
        match &self.line {
            Some(line) => line.set_message(escaped(what).into_owned()),
            None => self.console.detail(what),
        }
    }

    /// Prints a line that stays, unless all is to be quiet.
    pub fn announce(&self, text: impl Display) {
        let line = || say(format_args!("{text}"));
        match &self.line {
            Some(own) => own.suspend(line),
            None if self.console.quiet => {}
            None => line(),
        }
    }

    /// Says what has been done, where that is a line of its own.
    pub fn told(&self, what: &str) {
        if self.line.is_none() {
            self.console.detail(what);
        }
    }

    /// One more step is done; from any thread.
    pub fn step(&self) {
        let done = 1 + self.done.fetch_add(1, Ordering::Relaxed);
        match &self.line {
            Some(line) => line.inc(1),
            None if done.is_multiple_of(self.count.div_ceil(10)) => {
                self.console.detail(format!("{done} of {} {}", self.count, self.kind));
            }
            None => {}
        }
    }

    /// Leaves no trace on the terminal.
    pub fn clear(&self) {
        if let Some(line) = &self.line {
            line.finish_and_clear();
        }
    }
}

/// Prints one JSON object.
pub fn print(object: &impl Serialize) -> Result<(), Failure> {
    let json = serde_json::to_string(object).map_err(|_| {
        let why = "stdout: a path that is not UTF-8 has no JSON; the results are there, so leave out --json";
        Failure::Output(why.to_owned())
    })?;
    Ok(print_json(&json)?)
}

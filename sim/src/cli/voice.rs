//! What is said on stderr while a command works, and on stdout when it is done.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use serde::Serialize;

use super::failure::Failure;
use super::progress::{self, ProgressBar};

/// How a command speaks.
pub struct Voice {
    /// No progress, no tables.
    pub quiet: bool,
    /// Stages, files and times, each on a line.
    pub verbose: bool,
    begin: Instant,
}

impl Voice {
    pub fn new(quiet: bool, verbose: bool) -> Self {
        Self { quiet, verbose, begin: Instant::now() }
    }

    /// What one should know before trusting the results.
    pub fn warn(&self, warnings: impl IntoIterator<Item = impl Display>) {
        for warning in warnings {
            eprintln!("warning: {warning}");
        }
    }

    /// A line for those who want to know more, after the time since the program began.
    pub fn detail(&self, text: impl Display) {
        if self.verbose {
            eprintln!("[{:8.3} s] {text}", self.begin.elapsed().as_secs_f64());
        }
    }

    /// Stages of something long.
    pub fn stages(&self) -> Stages<'_> {
        Stages { line: self.shows_progress().then(progress::line), ..Stages::silent(self) }
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
        !self.quiet && !self.verbose && io::stderr().is_terminal()
    }
}

/// What is being done: on a line that moves, or each stage on a line of its own.
pub struct Stages<'a> {
    voice: &'a Voice,
    line: Option<ProgressBar>,
    /// Steps in all, of which kind, and how many are done.
    count: usize,
    kind: String,
    done: AtomicUsize,
}

impl<'a> Stages<'a> {
    fn silent(voice: &'a Voice) -> Self {
        Self { voice, line: None, count: 0, kind: String::new(), done: AtomicUsize::new(0) }
    }

    /// Says what begins now; from any thread.
    pub fn tell(&self, what: &str) {
        match &self.line {
            Some(line) => line.set_message(what.to_owned()),
            None => self.voice.detail(what),
        }
    }

    /// Says what has been done, where that is a line of its own.
    pub fn told(&self, what: &str) {
        if self.line.is_none() {
            self.voice.detail(what);
        }
    }

    /// One more step is done; from any thread.
    pub fn step(&self) {
        let done = 1 + self.done.fetch_add(1, Ordering::Relaxed);
        match &self.line {
            Some(line) => line.inc(1),
            None if done.is_multiple_of(self.count.div_ceil(10)) => {
                self.voice.detail(format!("{done} of {} {}", self.count, self.kind));
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
    let text = serde_json::to_string(object);
    // Only a path that is no Unicode has no JSON.
    let text = text.map_err(|error| Failure::Output(format!("stdout: no JSON can be made ({error})")))?;
    writeln!(io::stdout().lock(), "{text}")?;
    Ok(())
}

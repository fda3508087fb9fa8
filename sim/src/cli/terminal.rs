//! The one door to stdout and stderr. What would act on a terminal is shown as `\u{1b}` instead.
//!
//! Names of files, markers, keys and units come from others and may hold escape sequences. All text leaves through
//! here, whether a terminal reads it now or later, as from a file or behind `| less`.

use std::fmt::Arguments;
use std::io::{self, IsTerminal, Stdout, Write};

use efam_store::escape::{escaped, escaped_json, escaped_lines};

/// Text that goes to stdout; what is not on the screen or in the file when it ends is an error.
pub struct Output(Stdout);

/// Stdout. Call [`Output::end`] after the last line.
pub fn stdout() -> Output {
    Output(io::stdout())
}

impl Output {
    /// Sees that all has been written.
    /// # Errors
    /// What stdout said.
    pub fn end(mut self) -> io::Result<()> {
        self.flush()
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // Every piece comes from a formatted text, and so is whole.
        let text = String::from_utf8_lossy(bytes);
        self.0.write_all(escaped_lines(&text).as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// Prints a line of JSON.
/// # Errors
/// What stdout said.
pub fn print_json(json: &str) -> io::Result<()> {
    let mut to = io::stdout();
    writeln!(to, "{}", escaped_json(json))?;
    to.flush()
}

/// Says one line on stderr. That nobody listens any more, as after a terminal was closed, is no reason to stop.
pub fn say(line: Arguments) {
    let line = line.to_string();
    let _ = writeln!(io::stderr(), "{}", escaped(&line));
}

/// Says some lines on stderr whose colours are our own; names in them were escaped before.
pub fn say_coloured(text: &str) {
    let _ = io::stderr().write_all(text.as_bytes());
}

/// Whether somebody looks at stderr.
pub fn is_watched() -> bool {
    io::stderr().is_terminal()
}

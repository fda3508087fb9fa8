//! What a command says in the end.

use std::io::Write;
use std::path::Path;

use serde::Serialize;

use super::arguments::Output;
use super::browser;
use super::console::{Console, print};
use super::failure::Failure;
use super::terminal::stdout;

/// Prints an answer, as JSON or as a table above its folder, and shows its page on request.
pub fn answer(
    output: &Output,
    console: &Console,
    folder: &Path,
    printed: &impl Serialize,
    table: impl FnOnce() -> String,
) -> Result<(), Failure> {
    if output.form.json {
        print(printed)?;
    } else if !console.quiet {
        writeln!(stdout(), "{}\nresults in {}", table(), folder.display())?;
    }
    browser::show(output.open, folder, console);
    Ok(())
}

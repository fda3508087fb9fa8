//! What a test leaves out where something is not installed. The tests of the program compile this file, too.

use std::io::Write;

/// Says that a test leaves something out, also where the output of tests that pass is not shown. `EFAM_HAVE` names what
/// must be there, such as `disk,user`: in CI, where it is installed, leaving it out is an error.
pub fn skipped(what: &str, why: &str) {
    let have = std::env::var("EFAM_HAVE").unwrap_or_default();
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test").to_owned();
    assert!(!have.split(',').any(|own| own == what), "{test}: {what} must be there, and {why}");
    // The macros write where the output of a test is caught.
    let _ = writeln!(std::io::stderr(), "skipped: {test}: {why}");
}

//! Ctrl-C: the first one asks for an end at the next sample, the second one ends at once.

use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of a run that was interrupted.
pub const EXIT_CODE: u8 = 130;

static ASKED: AtomicBool = AtomicBool::new(false);

/// Listens from here on.
pub fn listen() {
    let handler = || {
        if ASKED.swap(true, Ordering::SeqCst) {
            std::process::exit(EXIT_CODE.into());
        }
    };
    // Without a handler Ctrl-C still ends the program.
    let _ = ctrlc::set_handler(handler);
}

/// Whether an end was asked for.
pub fn is_asked() -> bool {
    ASKED.load(Ordering::SeqCst)
}

//! Ctrl-C: the first one asks for an end at the next opportunity, the second one ends at once.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, LazyLock};
use std::thread;
use std::time::Duration;

use sim::forward::Cancel;

use super::failure::Failure;
use super::voice::Stages;

/// Exit code of what was interrupted.
pub const EXIT_CODE: u8 = 130;

static ASKED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// How long an interruption may go unnoticed.
const NOTICED: Duration = Duration::from_millis(50);
/// As a main thread has it.
const STACK: usize = 8 << 20;

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

/// Ends simulations when an end is asked for, within a step.
pub fn cancel() -> Cancel {
    Cancel::by(ASKED.clone())
}

/// Stops a command that was interrupted while it wrote, before its folder gets its name.
pub fn check() -> Result<(), Failure> {
    if is_asked() { Err(Failure::Interrupted) } else { Ok(()) }
}

/// Does what takes long. On Ctrl-C, `kept` is dropped, such as a folder that is not finished, and the program
/// ends: what works here keeps no state that would have to be put in order, and half a search says nothing.
pub fn during<K, T: Send>(kept: K, stages: &Stages, work: impl FnOnce() -> T + Send) -> (K, T) {
    during_or(kept, stages, work, || {
        Failure::Interrupted.report(false);
    })
}

/// The same with its own last words, for what keeps what it has done on its way.
pub fn during_or<K, T: Send>(
    kept: K,
    stages: &Stages,
    work: impl FnOnce() -> T + Send,
    last_words: impl FnOnce(),
) -> (K, T) {
    let (done, wait) = mpsc::channel::<()>();
    thread::scope(|scope| {
        let work = move || {
            let result = work();
            drop(done);
            result
        };
        let worker = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work);
        let worker = worker.expect("a thread can be had");
        // The channel breaks when the work is over, also when it panics.
        while wait.recv_timeout(NOTICED) == Err(RecvTimeoutError::Timeout) {
            if is_asked() {
                stages.clear();
                drop(kept);
                last_words();
                std::process::exit(EXIT_CODE.into());
            }
        }
        match worker.join() {
            Ok(result) => (kept, result),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

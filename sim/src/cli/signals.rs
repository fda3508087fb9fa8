//! Signals that end a command in order: Ctrl-C, and those by which systems and schedulers end a job.
//!
//! The first one requests an end at the next opportunity. A second Ctrl-C ends the program at once. Of the others a
//! second one changes nothing: kernel and shell both report a closed terminal, and schedulers repeat
//! themselves, while results are still being saved.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock, Once};

use efam_core::forward::Cancel;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Exit code of what Ctrl-C ended.
const CTRL_C: u8 = 128 + 2;

/// Whether an end was requested.
static ASKED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
/// By which signal; 0 for none.
static BY: AtomicUsize = AtomicUsize::new(0);
/// Whether nobody looks at [`ASKED`], so that a signal has to end the program itself.
static ALONE: AtomicBool = AtomicBool::new(false);

/// Listens from here on.
pub fn listen() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Without a handler a signal still ends the program.
        let _ = flag::register_conditional_shutdown(SIGINT, CTRL_C.into(), ASKED.clone());
        for signal in signals() {
            let _ = flag::register_conditional_shutdown(signal, 128 + signal, &ALONE);
            let _ = flag::register_usize(signal, &BY, signal as usize);
            let _ = flag::register(signal, ASKED.clone());
        }
    });
}

/// Ctrl-C; the end of a job; the end of a terminal, unless the program was started to outlive it (`nohup`); the end of
/// the processor time that the job was given.
#[cfg(unix)]
fn signals() -> impl Iterator<Item = i32> {
    use signal_hook::consts::{SIGHUP, SIGXCPU};
    [SIGINT, SIGTERM, SIGHUP, SIGXCPU].into_iter().filter(|signal| *signal != SIGHUP || !is_ignored(SIGHUP))
}

#[cfg(not(unix))]
fn signals() -> impl Iterator<Item = i32> {
    [SIGINT, SIGTERM].into_iter()
}

/// Whether whoever started the program had it ignore a signal. Only Linux says so without unsafe code.
///
/// Source: proc(5), `/proc/pid/status`, SigIgn: a mask in hexadecimal, the lowest bit for signal 1.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Makes a file that grows beyond what `ulimit -f` admits an error of writing. Unhandled, SIGXFSZ ends the program.
pub fn make_long_files_an_error() {
    #[cfg(unix)]
    {
        static MET: AtomicBool = AtomicBool::new(false);
        let _ = flag::register(signal_hook::consts::SIGXFSZ, &MET);
    }
}

/// Whether an end was requested.
pub fn is_requested() -> bool {
    ASKED.load(Ordering::SeqCst)
}

/// Ends simulations when an end is requested, within a step.
pub fn cancel() -> Cancel {
    Cancel::by(ASKED.clone())
}

/// Exit code of a command that was interrupted: 128 and the number of the signal, as shells have it.
pub fn exit_code() -> u8 {
    match BY.load(Ordering::SeqCst) {
        0 => CTRL_C,
        signal => 128 + signal as u8,
    }
}

/// Says whether nobody looks for a request.
pub(super) fn leave_alone(is_alone: bool) {
    ALONE.store(is_alone, Ordering::SeqCst);
}

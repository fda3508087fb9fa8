//! Signals that end a command in order: Ctrl-C, and those by which systems and schedulers end a job.
//!
//! The first one asks for an end at the next opportunity. A second Ctrl-C ends the program at once. Of the others a
//! second one changes nothing: a closed terminal is told by the kernel and by the shell, and schedulers repeat
//! themselves, while results are still being saved.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, LazyLock, Mutex, Once, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use efam_core::forward::Cancel;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::console::Stages;
use super::failure::{Failure, report};
use super::threads;

/// Exit code of what Ctrl-C ended.
const CTRL_C: u8 = 128 + 2;

/// Whether an end was requested.
static ASKED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
/// By which signal; 0 for none.
static BY: AtomicUsize = AtomicUsize::new(0);
/// Whether nobody looks at [`ASKED`], so that a signal has to end the program itself.
static ALONE: AtomicBool = AtomicBool::new(false);

/// How long an interruption may go unnoticed.
const NOTICED: Duration = Duration::from_millis(50);
/// As a main thread has it.
const STACK: usize = 8 << 20;

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

/// Ends simulations when an end is asked for, within a step.
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

/// Stops a command that was interrupted while it wrote, before its folder gets its name.
pub fn check() -> Result<(), Failure> {
    if is_requested() { Err(Failure::Interrupted) } else { Ok(()) }
}

/// Does what takes long. On a signal, `kept` is dropped, such as a folder that is not finished, and the program
/// ends: what works here keeps no state that would have to be put in order, and half a search says nothing.
pub fn during<K, T: Send>(kept: K, stages: &Stages, work: impl FnOnce() -> T + Send) -> (K, T) {
    during_or(kept, stages, work, || {
        report(&Failure::Interrupted, false);
    })
}

/// How a search ends that has an answer before it is over: when its time is spent, or by a signal.
pub struct Ending {
    until: Option<Instant>,
    has_answer: AtomicBool,
    stop: Arc<AtomicBool>,
}

impl Ending {
    /// After a time from now; a time beyond all clocks is none.
    pub fn after(budget: Duration) -> Self {
        Self {
            until: Instant::now().checked_add(budget),
            has_answer: AtomicBool::new(false),
            stop: Arc::default(),
        }
    }

    /// From here on there is an answer.
    pub fn begin(&self) {
        self.has_answer.store(true, Ordering::SeqCst);
    }

    /// Ends simulations when the search has to end.
    pub fn cancel(&self) -> Cancel {
        Cancel::by(self.stop.clone())
    }

    /// Asks for the end where the time is spent, or by a signal; whether that signal needs nothing more.
    fn takes_signal(&self) -> bool {
        let has_answer = self.has_answer.load(Ordering::SeqCst);
        let is_over = self.until.is_some_and(|until| Instant::now() >= until);
        if is_over || (has_answer && is_requested()) {
            self.stop.store(true, Ordering::SeqCst);
        }
        has_answer
    }
}

/// The same for a search whose answer so far is kept: on a signal, once there is one, it ends by itself.
pub fn during_search<K, T: Send>(
    kept: K,
    stages: &Stages,
    ending: &Ending,
    work: impl FnOnce() -> T + Send,
) -> (K, T) {
    wait_for(kept, stages, Some(ending), work, || {
        report(&Failure::Interrupted, false);
    })
}

/// The same with its own last words, for what keeps what it has done on its way.
pub fn during_or<K, T: Send>(
    kept: K,
    stages: &Stages,
    work: impl FnOnce() -> T + Send,
    last_words: impl FnOnce(),
) -> (K, T) {
    wait_for(kept, stages, None, work, last_words)
}

fn wait_for<K, T: Send>(
    kept: K,
    stages: &Stages,
    ending: Option<&Ending>,
    work: impl FnOnce() -> T + Send,
    last_words: impl FnOnce(),
) -> (K, T) {
    let (done, wait) = mpsc::channel::<()>();
    // Whoever can have a thread takes it.
    let work = Mutex::new(Some(move || {
        let result = work();
        drop(done);
        result
    }));
    let take = || work.lock().unwrap_or_else(PoisonError::into_inner).take();
    let run = || take().map(|work| work());
    thread::scope(|scope| {
        let worker = match threads::is_alone() {
            true => None,
            false => thread::Builder::new().stack_size(STACK).spawn_scoped(scope, run).ok(),
        };
        let Some(worker) = worker else {
            // There is no thread to be had. Nobody waits for a signal then, so it has to end the program itself.
            ALONE.store(true, Ordering::SeqCst);
            let result = run().expect("nobody else took the work");
            ALONE.store(false, Ordering::SeqCst);
            return (kept, result);
        };
        // The channel breaks when the work is over, also when it panics.
        while wait.recv_timeout(NOTICED) == Err(RecvTimeoutError::Timeout) {
            let is_taken = ending.is_some_and(Ending::takes_signal);
            if is_requested() && !is_taken {
                stages.clear();
                drop(kept);
                last_words();
                std::process::exit(exit_code().into());
            }
        }
        match worker.join() {
            Ok(result) => (kept, result.expect("nobody else took the work")),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

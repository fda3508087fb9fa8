//! Work that a signal ends in order, with what it has so far.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use efam_core::forward::Cancel;
use efam_store::{Folder, StoreError};

use super::console::Stages;
use super::failure::{Failure, report};
use super::{signals, threads};

/// How long an interruption may go unnoticed.
const NOTICED: Duration = Duration::from_millis(50);
/// As a main thread has it.
const STACK: usize = 8 << 20;

/// Stops a command that was interrupted while it wrote, before its folder gets its name.
pub fn check() -> Result<(), Failure> {
    if signals::is_requested() { Err(Failure::Interrupted) } else { Ok(()) }
}

/// Does what takes long. On a signal, `kept` is dropped, such as a folder that is not finished, and the program
/// ends: what works here keeps no state that would have to be put in order, and half a search says nothing.
pub fn during<K, T: Send>(kept: K, stages: &Stages, work: impl FnOnce() -> T + Send) -> (K, T) {
    during_or(kept, stages, work, || {
        report(&Failure::Interrupted, false);
    })
}

/// Writes results into a folder. On a signal nothing of them is left, and the program ends.
pub fn writing<T: Send>(folder: &Folder, stages: &Stages, write: impl FnOnce() -> T + Send) -> T {
    let last_words = || {
        folder.give_up();
        report(&Failure::Interrupted, false);
    };
    during_or((), stages, write, last_words).1
}

/// Writes results into a folder, and gives it its name unless a signal came. The folder under that name.
pub fn finished(
    folder: Folder,
    stages: &Stages,
    write: impl FnOnce(&Folder) -> Result<(), StoreError> + Send,
) -> Result<PathBuf, Failure> {
    writing(&folder, stages, || write(&folder))?;
    check()?;
    Ok(folder.finish()?)
}

/// How a search that has an answer before it is over is ended from outside: by a time limit, or by a signal.
pub struct Ending {
    until: Option<Instant>,
    has_answer: AtomicBool,
    stop: Arc<AtomicBool>,
}

impl Ending {
    /// After a time from now, if there is a limit; a time beyond all clocks is none.
    pub fn after(limit: Option<Duration>) -> Self {
        Self {
            until: limit.and_then(|limit| Instant::now().checked_add(limit)),
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

    /// Requests the end when the time limit has passed, or on a signal; whether that signal needs nothing more.
    fn takes_signal(&self) -> bool {
        let has_answer = self.has_answer.load(Ordering::SeqCst);
        let is_over = self.until.is_some_and(|until| Instant::now() >= until);
        if is_over || (has_answer && signals::is_requested()) {
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

/// The same with its own message at the end, for work that keeps its partial results.
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
        let worker = if threads::is_alone() {
            None
        } else {
            thread::Builder::new().stack_size(STACK).spawn_scoped(scope, run).ok()
        };
        let Some(worker) = worker else {
            // There is no thread to be had. Nobody waits for a signal then, so it has to end the program itself.
            signals::leave_alone(true);
            let result = run().expect("nobody else took the work");
            signals::leave_alone(false);
            return (kept, result);
        };
        // The channel breaks when the work is over, also when it panics.
        while wait.recv_timeout(NOTICED) == Err(RecvTimeoutError::Timeout) {
            let is_taken = ending.is_some_and(Ending::takes_signal);
            if signals::is_requested() && !is_taken {
                stages.clear();
                drop(kept);
                last_words();
                std::process::exit(signals::exit_code().into());
            }
        }
        match worker.join() {
            Ok(result) => (kept, result.expect("nobody else took the work")),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

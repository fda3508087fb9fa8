//! Long work on a thread of its own, while this one looks for Ctrl-C and says how far it has come.

use std::process;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::{self, Builder};
use std::time::Duration;

use efam_core::forward::Cancel;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::failure::EfamError;

/// How long an interruption may go unnoticed.
const NOTICED: Duration = Duration::from_millis(50);
/// As a main thread has it; that of a Python thread may be far smaller.
const STACK: usize = 8 << 20;
/// The process whose threads rayon's own pool has: the first that did long work.
static OWNER: OnceLock<u32> = OnceLock::new();

/// How far work has come; it is written on any thread, and read on that of the call.
#[derive(Default)]
pub struct Progress {
    done: AtomicUsize,
    all: AtomicUsize,
    doing: Mutex<String>,
}

impl Progress {
    /// One more of so many.
    pub fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    /// How many there are; nothing where that is not known.
    pub fn expect(&self, all: usize) {
        self.all.store(all, Ordering::Relaxed);
    }

    /// What is being done.
    pub fn say(&self, what: &str) {
        what.clone_into(&mut self.doing.lock().unwrap_or_else(PoisonError::into_inner));
    }

    fn seen(&self) -> Seen {
        let doing = self.doing.lock().unwrap_or_else(PoisonError::into_inner).clone();
        (self.done.load(Ordering::Relaxed), self.all.load(Ordering::Relaxed), doing)
    }
}

/// Done, of how many, and what is being done.
type Seen = (usize, usize, String);

/// Does work without the global lock. A signal cancels it, and becomes its exception.
pub fn watched<T: Send>(py: Python<'_>, work: impl FnOnce(Cancel) -> T + Send) -> PyResult<T> {
    followed(py, None, |cancel, _| work(cancel))
}

/// The same; `tell` is called with how far the work has come whenever that has changed, on the thread of the call. What
/// it raises ends the work as a signal does.
pub fn followed<T: Send>(
    py: Python<'_>,
    tell: Option<Py<PyAny>>,
    work: impl FnOnce(Cancel, &Progress) -> T + Send,
) -> PyResult<T> {
    let flag = Arc::new(AtomicBool::new(false));
    let cancel = Cancel::by(flag.clone());
    let progress = Progress::default();
    let mut told = Seen::default();
    let mut say = |py: Python<'_>| -> PyResult<()> {
        let Some(tell) = &tell else { return Ok(()) };
        let seen = progress.seen();
        if seen != told {
            tell.call1(py, seen.clone())?;
            told = seen;
        }
        Ok(())
    };
    let pool = pool_after_fork()?;
    py.detach(|| {
        let (done, wait) = mpsc::channel::<()>();
        thread::scope(|scope| {
            let own = &progress;
            let run = move || {
                let result = match &pool {
                    Some(pool) => pool.install(|| work(cancel, own)),
                    None => work(cancel, own),
                };
                drop(done);
                result
            };
            let worker = Builder::new().stack_size(STACK).spawn_scoped(scope, run);
            let worker = worker.map_err(|error| no_thread(&error))?;
            let mut interrupted = None;
            // The channel breaks when the work is over, also when it panics.
            while wait.recv_timeout(NOTICED) == Err(RecvTimeoutError::Timeout) {
                if interrupted.is_some() {
                    continue;
                }
                if let Err(raised) = Python::attach(|py| py.check_signals().and_then(|()| say(py))) {
                    flag.store(true, Ordering::Relaxed);
                    interrupted = Some(raised);
                }
            }
            let result = worker.join();
            match interrupted {
                Some(raised) => Err(raised),
                None => {
                    Python::attach(&mut say)?;
                    result.map_err(|_| {
                        EfamError::new_err("a fault of efam itself, told above on stderr; please report it")
                    })
                }
            }
        })
    })
}

/// Threads for one call in a process that was forked after its parent had worked: a fork copies no thread, so rayon's own
/// pool has none there, and would be waited for without end.
fn pool_after_fork() -> PyResult<Option<ThreadPool>> {
    if *OWNER.get_or_init(process::id) == process::id() {
        return Ok(None);
    }
    let pool = ThreadPoolBuilder::new().stack_size(STACK).build();
    pool.map(Some).map_err(|error| no_thread(&error))
}

fn no_thread(error: &dyn std::fmt::Display) -> PyErr {
    EfamError::new_err(format!("no thread can be had ({error}); raise ulimit -u"))
}

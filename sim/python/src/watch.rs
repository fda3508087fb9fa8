//! Long work on a thread of its own, while this one looks for Ctrl-C.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread::{self, Builder};
use std::time::Duration;

use pyo3::prelude::*;
use sim::forward::Cancel;

use crate::failure::EfamError;

/// How long an interruption may go unnoticed.
const NOTICED: Duration = Duration::from_millis(50);
/// As a main thread has it; that of a Python thread may be far smaller.
const STACK: usize = 8 << 20;

/// Does work without the global lock. A signal cancels it, and becomes its exception.
pub fn watched<T: Send>(py: Python<'_>, work: impl FnOnce(Cancel) -> T + Send) -> PyResult<T> {
    let flag = Arc::new(AtomicBool::new(false));
    let cancel = Cancel::by(flag.clone());
    py.detach(|| {
        let (done, wait) = mpsc::channel::<()>();
        thread::scope(|scope| {
            let run = move || {
                let result = work(cancel);
                drop(done);
                result
            };
            let worker = Builder::new().stack_size(STACK).spawn_scoped(scope, run);
            let worker = worker.map_err(|error| {
                EfamError::new_err(format!("no thread can be had ({error}); raise ulimit -u"))
            })?;
            let mut interrupted = None;
            // The channel breaks when the work is over, also when it panics.
            while wait.recv_timeout(NOTICED) == Err(RecvTimeoutError::Timeout) {
                if let Err(signal) = Python::attach(|py| py.check_signals()) {
                    flag.store(true, Ordering::Relaxed);
                    interrupted.get_or_insert(signal);
                }
            }
            let result = worker.join();
            match interrupted {
                Some(signal) => Err(signal),
                None => result.map_err(|_| {
                    EfamError::new_err("a fault of efam itself, told above on stderr; please report it")
                }),
            }
        })
    })
}

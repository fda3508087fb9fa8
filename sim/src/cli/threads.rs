//! The threads on which all computes: as many as RAYON_NUM_THREADS or the processors say, or as can be had.

use std::io;
use std::num::NonZero;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Sender};
use std::thread;

use rayon::{ThreadBuilder, ThreadPoolBuilder};

use crate::failure::Failure;

/// The variable that says how many; the name is rayon's, and what job scripts set.
const VARIABLE: &str = "RAYON_NUM_THREADS";
/// The most that may be requested. No machine that runs one program has more hardware threads today, and beyond
/// those threads only wait for one another.
const MOST: usize = 1024;

/// Whether the main thread is the only one.
static ALONE: AtomicBool = AtomicBool::new(false);

/// Whether no thread but the main one can be had.
pub fn is_alone() -> bool {
    ALONE.load(Ordering::Relaxed)
}

/// Starts the threads, and warns of fewer than were requested; with none the main thread does all.
///
/// A process may be refused threads by a limit on processes (`ulimit -u`, a container's `pids.max`). Rayon's own pool
/// panics then, and cannot be built a second time, so it is handed threads that are there already.
/// # Errors
/// [`Failure::Usage`] for a wrong variable.
pub fn begin() -> Result<Option<String>, Failure> {
    let wanted = wanted()?;
    let mut ready: Vec<Sender<ThreadBuilder>> = Vec::new();
    let refused = loop {
        // One more than the pool needs: a command waits for signals while another thread works.
        if ready.len() > wanted {
            break None;
        }
        let (give, take) = mpsc::channel::<ThreadBuilder>();
        let run = move || {
            if let Ok(own) = take.recv() {
                own.run();
            }
        };
        match thread::Builder::new().name(format!("worker {}", ready.len())).spawn(run) {
            Ok(_) => ready.push(give),
            Err(error) => break Some(error),
        }
    };
    let spare = ready.pop();
    let count = ready.len();
    let mut ready = ready.into_iter();
    let pool = match count {
        0 => {
            ALONE.store(true, Ordering::Relaxed);
            ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()
        }
        count => {
            let hand_over = |own| {
                let give = ready.next().ok_or_else(|| io::Error::other("fewer threads than were counted"))?;
                give.send(own).map_err(|_| io::Error::other("a thread has ended"))
            };
            ThreadPoolBuilder::new().num_threads(count).spawn_handler(hand_over).build_global()
        }
    };
    drop(spare);
    pool.map_err(|error| Failure::Output(format!("no threads can be had ({error}); raise ulimit -u")))?;
    Ok(refused.map(|error| {
        let have = if count > 1 { format!("{count} threads") } else { "one thread".to_owned() };
        format!(
            "{have} of {wanted} can be had ({error}), so this takes longer; raise the limit on processes (ulimit -u)"
        )
    }))
}

/// How many threads are requested.
fn wanted() -> Result<usize, Failure> {
    let Some(text) = std::env::var_os(VARIABLE).filter(|text| !text.is_empty()) else {
        return Ok(thread::available_parallelism().map_or(1, NonZero::get).min(MOST));
    };
    let count = text.to_str().and_then(|text| text.trim().parse().ok());
    count.filter(|count| (1..=MOST).contains(count)).ok_or_else(|| {
        let text = text.to_string_lossy();
        Failure::Usage(format!(
            "{VARIABLE} = {text}: must be a whole number from 1 to {MOST}; unset it to use all processors"
        ))
    })
}

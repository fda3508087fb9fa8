//! Results of parts that run in parallel.

use rayon::prelude::*;

/// The results in the order of their parts, such as a `Result` of all or the first failure in that order.
///
/// All parts are done, also where one fails: rayon's own collection into a `Result` returns the failure that comes
/// first in time, and leaves out parts, so that answers and counts of work differ from run to run.
pub(crate) fn in_order<T: Send, C: FromIterator<T>>(parts: impl ParallelIterator<Item = T>) -> C {
    parts.collect::<Vec<T>>().into_iter().collect()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::thread::sleep;
    use std::time::Duration;

    use super::*;

    /// The first part fails last, and the others are done beside it.
    #[test]
    fn the_first_failure_in_order_is_returned_when_all_parts_are_done() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
        let done = AtomicUsize::new(0);
        let part = |k: u64| -> Result<u64, u64> {
            sleep(Duration::from_millis(20 - k));
            done.fetch_add(1, Ordering::Relaxed);
            if k.is_multiple_of(2) { Err(k) } else { Ok(k) }
        };
        let all: Result<Vec<u64>, u64> = pool.install(|| in_order((0..20).into_par_iter().map(part)));
        assert_eq!((all, done.into_inner()), (Err(0), 20));
    }
}

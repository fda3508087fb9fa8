//! Goal: a run is as accurate as requested, or a warning says that it is not.
//! Setup: two drawn scenarios, which an earlier rule gave up too soon, against eight times finer
//! meshes; 200 at three: `accuracy_study`.
//! Expected: within 1.5 times the request; of the 200, but for one in twenty, and never three times it without a
//! warning.

use rayon::prelude::*;
use tests::accuracy::{Compared, Found, compared, found};

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn a_run_is_as_accurate_as_was_asked() {
    let all: Vec<Found> = (302..304_u64).into_par_iter().flat_map_iter(|seed| found(seed, &[5e-4])).collect();
    assert!(all.len() == 2, "{all:#?}");
    let off: Vec<_> = all.iter().filter(|found| found.ratio > 1.5).collect();
    assert!(off.is_empty(), "{off:#?}");
}

/// Accuracy `a` against `a / 10`: both paths lie within both errors, or a warning says that these cannot be trusted; and
/// the finer run is never the worse one by its own estimate. The range of seeds is drawn with friction, with and without
/// damping by the rate of bending; `EFAM_PAIRS` says how many, of which .ci/thorough takes 300.
#[test]
fn ten_times_the_accuracy_is_never_worse() {
    let count: u64 = std::env::var("EFAM_PAIRS").ok().and_then(|count| count.parse().ok()).unwrap_or(4);
    let all: Vec<Compared> = (1..=count).into_par_iter().filter_map(|seed| compared(seed, 5e-4)).collect();
    assert!(2 * all.len() as u64 > count, "{} of {count} came to an end", all.len());
    let warned = all.iter().filter(|pair| pair.warned).count();
    println!("{} pairs of accuracies, {warned} with errors that are not to be trusted", all.len());
    let wrong = |pair: &&Compared| (pair.ratio > 1.5 && !pair.warned) || pair.worse > 1.0;
    let wrong: Vec<_> = all.iter().filter(wrong).map(|pair| (pair.ratio, pair.worse, &pair.text)).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

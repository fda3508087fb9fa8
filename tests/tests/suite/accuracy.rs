//! Goal: a run is as accurate as was asked, or a warning says that it is not.
//! Setup: two drawn scenarios, which an earlier rule gave up too soon, against eight times finer
//! meshes; 200 at three: `accuracy_study`.
//! Expected: within 1.5 times what was asked; of the 200, but for one in twenty, and never three times it without a
//! warning.

use rayon::prelude::*;
use tests::accuracy::{Found, found};

#[test]
#[ignore = "long; .ci/run runs it"]
fn a_run_is_as_accurate_as_was_asked() {
    let all: Vec<Found> = (302..304_u64).into_par_iter().flat_map_iter(|seed| found(seed, &[5e-4])).collect();
    assert!(all.len() == 2, "{all:#?}");
    let off: Vec<_> = all.iter().filter(|found| found.ratio > 1.5).collect();
    assert!(off.is_empty(), "{off:#?}");
}

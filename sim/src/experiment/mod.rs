//! An experiment: recordings, what was measured in each, and the releases that are cut out of them.

pub mod release;

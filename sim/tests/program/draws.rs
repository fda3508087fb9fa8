//! Draws of tests that try many inputs: the same in CI, fresh ones by hand.

use std::time::{SystemTime, UNIX_EPOCH};

/// How many are tried: what a variable says, or else `usual`.
pub fn count(variable: &str, usual: usize) -> usize {
    std::env::var(variable).ok().and_then(|count| count.parse().ok()).unwrap_or(usual)
}

/// Whole numbers by xorshift64*, reproducible from a seed.
///
/// Source: Vigna (2016), ACM Transactions on Mathematical Software 42, 30.
pub struct Draws(u64);

impl Draws {
    /// The seed is fixed, or what `EFAM_SEED` says; `EFAM_SEED=new` takes a fresh one. It is printed, so that what was
    /// found can be found again.
    pub fn new(what: &str) -> Draws {
        let fresh =
            || SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |since| since.as_nanos() as u64);
        let seed = match std::env::var("EFAM_SEED").ok().as_deref() {
            Some("new") => fresh(),
            Some(seed) => seed.parse().expect("EFAM_SEED is a number, or new"),
            None => 24,
        };
        println!("{what}: EFAM_SEED={seed}");
        Draws(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// A number below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        (self.next() >> 33) as usize % end
    }

    /// One of some.
    pub fn one<'a, T: ?Sized>(&mut self, all: &[&'a T]) -> &'a T {
        all[self.below(all.len())]
    }

    /// True so often in a hundred.
    pub fn percent(&mut self, share: usize) -> bool {
        self.below(100) < share
    }
}

//! All suites in one binary.

mod accuracy;
mod architecture;
mod diagnosis;
mod documents;
mod generated;
mod hostile;
mod dynamics {
    mod accuracy;
    mod bump;
    mod creep_and_sticking;
    mod energy_budget;
    mod envelopes;
    mod equal_effects;
    mod linear_model;
    mod methods_agree;
    mod numbers_of_motions;
    mod pressure_changes;
    mod pressure_line;
    mod ring_down;
    mod starts;
}
mod inverse {
    mod analysed;
    mod between_pressures;
    mod blind_files;
    mod chain;
    mod coverage;
    mod poor_starts;
    mod predicted;
    mod pressures;
    mod same_answer;
    mod small_cases;
    mod units_and_order;
    mod written;
}
mod order {
    mod edge_length;
    mod step;
}
// Where generated laws look for them.
use models::{formula, written};

/// How property tests draw: the same cases each time, so many; `PROPTEST_RNG_SEED` draws others, `PROPTEST_CASES` more.
/// `.ci/thorough` does both, and prints the seed.
fn drawn(cases: u32) -> proptest::test_runner::Config {
    use proptest::test_runner::{Config, RngSeed};

    let wanted = std::env::var("PROPTEST_CASES").ok().and_then(|cases| cases.parse().ok());
    let usual = Config { cases: wanted.unwrap_or(cases), failure_persistence: None, ..Config::default() };
    match usual.rng_seed {
        RngSeed::Random => Config { rng_seed: RngSeed::Fixed(1), ..usual },
        RngSeed::Fixed(_) => usual,
    }
}

mod properties {
    mod allocation;
    mod catalogue;
    mod effort;
    mod energy;
    mod laws;
    mod round_trips;
    mod seen;
    mod sensitivities;
    mod similarity;
    mod strange;

    use proptest::test_runner::Config;

    use super::drawn;

    fn cases() -> Config {
        drawn(48)
    }
}
mod recordings {
    mod analysed_alike;
    mod errors;
    mod formats;
    mod mutations;
    mod samples;
}
mod twin {
    mod agreement;
    mod beam;
    mod drawn;
    mod hidden;
    mod hidden_at_rest;
    mod hidden_swings;
    mod lab;
    mod mesh;
    mod recording;
}

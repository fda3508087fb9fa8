//! All suites in one binary.

mod architecture;
mod readme;
mod dynamics {
    mod accuracy;
    mod bump;
    mod energy_budget;
    mod methods_agree;
    mod pressure_changes;
    mod ring_down;
    mod starts;
}
mod inverse {
    mod chain;
    mod coverage;
    mod poor_starts;
    mod pressures;
}
mod order {
    mod edge_length;
    mod step;
}
mod properties {
    mod allocation;
    mod catalogue;
    mod seen;
    mod sensitivities;
}
mod recordings {
    mod errors;
    mod formats;
    mod mutations;
    mod samples;
}
mod twin {
    mod agreement;
    mod beam;
    mod recording;
}

//! What can be wrong with a recording or its analysis.

/// Why an analysis has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AnalysisError {
    /// Samples are not evenly spaced in a way that makes sense.
    #[error("sampling step {step} s: must be positive")]
    Step {
        /// Time between samples, s.
        step: f64,
    },
    /// A value is missing; the caller fills or cuts gaps.
    #[error("sample {index} is {value}: fill or cut gaps before the analysis")]
    NotFinite {
        /// Its place in the recording, from 0.
        index: usize,
        /// The value found there.
        value: f64,
    },
    /// There is too little of the recording.
    #[error("{samples} samples: at least {least} are needed")]
    TooShort {
        /// Samples found.
        samples: usize,
        /// Samples needed.
        least: usize,
    },
    /// The spectrum has no peak.
    #[error(
        "no oscillation: the spectrum has no peak above {lowest:.3} rad/s; \
         try a recording of more than two periods"
    )]
    NoOscillation {
        /// Lowest angular frequency that the recording resolves, rad/s.
        lowest: f64,
    },
    /// A fit or a ratio of peaks needs more of them.
    #[error(
        "{found} upper peaks above rest: at least {least} are needed; try a longer recording, \
         a lower least prominence, or check the rest"
    )]
    TooFewPeaks {
        /// Peaks above rest.
        found: usize,
        /// Peaks needed.
        least: usize,
    },
    /// The recording begins at rest: nothing settles.
    #[error("the recording begins at its rest: no excursion to settle from")]
    BeginsAtRest,
    /// The recording ends before the tip has settled.
    #[error(
        "not settled: {last:.3e} m from rest at the end, {end:.3} s, outside of {band:.3e} m; \
         try a longer recording or check the rest"
    )]
    NotSettled {
        /// Distance from rest of the last sample, m.
        last: f64,
        /// Time of the last sample, s.
        end: f64,
        /// Half width of the band, m.
        band: f64,
    },
    /// The simplex search did not come to a point.
    #[error(
        "the search for {wanted} did not settle in {evaluations} evaluations; \
         try a start closer to the answer"
    )]
    SearchStalled {
        /// What was searched for, as a phrase.
        wanted: &'static str,
        /// Evaluations spent.
        evaluations: usize,
    },
    /// No beam hangs from its clamp as this tip does.
    #[error(
        "measured tip at x = {:.4} m, z = {:.4} m: must hang below the clamp, no farther than \
         {reach:.4} m from it", tip[0], tip[1]
    )]
    TipOutOfReach {
        /// Measured tip in W, m.
        tip: [f64; 2],
        /// Length of muscle and end fitting, m.
        reach: f64,
    },
    /// No bending stiffness gives this frequency.
    #[error(
        "natural frequency {:.3} Hz: no bending stiffness from 1/{reach} to {reach} times {bending_stiffness:.3e} \
         N m^2 gives it; check the mass of rod and end fitting", natural_frequency / std::f64::consts::TAU
    )]
    FrequencyOutOfReach {
        /// Natural angular frequency, rad/s.
        natural_frequency: f64,
        /// Where the search began, N m².
        bending_stiffness: f64,
        /// How far it went, as a factor.
        reach: f64,
    },
}

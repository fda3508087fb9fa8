//! How a diagnosis is made.

/// Node steps of a diagnosis at most, unless a budget is given: some ten times the usual diagnosis of a recording.
pub const USUAL_BUDGET: u64 = 2_000_000_000;

/// How a diagnosis is made.
#[derive(Clone, Debug, PartialEq)]
pub struct DiagnosisSettings {
    /// Probability that a round names an effect although none is missing.
    pub false_alarm: f64,
    /// Largest number of effects to add.
    pub most_effects: usize,
    /// Candidates that are left out.
    pub excluded: Vec<String>,
    /// Ranges of parameters of candidates that hold instead of those of the catalogue: path, and two values in SI.
    pub ranges: Vec<(String, (f64, f64))>,
    /// How well the experiment repeats, where that is stated: root mean square distance, m.
    pub repeatability: Option<f64>,
    /// Node steps from which on no further part of the search begins; see [`efam_core::work`].
    pub budget: u64,
}

impl Default for DiagnosisSettings {
    /// One in a hundred, three effects.
    fn default() -> Self {
        Self {
            false_alarm: 0.01,
            most_effects: 3,
            excluded: Vec::new(),
            ranges: Vec::new(),
            repeatability: None,
            budget: USUAL_BUDGET,
        }
    }
}

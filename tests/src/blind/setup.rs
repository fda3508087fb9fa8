//! What is off in the setup of a laboratory: recordings that are read and cleaned, with instants, noise and ghosts to
//! be found. Clamp or camera differ from what is stated, or a hand gives a push.

use std::fs;
use std::path::Path;
use std::time::Instant;

use efam_experiments::cleaning::clean;
use efam_experiments::experiment::Experiment;
use efam_inference::calibrate::Problem;
use efam_inference::diagnose::{Diagnosis, DiagnosisOutcome, DiagnosisSettings, Verdict, diagnose, problem};

use crate::twin::lab::Lab;
use crate::twin::random::Random;

/// What is off, with the bounds of its size in what is typical: angles of 2 to 5 degrees, and 1.2 to 3 rad/s, which a
/// release at 100 Hz distinguishes from another instant.
pub const KINDS: [(&str, [f64; 2]); 3] =
    [("frame_tilt", [17.5, 43.5]), ("clamp_tilt", [17.5, 43.5]), ("initial_velocity", [4.0, 10.0])];

/// One experiment with something off.
#[derive(Clone)]
pub struct Answer {
    /// What is off, and its size.
    pub hidden: (&'static str, f64),
    /// Seed of the experiment.
    pub seed: u64,
    /// What was said.
    pub diagnosis: Diagnosis,
    /// The models with it.
    pub repaired: Problem,
    /// How long it took, s.
    pub seconds: f64,
}

impl Answer {
    /// The first that is named: an effect, or what of the setup is not as stated.
    fn named(&self) -> Option<&str> {
        let effect = self.diagnosis.effects.first().map(|own| own.effect.as_str());
        match self.diagnosis.verdict {
            Verdict::Named | Verdict::Incomplete | Verdict::Class => effect,
            Verdict::Misstated | Verdict::NothingMissing => {
                self.diagnosis.contradictions.first().map(|own| own.parameter.as_str())
            }
            Verdict::Unknown => None,
        }
    }

    /// Whether what is off is named first.
    pub fn is_right(&self) -> bool {
        // A hand that pushes is part of the setup too.
        let own = match self.hidden.0 {
            "frame_tilt" => "tilt of the camera",
            "clamp_tilt" => "angle of the clamp",
            effect => effect,
        };
        let is_push = self.hidden.0 == "initial_velocity";
        self.named().is_some_and(|named| named.starts_with(own) || is_push && named.starts_with("push"))
    }

    /// In a line.
    pub fn told(&self) -> String {
        let (name, size) = self.hidden;
        let (is_right, said) = (self.is_right(), self.named().unwrap_or("no name"));
        let verdict = self.diagnosis.verdict;
        format!(
            "{name:18} x {size:6.2} {:7}  right {is_right:5}  {verdict:?}: {said}  {:.1} s",
            self.seed, self.seconds
        )
    }
}

/// The question of a seed: what is off, and how much.
pub fn hidden(kind: usize, seed: u64) -> (&'static str, f64) {
    let (name, [least, most]) = KINDS[kind];
    let mut random = Random::new(9_000_000 + seed);
    let size = random.between(least, most);
    // A hand pushes downwards or up, a camera leans to either side.
    (name, if random.share() < 0.5 { -size } else { size })
}

/// Draws it below a folder, reads it as a laboratory's, and diagnoses it.
/// # Errors
/// What keeps it from being written, read or diagnosed.
pub fn ask(hidden: (&'static str, f64), seed: u64, folder: &Path) -> Result<Answer, String> {
    let (name, size) = hidden;
    let words = ["drawn".to_owned(), seed.to_string(), format!("{name}={size}")];
    let lab = Lab::asked(&words).ok_or("no such effect")?;
    let file = folder.join("experiment.toml");
    fs::create_dir_all(folder).map_err(|error| error.to_string())?;
    fs::write(&file, lab.experiment()).map_err(|error| error.to_string())?;
    for (name, text) in lab.recordings() {
        fs::write(folder.join(name), text).map_err(|error| error.to_string())?;
    }
    let experiment = Experiment::load(&file, &[]).map_err(|error| error.to_string())?;
    let cleaned = clean(&experiment).map_err(|error| error.to_string())?;
    let problem = problem(&experiment, &cleaned).map_err(|error| error.to_string())?;
    let begin = Instant::now();
    let outcome = diagnose(&problem, &DiagnosisSettings::default(), &|_: &str| ())
        .map_err(|error| error.to_string())?;
    let (DiagnosisOutcome { diagnosis, repaired, .. }, seconds) = (outcome, begin.elapsed().as_secs_f64());
    Ok(Answer { hidden, seed, diagnosis, repaired, seconds })
}

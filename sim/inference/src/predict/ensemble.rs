//! The runs behind a prediction, to be shown side by side.

use efam_core::forward::Run;
use efam_experiments::scenario::Case;
use models::model::Model;
use models::muscle::Known;

use super::PredictionSettings;
use super::errors::Errors;

/// Draws that are shown.
const SHOWN: usize = 24;

/// One rod of an ensemble.
#[derive(Clone)]
pub struct Member {
    /// Its name.
    pub name: String,
    /// Its model.
    pub model: Model,
    /// How it is run.
    pub run: Run,
    /// Whether it is a draw from the errors of the calibration.
    pub is_draw: bool,
}

impl Member {
    /// A case as it is.
    pub fn case(case: &Case) -> Self {
        let run = Run { energy: false, ..case.run.clone() };
        Self { name: case.name.clone(), model: case.model.clone(), run, is_draw: false }
    }
}

/// The first draws of a prediction's, and the case itself.
pub fn ensemble(case: &Case, known: Option<&Known>, settings: &PredictionSettings) -> Vec<Member> {
    let errors = known.map(|known| Errors::new(known, case));
    let count = errors.as_ref().map_or(0, |_| settings.draws.min(SHOWN));
    let draw = |draw: usize| {
        let model = errors.as_ref()?.drawn(settings.seed, draw)?;
        Some(Member { name: format!("draw {}", draw + 1), model, is_draw: true, ..Member::case(case) })
    };
    let own = errors.as_ref().map_or(&case.model, |errors| &errors.model);
    let own = Member { model: own.clone(), ..Member::case(case) };
    (0..count).filter_map(draw).chain([own]).collect()
}

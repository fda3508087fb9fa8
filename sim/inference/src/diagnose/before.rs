//! The model without anything added, as a diagnosis begins with it.

use super::curve::Agreement;
use super::first_swings::FirstSwings;
use super::validation::{HeldOut, agreement};
use super::{Diagnosis, Listener, mesh_check};
use crate::calibrate::joint::{Estimate, Joint};
use crate::calibrate::{CalibrateError, Problem};

/// The baseline: its cost, how it meets what it was fitted to, and held-out releases; what it found.
pub(super) struct Before {
    pub model: Joint,
    pub cost: f64,
    pub fitted: Agreement,
    pub held_out: Option<HeldOut>,
    pub known: Vec<Estimate>,
    /// The first swings, where it does not meet even those.
    pub first_swings: Option<FirstSwings>,
}

impl Before {
    /// The baseline fitted to the whole recordings.
    pub fn searched(
        problem: &Problem,
        listener: &dyn Listener,
        diagnosis: &mut Diagnosis,
    ) -> Result<Self, CalibrateError> {
        let tell = |what: &str| listener.doing(&format!("baseline: {what}"));
        let (model, numerics) = mesh_check::on_fine_mesh(problem, &tell)?;
        diagnosis.numerics = numerics;
        listener.doing("validation on held-out releases");
        Self::of(model, HeldOut::meet, None)
    }

    /// A model that is shown held-out releases.
    pub fn of(
        model: Joint,
        show: fn(&Problem, &[Estimate]) -> Result<Option<HeldOut>, CalibrateError>,
        first_swings: Option<FirstSwings>,
    ) -> Result<Self, CalibrateError> {
        let (fitted, cost, known) = (agreement(&model), model.cost(), model.known());
        let held_out = show(&model.problem, &known)?;
        Ok(Self { model, cost, fitted, held_out, known, first_swings })
    }
}

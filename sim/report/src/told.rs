//! What a run comes to, and its page, before anything is written.

use std::time::SystemTime;

use efam_core::forward::Run;
use efam_core::rest::{Rest, rest};
use efam_core::trajectory::Trajectory;
use efam_experiments::summary::{self, Summary, Swings};
use efam_store::folder::utc;
use efam_store::sha::sha256;
use models::model::Model;

use crate::{Request, SCENARIO, picture, simulated};

/// What a run comes to, before anything is written.
pub struct Told {
    /// Its numbers.
    pub summary: Summary,
    rest: Option<Rest>,
    swings: Swings,
}

/// Summarises a run.
pub fn told(request: &Request, model: &Model, run: &Run, trajectory: &Trajectory) -> Told {
    let end = trajectory.times.last().copied().unwrap_or(0.0);
    let rest = rest(model, end, summary::MODES);
    let (numbers, swings) = summary::summarise(model, run, trajectory, &rest);
    let mut inputs_sha256 = request.input_hashes.clone();
    inputs_sha256.insert(SCENARIO.to_owned(), sha256(request.resolved_scenario.as_bytes()));
    let summary = Summary {
        name: request.name.clone(),
        warnings: request.warnings.iter().cloned().chain(numbers.warnings).collect(),
        wall_time_s: request.wall_time_s,
        real_time_factor: (request.wall_time_s > 0.0).then(|| end / request.wall_time_s),
        inputs_sha256,
        errors: request.errors.clone(),
        argv: request.argv.clone(),
        written_utc: utc(SystemTime::now()),
        ..numbers
    };
    Told { summary, rest: rest.ok(), swings }
}

impl Told {
    /// The page of the run.
    pub fn page(&self, request: &Request, model: &Model, run: &Run, trajectory: &Trajectory) -> String {
        let shown = self.shown(model, run, trajectory);
        let (pictures, rods) = (picture::released(&shown), picture::in_motion(&shown));
        simulated::page(request, &self.summary, &pictures, rods, SystemTime::now())
    }

    pub(super) fn shown<'a>(
        &'a self,
        model: &'a Model,
        run: &Run,
        trajectory: &'a Trajectory,
    ) -> picture::ReleasePicture<'a> {
        picture::ReleasePicture {
            model,
            trajectory,
            energy_followed: run.energy,
            rest: self.rest.as_ref(),
            summary: &self.summary,
            swings: &self.swings,
        }
    }
}

//! The core for a page in a browser: requests and answers are JSON texts.
//!
//! ```text
//! page ──▶ door (bytes) ──▶ answer(request) ──▶ catalogue, setup, live, release, fit ──▶ efam-core
//! ```
//!
//! | request | answer |
//! |---|---|
//! | [`Request::Catalogue`] | muscles, effects with parameters and pages, units |
//! | [`Request::LetGo`], [`Request::Change`], [`Request::Step`] | a rod that swings, as a [`live::Frame`] |
//! | [`Request::Rest`] | where the rod hangs, and its slowest modes |
//! | [`Request::Release`] | a whole run, with the numbers of `efam simulate` |
//! | [`Request::Fit`] | parameters fitted to a measured path of the tip |
//! | [`Request::Scenario`] | the setup as a scenario for `efam simulate` |
//! | [`Request::Experiment`] | setup and recording as an experiment for `efam calibrate` |
//!
//! All physics is that of `efam-core`; a new effect appears here by itself.

pub mod catalogue;
mod door;
pub mod error;
pub mod experiment;
pub mod fit;
pub mod live;
pub mod release;
pub mod scenario;
pub mod setup;

use std::collections::BTreeMap;

use efam_core::rest;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use error::PlaygroundError;
use live::Live;
use setup::Setup;

/// The requests of a page.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "ask", rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// What can be set.
    Catalogue,
    /// Lets a rod go; it replaces the one of that number.
    LetGo {
        /// Which rod.
        rod: u32,
        /// What it is.
        setup: Setup,
    },
    /// Changes a rod while it swings.
    Change {
        /// Which rod.
        rod: u32,
        /// What it is from now on.
        setup: Setup,
    },
    /// Goes on in time.
    Step {
        /// Which rod.
        rod: u32,
        /// For how long, s.
        duration: f64,
    },
    /// Where a rod hangs, and how it swings there.
    Rest {
        /// What it is.
        setup: Setup,
    },
    /// A whole run.
    Release {
        /// What is let go.
        setup: Setup,
    },
    /// Parameters from a measured path.
    Fit(fit::Fit),
    /// A text for `efam simulate`.
    Scenario {
        /// What is let go.
        setup: Setup,
    },
    /// A text for `efam calibrate`.
    Experiment {
        /// The model, with fitted values if there are any.
        setup: Setup,
        /// What was measured.
        recording: experiment::Recording,
    },
}

/// The rods that swing, by their numbers.
#[derive(Default)]
pub struct Playground {
    rods: BTreeMap<u32, Live>,
}

/// Modes that a page lists.
const MODES: usize = 3;

impl Playground {
    /// Answers a request: `{"ok": …}`, or `{"error": "what is wrong"}`.
    pub fn answer(&mut self, request: &str) -> String {
        let request = serde_json::from_str(request).map_err(PlaygroundError::from);
        match request.and_then(|request| self.result(request)) {
            Ok(value) => json!({ "ok": value }),
            Err(error) => json!({ "error": error.to_string() }),
        }
        .to_string()
    }

    fn result(&mut self, request: Request) -> Result<Value, PlaygroundError> {
        match request {
            Request::Catalogue => value(catalogue::catalogue()?),
            Request::LetGo { rod, setup } => {
                let mut live = Live::let_go(&setup)?;
                let frame = live.frame();
                self.rods.insert(rod, live);
                value(frame)
            }
            Request::Change { rod, setup } => {
                let live = self.rod(rod)?;
                live.change(&setup)?;
                value(live.frame())
            }
            Request::Step { rod, duration } => {
                let live = self.rod(rod)?;
                live.step(duration)?;
                value(live.frame())
            }
            Request::Rest { setup } => {
                let rest = rest::rest(&setup.model()?, 0.0, MODES)?;
                let modes = rest.modes.unwrap_or_default();
                value(json!({ "nodes": rest.nodes, "tip": rest.tip, "stable": rest.stable, "modes": modes }))
            }
            Request::Release { setup } => value(release::release(&setup)?),
            Request::Fit(fit) => value(fit.run()?),
            Request::Scenario { setup } => value(scenario::toml(&setup)?),
            Request::Experiment { setup, recording } => value(experiment::toml(&setup, &recording)?),
        }
    }

    fn rod(&mut self, rod: u32) -> Result<&mut Live, PlaygroundError> {
        self.rods.get_mut(&rod).ok_or(PlaygroundError::NoRod { rod })
    }
}

fn value(of: impl Serialize) -> Result<Value, PlaygroundError> {
    Ok(serde_json::to_value(of)?)
}

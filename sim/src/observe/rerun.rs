//! The rod in the Rerun viewer while it is integrated: the only door to that package.
//!
//! Everything is on the timeline `sim_time` (duration since release). Geometry is in W, metres,
//! below `world/fam/sim`; numbers are below `plots/<quantity with its unit>/sim`. Beside each `sim`
//! there is room for a `meas`. The viewer must be of the version of this library, 0.36.3.

use std::fs;
use std::io;
use std::mem;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use ::rerun::{RecordingStream, RecordingStreamBuilder, RecordingStreamError, RecordingStreamResult};
use efam_inference::calibrate::{self, Problem, Progress};
use efam_inference::diagnose::DiagnosisOutcome;
use efam_inference::diagnose::verdict::Round;
use efam_inference::predict::ensemble::Member;
use models::snapshot::Snapshot;

mod blueprint;
mod compared;
mod drawing;
mod ensemble;
mod entities;
mod fit;
mod scenery;
mod search;
mod sink;
mod tree;

use drawing::Drawing;
use fit::Fit;
use search::Search;
use sink::Destination;
pub use sink::{DEFAULT_PORT, Sink};

/// Groups runs in the viewer; they share a layout.
const APPLICATION: &str = "fam";

/// How long a viewer may take to swallow what is left at the end.
const VIEWER_PATIENCE: Duration = Duration::from_secs(10);

/// How long the disk may take for the same.
const DISK_PATIENCE: Duration = Duration::from_secs(60);
/// How often a server looks whether it is over.
const HELD: Duration = Duration::from_millis(50);

/// What stays the same during a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Title of the recording.
    pub run_name: String,
    /// Identity of the recording; runs from the same inputs should share it.
    pub recording_id: String,
    /// Length of the run, s, if it is known; plots then have room for all of it from the start.
    pub duration_s: f64,
    /// Length of the undeformed rod, m.
    pub rod_length_m: f64,
    /// Length of the end fitting beyond the last node, along the body's angle, m.
    pub body_length_m: f64,
    /// Mass of the payload, kg; drawn if positive.
    pub payload_kg: f64,
    /// Distance of the payload's centre of mass from the last node, along the body's angle, m.
    pub payload_com_m: f64,
    /// Names of the effects whose forces are drawn.
    pub effects: Vec<&'static str>,
    /// What else the viewer should show of the run, as name and value.
    pub properties: Vec<(String, String)>,
}

/// A recording in progress.
///
/// A viewer that is closed or hangs harms no run: what cannot be delivered waits in memory, up to
/// 1 GiB, half an hour of simulated time, and [`finish`](Self::finish) gives up on it after 10 s.
pub struct Stream<D = Drawing> {
    recording: Option<RecordingStream>,
    destination: Destination,
    drawing: D,
}

/// A recording of a diagnosis in progress, with the same patience: the ranking of the candidates on the
/// timeline `step`, and in the end each release on `sim_time`, measured and simulated before and after, below
/// `releases/<name>`.
pub type SearchStream = Stream<Search>;

/// A recording of a calibration in progress, with the same patience: residuals and parameters on the timeline
/// `step`, and in the end each release on `sim_time`, measured and as fitted, below `releases/<name>`.
pub type FitStream = Stream<Fit>;

/// A recording of an ensemble of rods, below `ensemble/<name>`, complete when it is opened.
pub type EnsembleStream = Stream<()>;

/// Why a recording cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum RerunError {
    /// No viewer is installed.
    #[error(
        "no program `rerun` on the PATH; install it with `pip install rerun-sdk==0.36.3`, or use `--rerun save`"
    )]
    ViewerMissing,
    /// The viewer's program does not run.
    #[error("the viewer `rerun` does not start ({0}); try `rerun --version`, or use `--rerun save`")]
    ViewerBroken(io::Error),
    /// The viewer runs, but opens no port.
    #[error(
        "the viewer started, but does not listen on port {port} after {seconds} s; without a display use `--rerun save`"
    )]
    ViewerSilent {
        /// Port it should listen on.
        port: u16,
        /// How long we waited, s.
        seconds: u64,
    },
    /// The viewer's address cannot be understood.
    #[error("{url}: is no address of a viewer; write HOST, HOST:PORT or rerun+http://HOST:PORT/proxy")]
    BadAddress {
        /// As given.
        url: String,
    },
    /// Nobody answers at the viewer's address.
    #[error("{url}: no viewer answers ({source}); start one there with `rerun`, or use `--rerun save`")]
    NoAnswer {
        /// The address that was requested.
        url: String,
        /// What the system said.
        source: io::Error,
    },
    /// The address to serve on cannot be had.
    #[error("{address}: cannot listen there ({source}); choose another port, 0 for a free one")]
    CannotListen {
        /// Where we would listen.
        address: SocketAddr,
        /// What the system said.
        source: io::Error,
    },
    /// The viewer would not open a file of this name.
    #[error("{}: a recording's name must end in .rrd; try {}", .path.display(), .path.with_extension("rrd").display())]
    NotRrd {
        /// As given.
        path: PathBuf,
    },
    /// The file cannot be written.
    #[error("{}: cannot be written ({reason}); check folder, permissions and free space", .path.display())]
    Unwritable {
        /// The recording or its folder.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// The viewer was closed or hangs, and did not get all.
    #[error(
        "{url}: the viewer did not take all of the run ({reason}); the run is unharmed, to see all use `--rerun save`"
    )]
    ViewerLost {
        /// Where it was.
        url: String,
        /// What is known of it.
        reason: String,
    },
    /// Rerun refused the data.
    #[error("rerun refused {what} ({source}); run without `--rerun`, and report it")]
    Refused {
        /// What was sent.
        what: &'static str,
        /// What it said.
        source: Box<RecordingStreamError>,
    },
}

impl Stream {
    /// Opens a recording, with its layout and all that does not move.
    /// # Errors
    /// If the file cannot be written, or the viewer or the port cannot be had.
    pub fn open(sink: &Sink, scene: &Scene) -> Result<Self, RerunError> {
        Self::begin(sink, &scene.recording_id, |recording, live| Drawing::begin(recording, scene, live))
    }

    /// Shows the rod at one instant; call with increasing time.
    /// # Errors
    /// [`RerunError::Refused`]; a viewer that left is reported at the end.
    pub fn log(&mut self, snapshot: &Snapshot) -> Result<(), RerunError> {
        self.show("a snapshot", |drawing, recording| drawing.log(recording, snapshot))
    }
}

impl SearchStream {
    /// Opens the recording of a diagnosis; runs from the same inputs should share its `recording_id`.
    /// # Errors
    /// If the file cannot be written, or the viewer or the port cannot be had.
    pub fn open_search(sink: &Sink, name: &str, recording_id: &str) -> Result<Self, RerunError> {
        Self::begin(sink, recording_id, |recording, live| Search::begin(recording, name, live))
    }

    /// Shows what is being done.
    /// # Errors
    /// [`RerunError::Refused`]; a viewer that left is reported at the end.
    pub fn doing(&mut self, what: &str) -> Result<(), RerunError> {
        self.show("a message", |search, recording| search.doing(recording, what))
    }

    /// Shows the candidates of a round.
    /// # Errors
    /// [`RerunError::Refused`]; a viewer that left is reported at the end.
    pub fn ranked(&mut self, number: usize, round: &Round) -> Result<(), RerunError> {
        self.show("a ranking", |search, recording| search.ranked(recording, number, round))
    }

    /// Shows the answer, and every release before and after.
    /// # Errors
    /// [`RerunError::Refused`]; a viewer that left is reported at the end.
    pub fn found(&mut self, outcome: &DiagnosisOutcome) -> Result<(), RerunError> {
        self.show("the answer", |search, recording| search.found(recording, outcome))
    }
}

impl FitStream {
    /// Opens the recording of a calibration; runs from the same inputs should share its `recording_id`.
    /// # Errors
    /// If the file cannot be written, or the viewer or the port cannot be had.
    pub fn open_fit(sink: &Sink, name: &str, recording_id: &str) -> Result<Self, RerunError> {
        Self::begin(sink, recording_id, |recording, live| Fit::begin(recording, name, live))
    }

    /// Shows what is being done.
    /// # Errors
    /// [`RerunError::Refused`]; a viewer that left is reported at the end.
    pub fn doing(&mut self, what: &str) -> Result<(), RerunError> {
        self.show("a message", |fit, recording| fit.doing(recording, what))
    }

    /// Shows how far a search has come.
    /// # Errors
    /// [`RerunError::Refused`]; a viewer that left is reported at the end.
    pub fn fitted(&mut self, progress: &Progress) -> Result<(), RerunError> {
        self.show("a stage", |fit, recording| fit.fitted(recording, progress))
    }

    /// Shows the answer, and every release as fitted.
    /// # Errors
    /// [`RerunError::Refused`]; a viewer that left is reported at the end.
    pub fn found(
        &mut self,
        problem: &Problem,
        outcome: &calibrate::CalibrationOutcome,
    ) -> Result<(), RerunError> {
        self.show("the answer", |fit, recording| fit.found(recording, problem, outcome))
    }
}

impl EnsembleStream {
    /// Opens the recording of an ensemble of rods, and draws it.
    /// # Errors
    /// If the file cannot be written, or the viewer or the port cannot be had.
    pub fn open_ensemble(
        sink: &Sink,
        name: &str,
        recording_id: &str,
        members: &[Member],
    ) -> Result<Self, RerunError> {
        Self::begin(sink, recording_id, |recording, live| ensemble::draw(recording, name, live, members))
    }
}

impl<D> Stream<D> {
    fn begin(
        sink: &Sink,
        recording_id: &str,
        draw: impl FnOnce(&RecordingStream, bool) -> RecordingStreamResult<D>,
    ) -> Result<Self, RerunError> {
        // Enabled whatever the environment variable RERUN says: the user requested a recording.
        let builder = RecordingStreamBuilder::new(APPLICATION).recording_id(recording_id).enabled(true);
        let (recording, destination) = sink.open(builder)?;
        // Wall time would differ between equal runs, and hide behind the time that matters.
        recording.set_log_time_enabled(false);
        let live = !matches!(destination, Destination::File { .. });
        let drawing = draw(&recording, live).map_err(refused("the scene"))?;
        Ok(Self { recording: Some(recording), destination, drawing })
    }

    fn show(
        &mut self,
        what: &'static str,
        draw: impl FnOnce(&mut D, &RecordingStream) -> RecordingStreamResult<()>,
    ) -> Result<(), RerunError> {
        match &self.recording {
            Some(recording) => draw(&mut self.drawing, recording).map_err(refused(what)),
            None => Ok(()),
        }
    }

    /// What to type to see it, once it is open or saved; nothing if a viewer shows it already.
    pub fn how_to_view(&self) -> Option<String> {
        match &self.destination {
            Destination::File { path, .. } => Some(format!("rerun {}", path.display())),
            Destination::Viewer { .. } => None,
            #[cfg(feature = "rerun-web")]
            Destination::Server { page, .. } => Some(page.url.clone()),
            #[cfg(not(feature = "rerun-web"))]
            Destination::Server { url } => Some(format!("rerun {url}")),
        }
    }

    /// Serves on until that is over; returns at once from all sinks but `Serve`.
    pub fn hold(&self, is_over: impl Fn() -> bool) {
        while matches!(self.destination, Destination::Server { .. }) && !is_over() {
            thread::sleep(HELD);
        }
    }

    /// Delivers what is left and closes; a file gets its footer and its name.
    /// # Errors
    /// [`RerunError::Unwritable`] if the disk is full; [`RerunError::ViewerLost`], which is worth a
    /// warning only.
    pub fn finish(mut self) -> Result<(), RerunError> {
        self.close()?;
        if let Destination::File { partial, path } = &self.destination {
            fs::rename(partial, path).map_err(|error| unwritable(path, error))?;
        }
        Ok(())
    }

    fn close(&mut self) -> Result<(), RerunError> {
        let Some(recording) = self.recording.take() else {
            return Ok(());
        };
        let patience = match self.destination {
            Destination::File { .. } => DISK_PATIENCE,
            Destination::Viewer { .. } | Destination::Server { .. } => VIEWER_PATIENCE,
        };
        let Err(error) = recording.flush_with_timeout(patience) else {
            return Ok(()); // dropped here, which writes the footer
        };
        // Its destructor waits without end for who does not listen.
        mem::forget(recording);
        Err(match &self.destination {
            Destination::File { partial, .. } => unwritable(partial, error),
            Destination::Viewer { url } | Destination::Server { url, .. } => {
                RerunError::ViewerLost { url: url.clone(), reason: error.to_string() }
            }
        })
    }
}

/// An abandoned file keeps its partial name; the viewer opens it.
impl<D> Drop for Stream<D> {
    fn drop(&mut self) {
        let _ = self.close();
    }
}

fn refused(what: &'static str) -> impl Fn(RecordingStreamError) -> RerunError {
    move |source| RerunError::Refused { what, source: Box::new(source) }
}

fn unwritable(path: &Path, reason: impl ToString) -> RerunError {
    RerunError::Unwritable { path: path.into(), reason: reason.to_string() }
}

//! `--rerun`: the rod in the viewer while it is integrated, a calibration or a diagnosis while it works, an ensemble
//! of rods that is predicted.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use efam_core::forward::Cancel;
use efam_experiments::scenario::Case;
use efam_inference::calibrate::{self, Problem, Progress};
use efam_inference::diagnose;
use efam_inference::diagnose::verdict::Round;
use efam_inference::predict::ensemble::Member;
use models::snapshot::Snapshot;

use super::console::Stages;
use super::failure::Failure;
use super::interrupt::Ending;

/// Name of a recording that is saved.
pub const RECORDING: &str = "run.rrd";

/// How to show the rod.
#[derive(Clone, Debug, PartialEq)]
pub enum Rerun {
    /// Into the results.
    Save,
    /// In a viewer that is started.
    Spawn,
    /// In a viewer that runs already, here or at an address.
    Connect(Option<String>),
    /// On a port to which viewers may connect.
    Serve,
}

impl Rerun {
    pub fn parse(text: &str) -> Result<Rerun, String> {
        match text.split_once('=') {
            None if text == "save" => Ok(Rerun::Save),
            None if text == "spawn" => Ok(Rerun::Spawn),
            None if text == "serve" => Ok(Rerun::Serve),
            None if text == "connect" => Ok(Rerun::Connect(None)),
            Some(("connect", url)) => Ok(Rerun::Connect(Some(url.to_owned()))),
            _ => Err("write save, spawn, connect, connect=URL or serve".to_owned()),
        }
    }
}

#[cfg(feature = "rerun")]
pub use with_rerun::{Live, LiveEnsemble, LiveFit, LiveSearch};
#[cfg(not(feature = "rerun"))]
pub use without::{Live, LiveEnsemble, LiveFit, LiveSearch};

/// A recording that is delivered in the end.
pub trait Recording: Sized {
    /// Delivers what is left; a server goes on until it is interrupted.
    fn finish(self, hold: bool) -> Result<(), Failure>;

    /// Delivers a file, which belongs to the results; a viewer is given back, to be served when they are there.
    fn saved(live: Option<Self>, how: Option<&Rerun>) -> Result<Option<Self>, Failure> {
        match live {
            Some(live) if how == Some(&Rerun::Save) => live.finish(false).map(|()| None),
            live => Ok(live),
        }
    }

    /// Delivers what a viewer has not yet.
    fn shown(live: Option<Self>, how: Option<&Rerun>) -> Result<(), Failure> {
        live.map_or(Ok(()), |live| live.finish(how == Some(&Rerun::Serve)))
    }
}

/// The value behind the mutex of the live views, when they are done.
pub fn unlocked<L>(live: Option<Mutex<L>>) -> Option<L> {
    live.map(|live| live.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// Sees a search go on: the line of progress, and the viewer.
pub struct Watcher<'a, L> {
    pub stages: &'a Stages<'a>,
    pub live: Option<&'a Mutex<L>>,
    /// How a search is ended that has an answer.
    pub ending: Option<&'a Ending>,
}

impl<L> Watcher<'_, L> {
    /// What the viewer refuses is no reason to stop a search.
    fn show(&self, show: impl FnOnce(&mut L) -> Result<(), Failure>) {
        if let Some(live) = self.live {
            let _ = show(&mut live.lock().unwrap_or_else(PoisonError::into_inner));
        }
    }
}

impl diagnose::Listener for Watcher<'_, LiveSearch> {
    fn doing(&self, what: &str) {
        self.stages.tell(what);
        self.show(|live| live.doing(what));
    }

    fn ranked(&self, number: usize, round: &Round) {
        self.show(|live| live.ranked(number, round));
    }

    fn began(&self) {
        if let Some(ending) = self.ending {
            ending.begin();
        }
    }

    fn stop(&self) -> Cancel {
        self.ending.map(Ending::cancel).unwrap_or_default()
    }
}

impl calibrate::Listener for Watcher<'_, LiveFit> {
    fn doing(&self, what: &str) {
        self.stages.tell(what);
        self.show(|live| live.doing(what));
    }

    fn fitted(&self, progress: &Progress) {
        self.show(|live| live.fitted(progress));
    }
}

#[cfg(feature = "rerun")]
mod with_rerun {
    use super::super::signals;
    use super::super::terminal::say;
    use super::*;
    use crate::observe::rerun::{EnsembleStream, FitStream, RerunError, Scene, SearchStream, Sink, Stream};

    /// A recording in progress: of a run, unless it says otherwise.
    pub struct Live<S = Stream>(S);

    /// That of a diagnosis.
    pub type LiveSearch = Live<SearchStream>;
    /// That of a calibration.
    pub type LiveFit = Live<FitStream>;
    /// An ensemble of rods, drawn when it is opened.
    pub type LiveEnsemble = Live<EnsembleStream>;

    impl Live {
        pub fn open(how: &Rerun, case: &Case, folder: &Path) -> Result<Live, Failure> {
            opened(how, Stream::open(&sink(how, folder), &scene(case)))
        }

        pub fn log(&mut self, snapshot: &Snapshot) -> Result<(), Failure> {
            self.0.log(snapshot).map_err(failure)
        }
    }

    impl LiveSearch {
        pub fn search(how: &Rerun, name: &str, id: &str, folder: &Path) -> Result<LiveSearch, Failure> {
            opened(how, SearchStream::open_search(&sink(how, folder), name, id))
        }

        pub fn doing(&mut self, what: &str) -> Result<(), Failure> {
            self.0.doing(what).map_err(failure)
        }

        pub fn ranked(&mut self, number: usize, round: &Round) -> Result<(), Failure> {
            self.0.ranked(number, round).map_err(failure)
        }

        pub fn found(&mut self, outcome: &diagnose::DiagnosisOutcome) -> Result<(), Failure> {
            self.0.found(outcome).map_err(failure)
        }
    }

    impl LiveFit {
        pub fn fit(how: &Rerun, name: &str, id: &str, folder: &Path) -> Result<LiveFit, Failure> {
            opened(how, FitStream::open_fit(&sink(how, folder), name, id))
        }

        pub fn doing(&mut self, what: &str) -> Result<(), Failure> {
            self.0.doing(what).map_err(failure)
        }

        pub fn fitted(&mut self, progress: &Progress) -> Result<(), Failure> {
            self.0.fitted(progress).map_err(failure)
        }

        pub fn found(
            &mut self,
            problem: &Problem,
            outcome: &calibrate::CalibrationOutcome,
        ) -> Result<(), Failure> {
            self.0.found(problem, outcome).map_err(failure)
        }
    }

    impl LiveEnsemble {
        pub fn ensemble(
            how: &Rerun,
            name: &str,
            id: &str,
            folder: &Path,
            members: &[Member],
        ) -> Result<LiveEnsemble, Failure> {
            opened(how, EnsembleStream::open_ensemble(&sink(how, folder), name, id, members))
        }
    }

    impl<D> Recording for Live<Stream<D>> {
        fn finish(self, hold: bool) -> Result<(), Failure> {
            if hold {
                self.0.hold(signals::is_requested);
            }
            match self.0.finish() {
                Err(error @ RerunError::ViewerLost { .. }) => {
                    say(format_args!("warning: {error}"));
                    Ok(())
                }
                done => done.map_err(failure),
            }
        }
    }

    fn opened<D>(how: &Rerun, stream: Result<Stream<D>, RerunError>) -> Result<Live<Stream<D>>, Failure> {
        let stream = stream.map_err(failure)?;
        if let Some(how) = stream.how_to_view().filter(|_| *how == Rerun::Serve) {
            say(format_args!("to see it: {how}"));
        }
        Ok(Live(stream))
    }

    fn sink(how: &Rerun, folder: &Path) -> Sink {
        match how {
            Rerun::Save => Sink::Save(folder.join(RECORDING)),
            Rerun::Spawn => Sink::Spawn,
            Rerun::Connect(url) => Sink::Connect(url.clone()),
            Rerun::Serve => Sink::serve_here(),
        }
    }

    fn failure(error: RerunError) -> Failure {
        Failure::Output(error.to_string())
    }

    fn scene(case: &Case) -> Scene {
        let model = &case.model;
        Scene {
            run_name: case.name.clone(),
            recording_id: efam_store::sha::sha256(case.resolved().as_bytes()),
            duration_s: case.run.duration,
            rod_length_m: model.rod().length,
            body_length_m: model.tip_distance,
            payload_kg: model.value_or_zero("effects.payload.mass"),
            payload_com_m: model.value_or_zero("effects.payload.center_of_mass"),
            effects: model.exerting(),
            properties: case.warnings.iter().map(|text| ("warning".to_owned(), text.clone())).collect(),
        }
    }
}

#[cfg(not(feature = "rerun"))]
mod without {
    use std::marker::PhantomData;

    use super::*;

    enum Never {}

    /// There is none in a program that was built without Rerun.
    pub struct Live<S = ()>(Never, PhantomData<S>);

    pub type LiveSearch = Live<diagnose::DiagnosisOutcome>;
    pub type LiveFit = Live<calibrate::CalibrationOutcome>;
    pub type LiveEnsemble = Live<Member>;

    impl Live {
        pub fn open(_: &Rerun, _: &Case, _: &Path) -> Result<Live, Failure> {
            Err(missing())
        }

        pub fn log(&mut self, _: &Snapshot) -> Result<(), Failure> {
            match self.0 {}
        }
    }

    impl LiveSearch {
        pub fn search(_: &Rerun, _: &str, _: &str, _: &Path) -> Result<LiveSearch, Failure> {
            Err(missing())
        }

        pub fn doing(&mut self, _: &str) -> Result<(), Failure> {
            match self.0 {}
        }

        pub fn ranked(&mut self, _: usize, _: &Round) -> Result<(), Failure> {
            match self.0 {}
        }

        pub fn found(&mut self, _: &diagnose::DiagnosisOutcome) -> Result<(), Failure> {
            match self.0 {}
        }
    }

    impl LiveFit {
        pub fn fit(_: &Rerun, _: &str, _: &str, _: &Path) -> Result<LiveFit, Failure> {
            Err(missing())
        }

        pub fn doing(&mut self, _: &str) -> Result<(), Failure> {
            match self.0 {}
        }

        pub fn fitted(&mut self, _: &Progress) -> Result<(), Failure> {
            match self.0 {}
        }

        pub fn found(&mut self, _: &Problem, _: &calibrate::CalibrationOutcome) -> Result<(), Failure> {
            match self.0 {}
        }
    }

    impl LiveEnsemble {
        pub fn ensemble(
            _: &Rerun,
            _: &str,
            _: &str,
            _: &Path,
            _: &[Member],
        ) -> Result<LiveEnsemble, Failure> {
            Err(missing())
        }
    }

    impl<S> Recording for Live<S> {
        fn finish(self, _: bool) -> Result<(), Failure> {
            match self.0 {}
        }
    }

    fn missing() -> Failure {
        let message = "this efam was built without Rerun; build it with `--features rerun`";
        Failure::Usage(message.to_owned())
    }
}

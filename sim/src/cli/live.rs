//! `--rerun`: the rod in the viewer while it is integrated, a diagnosis while it works.

use std::path::Path;

use models::snapshot::Snapshot;
use sim::diagnose::Outcome;
use sim::diagnose::verdict::Evidence;
use sim::scenario::Case;

use super::failure::Failure;

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
pub use with_rerun::{Live, LiveSearch};
#[cfg(not(feature = "rerun"))]
pub use without::{Live, LiveSearch};

#[cfg(feature = "rerun")]
mod with_rerun {
    use sim::observe::rerun::{RerunError, Scene, SearchStream, Sink, Stream};

    use super::super::interrupt;
    use super::*;

    /// A recording in progress.
    pub struct Live(Stream);

    impl Live {
        pub fn open(how: &Rerun, case: &Case, folder: &Path) -> Result<Live, Failure> {
            let stream = Stream::open(&sink(how, folder), &scene(case)).map_err(failure)?;
            tell(how, &stream);
            Ok(Live(stream))
        }

        pub fn log(&mut self, snapshot: &Snapshot) -> Result<(), Failure> {
            self.0.log(snapshot).map_err(failure)
        }

        /// Delivers what is left; a server goes on until it is interrupted.
        pub fn finish(self, hold: bool) -> Result<(), Failure> {
            finish(self.0, hold)
        }
    }

    /// The recording of a diagnosis in progress.
    pub struct LiveSearch(SearchStream);

    impl LiveSearch {
        pub fn open(how: &Rerun, name: &str, id: &str, folder: &Path) -> Result<LiveSearch, Failure> {
            let stream = SearchStream::open_search(&sink(how, folder), name, id).map_err(failure)?;
            tell(how, &stream);
            Ok(LiveSearch(stream))
        }

        pub fn doing(&mut self, what: &str) -> Result<(), Failure> {
            self.0.doing(what).map_err(failure)
        }

        pub fn ranked(&mut self, threshold: f64, candidates: &[Evidence]) -> Result<(), Failure> {
            self.0.ranked(threshold, candidates).map_err(failure)
        }

        pub fn found(&mut self, outcome: &Outcome) -> Result<(), Failure> {
            self.0.found(outcome).map_err(failure)
        }

        /// Delivers what is left; a server goes on until it is interrupted.
        pub fn finish(self, hold: bool) -> Result<(), Failure> {
            finish(self.0, hold)
        }
    }

    fn sink(how: &Rerun, folder: &Path) -> Sink {
        match how {
            Rerun::Save => Sink::Save(folder.join("run.rrd")),
            Rerun::Spawn => Sink::Spawn,
            Rerun::Connect(url) => Sink::Connect(url.clone()),
            Rerun::Serve => Sink::serve_here(),
        }
    }

    fn tell<D>(how: &Rerun, stream: &Stream<D>) {
        if let Some(how) = stream.how_to_view().filter(|_| *how == Rerun::Serve) {
            eprintln!("to see it: {how}");
        }
    }

    fn finish<D>(stream: Stream<D>, hold: bool) -> Result<(), Failure> {
        if hold {
            stream.hold(interrupt::is_asked);
        }
        match stream.finish() {
            Err(error @ RerunError::ViewerLost { .. }) => {
                eprintln!("warning: {error}");
                Ok(())
            }
            done => done.map_err(failure),
        }
    }

    fn failure(error: RerunError) -> Failure {
        Failure::Output(error.to_string())
    }

    fn scene(case: &Case) -> Scene {
        let model = &case.model;
        let value = |path: &str| model.index(path).map_or(0.0, |k| model.theta[k]);
        Scene {
            run_name: case.name.clone(),
            recording_id: sim::results::sha256(case.resolved.as_bytes()),
            duration_s: case.run.duration,
            rod_length_m: model.rod().length,
            body_length_m: model.tip_distance,
            payload_kg: value("effects.payload.mass"),
            payload_com_m: value("effects.payload.center_of_mass"),
            effects: model.exerting(),
            properties: case.warnings.iter().map(|text| ("warning".to_owned(), text.clone())).collect(),
        }
    }
}

#[cfg(not(feature = "rerun"))]
mod without {
    use super::*;

    /// There is none in a program that was built without Rerun.
    pub enum Live {}

    impl Live {
        pub fn open(_: &Rerun, _: &Case, _: &Path) -> Result<Live, Failure> {
            Err(missing())
        }

        pub fn log(&mut self, _: &Snapshot) -> Result<(), Failure> {
            match *self {}
        }

        pub fn finish(self, _: bool) -> Result<(), Failure> {
            match self {}
        }
    }

    /// Nor of a diagnosis.
    pub enum LiveSearch {}

    impl LiveSearch {
        pub fn open(_: &Rerun, _: &str, _: &str, _: &Path) -> Result<LiveSearch, Failure> {
            Err(missing())
        }

        pub fn doing(&mut self, _: &str) -> Result<(), Failure> {
            match *self {}
        }

        pub fn ranked(&mut self, _: f64, _: &[Evidence]) -> Result<(), Failure> {
            match *self {}
        }

        pub fn found(&mut self, _: &Outcome) -> Result<(), Failure> {
            match *self {}
        }

        pub fn finish(self, _: bool) -> Result<(), Failure> {
            match self {}
        }
    }

    fn missing() -> Failure {
        let message = "this efam was built without Rerun; build it with `--features rerun`";
        Failure::Usage(message.to_owned())
    }
}

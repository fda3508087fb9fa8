//! `efam view`: a finished run in the Rerun viewer.

use std::io;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

use clap::Args;
use efam_report::SCENARIO;
use efam_store::MARK;
use efam_store::escape::shell_word;

use super::failure::Failure;
use super::live::RECORDING;
use crate::observe::VIEWER as VERSION;

/// The viewer, of the version that can read what we write.
const VIEWER: &str = "rerun";

const HELP: &str = "Examples:
  efam view outputs/beam

Exit codes: 1 if there is no viewer, 2 if the folder holds no recording.";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct View {
    /// Folder of a run that was made with --rerun save.
    run: PathBuf,
}

/// Opens the recording of a run's folder.
pub fn run(args: &View) -> Result<ExitCode, Failure> {
    let folder = &args.run;
    let shown = folder.display();
    if !folder.join(MARK).is_file() {
        return Err(Failure::Usage(format!(
            "{shown}: is no folder of a run, for it has no {MARK}; give one that efam wrote, such as one below outputs/"
        )));
    }
    let recording = folder.join(RECORDING);
    if !recording.is_file() {
        let again = if folder.join(SCENARIO).is_file() {
            format!(
                "the same bits come from `efam simulate {} --rerun spawn`",
                shell_word(&folder.join(SCENARIO))
            )
        } else {
            "run it again with --rerun save".to_owned()
        };
        return Err(Failure::Usage(format!(
            "{shown}: has no {RECORDING}, because --rerun save was not given; {again}"
        )));
    }
    let started = Command::new(VIEWER).arg(&recording).status();
    match started {
        Ok(status) if status.success() => Ok(ExitCode::SUCCESS),
        Ok(status) => Err(Failure::Output(format!(
            "the viewer `{VIEWER}` ended with {status}; try `{VIEWER} --version`"
        ))),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Err(Failure::Output(format!(
            "no program `{VIEWER}` on the PATH; install it with `pip install rerun-sdk=={VERSION}`"
        ))),
        Err(error) => Err(Failure::Output(format!("the viewer `{VIEWER}` does not start ({error})"))),
    }
}

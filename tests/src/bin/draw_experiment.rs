//! Draws an experiment with a known secret, and writes it as a laboratory would have it: an experiment
//! file, and a recording for each release.
//!
//! `cargo run -p efam-tests --bin draw_experiment -- FOLDER SEED [EFFECT=SIZE…] [static]`; a size of 1 is what
//! one would expect of a muscle, and three sizes between commas are one for each pressure. Three pressures,
//! level and 25° below it; with `static` two level releases each at 10, 40 and 100 psi, of a muscle whose EI
//! is that of its table and is not fitted, as in the paper.

use std::fs;
use std::io;
use std::path::Path;
use std::process::ExitCode;

use tests::twin::lab::Lab;

const USAGE: &str =
    "draw_experiment FOLDER SEED [EFFECT=SIZE…] [static]; effects are those of tests/src/twin/hidden.rs";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let said = match Lab::asked(&words) {
        None => USAGE.to_owned(),
        Some(lab) => match write(Path::new(&words[0]), &lab) {
            Ok(()) => return ExitCode::SUCCESS,
            Err(error) => format!("{}: {error}", words[0]),
        },
    };
    eprintln!("{said}");
    ExitCode::FAILURE
}

fn write(folder: &Path, lab: &Lab) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    fs::write(folder.join("experiment.toml"), lab.experiment())?;
    lab.recordings().iter().try_for_each(|(name, text)| fs::write(folder.join(name), text))
}

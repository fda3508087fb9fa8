//! The folder of the results: made beside its place, and moved there when it is whole.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use models::statics::equilibrium;
use serde_json::{Value, json};
use sim::analysis::decay::fit_decay;
use sim::analysis::peaks::{PeakRules, upper_peaks};
use sim::analysis::spectrum::{Window, amplitude_spectrum};
use sim::analysis::{AnalysisError, Excursion};
use sim::scenario::Case;
use sim::trajectory::Trajectory;

use super::failure::Failure;

/// A folder in the making; it vanishes if it is not finished.
pub struct Folder {
    partial: PathBuf,
    path: PathBuf,
    overwrite: bool,
    is_finished: bool,
}

impl Folder {
    /// Makes it, before anything is computed.
    pub fn open(path: &Path, overwrite: bool) -> Result<Folder, Failure> {
        if path.exists() && !overwrite {
            let message = "is there already; choose another --out, or replace it by --overwrite";
            return Err(Failure::Usage(format!("{}: {message}", path.display())));
        }
        if path.exists() && !path.is_dir() {
            return Err(Failure::Usage(format!("{}: is a file; choose another --out", path.display())));
        }
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(format!(".partial-{}", std::process::id()));
        let partial = path.with_file_name(name);
        fs::create_dir_all(&partial).map_err(|error| unwritable(path, &error))?;
        Ok(Folder { partial, path: path.to_owned(), overwrite, is_finished: false })
    }

    /// Where files go until it is finished.
    pub fn partial(&self) -> &Path {
        &self.partial
    }

    /// Writes what belongs to one run, into a folder of its own if `name` says so.
    pub fn write(
        &self,
        name: Option<&str>,
        case: &Case,
        trajectory: &Trajectory,
        summary: &Value,
        csv: bool,
    ) -> Result<(), Failure> {
        let folder = name.map_or(self.partial.clone(), |name| self.partial.join(name));
        let write = |file: &str, text: &str| fs::write(folder.join(file), text);
        let all = || {
            fs::create_dir_all(&folder)?;
            write("scenario.resolved.toml", &case.resolved)?;
            write("summary.json", &format!("{summary:#}\n"))?;
            if csv { write("tip.csv", &tip_csv(trajectory)) } else { Ok(()) }
        };
        all().map_err(|error| unwritable(&self.path, &error))
    }

    /// Moves it to its place.
    pub fn finish(mut self) -> Result<PathBuf, Failure> {
        let place = || {
            if self.overwrite && self.path.exists() {
                fs::remove_dir_all(&self.path)?;
            }
            fs::rename(&self.partial, &self.path)
        };
        place().map_err(|error| unwritable(&self.path, &error))?;
        self.is_finished = true;
        Ok(self.path.clone())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !self.is_finished {
            let _ = fs::remove_dir_all(&self.partial);
        }
    }
}

/// What is worth knowing of a run, as one object.
pub fn summary(case: &Case, trajectory: &Trajectory) -> Value {
    let swing = swing(case, trajectory).ok();
    json!({
        "name": case.name,
        "pressure_pa": case.pressure,
        "status": trajectory.status,
        "duration_s": case.run.duration,
        "reached_s": trajectory.times.last(),
        "samples": trajectory.times.len(),
        "warnings": case.warnings,
        "tip_end_m": trajectory.tip.last(),
        "damped_frequency_hz": swing.map(|swing| swing.0 / TAU),
        "damping_ratio": swing.and_then(|swing| swing.1),
        "effort": trajectory.effort,
    })
}

/// Damped angular frequency, and damping ratio if there are enough peaks.
fn swing(case: &Case, trajectory: &Trajectory) -> Result<(f64, Option<f64>), AnalysisError> {
    let z = trajectory.tip_z();
    let step = trajectory.times.get(1).copied().unwrap_or_default();
    let excursion = match equilibrium(&case.model, None) {
        Ok(rest) if case.model.schedule.is_none() => {
            let system = models::system::System::new(&case.model);
            let at_rest = vec![0.0; rest.q.len()];
            Excursion::about(sim::forward::tip(&system, &rest.q, &at_rest).0[1], &z, step)?
        }
        _ => Excursion::about_end(case.run.duration / 4.0, &z, step)?,
    };
    let frequency = amplitude_spectrum(&excursion, Window::FallingHann, 8).peak()?.frequency;
    let peaks = upper_peaks(&excursion, TAU / frequency, &PeakRules::default());
    Ok((frequency, fit_decay(&peaks, frequency).ok().map(|decay| decay.damping_ratio)))
}

/// FNV-1a of a text, 16 digits.
#[cfg_attr(not(feature = "rerun"), allow(dead_code))]
pub fn hash(text: &str) -> String {
    let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    format!("{:016x}", text.bytes().fold(0xcbf2_9ce4_8422_2325, mix))
}

fn tip_csv(trajectory: &Trajectory) -> String {
    let mut text = "t_s,tip_x_m,tip_z_m,tip_vx_m_s,tip_vz_m_s\n".to_owned();
    let rows = trajectory.times.iter().zip(trajectory.tip.iter().zip(&trajectory.tip_velocity));
    for (t, ([x, z], [vx, vz])) in rows {
        let _ = writeln!(text, "{t},{x},{z},{vx},{vz}");
    }
    text
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    let message = "nothing is left there half-written; check folder, permissions and free space";
    Failure::Output(format!("{}: cannot be written ({error}); {message}", path.display()))
}

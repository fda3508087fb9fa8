//! Which system wrote a recording, detected from its content.

use std::fmt;

use super::cells::Rows;
use super::error::RecordingProblem;
use super::tidy;

/// Who wrote a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Format {
    /// No file: a program made the recording.
    #[default]
    Made,
    /// A table with one line of names, such as `t_s,tip_x_m,tip_z_m`.
    Tidy,
    /// The same columns in Parquet, such as a run's own `trajectory.parquet`.
    Parquet,
    /// Section `Trajectories` of Vicon Nexus.
    ViconNexus,
    /// Section `TRAJECTORIES` of older Vicon programs.
    ViconLegacy,
    /// OptiTrack Motive.
    Motive,
    /// Tab-separated text of Qualisys Track Manager.
    Qualisys,
    /// TRC, as OpenSim and Cortex use it.
    Trc,
    /// C3D.
    C3d,
}

impl Format {
    /// All that are read.
    const READ: [Format; 8] = [
        Format::Tidy,
        Format::Parquet,
        Format::ViconNexus,
        Format::ViconLegacy,
        Format::Motive,
        Format::Qualisys,
        Format::Trc,
        Format::C3d,
    ];

    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Format::Made => "made by a program",
            Format::Tidy => "tidy table",
            Format::Parquet => "Parquet",
            Format::ViconNexus => "Vicon Nexus trajectories",
            Format::ViconLegacy => "older Vicon trajectories",
            Format::Motive => "OptiTrack Motive CSV",
            Format::Qualisys => "Qualisys TSV",
            Format::Trc => "TRC",
            Format::C3d => "C3D",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Rows that are looked at before a file counts as unknown; a Nexus file may have other sections
/// before its trajectories, and those are looked through in whole.
const HEAD: usize = 40;
/// Titles of sections in exports of Vicon Nexus.
pub(super) const NEXUS_SECTIONS: [&str; 6] =
    ["Trajectories", "Model Outputs", "Devices", "Segments", "Joints", "Events"];

/// The format of a text, detected from the first cells of its first rows.
pub(super) fn of_text(text: &str) -> Result<Format, RecordingProblem> {
    let rows = &mut Rows::new(text);
    let mut first = None;
    let mut looked_at = 0;
    while looked_at < HEAD && rows.read_filled()? {
        looked_at += 1;
        let cell = rows.cell(0);
        // Programs put blanks or tabs after it.
        match cell.split_whitespace().next().unwrap_or_default() {
            "PathFileType" => return Ok(Format::Trc),
            "TRAJECTORIES" => return Ok(Format::ViconLegacy),
            _ if cell == "Format Version" => return Ok(Format::Motive),
            _ if cell.starts_with("NO_OF_") => return Ok(Format::Qualisys),
            _ if looked_at == 1 && NEXUS_SECTIONS.contains(&cell) => return Ok(Format::ViconNexus),
            _ => {}
        }
        if first.is_none() && !cell.starts_with('#') {
            first = Some((rows.line(), rows.start()));
        }
        if rows.is_data() {
            break;
        }
    }
    if tidy::is_table(&mut Rows::new(text))? {
        return Ok(Format::Tidy);
    }
    match first {
        None => Err(RecordingProblem::Empty),
        Some((line, text)) => {
            let known = Format::READ.map(Format::name).join(", ");
            Err(RecordingProblem::UnknownFormat { line, text, known })
        }
    }
}

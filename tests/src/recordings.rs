//! Small recordings in each format, written here: two markers on a swing, `tip` lost in two samples.

use std::fmt::Write;

use efam_core::forward::Run;
use efam_experiments::table::Table;
use efam_recordings::Recording;

use crate::{paper, simulate};

/// Samples of every small recording.
pub const SAMPLES: usize = 8;
/// Samples in which `tip` is lost.
pub const LOST: [usize; 2] = [3, 4];

/// Where marker 0 (`tip`) or 1 (`base`) is, in mm: multiples of 1/8, which every format holds exactly.
pub fn millimetres(marker: usize, sample: usize) -> Option<[f64; 3]> {
    let k = sample as f64;
    match marker {
        0 if LOST.contains(&sample) => None,
        0 => Some([100.0 - k, 2.5, -40.0 + 4.125 * k]),
        _ => Some([-5.0, 0.125 * k, 12.0]),
    }
}

/// Fails unless a finding of a recording contains that.
pub fn says(recording: &Recording, what: &str) {
    assert!(
        recording.findings.iter().any(|finding| finding.contains(what)),
        "{what}: {:?}",
        recording.findings
    );
}

/// A tidy table in metres.
pub fn tidy() -> String {
    let mut text = "t_s,tip_x_m,tip_y_m,tip_z_m,base_x_m,base_y_m,base_z_m\n".to_owned();
    for sample in 0..SAMPLES {
        let _ = writeln!(text, "{:.2}{}", 0.01 * sample as f64, cells(sample, ",", 1e-3, ""));
    }
    text
}

/// Trajectories of Vicon Nexus, ragged as exported; blank where lost.
pub fn nexus() -> String {
    let mut text = "Trajectories\n100\n,,My Arm:tip,,,My Arm:base\n\
                    Frame,Sub Frame,X,Y,Z,X,Y,Z\n,,mm,mm,mm,mm,mm,mm\n"
        .to_owned();
    for sample in 0..SAMPLES {
        let _ = writeln!(text, "{},0{}", sample + 695, cells(sample, ",", 1.0, ""));
    }
    text
}

/// Trajectories of older Vicon programs.
pub fn legacy() -> String {
    let mut text = "Title\nDate:\nNotes:,\"\"\n\nTRAJECTORIES\n100,Hz\n,tip,,,base,,\n\
                    Field #,X,Y,Z,X,Y,Z\n"
        .to_owned();
    for sample in 0..SAMPLES {
        let _ = writeln!(text, "{}{}", sample + 1, cells(sample, ",", 1.0, ""));
    }
    text
}

/// OptiTrack Motive: a rigid body `tip` with quaternions, a marker `base`; frames 10 to 12, then 20 on.
pub fn motive() -> String {
    let mut text = "Format Version,1.23,Take Name,Swing,Capture Frame Rate,200.000000,Export Frame Rate,\
                    100.000000,Total Exported Frames,8,Rotation Type,Quaternion,Length Units,Millimeters,\
                    Coordinate Space,Global\n\n\
                    ,Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,\
                    Rigid Body,Marker,Marker,Marker\n\
                    ,Name,tip,tip,tip,tip,tip,tip,tip,tip,base,base,base\n\
                    ,ID,1,1,1,1,1,1,1,1,2,2,2\n\
                    ,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error,\
                    Position,Position,Position\n\
                    Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z\n"
        .to_owned();
    for sample in 0..SAMPLES {
        let frame = if sample < 3 { 10 + sample } else { 17 + sample };
        let _ = write!(text, "{frame},{:.6}", 0.01 * frame as f64);
        let body = |marker: usize, cell: &str| match millimetres(marker, sample) {
            Some([x, y, z]) => format!(",{x},{y},{z}{cell}"),
            None => ",".repeat(3 + cell.matches(',').count()),
        };
        // Half a turn about y, and a norm that is not quite 1.
        let quaternion = if millimetres(0, sample).is_some() { ",0,1.002,0,0" } else { ",,,," };
        let _ = writeln!(text, "{quaternion}{}{}", body(0, ",0.1"), body(1, ""));
    }
    text
}

/// Qualisys, from frame 826 on; zeros where lost.
pub fn qualisys() -> String {
    let mut text = "NO_OF_FRAMES\t8\nNO_OF_CAMERAS\t7\nNO_OF_MARKERS\t2\nFREQUENCY\t100\n\
                    DESCRIPTION\t--\nTIME_STAMP\t2026-01-02, 15:19:24.317\t1483034.6\nDATA_INCLUDED\t3D\n\
                    MARKER_NAMES\ttip\tbase\nTRAJECTORY_TYPES\tMeasured\tMixed\n\
                    Frame\tTime\ttip X\ttip Y\ttip Z\tbase X\tbase Y\tbase Z\n"
        .to_owned();
    for sample in 0..SAMPLES {
        let _ = write!(text, "{}\t{:.5}", 826 + sample, 8.25 + 0.01 * sample as f64);
        let _ = writeln!(text, "{}", cells(sample, "\t", 1.0, "nan"));
    }
    text
}

/// TRC between tabs.
pub fn trc() -> String {
    let mut text = "PathFileType\t4\t(X/Y/Z)\tswing.trc\n\
                    DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n\
                    100\t100\t8\t2\tmm\t100\t1\t8\n\
                    Frame#\tTime\ttip\t\t\tbase\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
        .to_owned();
    for sample in 0..SAMPLES {
        let _ = write!(text, "{}\t{:.2}", 1 + sample, 0.01 * sample as f64);
        let _ = writeln!(text, "{}", cells(sample, "\t", 1.0, "0"));
    }
    text
}

/// The trajectory of a short run, as its folder keeps it: another swing, of a simulated muscle.
pub fn parquet() -> Vec<u8> {
    let model = paper(15.0, 8, &[]);
    let trajectory = simulate(&model, &Run::release(0.05, 100.0));
    let mut file = Vec::new();
    let table = Table::new(&model, &trajectory, false);
    table.write_parquet(&mut file, &[]).expect("memory takes it");
    file
}

/// Coordinates of both markers in a sample, each after a delimiter.
fn cells(sample: usize, delimiter: &str, scale: f64, lost: &str) -> String {
    let mut text = String::new();
    for marker in 0..2 {
        for axis in 0..3 {
            let _ = match millimetres(marker, sample) {
                Some(position) => write!(text, "{delimiter}{}", scale * position[axis]),
                None => write!(text, "{delimiter}{lost}"),
            };
        }
    }
    text
}

/// A C3D file to be written.
#[derive(Clone, Debug)]
pub struct C3d {
    /// 84 Intel, 85 DEC, 86 MIPS.
    pub processor: u8,
    /// Floats instead of integers.
    pub floats: bool,
    /// Label of each point.
    pub labels: Vec<String>,
    /// Number of the first frame.
    pub first_frame: usize,
    /// Frames.
    pub frames: usize,
    /// Analog samples in each frame.
    pub analog: usize,
    /// POINT:UNITS.
    pub units: String,
}

impl C3d {
    /// The small recording.
    pub fn small(processor: u8, floats: bool) -> Self {
        let labels = vec!["tip".to_owned(), "base".to_owned()];
        Self { processor, floats, labels, first_frame: 1, frames: SAMPLES, analog: 3, units: "mm".to_owned() }
    }

    /// Its bytes, with positions in mm; a lost point keeps coordinates, and has a residual of -1.
    pub fn bytes(&self, position: impl Fn(usize, usize) -> Option<[f64; 3]>) -> Vec<u8> {
        let scale: f32 = if self.floats { -0.125 } else { 0.125 };
        let last = self.first_frame + self.frames - 1;
        let mut parameters = vec![1, 80, 0, self.processor];
        self.group(&mut parameters, 1, "POINT");
        let points = self.labels.len();
        self.parameter(&mut parameters, 1, "USED", 2, &[], &self.word(points));
        self.parameter(&mut parameters, 1, "SCALE", 4, &[], &self.float(scale));
        self.parameter(&mut parameters, 1, "RATE", 4, &[], &self.float(100.0));
        self.parameter(&mut parameters, 1, "FRAMES", 2, &[], &self.word(self.frames.min(65_535)));
        let units = self.units.as_bytes();
        self.parameter(&mut parameters, 1, "UNITS", -1, &[units.len() as u8], units);
        for (index, labels) in self.labels.chunks(255).enumerate() {
            let name = if index == 0 { "LABELS".to_owned() } else { format!("LABELS{}", index + 1) };
            let text: String = labels.iter().map(|label| format!("{label:8}")).collect();
            self.parameter(&mut parameters, 1, &name, -1, &[8, labels.len() as u8], text.as_bytes());
        }
        if last > 65_535 {
            self.group(&mut parameters, 2, "TRIAL");
            let long = |frame: usize| [self.word(frame & 0xffff), self.word(frame >> 16)].concat();
            self.parameter(&mut parameters, 2, "ACTUAL_START_FIELD", 2, &[2], &long(self.first_frame));
            self.parameter(&mut parameters, 2, "ACTUAL_END_FIELD", 2, &[2], &long(last));
        }
        parameters.extend([0, 0]);
        let blocks = parameters.len().div_ceil(512);
        parameters[2] = blocks as u8;
        parameters.resize(512 * blocks, 0);

        let mut file = vec![2, 80];
        file.extend(self.word(points));
        file.extend(self.word(self.analog));
        file.extend(self.word(self.first_frame));
        file.extend(self.word(last.min(65_535)));
        file.extend(self.word(10));
        file.extend(self.float(scale));
        file.extend(self.word(2 + blocks));
        file.extend(self.word(1));
        file.extend(self.float(100.0));
        file.resize(512, 0);
        file.extend(parameters);
        for frame in 0..self.frames {
            for point in 0..points {
                let seen = position(point, frame);
                let values = seen.unwrap_or([-755.0, 3.0, 8.0]);
                values.iter().for_each(|value| self.number(&mut file, *value, 0.125));
                self.number(&mut file, if seen.is_some() { 1.0 } else { -1.0 }, 1.0);
            }
            (0..self.analog).for_each(|_| self.number(&mut file, 7.0, 1.0));
        }
        file.resize(file.len().div_ceil(512) * 512, 0);
        file
    }

    fn number(&self, file: &mut Vec<u8>, value: f64, scale: f64) {
        if self.floats {
            file.extend(self.float(value as f32))
        } else {
            file.extend(self.word((value / scale) as i16 as u16 as usize))
        }
    }

    fn group(&self, to: &mut Vec<u8>, id: i8, name: &str) {
        to.extend([name.len() as u8, -id as u8]);
        to.extend(name.as_bytes());
        to.extend(self.word(3));
        to.push(0);
    }

    fn parameter(&self, to: &mut Vec<u8>, id: u8, name: &str, kind: i8, lengths: &[u8], data: &[u8]) {
        to.extend([name.len() as u8, id]);
        to.extend(name.as_bytes());
        to.extend(self.word(5 + lengths.len() + data.len()));
        to.extend([kind as u8, lengths.len() as u8]);
        to.extend(lengths);
        to.extend(data);
        to.push(0);
    }

    fn word(&self, value: usize) -> Vec<u8> {
        let value = value as u16;
        if self.processor == 86 { value.to_be_bytes().into() } else { value.to_le_bytes().into() }
    }

    fn float(&self, value: f32) -> Vec<u8> {
        match self.processor {
            84 => value.to_le_bytes().into(),
            86 => value.to_be_bytes().into(),
            // A VAX gives a quarter of the value to the same bits, and has the words swapped.
            _ => {
                let [a, b, c, d] = (4.0 * value).to_le_bytes();
                vec![c, d, a, b]
            }
        }
    }
}

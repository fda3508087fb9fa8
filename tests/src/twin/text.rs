//! A recording as tidy CSV: `t_s`, then `<marker>_x_m`, `<marker>_y_m`, `<marker>_z_m`; what was lost
//! is blank.

use std::fmt::Write;

use efam_recordings::Recording;

/// The text of the file; positions to the micrometre.
pub fn tidy(recording: &Recording) -> String {
    let mut text = String::from("t_s");
    for marker in &recording.markers {
        for axis in ["x", "y", "z"] {
            write!(text, ",{}_{axis}_m", marker.name).expect("memory");
        }
    }
    for (k, time) in recording.time.iter().enumerate() {
        write!(text, "\n{time:.6}").expect("memory");
        for marker in &recording.markers {
            match marker.position[k] {
                Some([x, y, z]) => write!(text, ",{x:.6},{y:.6},{z:.6}").expect("memory"),
                None => text.push_str(",,,"),
            }
        }
    }
    text.push('\n');
    text
}

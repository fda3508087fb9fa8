//! A posture from a file: points along the rod, with velocities if they are known.

use super::error::ScenarioProblem;

/// Points with velocities, from lines `x_m,z_m` or `x_m,z_m,vx_m_s,vz_m_s`; a first line of names,
/// empty lines and lines that begin with `#` are passed over.
pub(super) fn read(file: &str, text: &str) -> Result<Vec<[f64; 4]>, Box<ScenarioProblem>> {
    let mut points = Vec::new();
    let mut lines = Vec::new();
    let wrong = |line: usize, message: String| {
        Box::new(ScenarioProblem::PostureFile { file: file.to_owned(), line, message })
    };
    for (index, line) in text.lines().enumerate() {
        let line_number = index + 1;
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        if line.trim().is_empty() || line.starts_with('#') || fields[0] == "x_m" {
            continue;
        }
        let mut point = [0.0; 4];
        if !matches!(fields.len(), 2 | 4) {
            return Err(wrong(line_number, format!("{} values, not 2 or 4", fields.len())));
        }
        for (value, field) in point.iter_mut().zip(&fields) {
            let number = field.parse().ok().filter(|number: &f64| number.is_finite());
            *value = number.ok_or_else(|| wrong(line_number, format!("\"{field}\" is no finite number")))?;
        }
        points.push(point);
        lines.push(line_number);
    }
    check(&points).map_err(|(at, message)| wrong(lines.get(at).copied().unwrap_or(1), message))?;
    Ok(points)
}

/// Whether points make a posture; else the index of the wrong one, and what is wrong.
pub(super) fn check(points: &[[f64; 4]]) -> Result<(), (usize, String)> {
    if points.len() < 2 {
        return Err((0, format!("{} points; a posture needs at least 2", points.len())));
    }
    if points[0] != [0.0; 4] {
        return Err((0, "the first point is the clamp; it must be 0,0 and at rest".to_owned()));
    }
    match points.windows(2).position(|pair| pair[0][..2] == pair[1][..2]) {
        Some(at) => Err((at + 1, "the point is that of the line before; leave one out".to_owned())),
        None => Ok(()),
    }
}

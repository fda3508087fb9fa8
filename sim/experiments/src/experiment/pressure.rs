//! The pressure of a recording: one for all of it, or over time, from a column of its own file or of another one.

use std::path::Path;

use models::quantity::Quantity;

use crate::scenario::document::{Document, Keys};
use crate::scenario::plan::Plan;
use crate::scenario::{ScenarioError, ScenarioProblem};

/// A pressure over time: straight lines between rows of time on the recording's clock, s, and gauge pressure, Pa.
#[derive(Clone, Debug, PartialEq)]
pub struct Pressures(Vec<(f64, f64)>);

/// Share of its range by which the straight lines may be off the pressure that was recorded.
const OFF: f64 = 5e-3;
/// Share of the largest pressure by which a step changes it: ripple and noise of a regulator are some per cent, and the swing of
/// a smaller step is small beside the others.
const STEP: f64 = 0.1;
/// Looks at the pressure within the time of a step, so that its begin is known to a twentieth of that; and at all of a series.
const LOOKS: f64 = 20.0;
const MOST_LOOKS: f64 = 1e6;

impl Pressures {
    /// From times on the recording's clock, s, and gauge pressures, Pa.
    pub fn of(rows: &[(f64, f64)]) -> Self {
        Self(straightened(rows))
    }

    /// Pressure at a time on the recording's clock, Pa.
    pub fn at(&self, time: f64) -> f64 {
        let rows = &self.0;
        let after = rows.partition_point(|row| row.0 <= time);
        match (after.checked_sub(1).map(|k| rows[k]), rows.get(after).copied()) {
            (Some((t, p)), Some((u, q))) => p + (q - p) * (time - t) / (u - t),
            (Some((_, only)), None) | (None, Some((_, only))) => only,
            (None, None) => 0.0,
        }
    }

    /// Times, s, on the recording's clock, at which it begins to change by a step within a time, s.
    pub fn steps(&self, within: f64) -> Vec<f64> {
        let Some((first, last)) = self.0.first().zip(self.0.last()) else { return Vec::new() };
        let largest = self.0.iter().map(|row| row.1.abs()).fold(0.0, f64::max);
        let grid = within / LOOKS;
        let time = |k: usize| first.0 + grid * k as f64;
        let off = |from: f64, to: f64| (self.at(to) - self.at(from)).abs() / largest;
        let looks = ((last.0 - first.0) / grid).ceil().min(MOST_LOOKS) as usize;
        let is_step = |k: &usize| off(time(*k), time(*k) + within) > STEP;
        let begins = (0..looks).filter(|k| is_step(k) && (*k == 0 || !is_step(&(k - 1))));
        let begin = |k: usize| {
            let still = (0..LOOKS as usize).take_while(|j| off(time(k), time(k + j)) <= 2.0 * OFF);
            time(k + still.count().saturating_sub(1))
        };
        begins.map(begin).collect()
    }

    /// The rows with times after an instant, s.
    pub(super) fn since(&self, instant: f64) -> Vec<(f64, f64)> {
        self.0.iter().map(|(time, pressure)| (time - instant, *pressure)).collect()
    }

    /// Mean over the time of the rows, Pa.
    fn mean(&self) -> f64 {
        let spans = self.0.windows(2).map(|pair| (pair[1].0 - pair[0].0, 0.5 * (pair[0].1 + pair[1].1)));
        let (time, sum) = spans.fold((0.0, 0.0), |(time, sum), (dt, p)| (time + dt, sum + dt * p));
        sum / time
    }
}

/// The pressure that a recording states: one, or the mean of one over time, and that itself. `own` is the recording's file.
pub(super) fn pressure(
    document: &Document,
    keys: &Keys,
    own: &Path,
    plan: Option<&Plan>,
) -> Result<(Option<f64>, Option<Pressures>), ScenarioError> {
    let Some(table) = keys.table("pressure").ok().filter(Keys::is_given) else {
        return Ok((keys.quantity("pressure", "Pa")?, None));
    };
    table.only(&["file", "column", "unit", "delay"])?;
    let wrong = |key: &str, message: String| table.wrong(key, ScenarioProblem::Other { message });
    if plan.is_some_and(|plan| plan.muscle.is_none()) {
        let message = "a [rod] does not say how it follows a pressure; give a [muscle]".to_owned();
        return Err(keys.wrong("pressure", ScenarioProblem::Other { message }));
    }
    let Some((column, _)) = table.text("column")? else {
        return Err(
            table.missing("column", "column = \"p\", a column of the recording\'s file or of file = …")
        );
    };
    if !table.has("file") && (keys.has("rate") || keys.has("columns")) {
        let message =
            "rate and columns overrule the times of this file; give the pressure in a file of its own";
        return Err(wrong("column", message.to_owned()));
    }
    let file = table.text("file")?.map_or(own.to_owned(), |(name, place)| document.file(place, name));
    let key = if table.has("file") { "file" } else { "column" };
    let read = efam_recordings::series(&file, column).map_err(|error| wrong(key, error.to_string()))?;
    let unit = table.text("unit")?.map(|(unit, _)| unit.to_owned()).or(read.unit);
    let factor = unit.as_ref().and_then(|unit| Quantity::parse(&format!("1 {unit}")).ok()?.to("Pa").ok());
    let Some(factor) = factor else {
        let message = format!("`{}` states no unit of pressure; give unit = \"bar\" or another", read.name);
        return Err(wrong(if table.has("unit") { "unit" } else { "column" }, message));
    };
    let delay = table.quantity("delay", "s")?.unwrap_or(0.0);
    let rows = read.time.iter().zip(&read.values).map(|(time, value)| (time + delay, factor * value));
    let pressures = Pressures::of(&rows.collect::<Vec<_>>());
    Ok((Some(pressures.mean()), Some(pressures)))
}

/// Rows without those that straight lines between the others show.
/// Source: Douglas and Peucker (1973), Cartographica 10, 112-122; with distances along the pressure.
fn straightened(rows: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let (low, high) =
        rows.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| (l.min(r.1), h.max(r.1)));
    let mut keep = vec![false; rows.len()];
    let mut open = vec![(0, rows.len() - 1)];
    while let Some((from, to)) = open.pop() {
        (keep[from], keep[to]) = (true, true);
        let ((t, p), (u, q)) = (rows[from], rows[to]);
        let off = |k: usize| (rows[k].1 - p - (q - p) * (rows[k].0 - t) / (u - t)).abs();
        let farthest = (from + 1..to).max_by(|a, b| off(*a).total_cmp(&off(*b)));
        if let Some(at) = farthest.filter(|at| off(*at) > OFF * (high - low)) {
            open.extend([(from, at), (at, to)]);
        }
    }
    rows.iter().zip(keep).filter(|(_, keep)| *keep).map(|(row, _)| *row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_of_pressure_is_four_rows() {
        let ramp = |t: f64| 1e5 + 2e5 * ((t - 0.5) / 0.1).clamp(0.0, 1.0);
        let rows: Vec<(f64, f64)> = (0..500).map(|k| 0.01 * f64::from(k)).map(|t| (t, ramp(t))).collect();
        let pressures = Pressures::of(&rows);
        assert_eq!(pressures.0.len(), 4, "{pressures:?}");
        for (time, pressure) in rows {
            assert!((pressures.at(time) - pressure).abs() < 1e3 && pressures.since(0.2)[0].0 == -0.2);
        }
        let steps = pressures.steps(0.3);
        assert!(steps.len() == 1 && (steps[0] - 0.5).abs() < 0.02, "{steps:?}");
        // In a tenth of the time of the ramp it does not change by a step.
        assert!(pressures.steps(0.01).is_empty());
        assert_eq!((pressures.at(-1.0), pressures.at(9.0)), (1e5, 3e5));
        assert!((pressures.mean() - (1e5 * 0.5 + 2e5 * 0.1 + 3e5 * 4.39) / 4.99).abs() < 1.0);
    }
}

//! A pressure that changes while the rod moves: its length, stiffnesses and diameter follow the
//! muscle's table at the pressure of the moment. The effect [`pressure_line`](crate::effects::pressure_line) delays it.
//!
//! Assumed: the muscle has no inertia of its own in filling, so the table of slow pressures holds;
//! distributed mass stays with the material, and that of the air inside is the one at release; the
//! regulator does the work that changes the energy stored at a fixed posture, and that of the forces
//! of damping against the change of the rest length, see [`Energy::supplied`].
//!
//! [`Energy::supplied`]: crate::snapshot::Energy::supplied

use crate::model::Schedule;
use crate::muscle::{AtPressure, Extrapolation, Muscle, MuscleError, RodSlopes};

/// Pressure over time: straight lines between the rows of a table, constant before and after.
#[derive(Clone, Debug)]
pub struct PressureSchedule {
    muscle: Muscle,
    stiffness_source: String,
    extrapolation: Extrapolation,
    times: Vec<f64>,
    pressures: Vec<f64>,
    at_release: AtPressure,
    resumes: Option<(f64, f64)>,
}

impl PressureSchedule {
    /// Builds a schedule from rows of time (s, ascending) and pressure (Pa).
    /// # Errors
    /// [`MuscleError`] if a pressure lies outside the muscle's table.
    pub fn new(
        muscle: Muscle,
        stiffness_source: &str,
        extrapolation: Extrapolation,
        rows: &[(f64, f64)],
    ) -> Result<Self, MuscleError> {
        assert!(
            rows.windows(2).all(|w| w[0].0 < w[1].0),
            "the reader of the scenario sees to ascending times"
        );
        let (times, pressures): (Vec<_>, Vec<_>) = rows.iter().copied().unzip();
        let initial = pressure_at(&times, &pressures, 0.0, 0.0).0;
        Self::of(muscle, stiffness_source, extrapolation, initial, rows)
    }

    /// Commands of a regulator while a rod at the pressure `release`, Pa, swings: each is held from its time, s, to the next. The
    /// pressure line goes on at a time, s, from a pressure in the rod, Pa.
    /// # Errors
    /// [`MuscleError`] if a pressure lies outside the muscle's table.
    pub fn steered(
        muscle: Muscle,
        stiffness_source: &str,
        extrapolation: Extrapolation,
        release: f64,
        (time, pressure): (f64, f64),
        commands: &[(f64, f64)],
    ) -> Result<Self, MuscleError> {
        let before = commands.iter().zip(commands.iter().skip(1)).map(|(held, next)| (next.0, held.1));
        let rows: Vec<_> = commands
            .iter()
            .zip([None].into_iter().chain(before.map(Some)))
            .flat_map(|(command, before)| before.into_iter().chain([*command]))
            .collect();
        let own = Self::of(muscle, stiffness_source, extrapolation, release, &rows)?;
        Ok(Self { resumes: Some((time, pressure - release)), ..own })
    }

    fn of(
        muscle: Muscle,
        stiffness_source: &str,
        extrapolation: Extrapolation,
        release: f64,
        rows: &[(f64, f64)],
    ) -> Result<Self, MuscleError> {
        for (_, pressure) in rows {
            muscle.at(*pressure, stiffness_source, extrapolation)?;
        }
        let (times, pressures) = rows.iter().copied().unzip();
        let at_release = muscle.at(release, stiffness_source, extrapolation)?;
        let stiffness_source = stiffness_source.to_owned();
        Ok(Self { muscle, stiffness_source, extrapolation, times, pressures, at_release, resumes: None })
    }

    /// Pressure, Pa, and its rate, Pa/s; of the straight line on which the time `since` lies.
    pub fn pressure(&self, time: f64, since: f64) -> (f64, f64) {
        pressure_at(&self.times, &self.pressures, time, since)
    }

    /// Length, bending stiffness, axial stiffness and diameter at a pressure, Pa, over those at release, with their first and
    /// second derivatives by it.
    fn at(&self, pressure: f64) -> [[f64; 3]; 4] {
        let (now, first, second) = self
            .muscle
            .derivatives(pressure, &self.stiffness_source, self.extrapolation)
            .expect("all pressures lie between those that were checked");
        let reference = &self.at_release;
        let of = |value: f64, first: f64, second: f64, reference: f64| {
            [value, first, second].map(|x| x / reference)
        };
        [
            of(now.length, first.length, second.length, reference.length),
            of(
                now.bending_stiffness,
                first.bending_stiffness,
                second.bending_stiffness,
                reference.bending_stiffness,
            ),
            of(now.axial_stiffness, first.axial_stiffness, second.axial_stiffness, reference.axial_stiffness),
            of(now.outer_diameter, first.outer_diameter, second.outer_diameter, reference.outer_diameter),
        ]
    }

    /// The muscle at release.
    pub fn at_release(&self) -> &AtPressure {
        &self.at_release
    }
}

fn pressure_at(times: &[f64], pressures: &[f64], time: f64, since: f64) -> (f64, f64) {
    let after = times.partition_point(|t| *t <= since);
    if after == 0 {
        return (pressures[0], 0.0);
    }
    if after == times.len() {
        return (pressures[after - 1], 0.0);
    }
    let rate = (pressures[after] - pressures[after - 1]) / (times[after] - times[after - 1]);
    (pressures[after - 1] + rate * (time - times[after - 1]), rate)
}

impl Schedule for PressureSchedule {
    fn factors(&self, time: f64, since: f64) -> [[f64; 3]; 4] {
        let (pressure, rate) = self.pressure(time, since);
        // The pressure follows a straight line, so only the table is curved.
        self.at(pressure).map(|[value, first, second]| [value, first * rate, second * rate * rate])
    }

    fn relative(&self, change: f64) -> Option<[[f64; 3]; 4]> {
        Some(self.at(self.at_release.pressure + change))
    }

    fn pressure_change(&self, time: f64, since: f64) -> (f64, f64) {
        let (pressure, rate) = self.pressure(time, since);
        (pressure - self.at_release.pressure, rate)
    }

    fn resumes(&self) -> Option<(f64, f64)> {
        self.resumes
    }

    fn breakpoints(&self) -> &[f64] {
        &self.times
    }
}

/// A pressure that begins to change at time 0, from a rod of known slopes: for the derivatives of the equations of motion
/// by the pressure and by its rate.
pub(crate) struct Begins {
    /// How the rod follows the pressure.
    pub slopes: RodSlopes,
    /// With a rate of 1 Pa/s; else from rest, with an acceleration of 1 Pa/s².
    pub at_once: bool,
}

impl Schedule for Begins {
    fn factors(&self, _time: f64, _since: f64) -> [[f64; 3]; 4] {
        self.slopes.map(|slope| if self.at_once { [1.0, slope, 0.0] } else { [1.0, 0.0, slope] })
    }

    fn pressure_change(&self, _time: f64, _since: f64) -> (f64, f64) {
        (0.0, if self.at_once { 1.0 } else { 0.0 })
    }

    fn breakpoints(&self) -> &[f64] {
        &[]
    }
}

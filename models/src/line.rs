//! The pressure in a rod behind its pressure line: what an effect at [`Place::Line`] makes of a command over time. The rod
//! does not move it, so it is known before the rod moves.

use std::sync::Arc;

use num_dual::Dual64;

use crate::effects::{Line, Place, Scalar};
use crate::model::{Active, Model, Schedule};

/// The pressure behind a line, over one scalar.
#[derive(Clone, Debug)]
pub(crate) struct Through<T> {
    dead_time: T,
    /// When the command begins a straight piece, s, and the state of the line then; pressures from that at the release.
    pieces: Vec<(f64, Line<T>)>,
    /// When each arrives, s: to the last bit the [kinks](Model::kinks) at which steps end.
    arrivals: Vec<f64>,
}

/// The line of a model, if it has one.
fn line(model: &Model) -> Option<&Active> {
    model.effects.iter().find(|active| active.effect.about().places.contains(&Place::Line))
}

impl<T: Scalar> Through<T> {
    /// That of a model whose pressure is commanded over time, if it has a line.
    pub fn new(model: &Model, theta: &[T]) -> Option<Self> {
        let schedule = model.schedule.as_deref().filter(|schedule| schedule.relative(0.0).is_some())?;
        let active = line(model)?;
        let (law, theta) = (T::laws(active.effect), &theta[active.theta.clone()]);
        let dead_time = law.dead_time(theta);
        let resumes = schedule.resumes();
        let first = resumes.map_or(0.0, |(time, _)| time - dead_time.re());
        let later = schedule.breakpoints().iter().copied().filter(|time| *time > first);
        let mut pieces: Vec<(f64, Line<T>)> = Vec::new();
        for start in [first].into_iter().chain(later) {
            let (command, rate) = schedule.pressure_change(start, start);
            let from = |(begin, at): &(f64, Line<T>)| {
                law.line(&Line { time: T::from(start - begin), ..*at }, theta)[0]
            };
            let begin = resumes.map_or(command, |(_, pressure)| pressure);
            let pressure = pieces.last().map_or(T::from(begin), from);
            let [command, command_rate, time] = [command, rate, 0.0].map(T::from);
            pieces.push((start, Line { pressure, command, command_rate, time }));
        }
        let mut arrivals: Vec<f64> = pieces.iter().map(|(start, _)| start + dead_time.re()).collect();
        arrivals[0] = resumes.map_or(arrivals[0], |(time, _)| time);
        Some(Self { dead_time, pieces, arrivals })
    }

    /// The pressure, Pa, from that at the release, and its rate, Pa/s, on the piece in which `since` lies.
    pub fn at(&self, model: &Model, theta: &[T], time: T, since: f64) -> [T; 2] {
        let piece = self.arrivals.partition_point(|arrival| *arrival <= since);
        let Some((start, at)) = piece.checked_sub(1).map(|piece| &self.pieces[piece]) else {
            return [self.pieces[0].1.pressure, T::from(0.0)];
        };
        let active = line(model).expect("there is one");
        let at = Line { time: time - self.dead_time - *start, ..*at };
        T::laws(active.effect).line(&at, &theta[active.theta.clone()])
    }
}

/// The pressure of a model over time, as it is in the rod.
pub struct RodPressure<'a> {
    model: &'a Model,
    line: Option<Through<f64>>,
}

impl<'a> RodPressure<'a> {
    /// That of a model.
    pub fn of(model: &'a Model) -> Self {
        Self { model, line: Through::new(model, &model.theta) }
    }

    /// Pressure above ambient at a time, s, Pa.
    pub fn at(&self, time: f64) -> f64 {
        let Some(line) = &self.line else { return self.command(time) };
        self.model.rod().pressure + line.at(self.model, &self.model.theta, time, time)[0]
    }

    /// Commanded pressure, likewise.
    pub fn command(&self, time: f64) -> f64 {
        let change = |own: &Arc<dyn Schedule>| own.pressure_change(time, time).0;
        self.model.rod().pressure + self.model.schedule.as_ref().map_or(0.0, change)
    }

    /// Whether the rod has another pressure than the command.
    pub fn is_behind(&self) -> bool {
        self.line.is_some()
    }
}

/// A pressure line in small motions, with the pressure p and its command u: `ṗ = by_pressure p + by_command u`, 1/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallLine {
    /// Below zero.
    pub by_pressure: f64,
    /// As large for a line that follows in the end.
    pub by_command: f64,
    /// Time that no linear equation has: before the pressure begins to follow, s.
    pub dead_time: f64,
}

impl SmallLine {
    /// That of a model; none where the pressure follows at once.
    pub fn of(model: &Model) -> Option<Self> {
        let active = line(model)?;
        let values = &model.theta[active.theta.clone()];
        let theta: Vec<Dual64> = values.iter().map(|value| Dual64::from(*value)).collect();
        let law = <Dual64 as Scalar>::laws(active.effect);
        let [zero, one] = [Dual64::from(0.0), Dual64::from(0.0).derivative()];
        let rate = |pressure, command| {
            law.line(&Line { pressure, command, command_rate: zero, time: zero }, &theta)[1].eps
        };
        let (by_pressure, by_command) = (rate(one, zero), rate(zero, one));
        let dead_time = law.dead_time(&theta).re;
        (by_pressure != 0.0).then_some(Self { by_pressure, by_command, dead_time })
    }
}

impl Model {
    /// Time before the pressure begins to follow its command, s; none without a pressure line.
    pub fn dead_time(&self) -> Option<f64> {
        let active = line(self)?;
        Some(<f64 as Scalar>::laws(active.effect).dead_time(&self.theta[active.theta.clone()]))
    }

    /// Times at which a rate of the pressure jumps, s, ascending.
    pub fn kinks(&self) -> Vec<f64> {
        let dead_time = self.dead_time().unwrap_or(0.0);
        let commanded = self.schedule.iter().flat_map(|schedule| schedule.breakpoints());
        let mut kinks: Vec<f64> = commanded.map(|time| time + dead_time).collect();
        if dead_time > 0.0 && !kinks.is_empty() {
            // A line begins at the release.
            kinks.push(dead_time);
            kinks.sort_by(f64::total_cmp);
        }
        kinks
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::effects::Rod;
    use crate::model::ModelSpec;
    use crate::muscle::{Extrapolation, Muscle};
    use crate::pressure::PressureSchedule;

    /// A step that begins where a command arrives is on the piece of that command, whatever the dead time: 0.15 − 0.03 is
    /// less than 0.12, and so on.
    #[test]
    fn a_command_acts_from_the_kink_at_which_it_arrives() {
        let muscle = Muscle::built_in("garbulinski-2022").unwrap();
        let at = muscle.at(2e5, "pder_32", Extrapolation::Refused).unwrap();
        let rod: Rod<f64> = muscle.rod(&at);
        for sent in (1..200).map(|k| 0.01 * f64::from(k)) {
            for dead_time in (1..30).map(|k| 0.01 * f64::from(k)) {
                let commands = [(0.0, 2e5), (sent, 2.2e5)];
                let schedule = PressureSchedule::steered(
                    muscle.clone(),
                    "pder_32",
                    Extrapolation::Refused,
                    2e5,
                    (sent, 2e5),
                    &commands,
                );
                let spec = ModelSpec { schedule: Some(Arc::new(schedule.unwrap())), ..ModelSpec::of(rod) };
                let values = [("pressure_line.dead_time", dead_time), ("pressure_line.time_constant", 0.1)];
                let model = Model::new(&spec.with(&values)).unwrap();
                let line = Through::new(&model, &model.theta).unwrap();
                let arrives = *model.kinks().last().unwrap();
                let rate = |since| line.at(&model, &model.theta, arrives, since)[1];
                assert!(
                    (rate(arrives) / 2e5 - 1.0).abs() < 1e-9,
                    "{sent} s, {dead_time} s: {}",
                    rate(arrives)
                );
                assert_eq!(rate(arrives - 1e-9), 0.0, "{sent} s, {dead_time} s");
            }
        }
    }
}

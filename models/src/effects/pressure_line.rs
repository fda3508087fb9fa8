//! Pressure line: a regulator and its hose bring the pressure to its command late, at a limited rate.
//!
//! Law:      τ ṗ = u(t − L) − p,   |ṗ| ≤ R
//!
//!   p       pressure in the rod, above ambient                 Pa
//!   u       commanded pressure, `muscle.pressure` over time    Pa
//!   τ       time constant                                      s
//!   L       dead time                                          s
//!   R       rate limit                                         Pa/s
//!
//! Assumes:  The rod does not move the pressure. The line has settled when the rod is let go: p = u(0).
//!           A command moves on straight lines between the rows of its table, and the solution there is
//!           exact. Linear models have the state p; they leave out the dead time and the rate limit.
//! Off:      time_constant = 0 and dead_time = 0, where the command never changes faster than rate_limit.
//! Silent:   A constant command.
//! Source:   First-order lag with dead time and slew rate: Åström and Hägglund (2006), Advanced PID
//!           Control, sec. 2.4 and 3.5.

use super::{About, Kind, Law, Line, Parameter, Place, Reach, Real, Separator, named};

/// A first-order lag with a dead time and a rate limit.
pub struct PressureLine;

impl Law for PressureLine {
    const ABOUT: About = About {
        name: "pressure_line",
        meaning: "a regulator brings the pressure to its command late, at a limited rate",
        kind: Kind::Load,
        places: &[Place::Line],
        memory: 0,
        timed: false,
        parameters: &[
            Parameter {
                name: "time_constant",
                meaning: "time in which a step of the command is followed to 63 %",
                unit: "s",
                default: 0.1,
                range: (0.0, 1e3),
                scale: 0.1,
                ..Parameter::PLAIN
            },
            Parameter {
                name: "dead_time",
                meaning: "time before the pressure begins to follow",
                unit: "s",
                default: 0.0,
                range: (0.0, 1e3),
                scale: 0.01,
                ..Parameter::PLAIN
            },
            Parameter {
                name: "rate_limit",
                meaning: "fastest change of the pressure; the default is faster than any valve",
                unit: "Pa/s",
                default: 1e9,
                range: (1.0, 1e12),
                scale: 1e5,
                ..Parameter::PLAIN
            },
        ],
        signature: "the response to a step of the pressure is late, and its first swing smaller",
        confounded_with: &["viscoelastic", "clock"],
        separated_by: &[Separator::Metrology],
        reach: Reach::Muscle,
    };

    fn line<T: Real>(&self, at: &Line<T>, theta: &[T]) -> [T; 2] {
        let [lag, _, limit] = named(theta);
        let rate = at.command_rate;
        // How far the pressure is behind, and the most of it that is followed at less than the limit.
        let (mut behind, most) = (at.command - at.pressure, limit * lag);
        let mut left = at.time;
        // At most three pieces: the limit, the lag, and the other limit.
        loop {
            let is_at = |sign: f64| {
                let beyond = (behind * sign - most).re();
                beyond > 0.0 || (beyond == 0.0 && sign * rate.re() > limit.re())
            };
            let limited = [1.0, -1.0].into_iter().find(|sign| is_at(*sign));
            let end = limited.unwrap_or(rate.re().signum());
            let (then, follows, meets) = match limited {
                Some(sign) => {
                    let closing = limit * sign - rate;
                    let meets = (behind - most * sign) / closing;
                    (behind - closing * left, limit * sign, (sign * closing.re() > 0.0).then_some(meets))
                }
                None if lag.re() == 0.0 => (rate * lag, rate, None),
                None => {
                    let settled = rate * lag;
                    let then = settled + (behind - settled) * (-left / lag).exp();
                    let meets = lag * ((settled - behind) / (settled - most * end)).ln();
                    (then, then / lag, (end * rate.re() > limit.re()).then_some(meets))
                }
            };
            match meets {
                Some(time) if time.re() < left.re() => (behind, left) = (most * end, left - time),
                _ => return [at.command + rate * at.time - then, follows],
            }
        }
    }

    fn dead_time<T: Real>(&self, theta: &[T]) -> T {
        let [_, dead_time] = named(theta);
        dead_time
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: f64 = 2e4;
    const LAG: f64 = 0.2;

    /// By steps of a fortieth of a millisecond, of first order.
    fn stepped(at: &Line<f64>) -> f64 {
        let count = 40_000;
        let step = at.time / f64::from(count);
        (0..count).fold(at.pressure, |pressure, k| {
            let command = at.command + at.command_rate * step * (f64::from(k) + 0.5);
            pressure + step * ((command - pressure) / LAG).clamp(-LIMIT, LIMIT)
        })
    }

    /// Every order of lag and limit, against small steps.
    #[test]
    fn a_command_is_followed_at_the_lag_and_at_the_limit() {
        let theta = [LAG, 0.0, LIMIT];
        for (command, command_rate) in [
            (3e3, 0.0),
            (3e4, 0.0),
            (-3e4, 0.0),
            (1e3, 3e4),
            (-9e3, 4e4),
            (9e3, -4e4),
            (0.0, 1e4),
            (5e4, 1.9e4),
        ] {
            let at = Line { pressure: 0.0, command, command_rate, time: 1.0 };
            let [found, follows] = PressureLine.line(&at, &theta);
            let due = stepped(&at);
            assert!((found - due).abs() < 1.0, "{command} at {command_rate}: {found}, due {due}");
            let before = PressureLine.line(&Line { time: 1.0 - 1e-6, ..at }, &theta)[0];
            assert!(((found - before) / 1e-6 - follows).abs() < 1.0, "{follows}");
        }
        // Without a lag the limit alone, and without a limit the command itself.
        let at = Line { pressure: 0.0, command: 3e4, command_rate: 0.0, time: 1.0 };
        assert_eq!(PressureLine.line(&at, &[0.0, 0.0, LIMIT]), [LIMIT, LIMIT]);
        assert_eq!(PressureLine.line(&Line { time: 2.0, ..at }, &[0.0, 0.0, LIMIT]), [3e4, 0.0]);
        let ramp = Line { pressure: 0.0, command: 0.0, command_rate: 1e4, time: 1.0 };
        assert_eq!(PressureLine.line(&ramp, &[0.0, 0.0, 1e9]), [1e4, 1e4]);
    }
}

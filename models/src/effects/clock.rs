//! Clock: the clock of the recording starts elsewhere, and runs at another rate.
//!
//! Law:      t = t₀ + (1 + r) t_rec
//!
//!   t       time since release                                s
//!   t_rec   time that the recording says                      s
//!   t₀      time since release at which the recording has 0   s
//!   r       relative error of the rate of its clock           –
//!
//! Assumes:  A steady clock. What the recording has before the release shows the rod as it is let go.
//! Off:      rate_error = 0, if offset = 0 as well.
//! Silent:   Rest.
//! Source:   A camera of (1 + r)⁻¹ times the frames a second that its file says.

use super::{About, Kind, Law, Parameter, Place, Reach, Real, Separator, named};

/// A clock that is off.
pub struct Clock;

impl Law for Clock {
    const ABOUT: About = About {
        name: "clock",
        meaning: "the clock of the recording starts elsewhere, and runs at another rate",
        kind: Kind::Measurement,
        places: &[Place::Sensor],
        memory: 0,
        timed: false,
        parameters: &[
            Parameter {
                name: "rate_error",
                meaning: "seconds that pass in one second of the recording, less one",
                unit: "",
                default: 1e-3,
                range: (-0.5, 1.0),
                scale: 1e-3,
                null_value: Some(0.0),
                is_part: true,
                plausible: Some((-0.01, 0.01)),
                ..Parameter::PLAIN
            },
            Parameter {
                name: "offset",
                meaning: "time since release at which the recording has its zero",
                unit: "s",
                default: 0.0,
                range: (-10.0, 10.0),
                scale: 0.01,
                null_value: Some(0.0),
                is_part: true,
                ..Parameter::PLAIN
            },
        ],
        signature: "phase runs away in proportion to time, at every amplitude and pressure alike",
        confounded_with: &["bend", "added_mass", "tip_inertia", "initial_velocity"],
        separated_by: &[Separator::Payload, Separator::Metrology],
        reach: Reach::Muscle,
    };

    fn clock<T: Real>(&self, recorded: T, theta: &[T]) -> T {
        let [rate_error, offset] = named(theta);
        recorded + rate_error * recorded + offset
    }
}

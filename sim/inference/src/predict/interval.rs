//! The 95 % interval of a predicted number: the one place where its parts are put together.
//!
//! Its parts are the errors of the calibration and of interpolation over pressure, both in the covariance of
//! [`models::muscle::KnownAt`], which reach a number by draws or along the principal directions of that covariance; and
//! those of the model itself (`model_error.rs`) and of the marker (`quantity.rs`).

use efam_core::quantile::quantile;

use crate::normal::NORMAL_95;

/// Shares of the draws below the ends.
const ENDS: [f64; 2] = [0.025, 0.975];

/// The interval of a number from what draws give; none where fewer than half of them have it.
///
/// It always holds the number itself: a parameter on its bound is at the end of all draws, not in their middle.
pub(super) fn of_draws(own: f64, values: Vec<f64>, draws: usize) -> Option<[f64; 2]> {
    if draws == 0 || 2 * values.len() < draws {
        return None;
    }
    let [low, high] = ENDS.map(|share| quantile(values.clone(), share));
    Some([low?.min(own), high?.max(own)])
}

/// The interval of a number with an independent error, half of whose own interval is given.
pub(super) fn with_error(own: f64, [low, high]: [f64; 2], half: f64) -> [f64; 2] {
    [own - (own - low).hypot(half), own + (high - own).hypot(half)]
}

/// What a number does along one direction of the errors, to one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Change {
    /// Change of the number for one standard deviation.
    pub slope: f64,
    /// Standard deviations that the parameters may go before one reaches its bound.
    pub room: f64,
}

/// The interval of a number from its changes along each direction, to the lower and the upper side; none where both
/// sides of a direction could not be simulated.
///
/// Each end is the root of the sum of squares of what moves the number that way, up to 1.96 standard deviations or the
/// bound of a parameter.
pub(super) fn carried(own: f64, changes: impl Iterator<Item = [Option<Change>; 2]>) -> Option<[f64; 2]> {
    let [mut below, mut above] = [0.0; 2];
    for change in changes {
        // A side that could not be simulated is taken to be as steep as the other.
        let mirrored = |other: Change| Change { slope: -other.slope, ..other };
        let sides = match change {
            [Some(low), Some(high)] => [low, high],
            [Some(low), None] => [low, mirrored(low)],
            [None, Some(high)] => [mirrored(high), high],
            [None, None] => return None,
        };
        let moved = sides.map(|side| side.slope * side.room.min(NORMAL_95));
        below += moved[0].min(moved[1]).min(0.0).powi(2);
        above += moved[0].max(moved[1]).max(0.0).powi(2);
    }
    Some([own - below.sqrt(), own + above.sqrt()])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(slope: f64) -> Option<Change> {
        Some(Change { slope, room: f64::INFINITY })
    }

    /// Two directions that move a number by 3 and 4 make a standard deviation of 5; where one side has no answer
    /// the other counts, where neither has there is no interval.
    #[test]
    fn errors_are_carried_along_their_directions() {
        let [low, high] = carried(10.0, [[side(-3.0), side(3.0)], [None, side(4.0)]].into_iter()).unwrap();
        assert!((high - low - 2.0 * NORMAL_95 * 5.0).abs() < 1e-12 && (high + low - 20.0).abs() < 1e-12);
        assert_eq!(carried(10.0, [[None, None]].into_iter()), None);
    }

    /// A damping ratio whose loss is on its bound of zero can only be larger.
    #[test]
    fn a_number_on_its_bound_has_an_interval_to_one_side() {
        let blocked = Some(Change { slope: 0.0, room: 0.0 });
        let interval = carried(0.03, [[blocked, side(0.01)]].into_iter()).unwrap();
        assert_eq!(interval, [0.03, 0.03 + NORMAL_95 * 0.01]);
        let near = Some(Change { slope: -0.01, room: 0.5 });
        assert_eq!(carried(0.03, [[near, side(0.01)]].into_iter()).unwrap()[0], 0.03 - 0.005);
    }

    /// A number at the end of its draws may be beyond that end by the error that is added.
    #[test]
    fn an_error_widens_both_sides() {
        assert_eq!(with_error(2.0, [2.0, 5.0], 4.0), [-2.0, 7.0]);
    }

    #[test]
    fn the_interval_of_draws_holds_the_number_itself() {
        let draws: Vec<f64> = (1..=200).map(|k| 0.029 + 3e-4 * f64::from(k)).collect();
        let [low, high] = of_draws(0.028, draws.clone(), 200).unwrap();
        assert!(low == 0.028 && high > 0.08 && high < 0.089, "{low} {high}");
        assert_eq!(of_draws(0.028, draws, 401), None);
    }
}

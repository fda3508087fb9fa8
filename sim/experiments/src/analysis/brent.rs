//! Brent's two searches along one number, by argmin: where a function crosses zero, and where it is least.
//!
//! Source: Brent (1973), Algorithms for Minimization without Derivatives, chapters 4 and 5.

use std::cell::RefCell;
use std::ops::Range;

use argmin::core::{CostFunction, Executor, Solver, State};
use argmin::core::{Error, IterState};
use argmin::solver::brent::{BrentOpt, BrentRoot};

/// Share of the range to which an answer is found.
const SHARE: f64 = 1e-3;
/// Evaluations after which a search ends where it is.
const MOST: u64 = 30;

/// Where in a range a function crosses zero, whose signs at the ends differ; none where they do not, or where
/// the function has no value.
pub fn root(range: Range<f64>, of: impl FnMut(f64) -> Option<f64>) -> Option<f64> {
    searched(BrentRoot::new(0.0, 1.0, SHARE), range, of)
}

/// Where in a range a function is least, if it falls towards one place and rises from there; none where it has no
/// value.
pub fn least(range: Range<f64>, of: impl FnMut(f64) -> Option<f64>) -> Option<f64> {
    searched(BrentOpt::new(0.0, 1.0).set_tolerance(f64::EPSILON.sqrt(), SHARE), range, of)
}

fn searched<F, S>(solver: S, range: Range<f64>, of: F) -> Option<f64>
where
    F: FnMut(f64) -> Option<f64>,
    S: Solver<Shares<F>, IterState<f64, (), (), (), (), f64>>,
{
    let (start, length) = (range.start, range.end - range.start);
    let shares = Shares { start, length, of: RefCell::new(of) };
    let done =
        Executor::new(shares, solver).configure(|state| state.max_iters(MOST)).timer(false).run().ok()?;
    done.state().get_param().map(|share| start + length * share)
}

/// A function of the share of a range.
struct Shares<F> {
    start: f64,
    length: f64,
    of: RefCell<F>,
}

impl<F: FnMut(f64) -> Option<f64>> CostFunction for Shares<F> {
    type Param = f64;
    type Output = f64;

    fn cost(&self, share: &f64) -> Result<f64, Error> {
        let value = (self.of.borrow_mut())(self.start + self.length * share);
        value.filter(|value| value.is_finite()).ok_or_else(|| Error::msg("there is no value"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cosine_crosses_zero_at_a_right_angle_and_is_least_at_two() {
        let crossing = root(1.0..2.0, |x| Some(x.cos())).unwrap();
        assert!((crossing - std::f64::consts::FRAC_PI_2).abs() < 1e-3);
        let bottom = least(2.0..4.0, |x| Some(x.cos())).unwrap();
        assert!((bottom - std::f64::consts::PI).abs() < 6e-3, "{bottom}");
    }

    #[test]
    fn without_a_crossing_or_a_value_there_is_no_answer() {
        assert_eq!(root(1.0..2.0, |x| Some(1.0 + x)), None);
        assert_eq!(root(1.0..2.0, |_| None), None);
        assert_eq!(least(1.0..2.0, |_| Some(f64::NAN)), None);
    }
}

//! The simplex search of Nelder and Mead, with which the paper fits, by argmin.
//!
//! Source: Lagarias, Reeds, Wright and Wright (1998), Convergence properties of the Nelder-Mead
//! simplex method in low dimensions, SIAM Journal on Optimization 9; MATLAB's fminsearch. Reflection
//! 1, expansion 2, contraction and shrinkage 1/2; the first simplex reaches 5 % along each parameter.

use std::cell::Cell;

use argmin::{
    core::{CostFunction, Executor, State},
    solver::neldermead::NelderMead,
};

/// Spread of costs over the simplex at which a search ends. Costs of order one are rounded at
/// 1e-16; a parabola that rises by this much has been left by 3e-8 of a parameter of order one.
const SPREAD: f64 = 1e-15;
/// Move of a parameter of order one, after a fresh start, that counts as none.
const SETTLED: f64 = 1e-6;
/// Fresh starts after which a search that still moves is given up.
const FRESH_STARTS: usize = 10;

/// Where a search has settled.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// The best parameters.
    pub parameters: Vec<f64>,
    /// Their cost.
    pub cost: f64,
    /// Evaluations of the cost that this took.
    pub evaluations: usize,
}

/// A search that did not settle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stalled {
    /// Evaluations spent.
    pub evaluations: usize,
}

/// The parameters of least cost near `start`.
///
/// Scale parameters and cost to order one. Where `cost` is not a number, nothing is there: the
/// search turns round. When the costs of the simplex agree, it starts afresh from its best point with
/// another simplex until that point stays, because two points on either side of a minimum agree as well.
/// # Errors
/// [`Stalled`] if it does not settle, or finds no finite cost.
pub fn minimize(start: &[f64], cost: impl Fn(&[f64]) -> f64) -> Result<Minimum, Stalled> {
    let evaluations = Cell::new(0);
    let mut best = start.to_vec();
    for round in 0..FRESH_STARTS {
        let reach = if round == 0 { 0.05 } else { -0.02 };
        let problem = Problem { cost: &cost, evaluations: &evaluations };
        let solver = NelderMead::new(first_simplex(&best, reach))
            .with_sd_tolerance(SPREAD)
            .expect("the tolerance is positive");
        let outcome = Executor::new(problem, solver)
            .configure(|state| state.max_iters(200 * start.len() as u64))
            .timer(false)
            .run()
            .expect("no cost fails, and none is NaN");
        let (Some(found), cost) = (outcome.state().get_best_param(), outcome.state().get_best_cost()) else {
            break;
        };
        if !cost.is_finite() {
            break;
        }
        let moves = |(a, b): (&f64, &f64)| (a - b).abs() > SETTLED * a.abs().max(1.0);
        let settled = round > 0 && !found.iter().zip(&best).any(moves);
        best = found.clone();
        if settled {
            return Ok(Minimum { parameters: best, cost, evaluations: evaluations.get() });
        }
    }
    Err(Stalled { evaluations: evaluations.get() })
}

/// The start, and one point away from it along each parameter by a fraction `reach` of it; by an
/// absolute step where it is zero.
fn first_simplex(start: &[f64], reach: f64) -> Vec<Vec<f64>> {
    let mut simplex = vec![start.to_vec(); start.len() + 1];
    for (i, value) in start.iter().enumerate() {
        simplex[i + 1][i] += if *value == 0.0 { 0.00025 } else { reach * value };
    }
    simplex
}

struct Problem<'a, F> {
    cost: &'a F,
    evaluations: &'a Cell<usize>,
}

impl<F: Fn(&[f64]) -> f64> CostFunction for Problem<'_, F> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, parameters: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        self.evaluations.set(self.evaluations.get() + 1);
        let cost = (self.cost)(parameters);
        // Comparisons with NaN lead the solver where its authors saw no way.
        Ok(if cost.is_nan() { f64::INFINITY } else { cost })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_banana_valley_is_followed_to_its_end() {
        let rosenbrock = |p: &[f64]| 100.0 * (p[1] - p[0] * p[0]).powi(2) + (1.0 - p[0]).powi(2);
        let minimum = minimize(&[-1.2, 1.0], rosenbrock).unwrap();
        assert!(minimum.parameters.iter().all(|p| (p - 1.0).abs() < 1e-6), "{minimum:?}");
        assert!(minimum.evaluations < 1000, "{minimum:?}");
    }

    /// The first simplex of 1 and 1.05 has equal costs on either side of 1.025.
    #[test]
    fn two_sides_of_a_minimum_are_no_minimum() {
        let minimum = minimize(&[1.0], |p| (p[0] - 1.025).powi(2)).unwrap();
        assert!((minimum.parameters[0] - 1.025).abs() < 1e-6, "{minimum:?}");
    }

    #[test]
    fn an_edge_beyond_which_nothing_is_turns_the_search_round() {
        let minimum = minimize(&[2.0], |p| p[0].sqrt().powi(2) + 1e-3 / p[0]).unwrap();
        assert!((minimum.parameters[0] - 1e-3f64.sqrt()).abs() < 1e-6, "{minimum:?}");
    }

    #[test]
    fn a_slope_without_end_stalls() {
        let stalled = minimize(&[1.0], |p| -p[0]).unwrap_err();
        assert!(stalled.evaluations > 0);
        assert!(minimize(&[1.0], |_| f64::NAN).is_err());
    }
}

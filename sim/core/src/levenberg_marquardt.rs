//! Nonlinear least squares: Levenberg's and Marquardt's method, with bounds.
//!
//! A step minimises the quadratic model `cost + gᵀs + sᵀ(H + S + μ D)s / 2` within the bounds, where H is
//! Gauss's and Newton's approximation of the second derivatives, S an estimate of the rest from slopes at several
//! points (`second_order.rs`), and D the largest diagonal of H so far. μ is the smallest for which the step is within a radius, in
//! the scale of D; the radius follows the ratio of actual to predicted decrease. The search stops where the *undamped* model
//! predicts no decrease worth having: with residuals in units of their noise, a predicted decrease
//! of `ε² / 2` means that no combination of parameters is more than `ε` standard errors from the
//! optimum. The length of the last step would say no such thing.
//!
//! Ours, because the kept crate (levenberg-marquardt 0.15) is bound to nalgebra 0.34 and knows no bounds.
//! Sources: Marquardt (1963), J. SIAM 11, 431-441; Moré (1978), Lecture Notes in Mathematics 630, for the
//! scaling and the radius.

mod quadratic;
mod second_order;

use nalgebra::{DMatrix, DVector};

use quadratic::{LEAST_DAMPING, Quadratic, length, widen};
use second_order::SecondOrder;

/// Cost and its derivatives at one point.
#[derive(Clone, Debug)]
pub struct Evaluated<T> {
    /// Half the sum of the squared residuals, or of what a robust loss makes of them.
    pub cost: f64,
    /// Its gradient.
    pub gradient: DVector<f64>,
    /// `JᵀJ`.
    pub hessian: DMatrix<f64>,
    /// What else belongs to the point.
    pub carried: T,
}

/// Where to search and when to stop.
#[derive(Clone, Debug)]
pub struct Search {
    /// Smallest and largest admissible value of each variable.
    pub bounds: Vec<(f64, f64)>,
    /// Largest change of each variable in one step.
    pub longest: Vec<f64>,
    /// Predicted decrease of the cost that is not worth a step.
    pub tolerance: f64,
    /// The same as a share of the cost; the larger of the two holds.
    pub relative: f64,
    /// Evaluations after which to give up.
    pub most_evaluations: usize,
    /// Damping of the first step, relative to D: little where the start is near the end already, since
    /// in a valley any damping stops the step short.
    pub first_damping: f64,
    /// Whether a point may have the slopes of the one before: where they cost several evaluations.
    pub reuses_slopes: bool,
    /// Whether another search goes on from where this one ends: it may end on reused slopes, and gives up
    /// sooner.
    pub is_followed: bool,
}

/// Slopes from another search, for the start of a search.
#[derive(Debug)]
pub struct Reused<'a, T> {
    /// What their point carries, see [`Evaluated::carried`].
    pub carried: &'a T,
    /// Where they were taken; none if this search takes slopes of another kind. It then takes its own before it ends.
    pub home: Option<&'a DVector<f64>>,
}

/// Where a search ended.
#[derive(Clone, Debug)]
pub struct Solution<T> {
    /// The variables.
    pub x: DVector<f64>,
    /// Cost and derivatives there.
    pub at: Evaluated<T>,
    /// Where its slopes were taken; none if they are of another kind, or if the search did not converge. Slopes taken at its
    /// end may then lower the cost further.
    pub home: Option<DVector<f64>>,
    /// Evaluations made.
    pub evaluations: usize,
    /// Decrease that the undamped model still predicts.
    pub predicted: f64,
    /// Whether that is below the tolerance, or was so with terms of second order, and steps without them gain nothing.
    pub converged: bool,
}

/// Steps that gain less than the tolerance, whatever was refused in between, after which no step helps: what is left is the
/// noise of the evaluation itself, or of its slopes. The second is for a search that is followed by another.
const MOST_IDLE: usize = 6;
const MOST_IDLE_FOLLOWED: usize = 2;
/// Usual damping of the first step.
pub const FIRST_DAMPING: f64 = 1e-3;
/// That of a search that begins near its end.
pub const NEAR_DAMPING: f64 = 1e-8;
/// Actual over predicted decrease from which on reused slopes are good enough for another step.
const TRUSTED: f64 = 0.8;
/// Actual over predicted decrease up to which the next step is shorter, and from which on it may be longer; and by how much a
/// step is shorter after one that was too long. Those of Moré (1978).
const POOR: f64 = 0.25;
const GOOD: f64 = 0.75;
const SHORTER: f64 = 0.25;

/// From a point, and perhaps what another one carries whose slopes are reused, to cost and slopes.
pub type Evaluate<'a, T> = dyn FnMut(&DVector<f64>, Option<&T>) -> Option<Evaluated<T>> + 'a;

/// Minimises a cost from `start`. `evaluate` says nothing where the cost cannot be had; given what an
/// earlier point carried, it may take the slopes of that point for its own. None, if the cost cannot be
/// had at the start.
///
/// With [`Search::reuses_slopes`] slopes are reused from point to point as long as they predict the cost's fall.
/// The final steps use slopes of the point itself or of one within a standard error, unless
/// [`Search::is_followed`].
pub fn minimise<T>(
    start: &DVector<f64>,
    reused: Option<Reused<T>>,
    search: &Search,
    evaluate: &mut Evaluate<T>,
) -> Option<Solution<T>> {
    let mut x = start.clone();
    for (x, (low, high)) in x.iter_mut().zip(&search.bounds) {
        *x = x.clamp(*low, *high);
    }
    let mut at = evaluate(&x, reused.as_ref().map(|reused| reused.carried))?;
    let mut evaluations = 1;
    let mut home = reused.map_or_else(|| Some(x.clone()), |reused| reused.home.cloned());
    // Unknown if the slopes come from another search.
    let mut home_cost = if home.as_ref() == Some(&x) { at.cost } else { f64::NAN };
    let mut diagonal = DVector::zeros(x.len());
    let mut second_order = SecondOrder::none(x.len());
    let (mut least_damping, mut radius) = (search.first_damping, f64::INFINITY);
    let (mut idle, mut is_refused, mut is_settled) = (0, false, false);
    let most_idle = if search.is_followed { MOST_IDLE_FOLLOWED } else { MOST_IDLE };
    loop {
        widen(&mut diagonal, &at.hessian);
        let moved = home.as_ref().map(|home| &x - home);
        let model = Quadratic::of(&at, moved.as_ref(), &second_order, &diagonal);
        let decrease_by = |model: &Quadratic| model.step(&x, &diagonal, LEAST_DAMPING, search, false).1;
        let predicted = decrease_by(&model);
        let tolerance = search.tolerance.max(search.relative * at.cost);
        let mut converged = predicted <= tolerance;
        let is_at_home = home.as_ref() == Some(&x);
        let is_learnt = second_order.is_known();
        // Terms that were learnt at other points may make the predicted decrease too small.
        if converged && is_learnt && (is_at_home || search.is_followed) {
            let without = Quadratic { hessian: at.hessian.clone(), gradient: model.gradient.clone() };
            if decrease_by(&without) > tolerance {
                second_order.forget();
                is_settled = true;
                continue;
            }
        }
        let (tried, decrease, is_shortened) = model.step_within(radius, &x, &diagonal, least_damping, search);
        // After a refused step, any step within the smaller radius would gain less than the tolerance.
        let is_worthless = is_refused && is_shortened && decrease <= tolerance;
        // It had converged with terms of second order, and steps without them gain nothing.
        converged |= is_worthless && is_settled;
        let is_stuck = is_worthless || idle >= most_idle;
        let is_over = converged || is_stuck || evaluations >= search.most_evaluations;
        let is_near = |moved: &DVector<f64>| !is_learnt && moved.dot(&(&at.hessian * moved)) < 1.0;
        let is_home = is_at_home || moved.as_ref().is_some_and(is_near);
        if is_over && (is_home || search.is_followed) {
            let home = home.filter(|_| converged);
            return Some(Solution { x, at, home, evaluations, predicted, converged });
        }
        let mut ratio = -1.0;
        if !is_over {
            let length = length(&(&tried - &x), &diagonal);
            least_damping = LEAST_DAMPING;
            let reused = search.reuses_slopes.then_some(&at.carried);
            let next = (decrease > 0.0).then(|| evaluate(&tried, reused)).flatten();
            evaluations += usize::from(decrease > 0.0);
            ratio = next.as_ref().map_or(-1.0, |next| (at.cost - next.cost) / decrease);
            match next {
                Some(next) if ratio > 1e-3 => {
                    let has_gained = at.cost - next.cost > tolerance;
                    idle = if has_gained { 0 } else { idle + 1 };
                    is_settled &= !has_gained;
                    (x, at) = (tried, next);
                    if !search.reuses_slopes {
                        home = Some(x.clone());
                    }
                    if ratio < POOR {
                        radius = SHORTER * length;
                    } else if ratio > GOOD {
                        radius = radius.max(2.0 * length);
                    }
                    is_refused = false;
                }
                _ if is_at_home => {
                    second_order.forget();
                    radius = SHORTER * length;
                    is_refused = true;
                }
                _ => {}
            }
        }
        if home.as_ref() != Some(&x) && ratio < TRUSTED {
            let own = evaluate(&x, None)?;
            evaluations += 1;
            if let Some(home) = &home {
                let (moved, changed) = (&x - home, &own.gradient - &at.gradient);
                // Slopes jump with friction. A curvature is learnt only if it brings the quadratic nearer to the cost at home.
                let plain = Quadratic::plain(&own).at(&-&moved) + own.cost - home_cost;
                if (plain + 0.5 * moved.dot(&changed)).abs() < plain.abs() {
                    second_order.learn(&moved, &changed, &own.hessian);
                }
            }
            (at, home) = (own, Some(x.clone()));
            home_cost = at.cost;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    /// A search without bounds, to such a predicted decrease.
    fn unbounded(variables: usize, tolerance: f64) -> Search {
        Search {
            bounds: vec![(f64::NEG_INFINITY, f64::INFINITY); variables],
            longest: vec![f64::INFINITY; variables],
            tolerance,
            relative: 0.0,
            most_evaluations: 200,
            first_damping: FIRST_DAMPING,
            reuses_slopes: false,
            is_followed: false,
        }
    }

    type Residuals = fn(&DVector<f64>) -> (DVector<f64>, DMatrix<f64>);

    fn solve(of: Residuals, start: &[f64], bounds: &[(f64, f64)]) -> Solution<()> {
        let search = Search { bounds: bounds.to_vec(), ..unbounded(bounds.len(), 1e-24) };
        let mut evaluate = |x: &DVector<f64>, _: Option<&()>| {
            let (r, j) = of(x);
            Some(Evaluated {
                cost: 0.5 * r.norm_squared(),
                gradient: j.tr_mul(&r),
                hessian: j.tr_mul(&j),
                carried: (),
            })
        };
        minimise(&DVector::from_column_slice(start), None, &search, &mut evaluate).unwrap()
    }

    /// Rosenbrock (1960): residuals `10 (y − x²)` and `1 − x`; root at (1, 1).
    fn rosenbrock(x: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let r = DVector::from_column_slice(&[10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]);
        (r, DMatrix::from_row_slice(2, 2, &[-20.0 * x[0], 10.0, -1.0, 0.0]))
    }

    /// Powell (1962): the Jacobian is singular at the root, so convergence is linear.
    fn powell(x: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let (a, b) = (x[1] - 2.0 * x[2], x[0] - x[3]);
        let (s, t) = (5f64.sqrt(), 10f64.sqrt());
        let r = [x[0] + 10.0 * x[1], s * (x[2] - x[3]), a * a, t * b * b];
        let (da, db) = (2.0 * a, 2.0 * t * b);
        #[rustfmt::skip]
        let j = [
            1.0, 10.0, 0.0, 0.0,
            0.0, 0.0, s, -s,
            0.0, da, -2.0 * da, 0.0,
            db, 0.0, 0.0, -db,
        ];
        (DVector::from_column_slice(&r), DMatrix::from_row_slice(4, 4, &j))
    }

    #[test]
    fn rosenbrocks_valley_is_followed_to_its_end() {
        let free = [(f64::NEG_INFINITY, f64::INFINITY); 2];
        let found = solve(rosenbrock, &[-1.2, 1.0], &free);
        assert!(found.converged && found.evaluations < 40, "{found:?}");
        assert!((found.x[0] - 1.0).abs() < 1e-9 && (found.x[1] - 1.0).abs() < 1e-9, "{found:?}");
    }

    /// With `x ≤ 0.5` the least cost lies at (0.5, 0.25); with `y ≤ 0.3` in the valley where
    /// `−400 x (y − x²) − 2 (1 − x) = 0`.
    #[test]
    fn rosenbrock_within_bounds_ends_on_them() {
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let found = solve(rosenbrock, &[-1.2, 1.0], &[(f64::NEG_INFINITY, 0.5), free]);
        assert_eq!(found.x[0], 0.5);
        assert!(found.predicted < 1e-16 && (found.x[1] - 0.25).abs() < 1e-9, "{found:?}");
        let found = solve(rosenbrock, &[-1.2, 0.1], &[(0.0, 2.0), (f64::NEG_INFINITY, 0.3)]);
        assert_eq!(found.x[1], 0.3);
        let x = found.x[0];
        assert!((-400.0 * x * (0.3 - x * x) - 2.0 * (1.0 - x)).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn powells_singular_function_comes_down() {
        let found = solve(powell, &[3.0, -1.0, 0.0, 1.0], &[(f64::NEG_INFINITY, f64::INFINITY); 4]);
        assert!(found.converged && found.x.amax() < 1e-4, "{found:?}");
    }

    /// Brown and Dennis (1971), as problem 16 of Moré, Garbow and Hillstrom (1981), ACM Transactions on Mathematical Software
    /// 7, 17-41: the least sum of squares is 85822.2. Without the terms of second order 500 evaluations do not reach it.
    #[test]
    fn large_residuals_take_few_slopes() {
        let taken = Cell::new(0);
        let of = |x: &DVector<f64>| {
            let row = |k: usize| {
                let t = 0.2 * (k + 1) as f64;
                let (a, b) = (x[0] + t * x[1] - t.exp(), x[2] + t.sin() * x[3] - t.cos());
                (a * a + b * b, [2.0 * a, 2.0 * a * t, 2.0 * b, 2.0 * b * t.sin()])
            };
            let rows: Vec<_> = (0..20).map(row).collect();
            (
                DVector::from_iterator(20, rows.iter().map(|row| row.0)),
                DMatrix::from_fn(20, 4, |i, j| rows[i].1[j]),
            )
        };
        let mut evaluate = |x: &DVector<f64>, reused: Option<&DMatrix<f64>>| {
            let (r, own) = of(x);
            taken.set(taken.get() + usize::from(reused.is_none()));
            let j = reused.cloned().unwrap_or(own);
            let (gradient, hessian) = (j.tr_mul(&r), j.tr_mul(&j));
            Some(Evaluated { cost: 0.5 * r.norm_squared(), gradient, hessian, carried: j })
        };
        let search = Search { reuses_slopes: true, most_evaluations: 500, ..unbounded(4, 1e-6) };
        let start = DVector::from_column_slice(&[25.0, 5.0, -5.0, -1.0]);
        let found = minimise(&start, None, &search, &mut evaluate).unwrap();
        assert!(found.converged && (2.0 * found.at.cost - 85822.2016).abs() < 1e-3, "{found:?}");
        assert!(taken.get() < 40, "slopes taken {} times", taken.get());
    }

    /// The cost jumps up before its minimum, as that of a rod with friction does. At the jump the search ends.
    #[test]
    fn a_search_ends_beside_a_jump() {
        let mut evaluate = |x: &DVector<f64>, _: Option<&()>| {
            let jump = if x[0] > 0.5 { 10.0 } else { 0.0 };
            Some(Evaluated {
                cost: 0.5 * (x[0] - 1.0).powi(2) + jump,
                gradient: x.add_scalar(-1.0),
                hessian: DMatrix::identity(1, 1),
                carried: (),
            })
        };
        let search = unbounded(1, 1e-2);
        let found = minimise(&DVector::from_element(1, -1.0), None, &search, &mut evaluate).unwrap();
        assert!(!found.converged && (found.x[0] - 0.5).abs() < 0.05, "{found:?}");
        assert!(found.evaluations < 12, "{} evaluations", found.evaluations);
    }

    /// A linear problem is solved by the damped steps in a handful of evaluations, and a variable
    /// without influence stays where it is.
    #[test]
    fn a_variable_without_influence_stays() {
        let line: Residuals = |x| {
            let j = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 2.0, 0.0, 3.0, 0.0]);
            (&j * x - DVector::from_column_slice(&[1.0, 2.0, 3.5]), j)
        };
        let found = solve(line, &[0.0, 0.7], &[(-10.0, 10.0); 2]);
        // Sum of products over sum of squares.
        assert!((found.x[0] - 15.5 / 14.0).abs() < 1e-9 && found.x[1] == 0.7, "{found:?}");
        assert!(found.evaluations < 10, "{found:?}");
    }

    /// Where the cost cannot be had, the step is shortened.
    #[test]
    fn a_step_into_the_unknown_is_shortened() {
        let search = Search { bounds: vec![(-10.0, 10.0)], most_evaluations: 100, ..unbounded(1, 1e-20) };
        // The first step would go to −1 + 1.5 / 0.5 = 2.
        let mut evaluate = |x: &DVector<f64>, _: Option<&()>| {
            let r = x[0].exp() - 0.6f64.exp();
            (x[0] < 1.0).then(|| Evaluated {
                cost: 0.5 * r * r,
                gradient: DVector::from_element(1, r * x[0].exp()),
                hessian: DMatrix::from_element(1, 1, (2.0 * x[0]).exp()),
                carried: (),
            })
        };
        let found = minimise(&DVector::from_element(1, -1.0), None, &search, &mut evaluate).unwrap();
        assert!((found.x[0] - 0.6).abs() < 1e-9, "{found:?}");
        assert!(minimise(&DVector::from_element(1, 2.0), None, &search, &mut evaluate).is_none());
    }

    /// Residuals of Rosenbrock's valley with slopes that are reused: the same end, for less slopes than
    /// points, and the last slopes are of a point within a standard error.
    #[test]
    fn reused_slopes_lead_to_the_same_end() {
        let search = Search { reuses_slopes: true, ..unbounded(2, 1e-24) };
        let slopes_taken = Cell::new(0);
        let mut evaluate = |x: &DVector<f64>, reused: Option<&DMatrix<f64>>| {
            let (r, own) = rosenbrock(x);
            slopes_taken.set(slopes_taken.get() + usize::from(reused.is_none()));
            let j = reused.cloned().unwrap_or(own);
            Some(Evaluated {
                cost: 0.5 * r.norm_squared(),
                gradient: j.tr_mul(&r),
                hessian: j.tr_mul(&j),
                carried: j,
            })
        };
        let start = DVector::from_column_slice(&[-1.2, 1.0]);
        let found = minimise(&start, None, &search, &mut evaluate).unwrap();
        assert!((found.x[0] - 1.0).abs() < 1e-9 && (found.x[1] - 1.0).abs() < 1e-9, "{found:?}");
        let home = found.home.as_ref().unwrap();
        assert_eq!(found.at.carried, rosenbrock(home).1);
        assert!((&found.at.carried * (&found.x - home)).norm() < 1.0, "{found:?}");
        // A search that goes on from there needs none of its own, unless it does not know where they were taken.
        let mut again = |home: Option<&DVector<f64>>| {
            let before = slopes_taken.get();
            let reused = Reused { carried: &found.at.carried, home };
            minimise(&found.x, Some(reused), &search, &mut evaluate).unwrap();
            slopes_taken.get() - before
        };
        assert_eq!((again(Some(home)), again(None)), (0, 1));
        let all = slopes_taken.get();
        assert!(all < found.evaluations, "{all} of {}", found.evaluations);
    }
}

//! Scores: how much of the residual each candidate would take away that nothing in the model can.
//!
//! With J the slopes by all that the fit knows and s those by a candidate's strength, both weighted and with
//! the rows of the priors, `s⊥ = s − J (JᵀJ)⁻¹ Jᵀs` is what the candidate does that the fit cannot. The
//! residual r pulls on it by `U = s⊥ᵀ r`; `U / |s⊥|²` is the strength that it asks for, `U² / |s⊥|²` the
//! decrease of χ² that it promises (the score test; Rao (1948), and Silvapulle and Silvapulle (1995) for
//! one side). The variance of U comes from how residuals follow one another, taken from what is left when
//! the fit and all candidates have had their way, so that a large effect does not pass for noise.
//!
//! Many candidates are looked at, and they resemble one another, so the largest score of a model that lacks
//! nothing is no normal number. Its law follows from the covariance of all U: it is drawn, and the threshold
//! is the quantile that the asked false-alarm level says.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::candidate::Candidate;
use super::design_matrix::{self, Column, differences, extended, movements, normal_equations, places};
use super::mesh_check::LAW;
use super::threshold::threshold;
use crate::calibrate::joint::Joint;
use crate::calibrate::prediction::Prediction;
use crate::calibrate::uncertainty::{pseudo_inverse, spread};

/// What is scored: one way to move the predictions, or several that belong together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Subject {
    /// Where its strength vanishes.
    pub null_value: f64,
    /// The admissible side of that, 1 or -1; 0 for both.
    pub side: f64,
    /// Share of a column's square that must be left when the fit has had its way: below that it is made of
    /// the errors of the slopes.
    pub own: f64,
    /// Standard deviation that is believed of each strength, where each release has its own: the baseline can do
    /// all but what differs between releases, and what it can do must not be asked for.
    pub believed: Option<f64>,
}

/// What a score vector is weighed by.
pub(super) struct Weight {
    /// `statistic = Uᵀ inverse U`.
    inverse: DMatrix<f64>,
    /// What the statistic is where nothing is missing, on average.
    degrees: f64,
    /// Takes the score vector to the strengths that it asks for.
    to_strengths: DMatrix<f64>,
    /// Takes it to the sum of these strengths.
    to_sum: DVector<f64>,
}

impl Weight {
    /// The size of a score vector, as a normal number.
    pub fn size(&self, score_vector: &DVector<f64>) -> f64 {
        normal_size(score_vector.dot(&(&self.inverse * score_vector)), self.degrees)
    }
}

/// Share of a column's square that must be left beside the fit for it to be heard: amplitude, phase and slopes are known to a
/// few per cent.
pub(super) const RESOLVED: f64 = 3e-3;
/// Standard deviations from which on two effects are separated, and below which they are one.
pub(super) const APART: f64 = 5.0;
pub(super) const ONE: f64 = 2.0;

impl Subject {
    /// What a score needs of a candidate for a fit.
    fn of(candidate: &Candidate, fit: &Joint) -> Self {
        let (low, high) = candidate.believed();
        let side = if fit.problem.has(candidate.name()) {
            0.0 // a change of the strength that the fit has may have either sign
        } else if low >= candidate.null_value {
            1.0
        } else if high <= candidate.null_value {
            -1.0
        } else {
            0.0
        };
        // A column of which so little is left is taken by differences on the same steps, which are good to some 1e-5.
        Self {
            null_value: candidate.null_value,
            side,
            own: 1e-9,
            believed: candidate.belief().map(|belief| belief.deviation),
        }
    }

    /// With the columns' gram matrix, the variance of their score vector, and its variance inflation.
    pub fn weight(self, gram: &DMatrix<f64>, variance: &DMatrix<f64>, variance_inflation: f64) -> Weight {
        let count = gram.nrows();
        let belief = self.believed.map_or(0.0, |deviation| variance_inflation / (deviation * deviation));
        let to_strengths = pseudo_inverse(&(gram + DMatrix::identity(count, count) * belief)).0;
        let (inverse, degrees) = match self.believed {
            None => (pseudo_inverse(variance).0, count as f64),
            Some(_) => {
                let inverse = &to_strengths / variance_inflation;
                let degrees = (&inverse * variance).trace();
                (inverse, degrees)
            }
        };
        let to_sum = to_strengths.row_sum_tr();
        Weight { inverse, degrees, to_strengths, to_sum }
    }

    /// Whether the strengths that a score vector asks for are on their side: one for all, or the mean of those of each
    /// pressure. Those of each release may differ in sign.
    pub fn admits(&self, score_vector: &DVector<f64>, weight: &Weight) -> bool {
        let is_of_releases = self.believed.is_some() && score_vector.len() > 1;
        self.side == 0.0 || is_of_releases || self.side * weight.to_sum.dot(score_vector) > 0.0
    }
}

/// The score of one subject.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Score {
    /// Its columns among all.
    pub columns: Vec<usize>,
    /// Size of the evidence, as a normal number that only a stronger effect makes larger.
    pub size: f64,
    /// How many independent strengths that is of, on average over the noise.
    pub degrees: f64,
    /// Promised decrease of χ², in units of the noise as it is.
    pub decrease: f64,
    /// What the residual asks of each column.
    pub estimates: Vec<f64>,
    /// Strength that the residual asks for; the mean where each pressure has its own, the root mean square where
    /// each release has.
    pub estimate: f64,
    /// Whether the estimate has an admissible sign.
    pub is_admissible: bool,
}

impl Score {
    /// Decrease of χ² whose size is this: what noise gives to several strengths is more than to one.
    pub fn decrease_at(&self, size: f64) -> f64 {
        statistic(size, self.degrees)
    }
}

/// All scores, and what they are measured by.
pub(super) struct Scores {
    pub each: Vec<Score>,
    /// Score that a model which lacks nothing exceeds as often as the false-alarm level says.
    pub threshold: f64,
    /// `s⊥ᵀ s⊥` of all columns.
    pub gram: DMatrix<f64>,
    /// Variance of the residuals' score vector over that of white noise as large as stated.
    pub variance_inflation: f64,
}

/// Residuals may be quieter than the stated noise by this share of its variance; below that what they say is
/// of mesh and step.
const QUIETEST: f64 = 0.25;
/// Scores candidates at a fit that predicts `off`; `tell` hears their names.
pub(super) fn scores_of(
    candidates: &[Candidate],
    fit: &Joint,
    off: &[Prediction],
    false_alarm: f64,
    tell: &(dyn Fn(&str) + Sync),
) -> Scores {
    let columns = columns(candidates, fit, off, tell);
    let subjects: Vec<Subject> = candidates.iter().map(|own| Subject::of(own, fit)).collect();
    scores(fit, &subjects, &columns, false_alarm)
}

/// Share of a column's square that its own errors make at the tolerance of a fit. Steps damp the rod, and slopes of the
/// variational equation in another way: these are a per cent off.
const OF_SLOPES: f64 = 1e-4;

/// The columns of candidates at a fit that predicts `off`; `tell` hears their names. Where the fit can do so much of one that
/// the errors of slopes are more than a tenth of what is left, they are taken by differences.
pub(super) fn columns(
    candidates: &[Candidate],
    fit: &Joint,
    off: &[Prediction],
    tell: &(dyn Fn(&str) + Sync),
) -> Vec<Column> {
    let mut moved = movements(fit, candidates, tell);
    let columns = design_matrix::columns(fit, candidates, &moved);
    let n = fit.found.x.len();
    let (_, hessian) = normal_equations(fit, &extended(fit, &columns), columns.len());
    let gram = gram(fit, &hessian);
    let is_hidden = |(k, column): (usize, &Column)| {
        (LAW * gram[(k, k)] < OF_SLOPES * hessian[(n + k, n + k)]).then_some(column.of)
    };
    let mut hidden: Vec<usize> = columns.iter().enumerate().filter_map(is_hidden).collect();
    hidden.dedup();
    if hidden.is_empty() {
        return columns;
    }
    let exactly = |c: &usize| differences(fit, off, &candidates[*c], moved[*c].as_ref()?);
    let exact: Vec<_> = hidden.par_iter().map(exactly).collect();
    for (c, exact) in hidden.into_iter().zip(exact).filter(|(_, exact)| exact.is_some()) {
        moved[c] = exact;
    }
    design_matrix::columns(fit, candidates, &moved)
}

/// The score vector of columns, with the unknowns of a fit free, and what it is measured by.
pub(super) struct Pulls {
    /// `U = s⊥ᵀ r` of each column.
    pub score_vector: DVector<f64>,
    /// Its covariance, as residuals follow one another.
    variance: DMatrix<f64>,
    /// `s⊥ᵀ s⊥`.
    pub gram: DMatrix<f64>,
    /// Whether enough of a column is left.
    is_own: Vec<bool>,
    /// As in [`Scores`].
    pub variance_inflation: f64,
}

impl Pulls {
    /// Of at least one column; `own` is [`Subject::own`] of each.
    pub fn of(fit: &Joint, columns: &[Column], own: impl Fn(&Column) -> f64) -> Self {
        let n = fit.found.x.len();
        let m = columns.len();
        let extended = extended(fit, columns);
        let (gradient, hessian) = normal_equations(fit, &extended, m);
        // What is left when the fit and all columns have had their way.
        let whole = &pseudo_inverse(&hessian).0 * &gradient;
        let mut left = extended;
        for (r, block) in left.iter_mut().enumerate() {
            let places = fit.objective.places(r, m);
            for series in block {
                for (residual, slopes) in series.residual.iter_mut().zip(&series.slopes) {
                    for (place, slope) in places.iter().zip(slopes) {
                        let step = whole[*place];
                        residual[0] += step * slope[0];
                        residual[1] += step * slope[1];
                    }
                }
            }
        }
        let lost =
            |r: usize| (fit.objective.part.locals[r].len() + m) as f64 / (left[r].len() * left.len()) as f64;
        let (spread, _) = spread(&fit.objective, &fit.found, &left, m, &lost);
        let (followed, gram) = orthogonal(&hessian, n);
        let score_vector = -(gradient.rows(n, m) - followed.transpose() * gradient.rows(0, n));
        // U = [−Aᵀ 1] g
        let mut take = DMatrix::zeros(m, n + m);
        take.view_mut((0, 0), (m, n)).copy_from(&(-followed.transpose()));
        take.view_mut((0, n), (m, m)).fill_with_identity();
        let mut variance = &take * spread * take.transpose();
        let is_own: Vec<bool> =
            (0..m).map(|k| gram[(k, k)] > own(&columns[k]) * hessian[(n + k, n + k)]).collect();
        let mut inflations: Vec<f64> =
            (0..m).filter(|k| is_own[*k]).map(|k| variance[(k, k)] / gram[(k, k)]).collect();
        inflations.sort_by(f64::total_cmp);
        let seen = inflations.get(inflations.len() / 2).copied().unwrap_or(1.0);
        if seen < QUIETEST {
            variance *= QUIETEST / seen.max(f64::MIN_POSITIVE);
        }
        Self { score_vector, variance, gram, is_own, variance_inflation: seen.max(1.0) }
    }

    /// Of these columns those of which enough is left.
    pub fn own(&self, columns: impl IntoIterator<Item = usize>) -> Vec<usize> {
        columns.into_iter().filter(|k| self.is_own[*k]).collect()
    }
}

/// Scores subjects at a fit.
pub(super) fn scores(fit: &Joint, subjects: &[Subject], columns: &[Column], false_alarm: f64) -> Scores {
    if columns.is_empty() {
        let each = vec![Score::default(); subjects.len()];
        return Scores { each, threshold: 0.0, gram: DMatrix::zeros(0, 0), variance_inflation: 1.0 };
    }
    let pulls = Pulls::of(fit, columns, |column| subjects[column.of].own);
    let variance_inflation = pulls.variance_inflation;
    let (each, weights): (Vec<Score>, Vec<Weight>) = (0..subjects.len())
        .map(|c| {
            let own = pulls.own(places(columns, c));
            let weight = subjects[c].weight(
                &pick(&pulls.gram, &own, &own),
                &pick(&pulls.variance, &own, &own),
                variance_inflation,
            );
            (score(subjects[c], own, &pulls.score_vector, &weight, variance_inflation), weight)
        })
        .unzip();
    let threshold = threshold(subjects, &each, &weights, &pulls.variance, false_alarm);
    Scores { each, threshold, gram: pulls.gram, variance_inflation }
}

/// `s⊥ᵀ s⊥` of columns behind the unknowns of a fit, whose second derivatives are given, all else being free.
pub(super) fn gram(fit: &Joint, hessian: &DMatrix<f64>) -> DMatrix<f64> {
    orthogonal(hessian, fit.found.x.len()).1
}

/// How far the scaled unknowns of a fit move to follow a unit of each column, shape `[unknown][column]`.
pub(super) fn followed(fit: &Joint, columns: &[Column]) -> DMatrix<f64> {
    let (_, hessian) = normal_equations(fit, &extended(fit, columns), columns.len());
    orthogonal(&hessian, fit.found.x.len()).0
}

/// What the first `n` unknowns take of the others, and what is left of those.
fn orthogonal(hessian: &DMatrix<f64>, n: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let m = hessian.nrows() - n;
    let known = hessian.view((0, 0), (n, n)).into_owned();
    let to_own = &pseudo_inverse(&known).0 * hessian.view((0, n), (n, m));
    let gram = hessian.view((n, n), (m, m)) - hessian.view((n, 0), (m, n)) * &to_own;
    (to_own, gram)
}

/// How far apart two traces are when all else is fitted: what is left of the first, at its strengths, when
/// the second does what it can; standard deviations of white noise. With one column each it is
/// `|s⊥| θ √(1 − cos²)`.
pub(super) fn distance(gram: &DMatrix<f64>, first: &[usize], second: &[usize], strengths: &[f64]) -> f64 {
    let strengths = DVector::from_column_slice(strengths);
    strengths.dot(&(left_beside(gram, first, second) * &strengths)).max(0.0).sqrt()
}

/// The same for strengths of unit size; where each release has its own, their signs are drawn, and it is the root
/// mean square.
pub(super) fn unit_distance(gram: &DMatrix<f64>, first: &[usize], second: &[usize]) -> f64 {
    left_beside(gram, first, second).trace().max(0.0).sqrt()
}

/// Gram's matrix of what is left of the first columns when the second do what they can.
fn left_beside(gram: &DMatrix<f64>, first: &[usize], second: &[usize]) -> DMatrix<f64> {
    let left = pick(gram, first, first);
    if second.is_empty() {
        return left;
    }
    let cross = pick(gram, first, second);
    left - &cross * pseudo_inverse(&pick(gram, second, second)).0 * cross.transpose()
}

/// Rows and columns of a matrix.
pub(super) fn pick(matrix: &DMatrix<f64>, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns.len(), |a, b| matrix[(rows[a], columns[b])])
}

fn score(
    subject: Subject,
    columns: Vec<usize>,
    score_vector: &DVector<f64>,
    weight: &Weight,
    variance_inflation: f64,
) -> Score {
    let own = DVector::from_fn(columns.len(), |a, _| score_vector[columns[a]]);
    if columns.is_empty() {
        return Score::default();
    }
    let estimates = &weight.to_strengths * &own;
    let mean = |of: fn(f64) -> f64| estimates.iter().map(|x| of(*x)).sum::<f64>() / estimates.len() as f64;
    let estimate = match subject.believed {
        Some(_) if columns.len() > 1 => mean(|x| x * x).sqrt(),
        _ => subject.null_value + mean(|x| x),
    };
    let is_admissible = subject.admits(&own, weight);
    Score {
        size: if is_admissible { weight.size(&own) } else { 0.0 },
        degrees: weight.degrees,
        decrease: own.dot(&estimates) / variance_inflation,
        estimate,
        estimates: estimates.as_slice().to_vec(),
        is_admissible,
        columns,
    }
}

/// A χ² with so many degrees of freedom as a normal number. Source: Wilson and Hilferty (1931), Proc.
/// National Academy of Sciences 17, 684-688; for one degree it is the root. For less than one, where the baseline
/// can do nearly all, theirs is no approximation: what is next to nothing would be made large.
fn normal_size(statistic: f64, k: f64) -> f64 {
    if k <= 1.0 {
        return statistic.max(0.0).sqrt();
    }
    let spread = 2.0 / (9.0 * k);
    (((statistic / k).max(0.0).cbrt() - (1.0 - spread)) / spread.sqrt()).max(0.0)
}

/// The χ² of a size: [`normal_size`] turned round.
fn statistic(size: f64, k: f64) -> f64 {
    if k <= 1.0 {
        return size * size;
    }
    let spread = 2.0 / (9.0 * k);
    k * (1.0 - spread + size * spread.sqrt()).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two releases whose common strength the baseline can do: only their difference is asked for, and what noise
    /// there is in the common part asks for nothing.
    #[test]
    fn what_the_baseline_can_do_of_all_releases_is_not_asked_for() {
        let differing = DMatrix::from_row_slice(2, 2, &[1.0, -1.0, -1.0, 1.0]) * 1e6;
        let gram = &differing + DMatrix::identity(2, 2) * 1e-3;
        let score_vector =
            &differing * DVector::from_column_slice(&[0.01, -0.01]) + DVector::from_element(2, 0.01);
        let subject = |believed| Subject { believed, ..Subject::default() };
        let weight = |believed| subject(believed).weight(&gram, &gram, 1.0);
        let strengths = weight(Some(0.015)).to_strengths * &score_vector;
        assert!((strengths - DVector::from_column_slice(&[0.01, -0.01])).amax() < 1e-4);
        // Without the belief the common part runs away.
        assert!((weight(None).to_strengths * &score_vector).amax() > 1.0);
        let weight = weight(Some(0.015));
        assert!((weight.degrees - 1.0).abs() < 0.01, "{}", weight.degrees);
    }

    /// An effect that cannot be negative, with strengths at two pressures of which the second is known better.
    #[test]
    fn strengths_with_a_mean_of_the_wrong_sign_are_not_admitted() {
        let gram = DMatrix::from_diagonal(&DVector::from_column_slice(&[1.0, 4.0]));
        let admits = |side, strengths: [f64; 2]| {
            let subject = Subject { side, ..Subject::default() };
            let score_vector = &gram * DVector::from_column_slice(&strengths);
            subject.admits(&score_vector, &subject.weight(&gram, &gram, 1.0))
        };
        assert!(admits(1.0, [-0.1, 0.3]) && !admits(1.0, [0.1, -0.3]) && !admits(1.0, [-0.1, -0.3]));
        assert!(admits(-1.0, [0.1, -0.3]) && admits(0.0, [-0.1, -0.3]));
    }

    /// Six strengths that are noise take 16.8 of χ² once in a hundred, one takes 6.63 (any table of χ²).
    #[test]
    fn several_strengths_have_to_be_worth_more_than_one() {
        let one_in_a_hundred = 2.3263;
        let of_six = Score { degrees: 6.0, ..Score::default() };
        assert!((of_six.decrease_at(one_in_a_hundred) - 16.81).abs() < 0.1);
        assert!((normal_size(of_six.decrease_at(3.4), 6.0) - 3.4).abs() < 1e-12);
        let of_one = Score { degrees: 1.0, ..Score::default() };
        assert!((of_one.decrease_at(2.5758) - 6.63).abs() < 0.01);
    }

    /// One release, whose own strength the baseline can do but for rounding: noise makes nothing of it.
    #[test]
    fn what_the_baseline_can_do_wholly_is_no_evidence() {
        let left = DMatrix::from_element(1, 1, 1e-3);
        let subject = Subject { believed: Some(0.015), ..Subject::default() };
        let weight = subject.weight(&left, &left, 1.0);
        let size = weight.size(&DVector::from_element(1, 3.0 * left[0].sqrt()));
        assert!(size < 0.01, "{size}");
    }
}

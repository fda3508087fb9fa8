//! Correlations, in plain words with numbers, and which experiment would.
//!
//! Source: Brun, Reichert and Künsch (2001), Water Resources Research 37, 1015-1030: the collinearity
//! index, one over the smallest singular value of the scaled slopes; above some ten, a change of one
//! parameter is made up for by others to within a tenth.

use nalgebra::{DMatrix, SymmetricEigen};

use super::calibration::Calibrated;
use super::objective::Objective;
use super::problem::Scale;
use super::search::Found;
use super::uncertainty::{Uncertainty, pseudo_inverse};
use super::waves::BETA;
use crate::listed::listed;

/// Correlation from which on two parameters are said to be badly separated.
const TOGETHER: f64 = 0.95;
/// Relative standard error that is worth words.
const VAGUE: f64 = 0.1;
/// Relative standard error from which on there is nothing to say.
const NOTHING: f64 = 1.0;
/// A posterior deviation of this share of the prior's comes from the prior.
const FROM_PRIOR: f64 = 0.9;
/// Collinearity from which on a combination is said to be weak.
const COLLINEAR: f64 = 10.0;
/// Share of the largest from which on a parameter takes part in a combination.
const TAKES_PART: f64 = 0.2;

/// Words on the parameters of one part; `places` are theirs among its unknowns.
pub(super) fn words(
    objective: &Objective,
    found: &Found,
    uncertainty: &Uncertainty,
    parameters: &[Calibrated],
    places: &[usize],
) -> Vec<String> {
    let told = |a: usize| uncertainty.is_determined[places[a]];
    let correlation = |a: usize, b: usize| {
        let of = |i: usize, j: usize| uncertainty.covariance[(places[i], places[j])];
        of(a, b) / (of(a, a) * of(b, b)).sqrt()
    };
    let all = (0..places.len()).flat_map(|a| (0..a).map(move |b| (b, a)));
    let pairs: Vec<(usize, usize)> =
        all.filter(|(b, a)| told(*a) && told(*b) && correlation(*a, *b).abs() > TOGETHER).collect();
    // Of the two of a combination nothing more is to be said alone.
    let (in_sum, others): (Vec<_>, Vec<_>) =
        pairs.into_iter().partition(|(b, a)| is_vague(&parameters[*a]) && is_vague(&parameters[*b]));
    let mut words: Vec<String> = in_sum.iter().map(|(b, a)| sum(&parameters[*b], &parameters[*a])).collect();
    let is_alone = |k: &usize| in_sum.iter().all(|(b, a)| b != k && a != k);
    words.extend((0..places.len()).filter(is_alone).filter_map(|k| alone(&parameters[k], told(k))));
    for group in groups(&others) {
        let of_group = others.iter().filter(|(b, _)| group.contains(b));
        let strength = |(b, a): &&(usize, usize)| correlation(*a, *b).abs();
        let Some((b, a)) = of_group.max_by(|x, y| strength(x).total_cmp(&strength(y))) else { continue };
        let strongest = (&parameters[*b], &parameters[*a], correlation(*a, *b));
        words.push(match group.len() {
            2 => pair(strongest),
            _ => together(&group.iter().map(|k| parameters[*k].label()).collect::<Vec<_>>(), strongest),
        });
    }
    words.extend(weakest(objective, found, parameters, places));
    words
}

/// Whether nothing is known of a parameter alone.
fn is_vague(parameter: &Calibrated) -> bool {
    parameter.relative_error().is_none_or(|error| error > NOTHING)
}

/// What is to be said of two of which the data fix a combination alone.
fn sum(a: &Calibrated, b: &Calibrated) -> String {
    format!(
        "the data fix only a combination of {} and {}: fit one of them, and leave the other out of [[calibrate.parameter]] (if none is listed, list those to fit); {}",
        a.label(),
        b.label(),
        advice(kind(&a.name), Some(kind(&b.name)))
    )
}

/// What is to be said of a parameter by itself.
fn alone(parameter: &Calibrated, is_determined: bool) -> Option<String> {
    let label = parameter.label();
    // The least value of β is not zero (`waves.rs`).
    let is_least = parameter.bounds[0].is_some_and(|low| parameter.value <= low);
    if is_least && (parameter.value == 0.0 || parameter.name == BETA) {
        let value = if parameter.value == 0.0 { "zero".to_owned() } else { significant(parameter) };
        return Some(format!(
            "{label} is {value}, the least that it can be: the recordings show none of it; take its interval as an upper limit, or leave it out of [[calibrate.parameter]]"
        ));
    }
    if parameter.at_bound {
        let value = significant(parameter);
        return Some(format!(
            "{label} hit its bound, {value}; the fit would go further: widen its bounds in [[calibrate.parameter]], or take it as a limit only"
        ));
    }
    if !is_determined {
        return Some(format!(
            "{label} is not determined: other values fit equally well together with other parameters; fix it to a measured value, give it a prior, or {}",
            advice(kind(&parameter.name), None)
        ));
    }
    if let (Some(prior), Some(error)) = (parameter.prior, parameter.standard_error)
        && error > FROM_PRIOR * prior.deviation
    {
        return Some(format!("{label} is known from its prior alone: the data add almost nothing"));
    }
    let is_positive = parameter.bounds[0].is_some_and(|low| low >= 0.0);
    let relative = parameter.relative_error().filter(|_| is_positive)?;
    if relative > NOTHING {
        let advice = advice(kind(&parameter.name), None);
        return Some(format!("the data do not determine {label}, not even its order of magnitude; {advice}"));
    }
    (relative > VAGUE).then(|| {
        format!("{label} is known to {:.0} % only; {}", 100.0 * relative, advice(kind(&parameter.name), None))
    })
}

/// The parameters that pairs connect, each group in order.
fn groups(pairs: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (b, a) in pairs {
        let (joined, apart): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group| group.contains(a) || group.contains(b));
        let mut group = [joined.concat(), vec![*b, *a]].concat();
        group.sort_unstable();
        group.dedup();
        groups = [apart, vec![group]].concat();
    }
    groups
}

/// What is to be said of several that make up for one another, by the two that do so most.
fn together(labels: &[String], (a, b, correlation): (&Calibrated, &Calibrated, f64)) -> String {
    format!(
        "{} are strongly correlated: a change of one can be offset by others with almost the same fit, most of all {} and {} (correlation {correlation:.3}); {}",
        listed(labels),
        a.label(),
        b.label(),
        advice(kind(&a.name), Some(kind(&b.name)))
    )
}

fn pair((a, b, correlation): (&Calibrated, &Calibrated, f64)) -> String {
    let both = if correlation > 0.0 { "rise together" } else { "move against each other" };
    format!(
        "{} and {} are strongly correlated: they {both} with almost the same result (correlation {correlation:.3}); standard error {} alone, {} with the other given; {}",
        a.label(),
        b.label(),
        percent(a.relative_error()),
        percent(a.relative_error().map(|error| error * (1.0 - correlation * correlation).sqrt())),
        advice(kind(&a.name), Some(kind(&b.name)))
    )
}

fn percent(share: Option<f64>) -> String {
    match share {
        Some(share) if share <= NOTHING => format!("{:.2} %", 100.0 * share),
        _ => "undetermined".to_owned(),
    }
}

/// The combination of parameters that the data feel least, and how much they feel of it.
fn weakest(
    objective: &Objective,
    found: &Found,
    parameters: &[Calibrated],
    places: &[usize],
) -> Option<String> {
    if places.len() < 2 {
        return None;
    }
    // Curvature by the parameters once the nuisances follow them.
    let n = places.len();
    let hessian = &found.at.hessian;
    let others: Vec<usize> = (0..hessian.nrows()).filter(|k| !places.contains(k)).collect();
    let block = |rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |a, b| hessian[(rows[a], columns[b])])
    };
    let across = block(places, &others);
    let reduced =
        block(places, places) - &across * pseudo_inverse(&block(&others, &others)).0 * across.transpose();
    let size: Vec<f64> = (0..n).map(|k| reduced[(k, k)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let scaled = DMatrix::from_fn(n, n, |a, b| reduced[(a, b)] / (size[a] * size[b]));
    let eigen = SymmetricEigen::new(scaled);
    let least = eigen.eigenvalues.imin();
    let collinearity = eigen.eigenvalues[least].max(1e-16).sqrt().recip();
    if collinearity < COLLINEAR {
        return None;
    }
    // A step of the logarithms, the largest by a tenth.
    let mut way: Vec<f64> = (0..n).map(|k| eigen.eigenvectors[(k, least)] / size[k]).collect();
    let most = way.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    let first = way.iter().copied().find(|v| v.abs() >= TAKES_PART * most).unwrap_or(1.0).signum();
    way.iter_mut().for_each(|v| *v *= 0.1 * first / most);
    let mut felt = 0.0;
    for a in 0..n {
        for b in 0..n {
            felt += way[a] * way[b] * reduced[(a, b)];
        }
    }
    let (mut samples, mut noise) = (0usize, 0.0);
    for (block, measured) in found.at.carried.blocks.iter().zip(&objective.measured) {
        for (series, own) in block.iter().zip(&measured.noise) {
            samples += series.residual.len();
            noise += own * series.residual.len() as f64;
        }
    }
    let noise = noise / samples.max(1) as f64;
    let rms = noise * (felt.max(0.0) / samples.max(1) as f64).sqrt();
    let parts: Vec<String> = (parameters.iter().zip(&way))
        .filter(|(_, v)| v.abs() >= TAKES_PART * 0.1)
        .map(|(parameter, v)| match parameter.scale {
            Scale::Logarithmic => format!("{} by {:+.1} %", parameter.label(), 100.0 * v),
            Scale::Linear => format!("{} by {:+.2} of its typical size", parameter.label(), v),
        })
        .collect();
    Some(format!(
        "the weakest combination: changing {} moves the fit by {:.3} mm rms, beside noise and misfit of {:.3} mm (collinearity index {collinearity:.0}; above 10 is strong)",
        parts.join(", "),
        1e3 * rms,
        1e3 * noise
    ))
}

/// What a parameter does.
#[derive(Clone, Copy, PartialEq)]
enum Does {
    Stiffens,
    Weighs,
    Loses,
    Turns,
    Other,
}

fn kind(path: &str) -> Does {
    let is = |ends: &[&str]| ends.iter().any(|end| path.ends_with(end));
    match path {
        _ if is(&["_stiffness", ".compliance"]) => Does::Stiffens,
        _ if is(&["mass", "center_of_mass", "rotary_inertia"]) && !path.contains("rayleigh") => Does::Weighs,
        _ if is(&[".alpha", ".beta", "drag_coefficient"]) || path.contains("viscoelastic") => Does::Loses,
        _ if path.ends_with("angle") => Does::Turns,
        _ => Does::Other,
    }
}

/// The experiment that would separate them.
fn advice(one: Does, other: Option<Does>) -> &'static str {
    match (one, other) {
        (Does::Stiffens, Some(Does::Weighs)) | (Does::Weighs, Some(Does::Stiffens)) => {
            "weigh the body and fix its mass, or add releases with a payload of known mass, which changes the one and not the other"
        }
        (Does::Loses, Some(Does::Loses)) => {
            "a loss at a second frequency would tell: add releases with a payload or at another pressure and let both share the parameters, or excite the second mode by a short push"
        }
        (Does::Stiffens, Some(Does::Stiffens)) => {
            "markers along the rod near the clamp would tell, or releases with a payload of known mass"
        }
        (Does::Turns, Some(_)) | (_, Some(Does::Turns)) => {
            "measure the angle at rest, with the clamp's base markers"
        }
        (Does::Loses, None) => "a longer recording, or a release from a greater height, would say more",
        (Does::Weighs, None) => "weigh it, or add releases with a payload of known mass",
        (Does::Stiffens, None) => "markers along the rod, or a payload of known mass, would say more",
        _ => "more markers along the rod, another payload or another pressure would say more",
    }
}

fn significant(parameter: &Calibrated) -> String {
    models::quantity::format_si(parameter.value, &parameter.unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Scope;

    fn parameter(value: f64, bounds: [Option<f64>; 2]) -> Calibrated {
        Calibrated {
            name: "effects.rayleigh_mass.alpha".to_owned(),
            unit: "1/s".to_owned(),
            scope: Scope::Shared,
            pressure_pa: None,
            release: None,
            value,
            start: 0.5,
            standard_error: Some(0.1),
            interval_95: None,
            profile_95: None,
            scale: Scale::Linear,
            bounds,
            at_bound: true,
            prior: None,
            error_inflation: None,
            numerical_shift: None,
        }
    }

    /// Nobody can widen the bounds of a loss below zero.
    #[test]
    fn a_loss_that_is_zero_is_told_from_a_bound_that_was_met() {
        let zero = alone(&parameter(0.0, [Some(0.0), None]), true).expect("words");
        assert!(zero.contains("is zero, the least that it can be") && !zero.contains("widen"), "{zero}");
        let met = alone(&parameter(3.0, [Some(0.0), Some(3.0)]), true).expect("words");
        assert!(met.contains("hit its bound, 3") && met.contains("[[calibrate.parameter]]"), "{met}");
        let least = Calibrated { name: BETA.to_owned(), ..parameter(8e-6, [Some(8e-6), None]) };
        let least = alone(&least, true).expect("words");
        assert!(least.contains("the least that it can be") && !least.contains("widen"), "{least}");
    }

    /// Two pairs that share a parameter are one group.
    #[test]
    fn correlated_parameters_are_told_in_groups() {
        assert_eq!(groups(&[(0, 1), (3, 4), (1, 2)]), [vec![3, 4], vec![0, 1, 2]]);
        let labels = ["a", "b", "c"].map(str::to_owned);
        let [one, other] = [1.0, 2.0].map(|value| parameter(value, [Some(0.0), None]));
        let told = together(&labels, (&one, &other, -0.99));
        assert!(told.starts_with("a, b and c are strongly correlated"), "{told}");
    }

    /// Beyond its whole value, or with no error, a parameter is known in a combination at best.
    #[test]
    fn two_losses_of_one_release_are_a_combination() {
        let known = |value: f64| parameter(value, [Some(0.0), None]);
        let nothing = Calibrated { standard_error: None, ..known(3.0) };
        assert!(is_vague(&known(0.05)) && is_vague(&nothing) && !is_vague(&known(3.0)));
        let beta = Calibrated { name: BETA.to_owned(), ..known(0.05) };
        let told = sum(&known(0.05), &beta);
        assert!(told.contains("only a combination of effects.rayleigh_mass.alpha and"), "{told}");
        assert!(told.contains("a payload or at another pressure"), "{told}");
    }
}

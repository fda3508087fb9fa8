//! From what the searches found to what is reported.

use efam_experiments::out_of_plane;
use efam_experiments::release::Release;

use super::calibration::{Calibrated, Calibration, Correlations, ReleaseFit, SearchReport, TrackFit};
use super::discrepancy::missed;
use super::identifiability;
use super::misfit::{Curve, FrequencyAndDamping, Misfit};
use super::problem::{Problem, Scale, Scope};
use super::uncertainty::TrackStatistics;
use super::unknowns::{Group, Scaled, UnknownKind, Unknowns};
use super::{PartFit, warnings, waves};
use crate::normal::NORMAL_95;

/// What was found, and the curves to show.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationOutcome {
    /// What is written.
    pub calibration: Calibration,
    /// Measurement and prediction of each track, in the order of the releases.
    pub curves: Vec<Curve>,
}

pub(super) fn outcome(problem: &Problem, unknowns: &Unknowns, fitted: &[PartFit]) -> CalibrationOutcome {
    let mut calibration = Calibration::default();
    let mut all: Vec<Option<Calibrated>> = vec![None; unknowns.list.len()];
    let mut fits: Vec<Option<ReleaseFit>> = vec![None; problem.trials.len()];
    let mut curves: Vec<Vec<Curve>> = vec![Vec::new(); problem.trials.len()];
    for fit in fitted {
        for (k, place) in fit.objective.part.places.iter().enumerate() {
            all[*place] = Some(calibrated(problem, fit, k));
        }
        let of = |k: &usize| !fit.objective.part.unknowns[*k].is_nuisance();
        let places: Vec<usize> = (0..fit.objective.part.unknowns.len()).filter(of).collect();
        let own: Vec<Calibrated> =
            places.iter().filter_map(|k| all[fit.objective.part.places[*k]].clone()).collect();
        calibration.correlations.push(correlations(fit, &own, &places));
        for (r, t) in fit.objective.part.trials.iter().enumerate() {
            curves[*t] = of_release(problem, fit, r);
            fits[*t] = Some(release_fit(problem, fit, r, &curves[*t]));
        }
        calibration.searches.push(SearchReport {
            releases: fit.objective.part.members.iter().map(|trial| trial.release.name.clone()).collect(),
            stages: fit.found.stages.clone(),
            starts: fit.found.starts,
            converged: fit.found.converged,
            cost: fit.found.at.cost,
            evaluations: fit.effort[0],
            steps: fit.effort[1],
        });
        calibration.warnings.extend(warnings::of_search(fit));
        calibration.warnings.extend(identifiability::words(
            &fit.objective,
            &fit.found,
            &fit.uncertainty,
            &own,
            &places,
        ));
    }
    for (unknown, found) in unknowns.list.iter().zip(all) {
        let list =
            if unknown.is_nuisance() { &mut calibration.nuisances } else { &mut calibration.parameters };
        list.extend(found);
    }
    calibration.releases = fits.into_iter().flatten().collect();
    calibration.warnings.extend(calibration.releases.iter().flat_map(warnings::of_release));
    calibration.warnings.extend(waves::warning(problem));
    calibration.warnings.extend(warnings::of_left_out(problem));
    calibration.warnings.extend(out_of_plane::warning(problem.trials().map(|trial| &trial.release)));
    let believed = calibration.parameters.iter().chain(&calibration.nuisances);
    let contradictions = warnings::of_beliefs(believed);
    // What is stated and not so comes before all else.
    calibration.warnings.splice(..0, contradictions);
    CalibrationOutcome { calibration, curves: curves.into_iter().flatten().collect() }
}

fn calibrated(problem: &Problem, fit: &PartFit, k: usize) -> Calibrated {
    let unknown = &fit.objective.part.unknowns[k];
    let x = fit.found.x[k];
    let (low, high) = unknown.bounds;
    let value = |x: f64| unknown.scaled.value(x);
    let is_determined = fit.uncertainty.is_determined[k];
    let variance = fit.uncertainty.covariance[(k, k)];
    let deviation = Some(variance.sqrt()).filter(|_| is_determined && variance > 0.0);
    let finite = |x: f64| Some(value(x)).filter(|value| value.is_finite());
    Calibrated {
        name: unknown.name.clone(),
        unit: unknown.unit.to_owned(),
        scope: match (unknown.kind, unknown.group) {
            (UnknownKind::Parameter(parameter), _) => problem.parameters[parameter].scope,
            _ => Scope::PerRelease,
        },
        pressure_pa: match unknown.group {
            Group::Pressure(pressure) => Some(pressure),
            _ => None,
        },
        release: match unknown.group {
            Group::Release(t) => Some(problem.trials[t].release.name.clone()),
            _ => None,
        },
        value: value(x),
        start: unknown.start,
        standard_error: deviation.map(|deviation| deviation * unknown.scaled.slope(x).abs()),
        interval_95: deviation.map(|deviation| {
            [-1.0, 1.0].map(|side| value((x + side * NORMAL_95 * deviation).clamp(low, high)))
        }),
        profile_95: fit.profiles[k].map(|bounds| bounds.map(value)),
        scale: match unknown.scaled {
            Scaled::Logarithmic => Scale::Logarithmic,
            Scaled::By(_) => Scale::Linear,
        },
        bounds: [finite(low), finite(high)],
        at_bound: unknown.is_at_bound(x),
        prior: unknown.prior,
        error_inflation: Some(fit.uncertainty.variance_inflation(k).sqrt())
            .filter(|factor| is_determined && factor.is_finite()),
        numerical_shift: fit.numerics.as_ref().map(|_| fit.shift[k]),
    }
}

fn correlations(fit: &PartFit, own: &[Calibrated], places: &[usize]) -> Correlations {
    let of = |a: usize, b: usize| fit.uncertainty.covariance[(a, b)];
    let row = |a: &usize| {
        let entry = |b: &usize| of(*a, *b) / (of(*a, *a) * of(*b, *b)).sqrt().max(f64::MIN_POSITIVE);
        places.iter().map(entry).collect()
    };
    Correlations {
        names: own.iter().map(Calibrated::label).collect(),
        matrix: places.iter().map(row).collect(),
    }
}

fn release_fit(problem: &Problem, fit: &PartFit, r: usize, curves: &[Curve]) -> ReleaseFit {
    let t = fit.objective.part.trials[r];
    let (release, measured) = (&problem.trials[t].release, &fit.objective.measured[r]);
    let tip = release.leading_track();
    let track = |(k, found): (usize, &TrackStatistics)| TrackFit {
        marker: release.tracks[k].marker.clone(),
        samples: found.samples,
        held_back: found.held_back,
        rms_mm: 1e3 * found.rms,
        stated_noise_mm: 1e3 * measured.camera_noise[k],
        noise_mm: 1e3 * found.noise,
        reduced_chi_squared: found.reduced_chi_squared,
        autocorrelation: found.autocorrelation,
    };
    let of_numerics = |of: fn(&super::Correction) -> &Vec<f64>| {
        fit.numerics.as_ref().map_or(0.0, |numerics| 1e3 * of(numerics)[r])
    };
    let seen = heard(fit, r, tip, &curves[tip]);
    let swings = [&seen.measured, &seen.predicted].map(|path| FrequencyAndDamping::of(&seen, path));
    let noise = measured.noise[tip];
    let missed = missed(&fit.found.at.carried.blocks[r][tip], &measured.samples, noise).deviation;
    ReleaseFit {
        name: release.name.clone(),
        pressure_pa: release.pressure,
        payload_kg: release.payload,
        excursion_m: excursion(release),
        held_out: release.held_out,
        duration_s: measured.samples.last().map_or(0.0, |k| release.time[*k]),
        tracks: fit.uncertainty.tracks[r].iter().enumerate().map(track).collect(),
        measured: swings[0],
        fitted: swings[1],
        misfit: Misfit::of(&seen, swings, missed, noise),
        numerical_error_mm: of_numerics(|numerics| &numerics.error),
        numerical_error_left_mm: of_numerics(|numerics| &numerics.left),
    }
}

/// The curve of a track without what the loss holds back, which is a ghost.
fn heard(fit: &PartFit, r: usize, track: usize, curve: &Curve) -> Curve {
    let series = &fit.found.at.carried.blocks[r][track];
    let mut seen = Curve { time: Vec::new(), measured: Vec::new(), predicted: Vec::new(), ..curve.clone() };
    for (k, length) in series.lengths().enumerate().take(curve.time.len()) {
        if fit.found.view.loss[r].weight(length) == 1.0 {
            seen.time.push(curve.time[k]);
            seen.measured.push(curve.measured[k]);
            seen.predicted.push(curve.predicted[k]);
        }
    }
    seen
}

/// Largest distance of the tip from where it was seen last, m.
fn excursion(release: &Release) -> f64 {
    let seen = || release.tracks[release.leading_track()].position.iter().flatten();
    let Some([x, z]) = seen().next_back() else { return 0.0 };
    seen().map(|at| (at[0] - x).hypot(at[1] - z)).fold(0.0, f64::max)
}

fn of_release(problem: &Problem, fit: &PartFit, r: usize) -> Vec<Curve> {
    let release = &problem.trials[fit.objective.part.trials[r]].release;
    let measured = &fit.objective.measured[r];
    let curve = |(t, series): (usize, &super::view::Series)| {
        let mut curve = Curve {
            release: release.name.clone(),
            pressure: release.pressure,
            marker: release.tracks[t].marker.clone(),
            ..Curve::default()
        };
        for (k, residual) in series.samples.iter().zip(&series.residual) {
            let sample = measured.samples[*k];
            let Some(seen) = release.tracks[t].position[sample] else { continue };
            curve.time.push(release.time[sample]);
            curve.measured.push(seen);
            let predicted = |axis: usize| seen[axis] - measured.noise[t] * residual[axis];
            curve.predicted.push([predicted(0), predicted(1)]);
        }
        curve
    };
    fit.found.at.carried.blocks[r].iter().enumerate().map(curve).collect()
}

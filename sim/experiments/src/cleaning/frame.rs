//! The frame at the clamp: x level and away from the clamp in the plane of the swing, z against gravity.
//!
//! Up is given, or an axis of the file (`up.rs`): systems are calibrated with one axis vertical. The plane is that of the
//! swing where the tip moves far enough sideways to show it, else that through clamp and held tip.

use nalgebra::{Matrix2, SymmetricEigen, Vector3};

use super::CleaningError;
use super::base::BasePose;
use super::cycles::{Cut, mean};
use super::decision::{Log, mm};
use super::up::Known;
use crate::experiment::{Direction, Entry};

/// The frame W of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The clamp, m, in the recording's frame.
    pub origin: [f64; 3],
    /// Its axes as unit vectors in the recording's frame.
    pub axes: [[f64; 3]; 3],
}

/// Largest angle between the way to the tip and an axis that is taken as the rod's, rad.
const ALONG: f64 = 10.0 * DEGREE;
const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// Range of the tip sideways, in its distance from the clamp, from which on its swing shows the plane.
const SHOWS_PLANE: f64 = 0.15;

impl Frame {
    /// A point of the recording's frame in this one, m.
    pub fn place(&self, at: [f64; 3]) -> [f64; 3] {
        let from = Vector3::from(at) - Vector3::from(self.origin);
        self.axes.map(|axis| from.dot(&Vector3::from(axis)))
    }
}

/// Finds the frame of a recording from its tip.
pub(super) fn find(
    entry: &Entry,
    base: Option<&BasePose>,
    base_angle: Option<f64>,
    (time, path): (&[f64], &[Option<[f64; 3]>]),
    cuts: &[Cut],
    log: &mut Log,
) -> Result<Frame, CleaningError> {
    let origin = match (entry.clamp, base) {
        (Some(clamp), Some(base)) if base.is_followed() => {
            let hold = cuts.first().map_or(0..1, |cut| cut.hold.clone());
            let mut moves = vec![Some(clamp); path.len()];
            base.take_off(&mut moves);
            log.say(
                "clamp",
                "the base moves: that the clamp is where it is said while the rod is held is assumed",
            );
            mean(&moves, hold).unwrap_or(clamp)
        }
        (Some(clamp), _) => clamp,
        (None, Some(base)) => {
            log.say("clamp", format!("the clamp is taken at the mean of the base, {}", point(base.position)));
            base.position
        }
        (None, None) => {
            log.say("clamp", "without a base the clamp is taken at the origin of the file's frame");
            [0.0; 3]
        }
    };
    let has_base = base.is_some() || entry.clamp.is_some();
    let known = Known { entry, base_angle, has_base, origin, time, path, cuts };
    let up = Vector3::from(known.up(log)?.unit());
    let along = along(entry, up, origin, path, cuts, log);
    Ok(Frame { origin, axes: [along.into(), up.cross(&along).into(), up.into()] })
}

/// The level direction from the clamp to the tip, in the plane of the swing.
fn along(
    entry: &Entry,
    up: Vector3<f64>,
    origin: [f64; 3],
    path: &[Option<[f64; 3]>],
    cuts: &[Cut],
    log: &mut Log,
) -> Vector3<f64> {
    let level = |v: Vector3<f64>| v - up * up.dot(&v);
    if let Some(along) = entry.along.map(|along| Vector3::from(along.unit())) {
        let rise = up.dot(&along).clamp(-1.0, 1.0).asin();
        if rise.abs() > DEGREE {
            log.say(
                "along",
                format!(
                    "the rod leaves the clamp {:.1} deg above the level; if so, say rod.base_angle, or base_angle here",
                    rise / DEGREE
                ),
            );
        }
        if level(along).norm() > 1e-6 {
            return level(along).normalize();
        }
    }
    let mut held = Vector3::zeros();
    for cut in cuts {
        held += (Vector3::from(cut.held) - Vector3::from(origin)) / cuts.len() as f64;
    }
    let far = held.norm();
    let held = level(held);
    let (sideways, range, flat) = plane(up, path, cuts);
    if range > SHOWS_PLANE * far && flat < 0.5 {
        let sign = if sideways.dot(&held) < 0.0 { -1.0 } else { 1.0 };
        log.say(
            "along",
            format!(
                "the plane is that of the swing, which goes {} sideways: x along {}",
                mm(range),
                point_of(sign * sideways)
            ),
        );
        return sign * sideways;
    }
    if held.norm() < 1e-3 * far.max(1e-9) {
        log.say(
            "along",
            "the tip is held straight above or below the clamp: x is the direction in which it moves most",
        );
        return sideways;
    }
    let (axis, angle) = Direction::nearest(held.normalize().into());
    let is_level = up.dot(&Vector3::from(axis.unit())).abs() < 1e-6;
    if angle < ALONG && is_level {
        log.say("along", format!(
            "the swing goes {} sideways, too little to show its plane; {} of the file is {:.1} deg from the way to the held tip, and taken as x",
            mm(range), axis.text(), angle / DEGREE
        ));
        return Vector3::from(axis.unit());
    }
    log.say("along", format!(
        "the swing goes {} sideways, too little to show its plane; x is the level way from the clamp to the held tip, {}",
        mm(range), point_of(held.normalize())
    ));
    held.normalize()
}

/// The level direction in which the tip moves most while it swings, the range along it, m, and how
/// far it moves across, as a share of that.
fn plane(up: Vector3<f64>, path: &[Option<[f64; 3]>], cuts: &[Cut]) -> (Vector3<f64>, f64, f64) {
    let other = if up.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
    let first = (other - up * up.dot(&other)).normalize();
    let second = up.cross(&first);
    let points: Vec<_> = cuts
        .iter()
        .flat_map(|cut| cut.swing.clone())
        .filter_map(|i| path[i])
        .map(|at| nalgebra::Vector2::new(Vector3::from(at).dot(&first), Vector3::from(at).dot(&second)))
        .collect();
    if points.is_empty() {
        return (first, 0.0, 1.0);
    }
    let mean = points.iter().sum::<nalgebra::Vector2<f64>>() / points.len() as f64;
    let covariance: Matrix2<f64> = points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
    let eigen = SymmetricEigen::new(covariance);
    let most = eigen.eigenvalues.imax();
    let direction = eigen.eigenvectors.column(most).into_owned();
    let ways = points.iter().map(|p| p.dot(&direction));
    let (low, high) = ways.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), w| (l.min(w), h.max(w)));
    let flat = (eigen.eigenvalues[1 - most].max(0.0) / eigen.eigenvalues[most].max(f64::MIN_POSITIVE)).sqrt();
    (first * direction.x + second * direction.y, high - low, flat)
}

fn point([x, y, z]: [f64; 3]) -> String {
    format!("({:.1}, {:.1}, {:.1}) mm", 1e3 * x, 1e3 * y, 1e3 * z)
}

fn point_of(v: Vector3<f64>) -> String {
    Direction::Vector(v.into()).text()
}

/// Farthest distances of some samples across the plane, m: from the vertical plane through the clamp, and from the plane
/// beside it through their mean.
pub(super) fn across(frame: &Frame, path: &[Option<[f64; 3]>], swing: std::ops::Range<usize>) -> [f64; 2] {
    let across: Vec<f64> = path[swing].iter().flatten().map(|at| frame.place(*at)[1]).collect();
    let mean = across.iter().sum::<f64>() / across.len().max(1) as f64;
    [0.0, mean].map(|plane| across.iter().map(|y| (y - plane).abs()).fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use efam_recordings::{ReadOptions, parse};

    use crate::cleaning::clean_all;
    use crate::cleaning::tests::{Noise, falling_swing};
    use crate::experiment::Experiment;

    /// A base that drifts by 30 mm while the rod is held and swings: a clamp that is said, 10 mm below it, is where it is said during
    /// the hold. Relative to the mean of the base the held tip was 13 mm above it.
    #[test]
    fn a_clamp_that_is_said_holds_while_the_rod_is_held() {
        let (time, tip) = falling_swing(1.0, 10.0, 0.4, 10.0, 0.01);
        let (mut noise, mut text) = (Noise::new(3), "t_s,T_x_m,T_z_m,B_x_m,B_z_m\n".to_owned());
        for (t, at) in time.iter().zip(tip.iter().flatten()) {
            let mut with_noise = |value: f64| value + 3e-5 * noise.normal();
            let drift = 0.03 * (0.1 * (t - 1.0).max(0.0));
            let cells =
                [at[0], at[2] + drift, -0.03, 0.01 + drift].map(|value| format!(",{:.7}", with_noise(value)));
            text += &format!("{t:.2}{}\n", cells.concat());
        }
        let recording = parse(text.into(), Path::new("a.csv"), &ReadOptions::default()).expect("a table");
        let text = "[[recording]]\nfile = \"a.csv\"\ntip = \"T\"\nbase = \"B\"\nclamp = [\"0 m\", \"0 m\", \"0 m\"]\n";
        let experiment = Experiment::parse(Path::new("e.toml"), text, &[]).expect("an experiment");
        let cleaned = clean_all(&experiment, vec![recording]).expect("a release");
        let [hold, rest] = [cleaned.releases[0].statistics.hold, cleaned.releases[0].statistics.rest];
        assert!(cleaned.recordings[0].base.as_ref().is_some_and(super::BasePose::is_followed));
        // The drift of the base is smoothed over the release, at which it begins.
        assert!(hold[1].abs() < 5e-4 && (rest[1] + 0.12).abs() < 2e-3, "{hold:?} {rest:?}");
    }
}

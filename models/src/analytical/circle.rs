//! A moment at the tip of a cantilever: every bend carries it, so the rod is an arc of a circle.
//!
//! `theta(s) = kappa s`, `kappa = M / EI`; `x = sin(kappa s) / kappa`, `z = (1 − cos(kappa s)) / kappa`
//!
//! Exact at any deflection. Source: Euler (1744), De curvis elasticis, ninth species.

use std::f64::consts::PI;

use super::{Pose, cantilever::Cantilever};

/// Where the point at arc length `s`, m, is under a tip moment, N m, positive from x towards z.
pub fn at(beam: &Cantilever, moment: f64, s: f64) -> Pose {
    let angle = moment / beam.bending_stiffness * s;
    // The chord over arc length `s` has length `s sinc(angle / 2)` and half the angle: this form
    // has no division by the curvature, which may be zero.
    let half = 0.5 * angle;
    let chord = if half == 0.0 { s } else { s * half.sin() / half };
    Pose { position: [chord * half.cos(), chord * half.sin()], angle }
}

/// Where the tip is under a tip moment, N m, positive from x towards z.
pub fn tip(beam: &Cantilever, moment: f64) -> Pose {
    at(beam, moment, beam.length)
}

/// Tip moment that brings the tip back to the clamp after one full circle, N m: `2 pi EI / L`.
pub fn closing_moment(beam: &Cantilever) -> f64 {
    2.0 * PI * beam.bending_stiffness / beam.length
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEAM: Cantilever = Cantilever { bending_stiffness: 0.007, length: 0.2 };

    #[test]
    fn quarter_half_and_full_circle_end_where_they_must() {
        let close = |pose: Pose, x: f64, z: f64| {
            let tolerance = 1e-15; // a few roundings of a length of 0.2 m
            assert!((pose.position[0] - x).abs() < tolerance, "{pose:?}, not x = {x}");
            assert!((pose.position[1] - z).abs() < tolerance, "{pose:?}, not z = {z}");
        };
        let moment = closing_moment(&BEAM);
        let radius = BEAM.length / (2.0 * PI);
        close(tip(&BEAM, moment), 0.0, 0.0);
        close(at(&BEAM, moment, 0.5 * BEAM.length), 0.0, 2.0 * radius);
        close(at(&BEAM, -moment, 0.25 * BEAM.length), radius, -radius);
        close(tip(&BEAM, 0.0), BEAM.length, 0.0);
    }

    #[test]
    fn a_small_moment_deflects_as_the_linear_beam_does() {
        let moment = 1e-6;
        let linear = BEAM.tip_moment(moment, BEAM.length);
        let pose = tip(&BEAM, moment);
        let tolerance = pose.angle.powi(2); // first neglected term is angle²/12
        assert!((pose.position[1] / linear.z - 1.0).abs() < tolerance);
        assert!((pose.angle / linear.slope - 1.0).abs() < tolerance);
    }
}

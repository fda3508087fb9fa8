//! Releases for tests.

use efam_core::example::muscle_at_15_psi;
use efam_core::forward::{Run, uniform};
use efam_experiments::release::{Point, Release, Track};

use crate::calibrate::Trial;
use crate::calibrate::hold::hold;

/// A release without pressure or payload, with an instant known to 10 ms.
pub fn release(time: Vec<f64>, tracks: Vec<Track>) -> Release {
    Release {
        name: "made-up".to_owned(),
        time,
        release_uncertainty: 0.01,
        tracks,
        pressure: None,
        payload: 0.0,
        held_out: false,
    }
}

/// A hanging rod that a hand holds aside at two markers: at the release they have these places, and at no other time any. The rod has
/// a natural curvature, over its length, or none.
pub fn pulled(curvature: f64) -> Trial {
    let mut model = muscle_at_15_psi().with_nodes(9).expect("enough nodes");
    model.set("rod.base_angle", -90f64.to_radians()).expect("every model has it");
    model.set("effects.rayleigh_stiffness.beta", 0.01).expect("every model has it");
    let length = model.rod().length;
    if curvature != 0.0 {
        let values = [("natural_curvature", curvature / length)];
        model = model.with_effect("set_curvature", &values).expect("it is in the catalogue");
    }
    let time = uniform(1.5, 50.0);
    let track = |marker: &str, at, seen: [f64; 2]| {
        let mut position = vec![None; time.len()];
        position[0] = Some(seen.map(|x| x * length));
        Track { marker: marker.to_owned(), at, position, noise: 1e-3, discrepancy: 0.0 }
    };
    let tracks =
        vec![track("mid", Point::Along(0.5), [0.13, -0.46]), track("tip", Point::Tip, [0.48, -0.82])];
    let mut trial = Trial { release: release(time, tracks), model, run: Run::release(1.5, 50.0) };
    hold(&mut trial).expect("a hand can hold it there");
    trial
}

//! Releases for tests.

use efam_experiments::release::{OutOfPlane, Release, Track};

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
        out_of_plane: OutOfPlane::default(),
    }
}

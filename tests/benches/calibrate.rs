//! Cost of a calibration: six releases of 20 s at 15 psi, four parameters; at most 3 s on two cores. The
//! recordings come from a mesh and steps so fine that the fit has nothing to see but noise.

use divan::Bencher;
use efam_core::forward::Run;
use efam_core::trajectory::Trajectory;
use efam_experiments::release::{OutOfPlane, Point, Release, Track};
use efam_inference::calibrate::{
    CalibrationSettings, FittedParameter, Nuisances, Problem, Scope, Trial, calibrate,
};
use models::model::Model;
use tests::{PSI, paper, simulate};

fn main() {
    divan::main();
}

/// A recording with noise from a fixed sequence: 0.3 mm, level in frequency.
fn release(path: &Trajectory, number: u64) -> Release {
    let mut state = number;
    let mut noise = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        3e-4 * 12f64.sqrt() * ((state >> 33) as f64 / (1u64 << 31) as f64 - 0.5)
    };
    let position = path.tip.iter().map(|x| Some(x.map(|x| x + noise()))).collect();
    let track = Track { marker: "tip".to_owned(), at: Point::Tip, position, noise: 3e-4, discrepancy: 0.0 };
    Release {
        name: format!("made-up#{number}"),
        time: path.times.clone(),
        release_uncertainty: 0.003,
        tracks: vec![track],
        pressure: Some(15.0 * PSI),
        payload: 0.0,
        held_out: false,
        out_of_plane: OutOfPlane::default(),
    }
}

fn start() -> Model {
    let mut model = paper(15.0, 32, &[("rayleigh_mass.alpha", 1.8), ("rayleigh_stiffness.beta", 0.0015)]);
    let k = model.index("rod.bending_stiffness").expect("there");
    model.theta[k] *= 0.8;
    model
}

#[divan::bench(sample_count = 5)]
fn six_releases(bencher: Bencher) {
    let truth = paper(15.0, 160, &[("rayleigh_mass.alpha", 0.6), ("rayleigh_stiffness.beta", 0.004)]);
    let path = simulate(&truth, &Run { tolerance: 1e-6, ..Run::release(20.0, 100.0) });
    let paths = [
        "rod.bending_stiffness",
        "effects.rayleigh_mass.alpha",
        "effects.rayleigh_stiffness.beta",
        "release.angle",
    ];
    let problem = Problem {
        trials: (1..=6)
            .map(|number| Trial {
                release: release(&path, number),
                model: start(),
                run: Run::release(20.0, 100.0),
            })
            .map(Into::into)
            .collect(),
        parameters: paths.map(|path| FittedParameter::new(path, Scope::Shared)).to_vec(),
        nuisances: Nuisances {
            release_instant: true,
            hold_angle: None,
            offset: None,
            ..Nuisances::default()
        },
    };
    bencher
        .bench_local(|| calibrate(&problem, &CalibrationSettings::default(), &|_: &str| ()).expect("a fit"));
}

//! The converged path of the tip that `tests/peers` measures all contestants by: from the twin, which is none of them.
//!
//! `cargo run -p efam-tests --no-default-features --bin peer_reference -- ALPHA BETA > reference.csv`: 20 s of the release at
//! 15 psi, at 100 Hz, with mass damping ALPHA, 1/s, and stiffness damping BETA, s. What half as many elements and
//! twice the step change goes to stderr.

use std::process::ExitCode;

use efam_core::forward::uniform;
use tests::twin::motion::Motion;
use tests::twin::muscle;

const DURATION: f64 = 20.0;

fn main() -> ExitCode {
    let words: Vec<f64> = std::env::args().skip(1).map_while(|word| word.parse().ok()).collect();
    let [alpha, beta] = words[..] else {
        eprintln!("peer_reference ALPHA BETA; in 1/s and s, such as 1 0.01");
        return ExitCode::FAILURE;
    };
    let times = uniform(DURATION, 100.0);
    let path = |elements: usize, step: f64| {
        let beam = muscle(15.0, elements, alpha, beta);
        let motion = Motion::from_rest(&beam, beam.straight(0.0), DURATION, step);
        motion.path(&beam, 1.0 + beam.bodies[0].center / beam.length, &times)
    };
    let (coarse, fine) = (path(16, 1e-3), path(32, 5e-4));
    let square = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
    let rms = (coarse.iter().zip(&fine).map(square).sum::<f64>() / times.len() as f64).sqrt();
    eprintln!("16 elements and 1 ms are {:.6} mm rms from 32 elements and 0.5 ms", 1e3 * rms);
    println!("t_s,tip_x_m,tip_z_m");
    times.iter().zip(&fine).for_each(|(t, [x, z])| println!("{t:.2},{x:.9},{z:.9}"));
    ExitCode::SUCCESS
}

//! Error of the mesh, against an independent beam: `cargo run -p tests --no-default-features --bin mesh_study`.
//!
//! For each pressure of the paper's table, released level and from a clamp that points 25 degrees down: distance of
//! the tip from that of the twin (Hermite elements, see `tests::twin`), mm, rms and largest over 4 s with alpha
//! 0.5 1/s and beta 8 ms.

use models::model::Model;
use sim::forward::{Run, uniform};
use tests::twin::motion::Motion;
use tests::twin::muscle;
use tests::{paper_spec, simulate};

const DURATION: f64 = 4.0;
const DAMPING: [f64; 2] = [0.5, 0.008];
const NODES: [usize; 6] = [8, 12, 16, 24, 32, 64];

fn main() {
    let times = uniform(DURATION, 100.0);
    let pressures: Vec<f64> = std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let all: Vec<f64> = (1..=20).map(|k| 5.0 * f64::from(k)).collect();
    println!("| pressure, psi | angle | {} nodes |", NODES.map(|n| n.to_string()).join(" nodes | "));
    for psi in if pressures.is_empty() { all } else { pressures } {
        for degrees in [0.0, -25.0_f64] {
            let incline = degrees.to_radians();
            let mut beam = muscle(psi, 20, DAMPING[0], DAMPING[1]);
            beam.incline = incline;
            let motion = Motion::from_rest(&beam, beam.straight(0.0), DURATION, 1e-3);
            let share = 1.0 + beam.bodies[0].center / beam.length;
            let (sin, cos) = incline.sin_cos();
            let turned = |[x, z]: [f64; 2]| [cos * x - sin * z, sin * x + cos * z];
            let expected: Vec<_> = motion.path(&beam, share, &times).into_iter().map(turned).collect();
            let cell = |nodes: usize| {
                let parameters =
                    [("rayleigh_mass.alpha", DAMPING[0]), ("rayleigh_stiffness.beta", DAMPING[1])];
                let mut spec = paper_spec(psi, nodes, &parameters);
                (spec.base_angle, spec.release_angle) = (incline, incline);
                let model = Model::new(&spec).expect("valid");
                let tip = simulate(&model, &Run { tolerance: 1e-8, ..Run::release(DURATION, 100.0) }).tip;
                let off: Vec<f64> =
                    tip.iter().zip(&expected).map(|(a, b)| 1e3 * (a[0] - b[0]).hypot(a[1] - b[1])).collect();
                let rms = (off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64).sqrt();
                format!("{rms:.4} / {:.4}", off.iter().copied().fold(0.0, f64::max))
            };
            println!("| {psi} | {degrees} | {} |", NODES.map(cell).join(" | "));
        }
    }
}

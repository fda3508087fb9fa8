//! Error of the mesh, against an independent beam: `cargo run -p efam-tests --no-default-features --bin mesh_study`.
//!
//! For each pressure of the paper's table, or those given, released level and from a clamp that points 25 degrees
//! down: distance of the tip from that of the twin, mm, rms and largest over 4 s with alpha 0.5 1/s and beta 8 ms.

use tests::twin::mesh::misses;

const NODES: [usize; 6] = [8, 12, 16, 24, 32, 64];

fn main() {
    let pressures: Vec<f64> = std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let all: Vec<f64> = (1..=20).map(|k| 5.0 * f64::from(k)).collect();
    println!("| pressure, psi | angle | {} nodes |", NODES.map(|n| n.to_string()).join(" nodes | "));
    for psi in if pressures.is_empty() { all } else { pressures } {
        for degrees in [0.0, -25.0_f64] {
            let misses = misses(psi, degrees.to_radians(), &NODES);
            let cell = |[rms, largest]: &[f64; 2]| format!("{:.4} / {:.4}", 1e3 * rms, 1e3 * largest);
            println!("| {psi} | {degrees} | {} |", misses.iter().map(cell).collect::<Vec<_>>().join(" | "));
        }
    }
}

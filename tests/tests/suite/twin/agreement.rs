//! Goal: the twin and the models converge to one continuum.
//! Setup: 15 psi, both kinds of damping or mass damping alone, sampled at 100 Hz; the discrete rod's
//! limit is Richardson's from 64 and 128 edges.
//! Expected: the tips agree to what the meshes leave. Over 20 s, 16 elements, steps of 1 ms, rms:
//! 0.0004 mm of the limit and of 128 edges with alpha 1 1/s, beta 10 ms; 0.0007 mm with mass damping
//! alone. 12 elements and steps of 5 ms: 0.0018 and 0.0098 mm.

use efam_core::forward::{Run, uniform};
use models::statics::equilibrium;
use models::system::System;
use tests::twin::beam::Beam;
use tests::twin::motion::Motion;
use tests::twin::muscle;
use tests::{paper, simulate};

fn rms(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sum();
    (sum / a.len() as f64).sqrt()
}

fn tip_share(beam: &Beam) -> f64 {
    1.0 + beam.bodies[0].center / beam.length
}

/// The discrete rod's path, extrapolated from two meshes.
fn path_of_models(damping: [f64; 2], duration: f64, edges: usize, tolerance: f64) -> [Vec<[f64; 2]>; 2] {
    let path = |edges: usize| {
        let parameters = [("rayleigh_mass.alpha", damping[0]), ("rayleigh_stiffness.beta", damping[1])];
        let model = paper(15.0, edges + 1, &parameters);
        simulate(&model, &Run { tolerance, ..Run::release(duration, 100.0) }).tip
    };
    let (coarse, fine) = (path(edges / 2), path(edges));
    let limit = coarse.iter().zip(&fine).map(|(c, f)| [0, 1].map(|k| f[k] + (f[k] - c[k]) / 3.0)).collect();
    [fine, limit]
}

fn path_of_twin(damping: [f64; 2], duration: f64, elements: usize, step: f64) -> Vec<[f64; 2]> {
    let beam = muscle(15.0, elements, damping[0], damping[1]);
    let motion = Motion::from_rest(&beam, beam.straight(0.0), duration, step);
    motion.path(&beam, tip_share(&beam), &uniform(duration, 100.0))
}

#[test]
fn at_rest() {
    let tip = |edges: usize| {
        let model = paper(15.0, edges + 1, &[]);
        let q = equilibrium(&model, None).expect("it hangs").q;
        let posture = System::new(&model).assembly.posture(&q, &vec![0.0; q.len()]);
        let [x, z] = posture.nodes[edges];
        [x + model.tip_distance * posture.angle.cos(), z + model.tip_distance * posture.angle.sin()]
    };
    let (coarse, fine) = (tip(128), tip(256));
    let limit = [0, 1].map(|k| fine[k] + (fine[k] - coarse[k]) / 3.0);
    let beam = muscle(15.0, 16, 0.0, 0.0);
    let twin = beam.axis(&beam.at_rest(), tip_share(&beam))[0];
    let off = (twin[0] - limit[0]).hypot(twin[1] - limit[1]);
    assert!(off < 2e-6, "{} mm", 1e3 * off);
}

#[test]
fn in_motion() {
    let damping = [1.0, 0.01];
    let [_, limit] = path_of_models(damping, 2.0, 128, 1e-7);
    let off = rms(&path_of_twin(damping, 2.0, 12, 2.5e-3), &limit);
    assert!(off < 0.01e-3, "{} mm", 1e3 * off);
}

#[test]
#[ignore = "a minute; prints figures, and holds those above to twice what is stated"]
fn figures_over_twenty_seconds() {
    for damping in [[1.0, 0.01], [1.0, 0.002], [1.0, 0.0]] {
        let [fine, limit] = path_of_models(damping, 20.0, 128, 1e-8);
        for (elements, step) in
            [(8, 2.5e-3), (12, 5e-3), (12, 2.5e-3), (16, 2.5e-3), (16, 1e-3), (24, 1.25e-3)]
        {
            let twin = path_of_twin(damping, 20.0, elements, step);
            let off = [&fine, &limit].map(|path| 1e3 * rms(&twin, path));
            println!(
                "damping {damping:?}, {elements} elements, {step} s: {:.4} mm of 128 edges, {:.4} mm of the limit",
                off[0], off[1]
            );
            let stated = match (elements, damping[1]) {
                (16, 0.01) if step < 2e-3 => 0.0004,
                (16, 0.0) if step < 2e-3 => 0.0007,
                (12, 0.01) if step > 4e-3 => 0.0018,
                (12, 0.0) if step > 4e-3 => 0.0098,
                _ => continue,
            };
            assert!(off.iter().all(|off| *off < 2.0 * stated), "{off:?} mm, {stated} is stated");
        }
    }
}

//! How far the tip of the paper's muscle on a mesh is from that of the independent beam.

use efam_core::forward::{Run, uniform};
use models::model::Model;

use super::motion::Motion;
use super::muscle;
use crate::{paper_spec, simulate};

const DURATION: f64 = 4.0;
/// Mass damping, 1/s, and stiffness damping, s.
const DAMPING: [f64; 2] = [0.5, 0.008];

/// Distance of the tip, m: root mean square and largest over 4 s, for each number of nodes. The muscle is at a pressure
/// in psi, and released straight along its clamp, which points `incline` upwards, rad. The beam has 20 Hermite
/// elements and steps of 1 ms.
pub fn misses(psi: f64, incline: f64, nodes: &[usize]) -> Vec<[f64; 2]> {
    let times = uniform(DURATION, 100.0);
    let mut beam = muscle(psi, 20, DAMPING[0], DAMPING[1]);
    beam.incline = incline;
    let motion = Motion::from_rest(&beam, beam.straight(0.0), DURATION, 1e-3);
    let share = 1.0 + beam.bodies[0].center / beam.length;
    let (sin, cos) = incline.sin_cos();
    let turned = |[x, z]: [f64; 2]| [cos * x - sin * z, sin * x + cos * z];
    let expected: Vec<_> = motion.path(&beam, share, &times).into_iter().map(turned).collect();
    let miss = |nodes: &usize| {
        let parameters = [("rayleigh_mass.alpha", DAMPING[0]), ("rayleigh_stiffness.beta", DAMPING[1])];
        let mut spec = paper_spec(psi, *nodes, &parameters);
        (spec.base_angle, spec.release_angle) = (incline, incline);
        let model = Model::new(&spec).expect("valid");
        let tip = simulate(&model, &Run { tolerance: 1e-8, ..Run::release(DURATION, 100.0) }).tip;
        let off: Vec<f64> =
            tip.iter().zip(&expected).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1])).collect();
        let rms = (off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64).sqrt();
        [rms, off.into_iter().fold(0.0, f64::max)]
    };
    nodes.iter().map(miss).collect()
}

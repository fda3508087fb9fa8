//! Where a run may start: at rest it stays; held under another load it is let go from there; a
//! mirrored posture gives the mirrored swing.

use efam_core::forward::{Initial, Run};
use models::history::History;
use models::model::Model;
use models::posture::Posture;
use models::statics::equilibrium;
use models::system::System;
use tests::{paper, paper_spec, rms, simulate};

#[test]
fn at_rest_it_stays() {
    let model = paper(40.0, 32, &[("rayleigh_mass.alpha", 1.0), ("viscoelastic.branch_stiffness", 0.2)]);
    let initial = Initial::Equilibrium { hold: Box::new(model.clone()), own: vec![] };
    let path = simulate(&model, &Run { initial, ..Run::release(2.0, 100.0) });
    let moved = path
        .tip
        .iter()
        .map(|tip| (tip[0] - path.tip[0][0]).hypot(tip[1] - path.tip[0][1]))
        .fold(0.0, f64::max);
    // The equilibrium is found to 1e-10 of the weight; a millionth of a millimetre is a thousand
    // times what that bends the rod.
    assert!(moved < 1e-9, "{moved} m");
}

#[test]
fn held_under_a_payload_it_starts_from_there() {
    let model = paper(40.0, 32, &[("rayleigh_mass.alpha", 1.0)]);
    let hold = paper(40.0, 32, &[("rayleigh_mass.alpha", 1.0), ("payload.mass", 0.1)]);
    let rest = equilibrium(&hold, None).expect("it hangs");
    let held = System::new(&hold).observed_tip(&rest.q, &vec![0.0; rest.q.len()]).0;
    let own = vec![model.index("effects.payload.mass").expect("baseline")];
    let initial = Initial::Equilibrium { hold: Box::new(hold), own };
    let path = simulate(&model, &Run { initial, ..Run::release(2.0, 100.0) });
    assert!((path.tip[0][0] - held[0]).hypot(path.tip[0][1] - held[1]) < 1e-12);
    assert!(path.tip.iter().any(|tip| tip[1] > held[1] + 0.01), "let go, it rises");
}

fn mirrored(model: &Model) -> Posture<f64> {
    let straight = Posture::straight(model.edges, model.rod().length / model.edges as f64, 0.7, 0.0);
    Posture {
        nodes: straight.nodes.iter().map(|x| [-x[0], x[1]]).collect(),
        velocities: straight.velocities.clone(),
        angle: std::f64::consts::PI - straight.angle,
        rate: 0.0,
    }
}

/// The mirror image in x of a swing is a swing: all but the clamp's angle are even in it.
#[test]
fn mirrored_it_swings_mirrored() {
    let parameters = [("rayleigh_mass.alpha", 1.0), ("air_drag.drag_coefficient", 1.0)];
    let spec = paper_spec(40.0, 24, &parameters);
    let at = |base_angle: f64| {
        let spec = models::model::ModelSpec { base_angle, release_angle: base_angle, ..spec.clone() };
        Model::new(&spec).expect("valid")
    };
    let (right, left) = (at(0.7), at(std::f64::consts::PI - 0.7));
    let run = Run { tolerance: 1e-9, ..Run::release(3.0, 100.0) };
    let there = simulate(&right, &run);
    let mut here = simulate(&left, &Run { initial: Initial::Posture(mirrored(&left)), ..run });
    for tip in &mut here.tip {
        tip[0] = -tip[0];
    }
    let distance = rms(&there, &here);
    // Rounding moves the choice of steps, so that the two differ by the error of the integration:
    // some ten times the tolerance times the length.
    assert!(distance < 1e-7, "{distance} m");
}

/// Creep of a tenth in 10 s. A rod that was held for long in the posture of release starts as one whose
/// memory is relaxed there. One that hung for 20 s, was raised in 3 s and held for 5 s remembers most of
/// its hanging: the branch pulls it down, so that it begins lower.
#[test]
fn what_went_before_moves_the_swing() {
    let model = paper(
        40.0,
        32,
        &[("rayleigh_mass.alpha", 1.0), ("creep.creep_stiffness", 0.1), ("creep.creep_time", 10.0)],
    );
    let run = Run { tolerance: 1e-7, ..Run::release(8.0, 100.0) };
    let with = |history| simulate(&model, &Run { history, ..run.clone() });
    let relaxed = with(None);
    let long = with(Some(History { hung: 20.0, raised: 3.0, held: 1e3 }));
    assert!(rms(&relaxed, &long) < 1e-8, "{} m", rms(&relaxed, &long));
    let hung = with(Some(History { hung: 20.0, raised: 3.0, held: 5.0 }));
    let mean =
        |of: &dyn Fn(usize) -> f64| (0..relaxed.tip.len()).map(of).sum::<f64>() / relaxed.tip.len() as f64;
    let lower = mean(&|k| relaxed.tip[k][1] - hung.tip[k][1]);
    let apart = rms(&relaxed, &hung);
    println!("mean {lower} rms {apart}");
    assert!(lower > 1e-3 && lower < 5e-3, "{lower} m lower in the mean");
}

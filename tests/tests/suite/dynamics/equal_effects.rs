//! Two ways to say one thing: effects against others, or against a model's own parameters, to which
//! they must be equal where their laws coincide.

use efam_core::forward::{Initial, Run};
use models::model::Model;
use tests::{paper, paper_spec, rms, simulate};

const DAMPING: [(&str, f64); 2] = [("rayleigh_mass.alpha", 0.5), ("rayleigh_stiffness.beta", 2e-3)];

fn distance(a: &Model, b: &Model, run: &Run) -> f64 {
    rms(&simulate(a, run), &simulate(b, run))
}

fn with(effects: &[(&str, f64)]) -> Model {
    paper(15.0, 24, &[&DAMPING[..], effects].concat())
}

#[test]
fn tip_inertia_and_tip_mass_are_bodies() {
    let run = Run::release(2.0, 100.0);
    let inertia = with(&[("tip_inertia.rotary_inertia", 1e-4)]);
    assert!(distance(&inertia, &with(&[("payload.rotary_inertia", 1e-4)]), &run) < 1e-12);
    assert!(distance(&inertia, &with(&[]), &run) > 1e-3);
    let mass = with(&[("tip_mass.mass", 0.01), ("tip_mass.distance", 0.03)]);
    assert!(
        distance(&mass, &with(&[("payload.mass", 0.01), ("payload.center_of_mass", 0.03)]), &run) < 1e-12
    );
}

#[test]
fn release_drift_scales_the_bending_stiffness() {
    let run = Run { tolerance: 1e-8, ..Run::release(2.0, 100.0) };
    let mut stiffer = with(&[]);
    stiffer.set("rod.bending_stiffness", 1.1 * stiffer.rod().bending_stiffness).expect("in range");
    // Stiffness damping is of the common stiffness: given back here.
    stiffer.set("effects.rayleigh_stiffness.beta", 2e-3 / 1.1).expect("in range");
    let mut axial = with(&[("release_drift.share", 0.1)]);
    for model in [&mut stiffer, &mut axial] {
        model.set("effects.rayleigh_mass.alpha", 1.0).expect("in range");
    }
    let found = distance(&stiffer, &axial, &run);
    // Axial damping is now 10 % apart; the stretch is a few per cent, and so is what it shifts.
    assert!(found < 1e-5, "{found} m");
}

/// Without an end fitting `c = α μ` is mass damping, to the second order in the edge length in which
/// midpoints of edges replace nodes: it shrinks fourfold with half the edges' length.
#[test]
fn linear_drag_of_a_bare_rod_is_mass_damping() {
    let apart = |nodes: usize| {
        let bare = |effect: (&str, f64)| {
            let mut spec = paper_spec(15.0, nodes, &[("end_fitting.mass", 0.0), effect]);
            spec.effects.push(("rayleigh_stiffness".to_owned(), vec![("beta".to_owned(), 2e-3)]));
            Model::new(&spec).expect("valid")
        };
        let alpha = 2.0;
        let damped = bare(("rayleigh_mass.alpha", alpha));
        let dragged = bare(("linear_drag.drag_per_length", alpha * damped.rod().mass / damped.rod().length));
        distance(&damped, &dragged, &Run { tolerance: 1e-8, ..Run::release(1.0, 100.0) })
    };
    let (coarse, fine) = (apart(17), apart(33));
    assert!(fine < 1e-4 && (3.0..5.0).contains(&(coarse / fine)), "{coarse} m, {fine} m");
}

/// The hand holds what it held: with all the time in the world the rod stays where it was held.
#[test]
fn a_hand_that_never_lets_go_holds() {
    let force = 0.2;
    let hold = Initial::Equilibrium { hold: Box::new(with(&[("tip_load.force_z", force)])), own: vec![] };
    let run = Run { initial: hold, ..Run::release(1.0, 100.0) };
    let path = simulate(&with(&[("hand_release.force", force), ("hand_release.release_time", 1e6)]), &run);
    let moved = path.tip.iter().map(|tip| (tip[1] - path.tip[0][1]).abs()).fold(0.0, f64::max);
    // A millionth of the force is gone by then.
    assert!(moved < 1e-6, "{moved} m");
    // One that lets go within a thousandth of the swing is none.
    let quick = simulate(&with(&[("hand_release.force", force), ("hand_release.release_time", 1e-4)]), &run);
    let none = simulate(&with(&[]), &run);
    // It is late by the release time at the most: 0.1 ms at some m/s.
    assert!(rms(&quick, &none) < 2e-4, "{} m", rms(&quick, &none));
    assert!(rms(&quick, &none) > 1e-6, "the hand did something");
}

/// A hose whose far end is out of sight is a dead load: `k r₀ → F`.
#[test]
fn a_hose_from_far_away_is_a_dead_load() {
    let (force, far) = (0.1, 100.0);
    let run = Run::release(2.0, 100.0);
    let loaded = with(&[("tip_load.force_z", force)]);
    let hose = with(&[("hose.stiffness", force / far), ("hose.anchor_z", far), ("hose.anchor_x", 0.0)]);
    let off = with(&[("hose.stiffness", 0.0)]);
    // What the spring adds is L/far of the load: 0.2 %, and as much of the path that the load moves.
    let effect = distance(&loaded, &off, &run);
    assert!(effect > 0.01, "{effect} m");
    assert!(distance(&hose, &loaded, &run) < 0.01 * effect);
    let damped = with(&[("hose.stiffness", force / far), ("hose.damping_time", 100.0)]);
    let last = |model: &Model| {
        let path = simulate(model, &Run { energy: true, ..Run::release(2.0, 10.0) });
        path.energy[path.energy.len() - 1].dissipated
    };
    assert!(last(&damped) > 1.1 * last(&off), "{} J against {} J", last(&damped), last(&off));
}

//! Goal: the twin is right by itself: its statics against closed forms, its motion by energy and by
//! its orders of convergence.

use models::analytical::cantilever::Cantilever;
use models::analytical::elastica;
use tests::order;
use tests::twin::beam::{Beam, Body};
use tests::twin::motion::Motion;
use tests::twin::muscle;

/// A weightless beam that hardly stretches, with a weight at its very end.
fn loaded(elements: usize, load: f64) -> Beam {
    Beam {
        elements,
        length: 1.0,
        mass: 1e-12,
        bending_stiffness: 1.0,
        axial_stiffness: 1e6,
        axial_compliance: 0.0,
        bodies: vec![Body { mass: load, center: 0.0, inertia: 0.0 }],
        gravity: 1.0,
        incline: 0.0,
        alpha: 0.0,
        beta: 0.0,
    }
}

/// Cubics in position are of fourth order, `4.9e-5 (16/48)⁴ = 6e-7` under a load of three; the
/// stretch, a load over 1e6, is ten times that.
#[test]
fn a_weight_bends_it_as_the_elastica() {
    for load in [1.0, 3.0, 10.0] {
        let beam = loaded(48, load);
        let closed = elastica::tip(&Cantilever { bending_stiffness: 1.0, length: 1.0 }, -load);
        let [tip, p] = beam.axis(&beam.at_rest(), 1.0);
        let off = (tip[0] - closed.position[0]).hypot(tip[1] - closed.position[1]);
        let turned = (p[1].atan2(p[0]) - closed.angle).abs();
        assert!(
            off < 2e-6 * (1.0 + load) && turned < 2e-6 * (1.0 + load),
            "load {load}: {off} L, {turned} rad"
        );
    }
}

fn tip_after(beam: &Beam, step: f64) -> [f64; 2] {
    let motion = Motion::from_rest(beam, beam.straight(0.0), 0.4, step);
    beam.axis(&motion.states[motion.states.len() - 1][0], 1.0)[0]
}

fn slope(sizes: &[f64], tips: &[[f64; 2]], limit: [f64; 2]) -> f64 {
    let errors: Vec<f64> = tips.iter().map(|x| (x[0] - limit[0]).hypot(x[1] - limit[1])).collect();
    order(sizes, &errors)
}

/// The method is of order four, and shows it where all modes are resolved: one element without stiffness damping.
#[test]
fn steps_converge_with_the_fourth_order() {
    let beam = muscle(15.0, 1, 1.0, 0.0);
    let sizes = [8e-3, 4e-3, 2e-3];
    let tips = sizes.map(|step| tip_after(&beam, step));
    let found = slope(&sizes, &tips, tip_after(&beam, 0.25e-3));
    assert!((3.4..4.6).contains(&found), "{found}");
}

/// Stiffness damping makes the fast modes stiff. Stages of first order then show less than the classical order (Hairer
/// and Wanner, IV.15): here a little less than three, with any number of elements.
#[test]
fn with_stiff_damping_steps_converge_with_nearly_the_third_order() {
    for elements in [1, 6] {
        let beam = muscle(15.0, elements, 1.0, 0.01);
        let sizes = [8e-3, 4e-3, 2e-3];
        let tips = sizes.map(|step| tip_after(&beam, step));
        let found = slope(&sizes, &tips, tip_after(&beam, 0.25e-3));
        assert!((2.5..3.4).contains(&found), "{elements} elements: {found}");
    }
}

#[test]
fn elements_converge_with_the_fourth_order() {
    let counts = [6, 8, 12, 16];
    let tip = |elements| tip_after(&muscle(15.0, elements, 1.0, 0.01), 1e-3);
    let found = slope(&counts.map(|n| 1.0 / n as f64), &counts.map(tip), tip(32));
    assert!((3.5..5.0).contains(&found), "{found}");
}

/// What is lost is what the damping took, `∫ 2 α T dt` for mass damping, and what the method damps of
/// the fast modes that it does not resolve: a millionth of what the first swing releases.
#[test]
fn energy_goes_where_damping_takes_it() {
    for alpha in [0.0, 1.0] {
        let beam = muscle(15.0, 8, alpha, 0.0);
        let mass = beam.mass_matrix();
        let motion = Motion::from_rest(&beam, beam.straight(0.0), 0.5, 0.5e-3);
        let energies: Vec<_> = motion.states.iter().map(|[q, v]| beam.energy(&mass, q, v)).collect();
        let kinetic: f64 = energies.windows(2).map(|w| 0.5 * motion.times[1] * (w[0][0] + w[1][0])).sum();
        let total = |k: usize| energies[k].iter().sum::<f64>();
        let released = energies.iter().map(|e| e[0]).fold(0.0, f64::max);
        let left = total(0) - total(energies.len() - 1) - 2.0 * alpha * kinetic;
        assert!(left.abs() < 1e-5 * released, "alpha {alpha}: {left} J of {released} J");
    }
}

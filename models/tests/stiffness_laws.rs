//! Goal: laws of stiffness against closed forms at rest.
//! Setup: a rod of 200 edges without weight, under a moment that bends it to about one radian, or
//! under an axial force.
//! Expected: end angle and length as each test derives. Curvature is uniform or smooth, so angles are
//! right to second order in the angle of a bend, (1/200)².

use models::effects::Rod;
use models::model::{Model, ModelSpec, Scheme};
use models::statics::equilibrium;
use models::system::System;

const EDGES: usize = 200;
const LENGTH: f64 = 0.2;
const BENDING: f64 = 0.008;
const AXIAL: f64 = 120.0;

fn model(effects: &[(&str, &str, f64)]) -> Model {
    let mut all = vec![("gravity".to_owned(), vec![("acceleration".to_owned(), 0.0)])];
    all.push(("end_fitting".to_owned(), vec![("mass".to_owned(), 0.05)]));
    all.extend(
        effects.iter().map(|(name, key, value)| ((*name).to_owned(), vec![((*key).to_owned(), *value)])),
    );
    Model::new(&ModelSpec {
        nodes: EDGES + 1,
        rod: Rod {
            length: LENGTH,
            mass: 0.03,
            bending_stiffness: BENDING,
            axial_stiffness: AXIAL,
            diameter: 0.027,
            pressure: 0.0,
        },
        base_angle: 0.0,
        release_angle: 0.0,
        release_rate: 0.0,
        scheme: Scheme::Consistent,
        tip_distance: 0.0,
        effects: all,
        catalogue: Default::default(),
        schedule: None,
    })
    .expect("valid")
}

/// End angle under a moment, rad.
fn end_angle(moment: f64, effect: (&str, &str, f64)) -> f64 {
    let model = model(&[("tip_load", "moment", moment), effect]);
    *equilibrium(&model, None).expect("it bends").q.last().expect("the angle")
}

fn assert_near(found: f64, expected: f64) {
    let tolerance = (1.0 / EDGES as f64).powi(2);
    assert!((found / expected - 1.0).abs() < tolerance, "{found} against {expected}");
}

const MOMENT: f64 = BENDING / LENGTH;

/// `κ + k₃ κ³ = M/EI`, solved for the moment that belongs to a curvature.
#[test]
fn cubic_stiffness_hardens_and_softens_both_ways_alike() {
    let kappa: f64 = 4.0;
    for k3 in [4e-3, -4e-3] {
        for sign in [1.0, -1.0] {
            let moment = sign * BENDING * (kappa + k3 * kappa.powi(3));
            assert_near(end_angle(moment, ("cubic_stiffness", "coefficient", k3)), sign * kappa * LENGTH);
        }
    }
}

/// `κ + k₂ κ² = M/EI`: stiffer upwards, softer downwards.
#[test]
fn quadratic_stiffness_takes_sides() {
    for kappa in [4.0, -4.0] {
        let moment = BENDING * (kappa + 0.02 * kappa * kappa);
        assert_near(end_angle(moment, ("quadratic_stiffness", "coefficient", 0.02)), kappa * LENGTH);
    }
}

/// `∫ M ds / (EI (1 + e (s/L − ½))) = M L/(EI e) ln((2 + e)/(2 − e))`.
#[test]
fn taper_bends_the_softer_end_more() {
    for taper in [0.4_f64, -0.4] {
        let expected = MOMENT * LENGTH / (BENDING * taper) * ((2.0 + taper) / (2.0 - taper)).ln();
        assert_near(end_angle(MOMENT, ("stiffness_taper", "taper", taper)), expected);
        let root_bend = {
            let model = model(&[("tip_load", "moment", MOMENT), ("stiffness_taper", "taper", taper)]);
            let q = equilibrium(&model, None).expect("it bends").q;
            q[1] / q[0]
        };
        // The first edge has turned by half an edge of curvature M / (EI (1 − e/2)).
        let expected = 0.5 * LENGTH / EDGES as f64 * MOMENT / (BENDING * (1.0 - 0.5 * taper));
        assert!((root_bend / expected - 1.0).abs() < 1e-3, "{root_bend} against {expected}");
    }
}

#[test]
fn release_drift_is_a_stiffness() {
    assert_near(end_angle(MOMENT, ("release_drift", "share", 0.25)), MOMENT * LENGTH / (1.25 * BENDING));
}

/// `ΔL/L = F (1/EA + c)`, exactly.
#[test]
fn compliances_along_the_rod_add() {
    let (force, compliance) = (3.0, 0.01);
    let model = model(&[("tip_load", "force_x", force), ("axial_compliance", "compliance", compliance)]);
    let q = equilibrium(&model, None).expect("it stretches").q;
    let length = q[q.len() - 3] - System::new(&model).assembly.context.body.center_of_mass;
    let expected = LENGTH * (1.0 + force * (1.0 / AXIAL + compliance));
    assert!((length / expected - 1.0).abs() < 1e-9, "{length} against {expected}");
}

//! Derivatives of the equations of motion against central differences, with every effect of the
//! catalogue switched on, at a posture and velocities of no symmetry.

use models::effects::{About, CATALOGUE, LANES, Rod};
use models::model::{Model, ModelSpec, Scheme};
use models::system::{System, TimePass};

const NODES: usize = 6;

/// A model with every effect, at its default or, where that is off, at half its scale.
fn model_with_everything(scheme: Scheme) -> Model {
    model_with(scheme, |_| true)
}

/// The same with some of them.
fn model_with(scheme: Scheme, chosen: impl Fn(&About) -> bool) -> Model {
    let effects = CATALOGUE.iter().filter(|effect| chosen(effect.about())).map(|effect| {
        let about = effect.about();
        let values = about.parameters.iter().map(|p| {
            // Friction turns round smoothly here: sharply it is a step to central differences.
            let value = match p.default {
                _ if p.name == "creep_rate" => 20.0,
                default if Some(default) == p.off || default == 0.0 => 0.5 * p.scale,
                default => default,
            };
            (p.name.to_owned(), value)
        });
        (about.name.to_owned(), values.collect())
    });
    Model::new(&ModelSpec {
        nodes: NODES,
        rod: Rod {
            length: 0.2,
            mass: 0.03,
            bending_stiffness: 0.008,
            axial_stiffness: 40.0,
            diameter: 0.027,
            pressure: 2e5,
        },
        base_angle: 0.1,
        release_angle: 0.2,
        release_rate: 0.3,
        scheme,
        tip_distance: 0.0168,
        effects: effects.collect(),
        schedule: None,
    })
    .unwrap()
}

struct State {
    q: Vec<f64>,
    v: Vec<f64>,
    z: Vec<f64>,
}

/// A bent, stretched and moving rod.
fn state(model: &Model) -> State {
    let wobble = |k: usize, phase: f64| ((k * k) as f64 * 0.7 + phase).sin();
    let system = System::new(model);
    let (mut q, mut v) = system.assembly.straight(-0.4, 0.3);
    for k in 0..model.dof() {
        q[k] += 0.008 * wobble(k, 0.3);
        v[k] += 0.3 * wobble(k, 1.1);
    }
    let z = (0..model.memory()).map(|k| 2.0 * wobble(k, 2.0)).collect();
    State { q, v, z }
}

fn evaluate(model: &Model, s: &State) -> (Vec<f64>, Vec<f64>) {
    let mut system = System::new(model);
    let mut force = vec![0.0; model.dof()];
    let mut rate = vec![0.0; model.memory()];
    system.force(0.1, &s.q, &s.v, &s.z, &mut force, &mut rate);
    (force, rate)
}

fn assert_close(found: f64, expected: f64, scale: f64, what: &str) {
    // Central differences at a relative step of 1e-6 leave some 1e-9 of the scale.
    assert!((found - expected).abs() <= 1e-7 * scale, "{what}: {found} against {expected}, scale {scale}");
}

/// Solves one implicit step both ways: with memory condensed, and from the full Jacobian by
/// differences.
#[test]
fn tangents_and_condensed_memory_match_differences() {
    for root in [Scheme::Consistent, Scheme::Paper] {
        let model = model_with_everything(root);
        let s = state(&model);
        let (nq, nz) = (model.dof(), model.memory());
        assert!(nz > 0);
        let column = |vary: &dyn Fn(&mut State, f64), step: f64| {
            let side = |sign: f64| {
                let mut t = State { q: s.q.clone(), v: s.v.clone(), z: s.z.clone() };
                vary(&mut t, sign * step);
                evaluate(&model, &t)
            };
            let ((fp, gp), (fm, gm)) = (side(1.0), side(-1.0));
            let slope = |p: Vec<f64>, m: Vec<f64>| -> Vec<f64> {
                p.iter().zip(m).map(|(p, m)| (p - m) / (2.0 * step)).collect()
            };
            (slope(fp, fm), slope(gp, gm))
        };
        let by_q: Vec<_> = (0..nq).map(|k| column(&|t, d| t.q[k] += d, 1e-7)).collect();
        let by_v: Vec<_> = (0..nq).map(|k| column(&|t, d| t.v[k] += d, 1e-6)).collect();
        let by_z: Vec<_> = (0..nz).map(|k| column(&|t, d| t.z[k] += d, 1e-5)).collect();

        let a = 70.0;
        let mut system = System::new(&model);
        let mut force = vec![0.0; nq];
        system.linearise(0.1, &s.q, &s.v, &s.z, &mut force);
        system.condense(a);
        let u_q: Vec<[f64; 1]> = (0..nq).map(|k| [1e-3 * (k as f64 * 1.3).cos()]).collect();
        let u_v: Vec<[f64; 1]> = (0..nq).map(|k| [0.1 * (k as f64 * 2.1).sin()]).collect();
        let r_z: Vec<[f64; 1]> = (0..nz).map(|k| [(k as f64 * 0.9).sin()]).collect();
        let mut u_z = r_z.clone();
        system.recover_memory(a, &u_q, &u_v, &mut u_z);
        for k in 0..nz {
            // (a − g_z) u_z = r_z + g_q u_q + g_v u_v
            let g = |by: &[(Vec<f64>, Vec<f64>)], u: &[[f64; 1]]| -> f64 {
                by.iter().zip(u).map(|(column, u)| column.1[k] * u[0]).sum()
            };
            let (by_memory, by_position, by_velocity) = (g(&by_z, &u_z), g(&by_q, &u_q), g(&by_v, &u_v));
            let imbalance = a * u_z[k][0] - by_memory - r_z[k][0] - by_position - by_velocity;
            // The terms are differences of rates, and friction's rates are large.
            let scale = a * u_z[k][0].abs() + 1.0 + by_position.abs() + by_velocity.abs();
            assert_close(imbalance, 0.0, scale, "memory");
        }
        // −(∂f/∂q u_q + ∂f/∂v u_v + ∂f/∂z u_z) = K u_q + D u_v − what r_z does
        let mut condensed = vec![[0.0]; nq];
        system.stiffness().multiply_add(&u_q, &mut condensed);
        system.damping().multiply_add(&u_v, &mut condensed);
        let mut from_memory = vec![[0.0]; nq];
        system.condense_residual(a, &r_z, &mut from_memory);
        for k in 0..nq {
            let f = |by: &[(Vec<f64>, Vec<f64>)], u: &[[f64; 1]]| -> f64 {
                by.iter().zip(u).map(|(column, u)| column.0[k] * u[0]).sum()
            };
            let full = -f(&by_q, &u_q) - f(&by_v, &u_v) - f(&by_z, &u_z);
            let scale: f64 = by_q.iter().map(|c| c.0[k].abs()).sum::<f64>() * 1e-3 + 1.0;
            assert_close(condensed[k][0] - from_memory[k][0], full, scale, &format!("force {k}"));
        }
    }
}

#[test]
fn derivatives_by_every_parameter_match_differences() {
    let model = model_with_everything(Scheme::Consistent);
    let s = state(&model);
    let (nq, nz) = (model.dof(), model.memory());
    let mut system = System::new(&model);
    let all: Vec<usize> = (0..model.theta.len()).collect();
    system.watch(&all.iter().map(|k| Some(*k)).collect::<Vec<_>>());
    let (force, _) = evaluate(&model, &s);
    let acceleration: Vec<f64> = force.iter().zip(&system.mass).map(|(f, m)| f / m).collect();
    for group in 0..all.len().div_ceil(LANES) {
        let mut by_theta = vec![[0.0; LANES]; nq];
        let mut rate_by_theta = vec![[0.0; LANES]; nz];
        system.by_parameters(group, 0.1, &s.q, &s.v, &s.z, &mut by_theta, &mut rate_by_theta);
        for lane in 0..LANES.min(all.len() - group * LANES) {
            let k = group * LANES + lane;
            // Long enough that what it does to a mass of a gram stands out of the rounding of EA/ℓ x.
            let step = 1e-3 * model.parameters[k].scale.max(model.theta[k].abs() * 0.1);
            let side = |sign: f64| {
                let mut moved = model.clone();
                moved.theta[k] += sign * step;
                let (force, rate) = evaluate(&moved, &s);
                let mass = System::new(&moved).mass.clone();
                let imbalance: Vec<f64> =
                    force.iter().zip(mass.iter().zip(&acceleration)).map(|(f, (m, a))| f - m * a).collect();
                (imbalance, rate)
            };
            // Of fourth order, so that the step may be as long.
            let [near, far] = [1.0, 2.0].map(|share| (side(share), side(-share)));
            let slope = |near: [f64; 2], far: [f64; 2]| {
                (8.0 * (near[0] - near[1]) - (far[0] - far[1])) / (12.0 * step)
            };
            let of_force = |i: usize| slope([near.0.0[i], near.1.0[i]], [far.0.0[i], far.1.0[i]]);
            let of_memory = |i: usize| slope([near.0.1[i], near.1.1[i]], [far.0.1[i], far.1.1[i]]);
            let scale = (0..nq).map(|i| of_force(i).abs()).fold(1e-3, f64::max);
            for i in 0..nq {
                let expected = of_force(i);
                let tolerance = 10.0 * scale + 1e-7 / step;
                assert_close(by_theta[i][lane], expected, tolerance, &model.parameters[k].path);
            }
            for i in 0..nz {
                let expected = of_memory(i);
                let tolerance = expected.abs() * 10.0 + 1e-3;
                assert_close(rate_by_theta[i][lane], expected, tolerance, &model.parameters[k].path);
            }
        }
    }
}

/// The force of a state at rest is the gradient of its energy: all laws agree with their energies. Not
/// so friction: its moment works on its memory, which holds the energy and moves with the bend.
#[test]
fn force_at_rest_is_the_gradient_of_energy() {
    let friction = ["dahl", "braid_friction", "friction_over_pressure", "clamp_friction", "hysteresis"];
    let model = model_with(Scheme::Consistent, |about| !friction.contains(&about.name));
    let mut s = state(&model);
    s.v.fill(0.0);
    let (force, _) = evaluate(&model, &s);
    let mut system = System::new(&model);
    for k in 0..model.dof() {
        let step = 1e-7;
        let mut energy = |sign: f64| {
            let mut q = s.q.clone();
            q[k] += sign * step;
            let (_, elastic, potential) = system.energy(0.1, &q, &s.v, &s.z);
            elastic + potential
        };
        let slope = (energy(1.0) - energy(-1.0)) / (2.0 * step);
        assert_close(force[k], -slope, 10.0 * force[k].abs() + 100.0, "gradient");
    }
}

#[test]
fn dissipated_power_is_never_negative_and_vanishes_at_rest() {
    let model = model_with(Scheme::Consistent, |about| !about.timed);
    let mut s = state(&model);
    let mut system = System::new(&model);
    let mut pass = TimePass::new(&model);
    let (lost, supplied) = system.powers(&mut pass, 0.1, &s.q, &s.v, &s.z);
    assert!(lost > 0.0, "{lost}");
    assert_eq!(supplied, 0.0);
    s.v.fill(0.0);
    system.relax_memory(0.1, &s.q, &mut s.z);
    let (lost, _) = system.powers(&mut pass, 0.1, &s.q, &s.v, &s.z);
    assert!(lost.abs() < 1e-15, "{lost}");
}

/// What observers show of each effect adds up to what acts: no force is shown twice or not at all,
/// the clamp's moment included.
#[test]
fn forces_of_effects_add_up() {
    let model = model_with_everything(Scheme::Consistent);
    let s = state(&model);
    let mut system = System::new(&model);
    let (mut force, mut rate) = (vec![0.0; model.dof()], vec![0.0; model.memory()]);
    let each = system.effect_forces(0.1, &s.q, &s.v, &s.z);
    system.force(0.1, &s.q, &s.v, &s.z, &mut force, &mut rate);
    let all = system.assembly.fields.node_forces(&system.assembly.context);
    for (i, total) in all.iter().enumerate() {
        for k in 0..2 {
            let (sum, scale) = each.iter().fold((0.0, 0.0), |(sum, scale): (f64, f64), (_, nodes)| {
                (sum + nodes[i][k], scale + nodes[i][k].abs())
            });
            assert!((sum - total[k]).abs() <= 1e-12 * scale, "node {i}: {sum} against {}", total[k]);
        }
    }
}

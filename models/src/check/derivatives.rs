//! Derivatives of the equations of motion against central differences.

use crate::effects::LANES;
use crate::model::Model;
use crate::system::System;

/// A state of motion.
#[derive(Clone, Debug)]
pub struct State {
    /// Time after release, s.
    pub time: f64,
    /// Coordinates.
    pub q: Vec<f64>,
    /// Their rates.
    pub v: Vec<f64>,
    /// Memories.
    pub z: Vec<f64>,
}

impl State {
    /// A bent, stretched and moving rod, without symmetry.
    pub fn of(model: &Model) -> State {
        let wobble = |k: usize, phase: f64| ((k * k) as f64 * 0.7 + phase).sin();
        let system = System::new(model);
        let (mut q, mut v) = system.assembly.straight(-0.4, 0.3);
        for k in 0..model.dof() {
            q[k] += 0.008 * wobble(k, 0.3);
            v[k] += 0.3 * wobble(k, 1.1);
        }
        let z = (0..model.memory()).map(|k| 2.0 * wobble(k, 2.0)).collect();
        State { time: 0.1, q, v, z }
    }
}

fn evaluate(model: &Model, s: &State) -> (Vec<f64>, Vec<f64>) {
    let mut system = System::new(model);
    let mut force = vec![0.0; model.dof()];
    let mut rate = vec![0.0; model.memory()];
    system.force(s.time, &s.q, &s.v, &s.z, &mut force, &mut rate);
    (force, rate)
}

fn close(found: f64, expected: f64, scale: f64, what: &str) -> Result<(), String> {
    // Central differences at a relative step of 1e-6 leave some 1e-9 of the scale.
    if (found - expected).abs() <= 1e-7 * scale {
        return Ok(());
    }
    Err(format!("{what}: {found} against {expected}, scale {scale}"))
}

/// Solves one implicit step both ways: with memory condensed, and from the full Jacobian by
/// differences.
/// # Errors
/// What differs, in words.
pub fn tangents_match_differences(model: &Model, s: &State) -> Result<(), String> {
    let (nq, nz) = (model.dof(), model.memory());
    let column = |vary: &dyn Fn(&mut State, f64), step: f64| {
        let side = |sign: f64| {
            let mut t = s.clone();
            vary(&mut t, sign * step);
            evaluate(model, &t)
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
    let mut system = System::new(model);
    let mut force = vec![0.0; nq];
    system.linearise(s.time, &s.q, &s.v, &s.z, &mut force);
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
        close(imbalance, 0.0, scale, "memory")?;
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
        close(condensed[k][0] - from_memory[k][0], full, scale, &format!("force {k}"))?;
    }
    Ok(())
}

/// Derivatives by every parameter of a model.
/// # Errors
/// What differs, in words.
pub fn parameters_match_differences(model: &Model, s: &State) -> Result<(), String> {
    let (nq, nz) = (model.dof(), model.memory());
    let mut system = System::new(model);
    let all: Vec<usize> = (0..model.theta.len()).collect();
    system.watch(&all.iter().map(|k| Some(*k)).collect::<Vec<_>>());
    let (_, rates) = evaluate(model, s);
    for group in 0..all.len().div_ceil(LANES) {
        let mut by_theta = vec![[0.0; LANES]; nq];
        let mut rate_by_theta = vec![[0.0; LANES]; nz];
        system.by_parameters(group, s.time, &s.q, &s.v, &s.z, &mut by_theta, &mut rate_by_theta);
        for lane in 0..LANES.min(all.len() - group * LANES) {
            let k = group * LANES + lane;
            // Long enough that what it does to a mass of a gram exceeds the rounding of EA/ℓ x.
            let step = 1e-3 * model.parameters[k].scale.max(model.theta[k].abs() * 0.1);
            let side = |sign: f64| {
                let mut moved = model.clone();
                moved.theta[k] += sign * step;
                let (force, rate) = evaluate(&moved, s);
                (force, rate, System::new(&moved).mass)
            };
            // Of fourth order, so that the step may be as long.
            let [near, far] = [1.0, 2.0].map(|share| (side(share), side(-share)));
            let slope = |near: [f64; 2], far: [f64; 2]| {
                (8.0 * (near[0] - near[1]) - (far[0] - far[1])) / (12.0 * step)
            };
            let of_force = |i: usize| slope([near.0.0[i], near.1.0[i]], [far.0.0[i], far.1.0[i]]);
            let of_memory = |i: usize| slope([near.0.1[i], near.1.1[i]], [far.0.1[i], far.1.1[i]]);
            let path = &model.parameters[k].path;
            let of_mass =
                |i: usize| slope([near.0.2[i], near.1.2[i]], [far.0.2[i], far.1.2[i]]) / system.mass[i];
            for (i, by_theta) in system.mass_by_parameters(group).enumerate() {
                close(by_theta[lane], of_mass(i), of_mass(i).abs() * 10.0 + 1e-7 / step, path)?;
            }
            let scale = (0..nq).map(|i| of_force(i).abs()).fold(1e-3, f64::max);
            for (i, by_theta) in by_theta.iter().enumerate() {
                close(by_theta[lane], of_force(i), 10.0 * scale + 1e-7 / step, path)?;
            }
            for (i, rate_by_theta) in rate_by_theta.iter().enumerate() {
                let expected = of_memory(i);
                // Beside the truncation, the rounding of rates, which the step divides.
                let rounding = 1e-8 * rates[i].abs() / step;
                close(rate_by_theta[lane], expected, expected.abs() * 10.0 + 1e-3 + rounding, path)?;
            }
        }
    }
    Ok(())
}

/// The force of a state at rest against the gradient of its energy.
/// # Errors
/// What differs, in words.
pub fn force_is_gradient(model: &Model, s: &State) -> Result<(), String> {
    let mut s = s.clone();
    s.v.fill(0.0);
    let (force, _) = evaluate(model, &s);
    let mut system = System::new(model);
    for (k, force) in force.iter().enumerate() {
        let step = 1e-7;
        let mut energy = |sign: f64| {
            let mut q = s.q.clone();
            q[k] += sign * step;
            let (_, elastic, potential) = system.energy(s.time, &q, &s.v, &s.z);
            elastic + potential
        };
        let slope = (energy(1.0) - energy(-1.0)) / (2.0 * step);
        close(*force, -slope, 10.0 * force.abs() + 100.0, "gradient")?;
    }
    Ok(())
}

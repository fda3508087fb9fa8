//! Goal: strain rates against a rest length that changes.
//! Setup: a schedule under which length, stiffnesses and diameter of the rod change; stiffness damping.
//! Expected: what the page of `rayleigh_stiffness` states, `T = β EA d(e/ℓ)/dt` and `M = β EI d(K/ℓ)/dt`,
//! with the strains differentiated along the motion by central differences; tangents and derivatives
//! by time of the forces by central differences, too.

use std::sync::Arc;

use models::effects::Rod;
use models::model::{Model, ModelSpec, Schedule, Scheme};
use models::system::{System, TimePass};

/// Smooth, without breakpoints.
struct Growing;

impl Schedule for Growing {
    fn factors(&self, time: f64, _since: f64) -> [[f64; 3]; 4] {
        let wave = |size: f64, rate: f64| {
            let (sin, cos) = (rate * time).sin_cos();
            [1.0 + size * sin, size * rate * cos, -size * rate * rate * sin]
        };
        [wave(0.2, 3.0), wave(-0.3, 5.0), wave(0.1, 2.0), wave(0.0, 1.0)]
    }
    fn breakpoints(&self) -> &[f64] {
        &[]
    }
}

const NOW: f64 = 0.13;
const BETA: f64 = 0.02;

fn model(effects: &[(&str, &[(&str, f64)])]) -> Model {
    let owned = |values: &[(&str, f64)]| values.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect();
    Model::new(&ModelSpec {
        nodes: 6,
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
        release_rate: 0.0,
        scheme: Scheme::Consistent,
        tip_distance: 0.0,
        effects: effects.iter().map(|(name, values)| ((*name).to_owned(), owned(values))).collect(),
        catalogue: Default::default(),
        schedule: Some(Arc::new(Growing)),
    })
    .unwrap()
}

fn state(model: &Model) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let wobble = |k: usize, phase: f64| ((k * k) as f64 * 0.7 + phase).sin();
    let (mut q, mut v) = System::new(model).assembly.straight(-0.4, 0.3);
    for k in 0..model.dof() {
        q[k] += 0.008 * wobble(k, 0.3);
        v[k] += 0.3 * wobble(k, 1.1);
    }
    let z = (0..model.memory()).map(|k| wobble(k, 2.0)).collect();
    (q, v, z)
}

#[test]
fn damping_sees_the_rates_of_the_strains() {
    let damped = model(&[("rayleigh_stiffness", &[("beta", BETA)])]);
    let plain = model(&[]);
    let (q, v, _) = state(&damped);
    let stresses = |model| {
        let mut system = System::new(model);
        system.force(NOW, &q, &v, &[], &mut vec![0.0; q.len()], &mut []);
        (system.assembly.fields.tension.clone(), system.assembly.fields.moment.clone())
    };
    let ((tension, moment), (elastic_tension, elastic_moment)) = (stresses(&damped), stresses(&plain));
    let strains = |step: f64| {
        let mut system = System::new(&plain);
        let moved: Vec<f64> = q.iter().zip(&v).map(|(q, v)| q + step * v).collect();
        system.force(NOW + step, &moved, &v, &[], &mut vec![0.0; q.len()], &mut []);
        let (c, f) = (&system.assembly.context, &system.assembly.fields);
        let curvature: Vec<f64> = f.kappa.iter().zip(&c.per_voronoi).map(|(k, per)| k * per).collect();
        (f.stretch.clone(), curvature, c.rod)
    };
    let step = 1e-6;
    let ((stretch, curvature, _), (stretch_before, curvature_before, _)) = (strains(step), strains(-step));
    let rod = strains(0.0).2;
    let check = |found: f64, before: f64, after: f64, stiffness: f64| {
        let due = BETA * stiffness * (after - before) / (2.0 * step);
        assert!((found / due - 1.0).abs() < 1e-6, "{found}, due {due}");
    };
    for j in 0..stretch.len() {
        let found = tension[j] - elastic_tension[j];
        check(found, stretch_before[j], stretch[j], rod.axial_stiffness);
    }
    for i in 0..curvature.len() {
        let found = moment[i] - elastic_moment[i];
        check(found, curvature_before[i], curvature[i], rod.bending_stiffness);
    }
}

/// In line with its clamp, at its rest length and as fast as that, it feels nothing at all.
#[test]
fn a_rod_that_grows_with_its_rest_length_feels_no_damping() {
    let model = model(&[("gravity", &[("acceleration", 0.0)]), ("rayleigh_stiffness", &[("beta", BETA)])]);
    let [[length, rate, _], ..] = Growing.factors(NOW, NOW);
    let mut system = System::new(&model);
    let (mut q, _) = system.assembly.straight(0.1, 0.0);
    let angle = q.len() - 1;
    let arm = system.assembly.context.body.center_of_mass;
    // The end body's centre of mass keeps its distance from the last node.
    let fixed = [arm * 0.1_f64.cos(), arm * 0.1_f64.sin()];
    let mut v = vec![0.0; q.len()];
    for k in 0..angle {
        let own = if k + 2 >= angle { fixed[k + 2 - angle] } else { 0.0 };
        let start = q[k] - own;
        q[k] = length * start + own;
        v[k] = rate * start;
    }
    let mut force = vec![0.0; q.len()];
    system.force(NOW, &q, &v, &[], &mut force, &mut []);
    assert!(force.iter().all(|f| f.abs() < 1e-12), "{force:?}");
}

/// The tangents of the step and the derivative by time, with everything that sees strain rates.
#[test]
fn tangents_and_the_derivative_by_time_match_differences() {
    let model = model(&[
        ("clamp_compliance", &[("compliance", 20.0)]),
        ("rayleigh_stiffness", &[("beta", BETA)]),
        ("strain_rate_cubed", &[("coefficient", 1e-5)]),
        ("dahl", &[("friction_moment", 1e-3), ("creep_rate", 20.0)]),
        ("viscoelastic", &[("branch_stiffness", 0.5), ("relaxation_time", 0.05)]),
    ]);
    let (q, v, z) = state(&model);
    let (nq, nz) = (q.len(), z.len());
    let evaluate = |time: f64, q: &[f64]| {
        let (mut force, mut rate) = (vec![0.0; nq], vec![0.0; nz]);
        System::new(&model).force(time, q, &v, &z, &mut force, &mut rate);
        [force, rate].concat()
    };
    let differences = |plus: Vec<f64>, minus: Vec<f64>, step: f64| -> Vec<f64> {
        plus.iter().zip(minus).map(|(p, m)| (p - m) / (2.0 * step)).collect()
    };
    let close = |found: &[f64], due: &[f64], what: &str| {
        let scale = due.iter().fold(1e-3, |most: f64, x| most.max(x.abs()));
        for (found, due) in found.iter().zip(due) {
            assert!((found - due).abs() < 1e-6 * scale, "{what}: {found}, due {due}");
        }
    };
    let mut system = System::new(&model);
    let (mut by_time, mut z_by_time) = (vec![0.0; nq], vec![0.0; nz]);
    system.by_time(&mut TimePass::new(&model), NOW, &q, &v, &z, &mut by_time, &mut z_by_time);
    let due = differences(evaluate(NOW + 1e-6, &q), evaluate(NOW - 1e-6, &q), 1e-6);
    close(&by_time, &due[..nq], "forces by time");
    close(&z_by_time, &due[nq..], "memory rates by time");
    // The step's matrix at once: a fast step, so that the memory hardly answers.
    let direction: Vec<f64> = (0..nq).map(|k| (1.3 * k as f64).cos()).collect();
    let moved = |step: f64| -> Vec<f64> { q.iter().zip(&direction).map(|(q, d)| q + step * d).collect() };
    let due = differences(evaluate(NOW, &moved(1e-7)), evaluate(NOW, &moved(-1e-7)), 1e-7);
    let mut force = vec![0.0; nq];
    system.linearise(NOW, &q, &v, &z, &mut force);
    let a = 1e12;
    system.condense(a);
    let mut pulled = vec![0.0; nq];
    system.stiffness().multiply_add(direction.as_chunks::<1>().0, pulled.as_chunks_mut().0);
    let pulled: Vec<f64> = pulled.iter().map(|f| -f).collect();
    close(&pulled, &due[..nq], "forces by coordinates");
    let mut increments = vec![[0.0]; nz];
    let still = vec![[0.0]; nq];
    system.recover_memory(a, direction.as_chunks::<1>().0, &still, &mut increments);
    let rates: Vec<f64> = increments.iter().map(|u| a * u[0]).collect();
    close(&rates, &due[nq..], "memory rates by coordinates");
}

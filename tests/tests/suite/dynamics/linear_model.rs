//! Goal: the linear model about a rest is the nonlinear one for small motions.
//! Setup: the paper's muscle with damping and memory, hanging from a level clamp; small forces and pressures.
//! Expected: poles of the modes, static gains of two rests, responses of simulated swings, samples of the continuous
//! model, and reduced models within their bound; each tolerance is written beside its test.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

use efam_core::forward::{Initial, Run};
use efam_core::linear::{Complex, DMatrix, DVector, Linear, LinearError, linearise};
use efam_core::stepper::Stepper;
use efam_experiments::scenario::parse_laws;
use models::model::{Model, ModelSpec};
use models::muscle::{Extrapolation, Muscle};
use models::pressure::PressureSchedule;
use models::statics::{equilibrium, equilibrium_at, modes};
use models::system::System;
use tests::{PSI, paper, paper_spec, simulate};

pub(super) const NODES: usize = 16;
/// So that a transient is gone after 10 s.
pub(super) const DAMPING: [(&str, f64); 2] =
    [("rayleigh_mass.alpha", 2.0), ("rayleigh_stiffness.beta", 2e-3)];
pub(super) const VISCOELASTIC: [(&str, f64); 2] =
    [("viscoelastic.branch_stiffness", 0.2), ("viscoelastic.relaxation_time", 0.1)];

pub(super) fn linear(model: &Model, psi: f64, inputs: &[&str], outputs: &[&str]) -> Linear {
    let muscle = Muscle::built_in("garbulinski-2022").expect("built in");
    let slopes = muscle.rod_slopes(psi * PSI, "pder_32", Extrapolation::Refused).expect("in the table");
    linearise(model, Some(slopes), inputs, outputs).expect("it hangs")
}

/// The muscle under a pressure over time.
pub(super) fn under(rows: &[(f64, f64)], effects: &[(&str, f64)]) -> Model {
    let muscle = Muscle::built_in("garbulinski-2022").expect("built in");
    let schedule =
        PressureSchedule::new(muscle, "pder_32", Extrapolation::Refused, rows).expect("in the table");
    let spec = paper_spec(rows[0].1 / PSI, NODES, effects);
    Model::new(&ModelSpec { schedule: Some(Arc::new(schedule)), ..spec }).expect("valid")
}

fn tip_at(model: &Model, time: f64) -> [f64; 2] {
    let rest = equilibrium_at(model, time, None).expect("it hangs");
    let mut system = System::at_rest(model);
    let at_rest = vec![0.0; rest.q.len()];
    system.assembly.place(model, time, &rest.q, &at_rest);
    system.observed_tip(&rest.q, &at_rest).0
}

/// With damping by mass alone, and with friction that never lets go, poles and modes solve the same
/// equations.
#[test]
fn poles_are_those_of_the_modes() {
    let text = "[laws.stuck]\nplace = \"bend\"\nkind = \"dissipative\"\nmoment = \"stiffness * memory\"\n\
                memory = \"kappa_rate\"\nmemory_unit = \"1/m\"\n\
                parameters.stiffness = { unit = \"N m^2\", default = 0.002, range = [0, 10] }";
    let laws = parse_laws(Path::new("stuck.toml"), text).unwrap_or_else(|error| panic!("{error}"));
    let mut stuck = paper_spec(40.0, 32, &[("rayleigh_mass.alpha", 0.4)]);
    stuck.catalogue = stuck.catalogue.with(laws[0].effect().expect("sound")).expect("a name of its own");
    stuck.effects.push(("stuck".to_owned(), Vec::new()));
    for model in [paper(40.0, 32, &[("rayleigh_mass.alpha", 0.4)]), Model::new(&stuck).expect("valid")] {
        let rest = equilibrium(&model, None).expect("it hangs");
        let poles = linear(&model, 40.0, &["force_z"], &["tip_z"]).modal.poles();
        let bending = poles.iter().filter(|pole| !pole.is_along && pole.at.im > 0.0);
        // Of faster ones the damping ratio is so small that rounding of the pole is a billionth of it.
        let modes = modes(&model, &rest, 5).expect("stable");
        for (pole, mode) in bending.zip(&modes) {
            let frequency = pole.frequency * TAU / mode.angular_frequency - 1.0;
            let ratio = pole.damping_ratio / mode.damping_ratio - 1.0;
            println!("{:.4} Hz: {frequency:.1e}, {ratio:.1e}", pole.frequency);
            assert!(frequency.abs() < 1e-9 && ratio.abs() < 1e-9, "{pole:?}: {frequency:.1e}, {ratio:.1e}");
        }
    }
}

/// Central differences of rests: the error is of second order in their distance.
#[test]
fn static_gains_are_differences_of_rests() {
    let effects = [&DAMPING[..], &VISCOELASTIC, &[("set_curvature.curvature_over_pressure", 1e-6)]].concat();
    let model = paper(33.0, NODES, &effects);
    let inputs = [
        "force_x",
        "force_z",
        "moment",
        "base_acceleration_z",
        "effects.set_curvature.natural_curvature",
        "rod.bending_stiffness",
        "pressure",
    ];
    let steps = [1e-3, 1e-3, 1e-4, 1e-2, 1e-2, 1e-5, 500.0];
    let gains = linear(&model, 33.0, &inputs, &["tip_x", "tip_z"]).modal.static_gain();
    for (k, (input, step)) in inputs.iter().zip(steps).enumerate() {
        let tip = |by: f64| match *input {
            "pressure" => tip_at(&under(&[(0.0, 33.0 * PSI), (1.0, 33.0 * PSI + by)], &effects), 1.0),
            input => {
                let path = match input {
                    "base_acceleration_z" => "effects.gravity.acceleration".to_owned(),
                    input if input.contains('.') => input.to_owned(),
                    input => format!("effects.tip_load.{input}"),
                };
                let mut model = model.with_effect("tip_load", &[]).expect("a load");
                model.set(&path, model.value(&path).unwrap() + by).expect("in its range");
                tip_at(&model, 0.0)
            }
        };
        let (more, less) = (tip(step), tip(-step));
        for axis in 0..2 {
            let due = (more[axis] - less[axis]) / (2.0 * step);
            let error = gains[(axis, k)] / due - 1.0;
            println!("{input} axis {axis}: {:.6e}, {error:.1e}", gains[(axis, k)]);
            assert!(error.abs() < 1e-4, "{input}, axis {axis}: {} against {due}", gains[(axis, k)]);
        }
    }
}

/// Amplitude and phase at a frequency of what came after a time, by least squares.
fn phasor(times: &[f64], values: &[f64], frequency: f64, after: f64) -> Complex {
    let kept: Vec<usize> = (0..times.len()).filter(|k| times[*k] >= after).collect();
    let basis = DMatrix::from_fn(kept.len(), 3, |row, column| {
        let phase = TAU * frequency * times[kept[row]];
        [phase.sin(), phase.cos(), 1.0][column]
    });
    let values = DVector::from_iterator(kept.len(), kept.iter().map(|k| values[*k]));
    let found = basis.svd(true, true).solve(&values, 1e-12).expect("solved");
    Complex::new(found[0], found[1])
}

/// Ten frequencies about the first two modes, a force that moves the tip by at most 1 % of the swing, and 1 % in amplitude and phase.
#[test]
fn a_swept_force_gives_the_response() {
    let effects = [&DAMPING[..], &VISCOELASTIC].concat();
    let linear = linear(&paper(30.0, NODES, &effects), 30.0, &["force_z"], &["tip_z"]);
    let gain = |frequency: f64| linear.modal.response(Complex::new(0.0, TAU * frequency))[(0, 0)];
    let frequencies = [0.2, 0.5, 0.9, 1.2, 1.5, 2.0, 3.5, 6.0, 9.0, 12.0];
    let amplitude = 0.01 * 0.3 / frequencies.iter().map(|own| gain(*own).norm()).fold(0.0, f64::max);
    let text = "[laws.shaker]\nplace = \"tip\"\nkind = \"load\"\nforce_z = \"force * sin(2 * pi * frequency * time)\"\n\
                parameters.force = { unit = \"N\", default = 0.001, range = [0, 10] }\n\
                parameters.frequency = { unit = \"1/s\", default = 1, range = [0, 100] }";
    let laws = parse_laws(Path::new("shaker.toml"), text).unwrap_or_else(|error| panic!("{error}"));
    for frequency in frequencies {
        let mut spec = paper_spec(30.0, NODES, &effects);
        spec.catalogue = spec.catalogue.with(laws[0].effect().expect("sound")).expect("a name of its own");
        let values = [("force".to_owned(), amplitude), ("frequency".to_owned(), frequency)];
        spec.effects.push(("shaker".to_owned(), values.to_vec()));
        let model = Model::new(&spec).expect("valid");
        let found = swept(&model, &paper(30.0, NODES, &effects), frequency) / amplitude;
        let due = gain(frequency);
        let error = (found / due - 1.0).norm();
        println!("force, {frequency} Hz: {error:.1e}");
        assert!(error < 0.01, "{frequency} Hz: {found} against {due}, {error:.4}");
    }
}

/// The same for a pressure of 0.3 psi up and down, in straight pieces of a hundredth of a period.
#[test]
fn a_swept_pressure_gives_the_response() {
    let effects = [&DAMPING[..], &VISCOELASTIC].concat();
    let linear = linear(&paper(30.0, NODES, &effects), 30.0, &["pressure"], &["tip_z"]);
    for frequency in [0.3, 1.3, 3.0, 8.0] {
        let rows: Vec<_> = (0..=(14.0 * frequency * 100.0) as usize)
            .map(|k| {
                let phase = TAU * k as f64 / 100.0;
                (k as f64 / 100.0 / frequency, (30.0 + 0.3 * phase.sin()) * PSI)
            })
            .collect();
        let found = swept(&under(&rows, &effects), &paper(30.0, NODES, &effects), frequency) / (0.3 * PSI);
        let due = linear.modal.response(Complex::new(0.0, TAU * frequency))[(0, 0)];
        let error = (found / due - 1.0).norm();
        println!("pressure, {frequency} Hz: {error:.1e}, {:.2} mm/psi", due.norm() * PSI * 1e3);
        assert!(error < 0.01, "{frequency} Hz: {found} against {due}, {error:.4}");
    }
}

/// Height of the tip of a model that starts at the rest of another, at a frequency, in the last of 14 s.
pub(super) fn swept(model: &Model, hold: &Model, frequency: f64) -> Complex {
    let rest = equilibrium(hold, None).expect("it hangs");
    let posture = System::new(hold).assembly.posture(&rest.q, &vec![0.0; rest.q.len()]);
    let run = Run { initial: Initial::Posture(posture), tolerance: 1e-8, ..Run::release(14.0, 500.0) };
    let path = simulate(model, &run);
    let last = 14.0 - (4.0 * frequency).floor().max(1.0) / frequency;
    phasor(&path.times, &path.tip_z(), frequency, last)
}

/// A nonlinear rod under a small force that is held over each sample, and the discrete model.
#[test]
fn samples_follow_the_stepped_rod() {
    let effects = [&DAMPING[..], &VISCOELASTIC].concat();
    let model = paper(30.0, NODES, &effects).with_effect("tip_load", &[]).expect("a load");
    let linear = linear(&model, 30.0, &["force_z"], &["tip_z"]);
    let sample = 0.02;
    let discrete = linear.modal.discrete(sample);
    let rest = equilibrium(&model, None).expect("it hangs");
    let state = efam_core::integrate::State {
        time: 0.0,
        v: vec![0.0; rest.q.len()],
        q: rest.q.clone(),
        z: rest.z.clone(),
    };
    let control = efam_core::integrate::Control { tolerance: 1e-9, ..Default::default() };
    let mut stepper =
        Stepper::with(&model, state, efam_core::forward::DEFAULT_METHOD, control).expect("it starts");
    let start = stepper.tip().position[1];
    let mut x = DVector::zeros(discrete.a.nrows());
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for k in 0..100 {
        let force = 1e-4 * (0.37 * f64::from(k * k)).sin().signum();
        stepper.set("tip_load.force_z", force).expect("a force");
        stepper.step_to(sample * f64::from(k + 1)).expect("it goes on");
        x = &discrete.a * x + discrete.b.column(0) * force;
        let (found, due) = ((&discrete.c * &x)[0], stepper.tip().position[1] - start);
        worst = worst.max((found - due).abs());
        largest = largest.max(due.abs());
    }
    println!("samples: {:.1e} of {largest:.2e} m", worst / largest);
    // Second order in the swing, which is a thousandth of the rod.
    assert!(worst < 3e-3 * largest, "{worst:e} of {largest:e} m");
}

/// A step of the continuous model at the samples, and the matrix exponential of a reduced one.
#[test]
fn samples_are_those_of_the_continuous_model() {
    let model = paper(30.0, NODES, &[&DAMPING[..], &VISCOELASTIC].concat());
    let linear = linear(&model, 30.0, &["pressure"], &["tip_z", "tip_angle"]);
    let sample = 0.01;
    let discrete = linear.modal.discrete(sample);
    let mut x = DVector::zeros(discrete.a.nrows());
    for k in 1..=200 {
        x = &discrete.a * x + discrete.b.column(0);
        let due = linear.modal.step(sample * f64::from(k));
        let error = (&discrete.c * &x - due.column(0)).amax() / due.amax();
        assert!(error < 1e-9, "sample {k}: {error:e}");
    }
    let small = linear.modal.reduced(6).expect("it decays").matrices;
    let own = small.modal().expect("poles of its own").discrete(sample);
    let mut whole = DMatrix::zeros(7, 7);
    whole.view_mut((0, 0), (6, 6)).copy_from(&(&small.a * sample));
    whole.view_mut((0, 6), (6, 1)).copy_from(&(&small.b * sample));
    let whole = whole.exp();
    let error = |found: &DMatrix<f64>, due: DMatrix<f64>| (found - &due).amax() / due.amax();
    let errors = [
        error(&own.a, whole.view((0, 0), (6, 6)).into_owned()),
        error(&own.b, whole.view((0, 6), (6, 1)).into_owned()),
    ];
    assert!(errors.iter().all(|error| *error < 1e-11), "{errors:?}");
}

/// Largest error of a reduced model over frequencies, over its bound: at most one, and not idle.
#[test]
fn a_reduced_model_stays_within_its_bound() {
    let model = paper(30.0, NODES, &[&DAMPING[..], &VISCOELASTIC].concat());
    let linear = linear(&model, 30.0, &["pressure", "force_z"], &["tip_x", "tip_z", "tip_angle"]);
    let mut closest = 0.0_f64;
    for order in [1, 2, 4, 6, 10] {
        let small = linear.modal.reduced(order).expect("it decays");
        let poles = small.matrices.modal().expect("poles of its own");
        assert!(poles.slowest_decay() < 0.0);
        let mut share = 0.0_f64;
        for k in 0..=600 {
            let s = Complex::new(0.0, TAU * 10f64.powf(-2.0 + 0.01 * f64::from(k)));
            let error = (linear.modal.response(s) - poles.response(s)).map(|x| x.norm());
            share = share.max(error.component_div(&small.error_bound).max());
        }
        println!(
            "{order} states: {share:.3} of the bound, pressure to tip_z {:.2e} m/psi",
            small.error_bound[(1, 0)] * PSI
        );
        assert!(share <= 1.0, "{order} states: {share} of the bound");
        closest = closest.max(share);
    }
    assert!(closest > 0.1, "{closest}: a bound that nothing comes near says nothing");
}

/// A step of 30 to 40 psi is no small motion: how far the linear models of both ends and of the middle are off at the end
/// and at the peak, per cent, is what the guide says.
#[test]
fn a_large_step_of_pressure_is_off_by_a_part() {
    let effects = [&DAMPING[..], &VISCOELASTIC].concat();
    let hold = paper(30.0, NODES, &effects);
    let rest = equilibrium(&hold, None).expect("it hangs");
    let posture = System::new(&hold).assembly.posture(&rest.q, &vec![0.0; rest.q.len()]);
    let run = Run { initial: Initial::Posture(posture), ..Run::release(8.0, 200.0) };
    let path = simulate(&under(&[(0.0, 30.0 * PSI), (1e-3, 40.0 * PSI)], &effects), &run);
    let z: Vec<f64> = path.tip_z().iter().map(|z| z - path.tip_z()[0]).collect();
    let most = |values: &[f64]| values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let end = |values: &[f64]| values[values.len() - 1];
    for (psi, due) in [(30.0, [43.6, 33.1]), (35.0, [4.5, 9.5]), (40.0, [-34.0, -16.5])] {
        let linear = linear(&paper(psi, NODES, &effects), psi, &["pressure"], &["tip_z"]);
        let own: Vec<f64> = path.times.iter().map(|t| linear.modal.step(*t)[(0, 0)] * 10.0 * PSI).collect();
        let off = [end(&own) / end(&z) - 1.0, most(&own) / most(&z) - 1.0].map(|x| 100.0 * x);
        println!("from {psi} psi: {:.2} mm at the end, linear off by {off:.1?} %", 1e3 * end(&z));
        assert!(
            off.iter().zip(due).all(|(off, due)| (off - due).abs() < 1.0),
            "{psi} psi: {off:?}, due {due:?}"
        );
    }
}

#[test]
fn what_cannot_be_linearised_is_refused() {
    let model = paper(30.0, NODES, &[]);
    let fails = |inputs: &[&str], outputs: &[&str]| {
        linearise(&model, None, inputs, outputs).expect_err("refused").to_string()
    };
    assert!(fails(&["presure"], &["tip_z"]).contains("did you mean `pressure`"));
    assert!(fails(&["force_z"], &["tip_zz"]).contains("did you mean `tip_z`"));
    assert!(fails(&["force_z"], &["point_1.5_z"]).contains("no such output"));
    assert!(fails(&["pressure"], &["tip_z"]).contains("no muscle"));
    assert!(fails(&["rod.length"], &["tip_z"]).contains("no input"));
    assert!(fails(&["release.angle"], &["tip_z"]).contains("does not move"));
    assert!(fails(&["force_z", "force_z"], &["tip_z"]).contains("once"));
    assert!(fails(&[], &["tip_z"]).contains("at least one"));
    let undamped = linear(&model, 30.0, &["force_z"], &["tip_z"]);
    assert!(matches!(undamped.modal.reduced(4), Err(LinearError::NoDecay { .. })));
    let damped = linear(&paper(30.0, NODES, &DAMPING), 30.0, &["force_z"], &["tip_z"]);
    assert!(matches!(damped.modal.reduced(0), Err(LinearError::Order { .. })));
    assert!(matches!(damped.modal.reduced(1000), Err(LinearError::Order { .. })));
}

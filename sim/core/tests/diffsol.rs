//! diffsol's methods on the rod: they converge to one another and to ours, keep their order, end their steps on
//! stops, and solve their stages with the right tangents.

use std::sync::Arc;

use efam_core::integrate::{self, Control, Effort, IntegrateError, Integrator, Method, State, Steps};
use models::effects::Rod;
use models::model::{Model, ModelSpec, Schedule, Scheme};
use models::system::System;

const INCH: f64 = 0.0254;
const METHODS: [Method; 2] = [Method::TrBdf2, Method::Esdirk34];

/// The muscle of the paper with 32 nodes and its end fitting, let go horizontally.
fn muscle(effects: &[(&str, &[(&str, f64)])]) -> ModelSpec {
    let mut all: Vec<(&str, &[(&str, f64)])> = vec![
        ("end_fitting", &[("mass", 0.05492), ("center_of_mass", 0.662 * INCH)]),
        ("rayleigh_mass", &[("alpha", 1.0)]),
    ];
    all.extend(effects);
    let named = |(name, values): (&str, &[(&str, f64)])| {
        (name.to_owned(), values.iter().map(|(key, value)| ((*key).to_owned(), *value)).collect())
    };
    ModelSpec {
        nodes: 32,
        rod: Rod {
            length: 0.20295,
            mass: 0.14227 * 6.69 * INCH,
            bending_stiffness: 0.00709,
            axial_stiffness: 16.0 * 0.01112 / ((1.06 * INCH).powi(2) + (0.98 * INCH).powi(2)),
            diameter: 1.02 * INCH,
            pressure: 0.0,
        },
        base_angle: 0.0,
        release_angle: 0.0,
        release_rate: 0.0,
        scheme: Scheme::Consistent,
        tip_distance: 0.0168,
        effects: all.into_iter().map(named).collect(),
        catalogue: Default::default(),
        schedule: None,
    }
}

/// There is no answer after a while.
struct Broken;

impl Schedule for Broken {
    fn factors(&self, time: f64, _since: f64) -> [[f64; 3]; 4] {
        let stiffness = if time > 0.05 { f64::NAN } else { 1.0 };
        [1.0, stiffness, 1.0, 1.0].map(|value| [value, 0.0, 0.0])
    }
    fn breakpoints(&self) -> &[f64] {
        &[]
    }
}

/// Five nodes without any fast motion and with memory; the rod stiffens as time goes on.
fn soft() -> ModelSpec {
    let mut spec = muscle(&[("viscoelastic", &[("branch_stiffness", 0.5), ("relaxation_time", 0.05)])]);
    spec.nodes = 5;
    spec.rod.axial_stiffness = 30.0;
    spec.rod.bending_stiffness = 0.02;
    spec.schedule = Some(Arc::new(Stiffening));
    spec
}

struct Stiffening;

impl Schedule for Stiffening {
    fn factors(&self, time: f64, _since: f64) -> [[f64; 3]; 4] {
        [[1.0, 0.0, 0.0], [1.0 + 8.0 * time, 8.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    }
    fn breakpoints(&self) -> &[f64] {
        &[]
    }
}

fn start(model: &Model, method: Method, control: Control) -> Box<dyn Integrator> {
    let mut system = System::new(model);
    let (q, v) = system.assembly.straight(0.0, 0.0);
    let mut z = vec![0.0; model.memory()];
    system.relax_memory(0.0, &q, &mut z);
    integrate::start(method, model, State { time: 0.0, q, v, z }, control).unwrap()
}

fn control(tolerance: f64) -> Control {
    Control { tolerance, most_steps: 1_000_000, ..Control::default() }
}

/// Makes a step towards the next of the stops; at the last one none.
fn advance(run: &mut dyn Integrator, stops: &[f64]) -> Result<(), IntegrateError> {
    let time = run.state().time;
    run.advance(*stops.iter().find(|stop| **stop > time).unwrap_or(&stops[stops.len() - 1]))
}

/// Positions of the end body every 10 ms.
fn path(model: &Model, method: Method, control: Control, end: f64) -> (Vec<[f64; 2]>, Effort) {
    let mut run = start(model, method, control);
    let mut at = run.state().clone();
    let mut path = Vec::new();
    let last = 2 * model.edges;
    while run.state().time < end {
        run.advance(end).unwrap();
        while path.len() as f64 * 0.01 <= run.state().time {
            run.interpolate(path.len() as f64 * 0.01, &mut at);
            path.push([at.q[last - 2], at.q[last - 1]]);
        }
    }
    (path, run.effort())
}

fn rms(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sum();
    (sum / a.len() as f64).sqrt()
}

#[test]
fn the_standard_case_converges() {
    let model = Model::new(&muscle(&[])).unwrap();
    let (tight, _) = path(&model, Method::Esdirk34, control(1e-8), 5.0);
    for method in METHODS {
        let [loose, finer] =
            [1e-5, 1e-6].map(|tolerance| rms(&path(&model, method, control(tolerance), 5.0).0, &tight));
        assert!(loose < 5e-5 && finer < 0.4 * loose, "{method:?}: {loose} m, then {finer} m");
    }
    let ours = rms(&path(&model, Method::Rodas4, control(3e-5), 5.0).0, &tight);
    assert!(ours < 5e-5, "{ours} m");
}

#[test]
fn with_memory_and_drag_all_implicit_methods_agree_and_newton_is_quick() {
    let effects: &[(&str, &[(&str, f64)])] = &[
        ("viscoelastic", &[("branch_stiffness", 0.5), ("relaxation_time", 0.05)]),
        ("air_drag", &[("drag_coefficient", 2.0)]),
        ("rayleigh_stiffness", &[("beta", 1e-4)]),
        ("clamp_compliance", &[("compliance", 0.5)]),
    ];
    let model = Model::new(&muscle(effects)).unwrap();
    let [(a, effort), (b, _)] = [(Method::TrBdf2, 1e-7), (Method::Esdirk34, 1e-7)]
        .map(|(m, tolerance)| path(&model, m, control(tolerance), 1.0));
    assert!(rms(&a, &b) < 2e-6, "{} m apart", rms(&a, &b));
    // Ours shares with them the equations, and neither the formulas of its stages nor its error control.
    let (ours, _) = path(&model, Method::Rodas4, control(1e-7), 1.0);
    assert!(rms(&a, &ours) < 2e-6, "{} m apart", rms(&a, &ours));
    // Two stages a step, three iterations a stage with a tangent that is up to five steps old.
    assert!(effort.newton_iterations < 6 * effort.steps, "{effort:?}");
    assert!(effort.rejected < effort.steps / 20, "{effort:?}");
}

/// Fixed steps, with memory, in a rod that changes with time, and with a stop between two steps.
#[test]
fn both_methods_keep_their_order() {
    let model = Model::new(&soft()).unwrap();
    let end = |method, step| {
        let control = Control { steps: Steps::Fixed(step), ..control(1e-13) };
        let mut run = start(&model, method, control);
        while run.state().time < 0.2 {
            advance(&mut *run, &[0.0997, 0.2]).unwrap();
        }
        run.state().clone()
    };
    let exact = end(Method::Esdirk34, 1.25e-4 / 64.0);
    for (method, order) in [(Method::TrBdf2, 2.0), (Method::Esdirk34, 3.0)] {
        let error = |step| -> f64 {
            let found = end(method, step);
            let pairs = found.q.iter().chain(&found.z).zip(exact.q.iter().chain(&exact.z));
            pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        let errors: Vec<f64> = (0..4).map(|k| error(1.25e-4 / f64::from(1 << k))).collect();
        let slopes: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
        for slope in slopes {
            assert!((slope - order).abs() < 0.2, "{method:?}: {errors:?}, order {slope}");
        }
    }
}

#[test]
fn steps_end_on_stops_and_the_run_on_the_last() {
    let model = Model::new(&soft()).unwrap();
    let stops = [0.05, 0.05 + 1e-6, 0.1, 0.1 + 1e-14, 0.13];
    for method in METHODS {
        let mut run = start(&model, method, control(1e-5));
        let mut ends = vec![0.0];
        let mut at = run.state().clone();
        while run.state().time < 0.13 {
            advance(&mut *run, &stops).unwrap();
            assert_eq!(run.step_start(), *ends.last().unwrap());
            ends.push(run.state().time);
            run.interpolate(run.state().time, &mut at);
            let gap = at.q.iter().zip(&run.state().q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(gap < 1e-12, "{gap} m between a step's end and its interpolant");
        }
        for stop in [0.05, 0.05 + 1e-6, 0.1, 0.13] {
            assert!(ends.contains(&stop), "{method:?}: {ends:?}");
        }
        let sliver = ends.iter().position(|end| *end == 0.05 + 1e-6).unwrap();
        let next = ends[sliver + 1] - ends[sliver];
        assert!(next > 1e-4, "{method:?}: after the short way between two stops a step of only {next} s");
        let (state, effort) = (run.state().clone(), run.effort());
        advance(&mut *run, &stops).unwrap();
        assert_eq!((run.state(), run.effort()), (&state, effort));
    }
}

#[test]
fn a_run_that_cannot_go_on_says_so() {
    let model = Model::new(&soft()).unwrap();
    let mut run = start(&model, Method::TrBdf2, Control { most_steps: 3, ..control(1e-5) });
    let failure = (0..10).find_map(|_| run.advance(1.0).err()).unwrap();
    assert!(matches!(failure, IntegrateError::TooManySteps { steps: 3, .. }), "{failure}");
    assert_eq!(run.advance(1.0), Err(failure));

    let (mut q, v) = System::new(&model).assembly.straight(0.0, 0.0);
    q[3] = f64::NAN;
    let state = State { time: 0.0, q, v, z: vec![0.0; model.memory()] };
    let failure = integrate::start(Method::TrBdf2, &model, state, control(1e-5)).err().unwrap();
    assert!(matches!(failure, IntegrateError::NotFinite { .. }), "{failure}");

    let model = Model::new(&ModelSpec { schedule: Some(Arc::new(Broken)), ..soft() }).unwrap();
    for method in METHODS {
        let mut run = start(&model, method, control(1e-5));
        let failure = (0..1000).find_map(|_| run.advance(1.0).err()).unwrap();
        assert!(
            matches!(failure, IntegrateError::Stalled { time, .. } if (time - 0.05).abs() < 1e-3),
            "{failure}"
        );
        let mut at = run.state().clone();
        run.interpolate(0.049, &mut at);
        assert_eq!(&at, run.state());
    }
}

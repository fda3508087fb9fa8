use models::{effects::Rod, model::*};
use sim::integrate::*;
fn cpu() -> f64 {
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .unwrap()
        .split(' ')
        .next()
        .unwrap()
        .parse::<f64>()
        .unwrap()
        * 1e-6
}
fn model(nodes: usize, beta: f64) -> Model {
    let inch = 0.0254;
    let d = (1.06 * inch, 0.98 * inch);
    let ea = 16.0 * 0.01112 / (d.0 * d.0 + d.1 * d.1);
    Model::new(&ModelSpec {
        nodes,
        rod: Rod {
            length: 7.99 * inch,
            mass: 0.14227 * 6.69 * inch,
            bending_stiffness: 0.00709,
            axial_stiffness: ea,
            diameter: d.0,
        },
        base_angle: 0.0,
        release_angle: 0.0,
        release_rate: 0.0,
        root: Root::Consistent,
        tip_distance: 0.662 * inch,
        effects: vec![
            ("end_fitting".into(), vec![("mass".into(), 0.05492), ("center_of_mass".into(), 0.662 * inch)]),
            ("rayleigh_mass".into(), vec![("alpha".into(), 1.0)]),
            ("rayleigh_stiffness".into(), vec![("beta".into(), beta)]),
        ],
        schedule: None,
    })
    .unwrap()
}
fn run(model: &Model, method: Method, tol: f64, fixed: Option<f64>) -> (Vec<[f64; 2]>, Effort, f64) {
    let system = models::system::System::new(model);
    let (q, v) = system.assembly.straight(0.0, 0.0);
    let s = State { time: 0.0, q, v, z: vec![0.0; model.memory()] };
    let mut out = s.clone();
    let begin = cpu();
    let mut st = start(
        method,
        model,
        s,
        Control { tolerance: tol, fixed_step: fixed, stops: vec![20.0], most_steps: 10_000_000 },
    );
    let mut tip = vec![];
    for k in 0..=2000 {
        let t = k as f64 * 0.01;
        while st.state().time < t - 1e-12 {
            st.advance().unwrap();
        }
        st.interpolate(t, &mut out);
        let n = model.dof();
        tip.push([out.q[n - 3], out.q[n - 2]]);
    }
    (tip, st.effort(), cpu() - begin)
}
fn main() {
    for beta in [0.0, 1e-3] {
        for nodes in [33] {
            let m = model(nodes, beta);
            let (r, e, ms) = run(&m, Method::Rodas5p, 1e-8, None);
            println!("ref {ms:.0} ms {e:?} end {:?}", r[2000]);
            let (r2, _, _) = run(&m, Method::Rodas4, 1e-7, None);
            let rms = |a: &[[f64; 2]], b: &[[f64; 2]]| {
                (a.iter().zip(b).map(|(a, b)| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sum::<f64>()
                    / a.len() as f64)
                    .sqrt()
                    * 1e3
            };
            println!("refs differ {:.2e} mm", rms(&r, &r2));
            for method in [Method::Rodas4, Method::Rodas5p] {
                for tol in [3e-3, 1e-3, 3e-4, 1e-4, 3e-5] {
                    let mut best = f64::MAX;
                    let mut res = None;
                    for _ in 0..3 {
                        let x = run(&m, method, tol, None);
                        best = best.min(x.2);
                        res = Some(x);
                    }
                    let (t, e, _) = res.unwrap();
                    println!(
                        "beta {beta} n {nodes} {method:?} {tol:.0e}: {best:.1} ms rms {:.4} mm steps {} rej {}",
                        rms(&t, &r),
                        e.steps,
                        e.rejected
                    );
                }
            }
        }
    }
}

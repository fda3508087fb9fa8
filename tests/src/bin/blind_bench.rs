//! Blind bench of the diagnosis: experiments drawn by the twin, with one effect hidden in each or none,
//! are diagnosed, and what is said is counted.
//!
//! `cargo run --release -p tests --bin blind_bench -- [FIRST SEED] [SETS OF EACH]`

use std::time::Instant;

use models::model::Model;
use sim::calibrate::{Nuisances, Parameter, Prior, Problem, Scope, Trial};
use sim::diagnose::{Settings, Verdict, diagnose};
use sim::forward::Run;
use tests::twin::drawn::{Drawn, Plan};
use tests::twin::hidden::Hidden;

fn main() {
    let numbers: Vec<u64> = std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let (first, sets) = (numbers.first().copied().unwrap_or(1), numbers.get(1).copied().unwrap_or(1));
    for (name, hidden) in KINDS {
        for seed in first..first + sets {
            let drawn = Plan::usual(hidden).draw(seed);
            let problem = problem(&drawn);
            let begin = Instant::now();
            match diagnose(&problem, &Settings::default(), &|_| ()) {
                Ok(outcome) => report(name, seed, &outcome.diagnosis, begin.elapsed().as_secs_f64()),
                Err(error) => println!("{name:18} {seed:4}  {error}"),
            }
        }
    }
}

fn report(name: &str, seed: u64, diagnosis: &sim::diagnose::Diagnosis, seconds: f64) {
    let said: Vec<&str> = match diagnosis.verdict {
        Verdict::NothingMissing => vec!["nothing"],
        Verdict::Unknown => vec!["unknown"],
        _ => diagnosis.effects.iter().map(|added| added.effect.as_str()).collect(),
    };
    let members: Vec<&str> = diagnosis.members.iter().map(|member| member.effect.as_str()).collect();
    let mean = |of: fn(&sim::diagnose::verdict::Gap) -> f64, held_out: bool| {
        let all: Vec<f64> = diagnosis.gap.iter().filter(|gap| gap.held_out == held_out).map(of).collect();
        all.iter().sum::<f64>() / all.len().max(1) as f64
    };
    println!(
        "{name:18} {seed:4}  {:40} class {:40} gap {:.3} to {:.3}, locked {:.3} to {:.3}  {seconds:.1} s",
        said.join(" + "),
        members.join(", "),
        mean(|gap| gap.before, false),
        mean(|gap| gap.after, false),
        mean(|gap| gap.before, true),
        mean(|gap| gap.after, true),
    );
    let mut evidence: Vec<_> = diagnosis.evidence.iter().filter(|evidence| evidence.round == 1).collect();
    evidence.sort_by(|a, b| b.score.total_cmp(&a.score));
    for evidence in evidence.iter().take(6) {
        println!(
            "      {:20} score {:7.2} of {:.2}  promises {:8.1}  keeps {:8.1}  strength {:.3e}  {}",
            evidence.effect,
            evidence.score,
            diagnosis.thresholds[0],
            evidence.predicted_decrease,
            evidence.realised_decrease.unwrap_or(f64::NAN),
            evidence.strength,
            evidence.rejected.as_deref().unwrap_or("chosen"),
        );
    }
}

/// What is hidden, at sizes that stand out.
const KINDS: &[(&str, &[Hidden])] = &[
    ("nothing", &[]),
    ("air_drag", &[Hidden::AirDrag { drag_coefficient: 1.1 }]),
    ("braid_friction", &[Hidden::BraidFriction { moment: 2e-4 }]),
    ("viscoelastic", &[Hidden::Viscoelastic { branch_stiffness: 0.1, relaxation_time: 0.2 }]),
    ("cubic_stiffness", &[Hidden::CubicStiffness { coefficient: 5e-4 }]),
    ("clamp_compliance", &[Hidden::ClampCompliance { compliance: 0.3 }]),
    ("hysteresis", &[Hidden::Hysteresis { loss_factor: 0.03 }]),
];

/// The middle pressure and one release more are locked away.
fn problem(drawn: &Drawn) -> Problem {
    let pressures: Vec<f64> = drawn.releases.iter().filter_map(|drawn| drawn.release.pressure).collect();
    let middle = {
        let mut sorted = pressures.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    };
    let last = drawn.releases.len() - 1;
    let trial = |(k, drawn): (usize, &tests::twin::drawn::DrawnRelease)| {
        let mut release = drawn.release.clone();
        release.held_out = release.pressure == Some(middle) || k == last;
        let duration = release.time.last().copied().unwrap_or(0.0);
        let model = Model::new(&drawn.nominal).expect("the paper's muscle");
        Trial { release, model, run: Run::release(duration, 100.0) }
    };
    let trials: Vec<Trial> = drawn.releases.iter().enumerate().map(trial).collect();
    // A balance: to a per cent, level within.
    let weighed = |path: &str| {
        let model = &trials[0].model;
        let mean = model.theta[model.index(path).expect("there")];
        let prior = Some(Prior { mean, deviation: 0.01 * mean / 3f64.sqrt() });
        Parameter { prior, ..Parameter::new(path, Scope::Shared) }
    };
    let parameters = vec![
        Parameter::new("rod.bending_stiffness", Scope::PerPressure),
        Parameter::new("effects.rayleigh_mass.alpha", Scope::Shared),
        Parameter::new("effects.rayleigh_stiffness.beta", Scope::Shared),
        weighed("rod.mass"),
        weighed("effects.end_fitting.mass"),
    ];
    let nuisances =
        Nuisances { release_instant: true, hold_angle: Some(0.25f64.to_radians()), offset: Some(2e-4) };
    Problem { trials, parameters, nuisances }
}

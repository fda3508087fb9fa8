//! Goal: the answer of a diagnosis depends on its data and its budget of work alone, to the last bit.
//! Setup: a release of the twin with hidden air drag, two candidates; one thread, two threads, and two
//! threads that wait at every report of progress, which changes the order of the work as a busy machine does. Budgets
//! that end the search before its first round, later, and not at all.
//! Expected: the same text of `diagnosis.json`, the count of work included; what a budget cut off is listed.

use std::thread::sleep;
use std::time::Duration;

use efam_inference::diagnose::verdict::CutBy;
use efam_inference::diagnose::{Diagnosis, DiagnosisSettings, Verdict, diagnose};
use models::effects::CATALOGUE;
use tests::blind::all_fitted;
use tests::twin::drawn::Plan;
use tests::twin::hidden::Hidden;

const CANDIDATES: [&str; 2] = ["air_drag", "tip_mass"];

fn answer(budget: u64, threads: usize, is_slowed: bool) -> Diagnosis {
    let hidden = [Hidden::named("air_drag", 1.0).expect("it is known")];
    let plan = Plan { pressures: vec![40.0], angles: vec![0.0], duration: 3.0, ..Plan::usual(&hidden) };
    let problem = all_fitted(&plan.draw(921));
    let names = CATALOGUE.iter().map(|effect| effect.about().name);
    let excluded = names.filter(|name| !CANDIDATES.contains(name)).map(str::to_owned).collect();
    let settings = DiagnosisSettings { excluded, budget, ..DiagnosisSettings::default() };
    // Some parts wait longer than others.
    let wait = |what: &str| {
        if is_slowed {
            sleep(Duration::from_millis(what.len() as u64 % 7));
        }
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| diagnose(&problem, &settings, &wait)).expect("it can be diagnosed").diagnosis
}

fn text(diagnosis: &Diagnosis) -> String {
    serde_json::to_string(diagnosis).expect("it has a JSON")
}

#[test]
#[ignore = "long; .ci/thorough runs it"]
fn threads_and_load_change_no_bit_of_an_answer() {
    let usual = DiagnosisSettings::default().budget;
    let whole = answer(usual, 2, false);
    assert!(!whole.rounds.is_empty(), "{}", whole.summary);
    assert!(whole.cut_short.is_none() && whole.node_steps > 0, "{:?}", whole.cut_short);
    // Nothing but the baseline; a part of the search; all of it.
    let [none, some] = [0.0, 0.4].map(|share| (share * whole.node_steps as f64) as u64);
    let cut = [none, some].map(|budget| answer(budget, 2, false));
    for (budget, first) in [(none, &cut[0]), (some, &cut[1]), (usual, &whole)] {
        for (threads, is_slowed) in [(1, false), (2, true)] {
            let other = answer(budget, threads, is_slowed);
            assert_eq!(text(first), text(&other), "budget {budget}, {threads} threads");
        }
    }
    for (budget, found) in [none, some].into_iter().zip(&cut) {
        let Some(cut) = &found.cut_short else { panic!("{budget}: {}", found.summary) };
        println!("{budget} of {}: {} {:?} {cut:?}", whole.node_steps, found.node_steps, found.summary);
        assert_eq!(cut.by, CutBy::Budget);
        assert!(found.node_steps >= budget && found.node_steps < whole.node_steps, "{}", found.node_steps);
    }
    let none = &cut[0];
    assert_eq!((none.verdict, none.effects.len()), (Verdict::Unknown, 0), "{}", none.summary);
}

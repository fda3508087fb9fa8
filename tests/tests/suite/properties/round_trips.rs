//! Goal: what is written can be read again, to the same bits.
//! Setup: the paper's muscle at any pressure and angle with up to five effects of the catalogue, each parameter
//! anywhere within its range or at its scale, given as text in a scenario.
//! Expected: each number is the one that was given, and the scenario as it is written beside results, given again,
//! makes the same model and run, and is written as before.

use std::path::Path;

use efam_experiments::scenario::{Case, Scenario};
use models::effects::{CATALOGUE, Kind, Parameter};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

use super::cases;

const MUSCLE: &str = "[muscle]\nname = \"garbulinski-2022\"\npressure = \"15 psi\"\n";

/// The case of a scenario; none where no hand can hold the rod, which softens without end, at its angle.
fn one(text: &str, overrides: &[String]) -> Option<Case> {
    let scenario = Scenario::parse(Path::new("drawn.toml"), text, overrides);
    match scenario.and_then(|scenario| scenario.cases()) {
        Ok(mut cases) => Some(cases.remove(0)),
        Err(error) => {
            assert!(error.to_string().contains("no equilibrium found"), "{error}\n{overrides:?}");
            None
        }
    }
}

/// A value within the range of a parameter, and of what is plausible where that is known.
fn value(parameter: &Parameter, share: f64) -> f64 {
    let (low, high) = parameter.plausible.unwrap_or((-parameter.scale, parameter.scale));
    let (low, high) = (low.max(parameter.range.0), high.min(parameter.range.1));
    (low + share * (high - low)).clamp(low, high)
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn a_scenario_is_written_as_it_was_run(
        psi in 5.0..100.0f64,
        angle in -90.0..90.0f64,
        drawn in vec((any::<Index>(), 0.0..1.0f64), 0..=5),
    ) {
        let all: Vec<_> = CATALOGUE.iter().map(|effect| effect.about()).collect();
        let all: Vec<_> = all.into_iter().filter(|about| !matches!(about.kind, Kind::Description)).collect();
        let mut overrides = vec![format!("muscle.pressure={psi:?} psi"), format!("release.angle={angle:?} deg")];
        let mut given = Vec::new();
        for (index, share) in &drawn {
            let about = index.get(&all);
            for parameter in about.parameters {
                let (path, value) = (format!("effects.{}.{}", about.name, parameter.name), value(parameter, *share));
                overrides.push(format!("{path}={value:?} {}", parameter.unit).trim_end().to_owned());
                given.retain(|(other, _)| *other != path);
                given.push((path, value));
            }
        }
        let case = one(MUSCLE, &overrides);
        prop_assume!(case.is_some());
        let case = case.expect("assumed");
        for (path, value) in &given {
            if let Ok(k) = case.model.index(path) {
                prop_assert_eq!(case.model.theta[k].to_bits(), value.to_bits(), "{}", path);
            }
        }
        let again = one(&case.resolved(), &[]).expect("as it was run");
        let bits = |case: &Case| case.model.theta.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&again), bits(&case), "{}", case.resolved());
        let paths = |case: &Case| case.model.parameters.iter().map(|own| own.path.clone()).collect::<Vec<_>>();
        prop_assert_eq!(paths(&again), paths(&case));
        prop_assert_eq!((again.run.duration, &again.run.samples), (case.run.duration, &case.run.samples));
        prop_assert_eq!(again.resolved(), case.resolved());
    }
}

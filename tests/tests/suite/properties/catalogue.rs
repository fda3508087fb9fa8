//! What every registered effect keeps, whoever wrote it: the tests are functions of an effect, in `models::check`, which
//! `efam effects --check` runs over a law as text.

use models::check::TESTS;
use models::effects::CATALOGUE;
use models::model::{Model, ModelSpec};
use tests::paper_spec;

/// Frictions have steep derivatives, which differences see only where they turn round smoothly; these, the gradient, and
/// the whole catalogue at once are in models/tests/derivatives.rs.
const OF_DIFFERENCES: [&str; 2] =
    ["derivatives match differences", "the force at rest is the gradient of the energy"];

#[test]
fn all_keep_what_effects_keep() {
    let mut wrong = Vec::new();
    for effect in CATALOGUE {
        for (what, test) in TESTS.iter().filter(|(what, _)| !OF_DIFFERENCES.contains(what)) {
            wrong
                .extend(test(*effect).err().map(|error| format!("{}: {what}: {error}", effect.about().name)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Spec of the shared muscle with nothing added, so that the helper of those tests is seen to add.
#[test]
fn the_baseline_is_in_every_model() {
    let model = Model::new(&ModelSpec { ..paper_spec(40.0, 8, &[]) }).expect("valid");
    for name in models::model::BASELINE {
        assert!(model.effect(name).is_some(), "{name}");
    }
}

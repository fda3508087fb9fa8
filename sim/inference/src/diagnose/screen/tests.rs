use std::ops::ControlFlow;

use efam_core::example::muscle_at_15_psi;
use efam_core::forward::{Run, forward};
use efam_experiments::release::{Point as Place, Track};

use super::super::DiagnosisSettings;
use super::super::extension::effects;
use super::super::setup::{nothing, trials};
use super::*;
use crate::calibrate::{Nuisances, Problem, Trial};
use crate::example::release;

/// The slope at zero is what a small strength makes, over it; those of all effects come from models that have many.
#[test]
fn slopes_at_zero_are_those_of_small_strengths() {
    let (model, run) = (muscle_at_15_psi(), Run::release(2.0, 100.0));
    let path = forward(&model, &run, &mut |_| ControlFlow::Continue(())).unwrap();
    let tip = Track {
        marker: "tip".to_owned(),
        at: Place::Tip,
        position: path.tip.iter().map(|tip| Some(*tip)).collect(),
        noise: 1e-4,
        discrepancy: 0.0,
    };
    let trial = Trial { release: release(path.times, vec![tip]), model, run };
    let problem =
        Problem { trials: vec![trial.into()], parameters: Vec::new(), nuisances: Nuisances::default() };
    let trials = trials(&problem, true).unwrap();
    let (data, _) = Data::of(&trials, None, None);
    let before = nothing(&problem, trials, &data.all()).unwrap();
    let at = Point::of(&data, &before, before.start()).unwrap();
    let groups = effects(&before, &DiagnosisSettings::default());
    let origin = Origin::of(&data, &before, &at, &groups);
    for (group, slopes) in groups.iter().zip(&origin.slopes) {
        let own = &group.extensions[0];
        let Some(slopes) = slopes else {
            assert!(group.candidate.as_ref().unwrap().strength.is_friction, "{}", own.name);
            continue;
        };
        // Errors of the integrator hide what a very small strength does, and a large one is not linear.
        let difference = |strength: f64| {
            let mut z = own.hypothesis.start();
            own.strengths.iter().for_each(|place| z[*place] = strength);
            let there = data.compare_with(&own.hypothesis, &z, &at.seen).unwrap();
            let due = &Secants::between(&at.seen, &there, strength).samples[0];
            (&slopes.samples[0] - due).norm() / due.norm()
        };
        let least = difference(0.01).min(difference(0.1));
        assert!(least < 0.4, "{}: {least}", own.name);
    }
}

//! Derivatives of the equations of motion against central differences, with every effect of the
//! catalogue switched on, at a posture and velocities of no symmetry.

use models::check::{State, force_is_gradient, parameters_match_differences, tangents_match_differences};
use models::effects::{About, CATALOGUE, Rod};
use models::model::{Model, ModelSpec, Scheme};
use models::system::{System, TimePass};

const NODES: usize = 6;

/// A model with every effect, at its default or, where that is off, at half its scale.
fn model_with_everything(scheme: Scheme) -> Model {
    model_with(scheme, |_| true)
}

/// The same with some of them.
fn model_with(scheme: Scheme, chosen: impl Fn(&About) -> bool) -> Model {
    let effects = CATALOGUE.iter().filter(|effect| chosen(effect.about())).map(|effect| {
        let about = effect.about();
        let values = about.parameters.iter().map(|p| {
            // Friction turns round smoothly here: sharply it is a step to central differences.
            let value = match p.default {
                _ if p.name == "creep_rate" => 20.0,
                default if Some(default) == p.null_value || default == 0.0 => 0.5 * p.scale,
                default => default,
            };
            (p.name.to_owned(), value)
        });
        (about.name.to_owned(), values.collect())
    });
    Model::new(&ModelSpec {
        nodes: NODES,
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
        release_rate: 0.3,
        scheme,
        tip_distance: 0.0168,
        effects: effects.collect(),
        catalogue: Default::default(),
        schedule: None,
    })
    .unwrap()
}

/// Both ways of one implicit step: with memory condensed, and from the full Jacobian.
#[test]
fn tangents_and_condensed_memory_match_differences() {
    for root in [Scheme::Consistent, Scheme::Paper] {
        let model = model_with_everything(root);
        assert!(model.memory() > 0);
        tangents_match_differences(&model, &State::of(&model)).unwrap();
    }
}

#[test]
fn derivatives_by_every_parameter_match_differences() {
    let model = model_with_everything(Scheme::Consistent);
    parameters_match_differences(&model, &State::of(&model)).unwrap();
}

/// The force of a state at rest is the gradient of its energy: all laws agree with their energies. Not
/// so friction: its moment works on its memory, which holds the energy and moves with the bend.
#[test]
fn force_at_rest_is_the_gradient_of_energy() {
    let friction = ["dahl", "braid_friction", "friction_over_pressure", "clamp_friction", "hysteresis"];
    let model = model_with(Scheme::Consistent, |about| !friction.contains(&about.name));
    force_is_gradient(&model, &State::of(&model)).unwrap();
}

#[test]
fn dissipated_power_is_never_negative_and_vanishes_at_rest() {
    let model = model_with(Scheme::Consistent, |about| !about.timed);
    let mut s = State::of(&model);
    let mut system = System::new(&model);
    let mut pass = TimePass::new(&model);
    let (lost, supplied) = system.powers(&mut pass, 0.1, &s.q, &s.v, &s.z);
    assert!(lost > 0.0, "{lost}");
    assert_eq!(supplied, 0.0);
    s.v.fill(0.0);
    system.relax_memory(0.1, &s.q, &mut s.z);
    let (lost, _) = system.powers(&mut pass, 0.1, &s.q, &s.v, &s.z);
    assert!(lost.abs() < 1e-15, "{lost}");
}

/// What observers show of each effect adds up to what acts: no force is shown twice or not at all,
/// the clamp's moment included.
#[test]
fn forces_of_effects_add_up() {
    let model = model_with_everything(Scheme::Consistent);
    let s = State::of(&model);
    let mut system = System::new(&model);
    let (mut force, mut rate) = (vec![0.0; model.dof()], vec![0.0; model.memory()]);
    let each = system.effect_forces(0.1, &s.q, &s.v, &s.z);
    system.force(0.1, &s.q, &s.v, &s.z, &mut force, &mut rate);
    let all = system.assembly.fields.node_forces(&system.assembly.context);
    for (i, total) in all.iter().enumerate() {
        for k in 0..2 {
            let (sum, scale) = each.iter().fold((0.0, 0.0), |(sum, scale): (f64, f64), (_, nodes)| {
                (sum + nodes[i][k], scale + nodes[i][k].abs())
            });
            assert!((sum - total[k]).abs() <= 1e-12 * scale, "node {i}: {sum} against {}", total[k]);
        }
    }
}

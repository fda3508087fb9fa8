//! Where a run comes to rest, and how it swings about it: what statics says, for reports.

use models::error::ModelError;
use models::model::Model;
use models::statics::{Equilibrium, Mode, equilibrium_at, modes};
use models::system::System;

/// The posture in which a model hangs.
#[derive(Clone, Debug)]
pub struct Rest {
    /// Node positions in W, m, shape `[N+1]`.
    pub nodes: Vec<[f64; 2]>,
    /// The observed tip in W, m.
    pub tip: [f64; 2],
    /// Angle of the end body, rad.
    pub tip_angle: f64,
    /// Bending moment at the root, N m; positive where the rod is bent towards +z.
    pub root_moment: f64,
    /// Whether the rod comes back when it is pushed.
    pub stable: bool,
    /// Undamped frequency, Hz, and damping ratio of the slowest modes. Friction sticks in them.
    pub modes: Result<Vec<(f64, f64)>, ModelError>,
    /// Unit vector in W along which the observed tip moves in the slowest mode; none without modes, or where it does not
    /// move.
    pub first_direction: Option<[f64; 2]>,
}

/// Undamped frequency, Hz, and damping ratio.
fn in_hertz(mode: &Mode) -> (f64, f64) {
    (mode.angular_frequency / std::f64::consts::TAU, mode.damping_ratio)
}

/// Undamped frequency, Hz, and damping ratio of the slowest modes of the rod whose friction slips, about the rest
/// without it under the pressure of a time, s: none where the rod has no friction, empty where they are not found.
pub fn slipping_modes(model: &Model, time: f64, count: usize) -> Option<Vec<(f64, f64)>> {
    let slipping = model.slipping()?;
    Some(rest(&slipping, time, count).and_then(|rest| rest.modes).unwrap_or_default())
}

/// The rest under the pressure and the loads of a time, s, and `count` modes about it.
///
/// ```
/// use efam_core::models::model::Model;
/// use efam_core::models::muscle::{Extrapolation, Muscle};
/// use efam_core::rest::rest;
///
/// let muscle = Muscle::built_in("garbulinski-2022")?;
/// let model = Model::new(&muscle.spec(&muscle.at(100e3, "pder_32", Extrapolation::Refused)?))?;
/// let rest = rest(&model, 0.0, 2)?;
/// let (frequency, _) = rest.modes?[0];
/// println!("hangs {:.1} mm below the clamp, swings at {frequency:.2} Hz", -1e3 * rest.tip[1]);
/// # assert!(rest.stable && rest.tip[1] < -0.1 && (1.0..2.0).contains(&frequency), "{frequency}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// # Errors
/// [`ModelError::Equilibrium`], or a pressure at which there is no rod.
pub fn rest(model: &Model, time: f64, count: usize) -> Result<Rest, ModelError> {
    let found = equilibrium_at(model, time, None)?;
    let at_rest = vec![0.0; found.q.len()];
    let mut system = System::at_rest(model);
    let posture = system.assembly.posture(&found.q, &at_rest);
    let (tip, _) = system.observed_tip(&found.q, &at_rest);
    let root_moment = root_moment(&mut system, &found);
    let modes = modes(model, &found, count);
    let first = modes.as_ref().ok().and_then(|modes| modes.first());
    let first_direction = first.and_then(|mode| {
        let [x, z] = system.observed_tip(&found.q, &mode.shape).1;
        let length = x.hypot(z);
        (length > 0.0).then(|| [x / length, z / length])
    });
    Ok(Rest {
        nodes: posture.nodes,
        tip,
        tip_angle: posture.angle,
        root_moment,
        stable: found.stable,
        modes: modes.map(|modes| modes.iter().map(in_hertz).collect()),
        first_direction,
    })
}

/// Frequency of the slowest mode about the rest, Hz; none where there is no rest.
pub(crate) fn slowest_frequency(model: &Model) -> Option<f64> {
    let (slowest, _) = *rest(model, 0.0, 1).ok()?.modes.ok()?.first()?;
    (slowest.is_finite() && slowest > 0.0).then_some(slowest)
}

/// Bending moment at the root in an equilibrium of a system, N m; positive where the rod is bent towards +z.
pub fn root_moment(system: &mut System, at: &Equilibrium) -> f64 {
    system.root_moment(at.time, &at.q, &vec![0.0; at.q.len()], &at.z)
}

#[cfg(test)]
mod tests {
    use models::effects::Rod;
    use models::model::ModelSpec;

    use super::*;

    /// A hand that lets go in a tenth of a second bears a rod at the release, and not twenty of these times later.
    #[test]
    fn a_hand_that_has_let_go_bears_nothing() {
        let rod = Rod {
            length: 0.2,
            mass: 0.02,
            bending_stiffness: 5e-3,
            axial_stiffness: 500.0,
            diameter: 0.02,
            pressure: 0.0,
        };
        let free = ModelSpec { nodes: 12, ..ModelSpec::of(rod) }.with(&[("gravity.acceleration", 9.81)]);
        let hand = [("hand_release.force", 0.1), ("hand_release.release_time", 0.1)];
        let height = |spec: &ModelSpec, time: f64| {
            let rest = rest(&Model::new(spec).unwrap(), time, 1).unwrap();
            (rest.tip[1], rest.root_moment, rest.modes.unwrap()[0].0)
        };
        let (held, free_rest) = (free.clone().with(&hand), height(&free, 0.0));
        let late = height(&held, 2.0);
        assert!((late.0 - free_rest.0).abs() < 1e-7, "{late:?} {free_rest:?}");
        assert!((late.1 / free_rest.1 - 1.0).abs() < 1e-6 && (late.2 / free_rest.2 - 1.0).abs() < 1e-6);
        assert!(height(&held, 0.0).0 > free_rest.0 + 0.01);
    }
}

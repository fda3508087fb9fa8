//! Tip drag: the air resists whatever sits at the tip, with the square of its speed.
//!
//! Law:      F = −½ ρ C_d A |v| v
//!
//!   F       force on the end body, at the last node    N
//!   ρ       density of the air                         kg/m³
//!   C_d A   drag coefficient times frontal area        m²
//!   v       velocity of the last node                  m/s
//!
//! Assumes:  Still air, quasi-steady flow, and the same area from all sides.
//! Off:      drag_area = 0.
//! Silent:   In the limit, small swings: the loss is of third order.
//! Source:   Morison's drag term, Morison et al. (1950); coefficients of blunt bodies, 0.4 to 1.2 on
//!           the frontal area: Hoerner (1965), Fluid-Dynamic Drag, ch. 3.

use super::air_drag::AIR_DENSITY;
use super::{About, Kind, Law, Parameter, Place, Reach, Real, Separator, Tip, TipLoad};

/// Quadratic drag of a blunt body at the tip.
pub struct TipDrag;

impl Law for TipDrag {
    const ABOUT: About = About {
        name: "tip_drag",
        meaning: "the air resists whatever sits at the tip, with the square of its speed",
        kind: Kind::Dissipative,
        places: &[Place::Tip],
        memory: 0,
        timed: false,
        parameters: &[
            Parameter {
                name: "drag_area",
                meaning: "drag coefficient times frontal area of what sits at the tip",
                unit: "m^2",
                default: 1e-3,
                range: (0.0, 10.0),
                scale: 1e-3,
                off: Some(0.0),
                plausible: Some((0.0, 4e-3)),
                ..Parameter::PLAIN
            },
            AIR_DENSITY,
        ],
        looks_like: "the first large swings lose more than the later ones: one over the amplitude grows on a straight line",
        confounded_with: &["air_drag", "strain_rate_cubed"],
        separated_by: &[Separator::TipPlate],
        reach: Reach::Muscle,
    };

    fn tip<T: Real>(at: &Tip<T>, theta: &[T]) -> TipLoad<T> {
        let [x, z] = at.velocity;
        let square = x * x + z * z;
        // At rest the root has no slope, but the force, of second order, has: zero.
        let speed = if square.re() > 0.0 { square.sqrt() } else { T::from(0.0) };
        let resistance = theta[0] * theta[1] * speed * 0.5;
        TipLoad { force: [-resistance * x, -resistance * z], moment: T::from(0.0) }
    }
}

//! Air drag on the body: the air resists the motion of each edge across itself.
//!
//! Law:      f = −½ ρ C_d D |v_n| v_n
//!
//!   f     force across the edge, per length     N/m
//!   ρ     density of the air                    kg/m³
//!   C_d   drag coefficient                      –
//!   D     diameter, `rod.diameter`               m
//!   v_n   velocity across the edge, midpoint    m/s
//!
//! Assumes:  Still air, quasi-steady flow, nothing along the edge. At small swings (a path shorter
//!           than some five diameters) the flow is unsteady, and C_d is no longer a constant.
//! Off:      drag_coefficient = 0.
//! Silent:   Motion along the rod itself; in the limit, small swings: the loss is of third order.
//! Source:   Morison's drag term; C_d 1 to 1.2 for a smooth cylinder at Re 10³ to 10⁵, Hoerner
//!           (1965); cantilevers: Colin et al. (2020), 10.1016/j.jfluidstructs.2020.103056.

use super::{About, Flow, Kind, Law, Parameter, Place, Reach, Real, Separator, named};

/// Quadratic drag of a cylinder across the flow.
pub struct AirDrag;

/// Density of the air.
pub(super) const AIR_DENSITY: Parameter = Parameter {
    name: "air_density",
    meaning: "density of the air",
    unit: "kg/m^3",
    default: 1.2,
    range: (0.0, 2000.0),
    scale: 1.2,
    null_value: Some(0.0),
    ..Parameter::PLAIN
};

impl Law for AirDrag {
    const ABOUT: About = About {
        name: "air_drag",
        meaning: "the air resists the motion of each edge across itself, with the square of its speed",
        kind: Kind::Dissipative,
        places: &[Place::Flow],
        memory: 0,
        timed: false,
        parameters: &[
            Parameter {
                name: "drag_coefficient",
                meaning: "drag coefficient of the cross-section",
                unit: "",
                default: 1.1,
                range: (0.0, 10.0),
                scale: 1.0,
                null_value: Some(0.0),
                plausible: Some((0.0, 6.0)),
                ..Parameter::PLAIN
            },
            AIR_DENSITY,
        ],
        signature: "the first large swings lose more than the later ones: loss per cycle in proportion to amplitude",
        confounded_with: &["tip_drag", "rayleigh_mass"],
        separated_by: &[Separator::TipPlate, Separator::BodyMarkers, Separator::Angles],
        reach: Reach::Muscle,
    };

    fn flow<T: Real>(&self, at: &Flow<T>, theta: &[T]) -> [T; 2] {
        let [coefficient, density] = named(theta);
        let speed = at.normal_velocity.abs();
        let pressure = coefficient * density * speed * at.normal_velocity * 0.5;
        [T::from(0.0), -pressure * at.rod.diameter]
    }
}

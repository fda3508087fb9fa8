//! What a command line says of the release, over the scenario.

/// Of a blunt body. Source: Hoerner (1965), Fluid-Dynamic Drag, chapter 3: a cube, face on, 1.05.
const DRAG_COEFFICIENT: f64 = 1.05;

/// Payload, angle and duration of a release, SI; `None` leaves what the scenario says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReleaseOptions {
    /// Mass at the tip, kg.
    pub payload: Option<f64>,
    /// Centre of mass of the payload beyond the active length, m.
    pub payload_center: Option<f64>,
    /// Rotary inertia of the payload about that, kg m².
    pub payload_inertia: Option<f64>,
    /// Frontal area of the payload, m².
    pub frontal_area: Option<f64>,
    /// Angle of the straight rod above the horizontal, from which it is let go, rad.
    pub angle: Option<f64>,
    /// How long to simulate, s.
    pub duration: Option<f64>,
}

impl ReleaseOptions {
    /// The same as overrides of a scenario, each as `path=value`.
    pub fn overrides(&self) -> Vec<String> {
        let all = [
            ("release.angle", self.angle, "rad"),
            ("run.duration", self.duration, "s"),
            ("effects.payload.mass", self.payload, "kg"),
            ("effects.payload.center_of_mass", self.payload_center, "m"),
            ("effects.payload.rotary_inertia", self.payload_inertia, "kg m^2"),
            ("effects.tip_drag.drag_area", self.frontal_area.map(|area| DRAG_COEFFICIENT * area), "m^2"),
        ];
        let one = |(path, value, unit): (&str, Option<f64>, &str)| {
            value.map(|value| format!("{path}=\"{value:?} {unit}\""))
        };
        all.into_iter().filter_map(one).collect()
    }
}

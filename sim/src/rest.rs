//! What a scenario's rod does without being let go: its rest posture, and the small vibrations about it.

use efam_core::rest::{rest, root_moment, slipping_modes};
use efam_experiments::scenario::Case;
use efam_report::aligned::{Aligned, Side};
use models::error::ModelError;
use models::quantity::format_si;
use models::statics::equilibrium;
use models::system::System;
use schemars::JsonSchema;
use serde::Serialize;

/// The JSON output: rest postures.
#[derive(Serialize, JsonSchema)]
pub struct StaticsPrinted {
    /// One for each case of the scenario.
    pub statics: Vec<Resting>,
}

/// A rest posture; in W, SI.
#[derive(Serialize, JsonSchema)]
pub struct Resting {
    /// Name of the case.
    name: String,
    /// Pressure above ambient.
    pressure_pa: Option<f64>,
    /// Tip along the undeformed rod.
    tip_x_m: f64,
    /// Tip upwards.
    tip_z_m: f64,
    /// Angle of the end body from x towards z.
    tip_angle_rad: f64,
    /// Bending moment at the root.
    root_moment_n_m: f64,
    /// What is left of the forces.
    imbalance_n: f64,
    /// Iterations of the search.
    iterations: usize,
    /// Whether the posture is stable.
    stable: bool,
    /// Caveats of the numbers.
    warnings: Vec<String>,
}

/// The JSON output: vibrations about the rest.
#[derive(Serialize, JsonSchema)]
pub struct ModesPrinted {
    /// All modes of all cases of the scenario, slowest first.
    pub modes: Vec<Vibration>,
}

/// A small vibration about the rest.
#[derive(Serialize, JsonSchema)]
pub struct Vibration {
    /// Name of the case.
    name: String,
    /// Pressure above ambient.
    pressure_pa: Option<f64>,
    /// Its number, the slowest being 1.
    mode: usize,
    /// Undamped frequency.
    frequency_hz: f64,
    /// Share of critical damping.
    damping_ratio: f64,
    /// What friction does in it, if there is any: it sticks in the smallest vibrations, and slips in a swing.
    friction: Option<Friction>,
}

/// What friction does in a vibration.
#[derive(Clone, Copy, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Friction {
    /// It holds as a spring.
    Sticks,
    /// It holds nothing.
    Slips,
}

/// The rest posture of a case.
/// # Errors
/// None is found.
pub fn resting(case: &Case) -> Result<Resting, ModelError> {
    let rest = equilibrium(&case.model, None)?;
    let mut system = System::at_rest(&case.model);
    let at_rest = vec![0.0; rest.q.len()];
    let root_moment = root_moment(&mut system, &rest);
    let tip = system.observed_tip(&rest.q, &at_rest).0;
    Ok(Resting {
        name: case.name.clone(),
        pressure_pa: case.pressure,
        tip_x_m: tip[0],
        tip_z_m: tip[1],
        tip_angle_rad: rest.q[rest.q.len() - 1],
        root_moment_n_m: root_moment,
        imbalance_n: rest.imbalance,
        iterations: rest.iterations,
        stable: rest.stable,
        warnings: case.warnings.clone(),
    })
}

/// The slowest vibrations of a case about its rest.
/// # Errors
/// No rest is found.
pub fn vibrations(case: &Case, count: usize) -> Result<Vec<Vibration>, ModelError> {
    let modes = rest(&case.model, 0.0, count)?.modes?;
    let slipping = slipping_modes(&case.model, 0.0, count);
    let sticks = slipping.as_ref().map(|_| Friction::Sticks);
    let mut rows = Vec::new();
    for (modes, friction) in [(modes, sticks), (slipping.unwrap_or_default(), Some(Friction::Slips))] {
        for (index, (frequency_hz, damping_ratio)) in modes.into_iter().enumerate() {
            rows.push(Vibration {
                name: case.name.clone(),
                pressure_pa: case.pressure,
                mode: index + 1,
                frequency_hz,
                damping_ratio,
                friction,
            });
        }
    }
    Ok(rows)
}

fn aligned(numbers: &[&str]) -> Aligned {
    let numbers = numbers.iter().map(|head| (*head, Side::Number));
    Aligned::new(
        &[("", Side::Words)].into_iter().chain(numbers).chain([("", Side::Name)]).collect::<Vec<_>>(),
    )
}

impl StaticsPrinted {
    /// As people read it.
    pub fn table(&self) -> String {
        let mut table = aligned(&["tip x", "tip z", "end angle", "root moment"]);
        for row in &self.statics {
            table.row([
                row.name.clone(),
                format_si(row.tip_x_m, "m"),
                format_si(row.tip_z_m, "m"),
                format!("{:.2} deg", row.tip_angle_rad.to_degrees()),
                format_si(row.root_moment_n_m, "N m"),
                if row.stable { "" } else { "not stable" }.to_owned(),
            ]);
        }
        table.to_string()
    }
}

impl ModesPrinted {
    /// As people read it.
    pub fn table(&self) -> String {
        let mut table = aligned(&["mode", "frequency", "damping ratio"]);
        for row in &self.modes {
            let friction = match row.friction {
                Some(Friction::Sticks) => "friction sticks",
                Some(Friction::Slips) => "friction slips",
                None => "",
            };
            table.row([
                row.name.clone(),
                row.mode.to_string(),
                format_si(row.frequency_hz, "Hz"),
                format!("{:.4}", row.damping_ratio),
                friction.to_owned(),
            ]);
        }
        table.to_string()
    }
}

//! A muscle whose pressure is changed while it swings, one step at a time; then it picks up a payload.
//!
//! `cargo run --release -p efam-core --example steer` prints where the tip is ten times a second.

use std::error::Error;

use efam_core::initial::Initial;
use efam_core::models::model::{Model, ModelSpec};
use efam_core::models::muscle::{Extrapolation, Muscle};
use efam_core::stepper::Stepper;

/// Between two commands, s.
const STEP: f64 = 0.01;

/// The pressure that a regulator must hold, Pa: from 100 to 400 kPa in the second second.
fn commanded(time: f64) -> f64 {
    100e3 + 300e3 * (time - 1.0).clamp(0.0, 1.0)
}

fn main() -> Result<(), Box<dyn Error>> {
    let muscle = Muscle::built_in("garbulinski-2022")?;
    let rod = |pressure: f64| {
        muscle.at(pressure, "pder_32", Extrapolation::Refused).map(|at| (muscle.rod(&at), muscle.spec(&at)))
    };
    let (_, spec) = rod(commanded(0.0))?;
    let damping = [("rayleigh_mass.alpha", 2.0), ("rayleigh_stiffness.beta", 2e-3)];
    let model = Model::new(&ModelSpec { nodes: 16, ..spec }.with(&damping))?;
    let mut stepper = Stepper::new(&model, Initial::Straight.state(&model)?)?;
    println!("time/s  pressure/kPa  tip_x/mm  tip_z/mm");
    for command in 0..=500 {
        let time = stepper.state().time;
        if command % 10 == 0 {
            let [x, z] = stepper.tip().position.map(|x| 1e3 * x);
            println!("{time:6.2}  {:12.1}  {x:8.1}  {z:8.1}", 1e-3 * commanded(time));
        }
        stepper.set_rod(&rod(commanded(time))?.0)?;
        if command == 300 {
            stepper.set("payload.mass", 0.02)?;
        }
        stepper.step(STEP)?;
    }
    Ok(())
}

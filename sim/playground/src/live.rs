//! A rod that swings while its sliders are moved.

use efam_core::integrate::{Control, Method, State};
use efam_core::models::model::Model;
use efam_core::models::muscle::Muscle;
use efam_core::models::system::System;
use efam_core::stepper::Stepper;
use serde::Serialize;

use crate::error::PlaygroundError;
use crate::setup::Setup;

/// How fast a pressure follows its slider, Pa/s: 50 psi in a second, as a regulator and its hose may do.
const FILLING: f64 = 345e3;
/// Longest step of one request, s.
const MOST_STEP: f64 = 1.0;
/// Error admitted in a step: the tip stays within 0.05 mm rms, which no screen shows.
const TOLERANCE: f64 = 3e-5;

/// A rod in motion.
pub struct Live {
    stepper: Stepper,
    setup: Setup,
    muscle: Option<Muscle>,
    /// Pressure now, Pa.
    pressure: f64,
}

/// What a page draws.
#[derive(Clone, Debug, Serialize)]
pub struct Frame {
    /// Time since the release, s.
    pub time: f64,
    /// Pressure now, Pa.
    pub pressure: f64,
    /// Node positions, m.
    pub nodes: Vec<[f64; 2]>,
    /// Observed tip, m.
    pub tip: [f64; 2],
    /// Its velocity, m/s.
    pub tip_velocity: [f64; 2],
    /// Kinetic, elastic and potential energy, J.
    pub energy: [f64; 3],
    /// Steps of the integrator since the release.
    pub steps: usize,
}

impl Live {
    /// Lets a rod go.
    pub fn let_go(setup: &Setup) -> Result<Self, PlaygroundError> {
        let model = setup.model()?;
        let state = setup.initial(&model)?.state(&model)?;
        Ok(Self {
            stepper: stepper(&model, state)?,
            muscle: setup.muscle()?,
            pressure: setup.pressure,
            setup: setup.clone(),
        })
    }

    /// Makes it another rod where it is: its place, velocity and memories stay. The pressure follows in the steps.
    pub fn change(&mut self, setup: &Setup) -> Result<(), PlaygroundError> {
        let muscle = setup.muscle()?;
        // What another muscle or another mesh was doing is not known.
        if setup.muscle != self.setup.muscle || setup.nodes != self.setup.nodes {
            *self = Self::let_go(setup)?;
            return Ok(());
        }
        let pressure = if muscle.is_some() { self.pressure } else { setup.pressure };
        let now = Setup { pressure, ..setup.clone() };
        let model = now.model()?;
        let paths = |model: &Model| model.parameters.iter().map(|p| p.path.clone()).collect::<Vec<_>>();
        if paths(&model) == paths(self.stepper.model()) {
            let names = paths(&model);
            let values: Vec<_> = names.iter().map(String::as_str).zip(model.theta.iter().copied()).collect();
            self.stepper.set_all(&values)?;
        } else {
            self.stepper = stepper(&model, carried(&self.stepper, &model))?;
        }
        (self.setup, self.muscle, self.pressure) = (setup.clone(), muscle, pressure);
        Ok(())
    }

    /// Goes on for a duration, s.
    pub fn step(&mut self, duration: f64) -> Result<(), PlaygroundError> {
        if !(0.0..=MOST_STEP).contains(&duration) {
            let (low, high) = (0.0, MOST_STEP);
            return Err(PlaygroundError::OutOfRange { name: "duration", value: duration, low, high });
        }
        if let Some(muscle) = self.muscle.as_ref().filter(|_| self.pressure != self.setup.pressure) {
            let most = FILLING * duration;
            let pressure = self.pressure + (self.setup.pressure - self.pressure).clamp(-most, most);
            let values = self.setup.at_pressure(muscle, pressure)?;
            let values: Vec<_> = values.iter().map(|(path, value)| (path.as_str(), *value)).collect();
            self.stepper.set_all(&values)?;
            self.pressure = pressure;
        }
        self.stepper.step(duration)?;
        Ok(())
    }

    /// What is to be drawn.
    pub fn frame(&mut self) -> Frame {
        let energy = self.stepper.energy();
        let tip = self.stepper.tip();
        Frame {
            time: self.stepper.state().time,
            pressure: self.pressure,
            nodes: self.stepper.nodes().to_vec(),
            tip: tip.position,
            tip_velocity: tip.velocity,
            energy: [energy.kinetic, energy.elastic, energy.potential],
            steps: self.stepper.effort().steps,
        }
    }
}

fn stepper(model: &Model, state: State) -> Result<Stepper, PlaygroundError> {
    let control = Control { tolerance: TOLERANCE, ..Control::default() };
    Ok(Stepper::with(model, state, Method::Auto, control)?)
}

/// The state of a rod as one of a model with other effects: those that both have keep their memories.
fn carried(from: &Stepper, model: &Model) -> State {
    let (before, State { time, q, v, z }) = (from.model(), from.state());
    let posture = System::new(before).assembly.posture(q, v);
    let mut system = System::new(model);
    let (q, v) = system.assembly.coordinates(&posture);
    let mut memory = vec![0.0; model.memory()];
    system.relax_memory(*time, &q, &mut memory);
    for active in &model.effects {
        if let Some(old) = before.effect(active.effect.about().name) {
            memory[active.memory.clone()].copy_from_slice(&z[old.memory.clone()]);
        }
    }
    State { time: *time, q, v, z: memory }
}

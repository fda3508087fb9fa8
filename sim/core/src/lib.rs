//! A planar elastic rod, clamped at one end, with a rigid body at the other: how it moves in time, where it rests, and
//! how both depend on its parameters.
//!
//! ```text
//! q̇ = v,    M v̇ = f(q, v, z, t; θ),    ż = g(q, v, z, t; θ)
//! ```
//!
//! `q` are the positions of the nodes, then centre of mass and angle of the end body; `M` is constant and diagonal; `f`
//! sums the laws of the effects that the model has: bending, stretch, weight, drag, damping and some forty more; `z` is
//! what they remember; `θ` is the list of all parameters. Dual numbers give the tangents and `∂f/∂θ`. Units are SI,
//! angles rad from x towards z, the clamp is the origin.
//!
//! The muscle of the paper at 100 kPa, let go level, for two seconds:
//!
//! ```
//! use std::ops::ControlFlow;
//!
//! use efam_core::forward::{Run, forward};
//! use efam_core::models::model::Model;
//! use efam_core::models::muscle::{Extrapolation, Muscle};
//!
//! let muscle = Muscle::built_in("garbulinski-2022")?;
//! let at = muscle.at(100e3, "pder_32", Extrapolation::Refused)?;
//! let model = Model::new(&muscle.spec(&at).with(&[("rayleigh_mass.alpha", 1.0), ("rayleigh_stiffness.beta", 1e-3)]))?;
//! let trajectory = forward(&model, &Run::release(2.0, 100.0), &mut |_| ControlFlow::Continue(()))?;
//! let lowest = trajectory.trace.lowest().ok_or("no trace")?;
//! println!("lowest after {:.3} s, {:.1} mm below the clamp", lowest.time, -1e3 * lowest.tip[1]);
//! # assert!((lowest.time - 0.305).abs() < 0.01 && (lowest.tip[1] + 0.185).abs() < 0.002, "{lowest:?}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | to … | take |
//! |---|---|
//! | run from a start to an end | [`forward::forward`] with a [`run::Run`]; a [`trajectory::Trajectory`] comes out |
//! | go on step by step, and change parameters between | [`stepper::Stepper`] |
//! | have a linear model for a controller | [`linear::linearise`] |
//! | differentiate a run by parameters | [`run::Run::sensitivities`] |
//! | find where the rod hangs, and how it swings there | [`rest::rest`], or [`models::statics`] |
//! | know how wrong a run is, and have mesh and tolerance chosen | [`accuracy::settle`] |
//! | fit parameters to a path | [`levenberg_marquardt::minimise`] |
//! | make a model | [`models::model::ModelSpec`]; a muscle makes its own: [`models::muscle::Muscle::spec`] |
//!
//! # Features
//! None is on by default. `diffsol`: TR-BDF2 and ESDIRK34, to compare with our own methods. `parallel`: the runs that
//! estimate errors on two threads. `schema`: JSON schemas of what can be written.

pub use models;

pub mod accuracy;
pub mod example;
pub mod forward;
pub mod initial;
pub mod integrate;
pub mod left_out;
pub mod levenberg_marquardt;
pub mod limits;
pub mod linear;
pub mod loss;
mod observed;
pub mod pace;
pub mod point;
pub mod quantile;
pub mod rest;
pub mod run;
pub mod stepper;
pub mod trajectory;
pub mod work;

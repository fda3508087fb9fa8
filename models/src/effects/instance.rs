//! Laws that have a self: what the loops over the rod are written over. A [`Law`] of the catalogue has nothing in it;
//! one that is [read from text](crate::written) has its formulas.

use std::marker::PhantomData;

use super::about::{About, Place};
use super::law::{
    Bend, Body, Edge, Flow, Law, Line, LineMass, Mass, MassLoad, Moment, Release, Sight, Tip, TipLoad,
};
use crate::real::Real;
use crate::rod::Rod;

/// The laws of an effect; each method as that of [`Law`] of the same name.
pub trait Instance: Sync + 'static {
    /// Where it can act at all: no loop is compiled for other places.
    const PLACES: &'static [Place];

    /// What the catalogue knows.
    fn about(&self) -> &'static About;
    /// Its page.
    fn page(&self) -> String;
    /// The text that it was read from, if it was.
    fn text(&self) -> Option<&str> {
        None
    }
    /// Whether it needs the diameter elsewhere than in the flow, where it shows by itself.
    fn needs_diameter(&self) -> bool {
        false
    }

    /// Moment at a bend.
    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T>;
    /// Energy stored at a bend, J/m.
    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T;
    /// Tension in an edge, N.
    fn edge<T: Real>(&self, at: &Edge<T>, theta: &[T]) -> T;
    /// Energy stored in an edge, J/m.
    fn edge_energy<T: Real>(&self, at: &Edge<T>, theta: &[T]) -> T;
    /// Force on an edge from outside, tangential and normal, N/m.
    fn flow<T: Real>(&self, at: &Flow<T>, theta: &[T]) -> [T; 2];
    /// Load that goes with mass.
    fn mass<T: Real>(&self, at: &Mass<T>, theta: &[T]) -> MassLoad<T>;
    /// Load on the end body.
    fn tip<T: Real>(&self, at: &Tip<T>, theta: &[T]) -> TipLoad<T>;
    /// Potential energy of that load, J.
    fn tip_energy<T: Real>(&self, at: &Tip<T>, theta: &[T]) -> T;
    /// Rotational compliance of the clamp, rad/(N m).
    fn clamp<T: Real>(&self, theta: &[T]) -> T;

    /// Body at the end of the active length.
    fn body<T: Real>(&self, _theta: &[T]) -> Body<T> {
        let zero = T::from(0.0);
        Body { mass: zero, heavy: zero, center_of_mass: zero, offset: zero, rotary_inertia: zero }
    }
    /// How much further out all bodies at the end lie, m.
    fn shift<T: Real>(&self, _theta: &[T]) -> T {
        T::from(0.0)
    }
    /// Mass that moves with a metre of the rod.
    fn inertia<T: Real>(&self, _at_release: &Rod<T>, _theta: &[T]) -> LineMass<T> {
        let zero = T::from(0.0);
        LineMass { inert: zero, heavy: zero }
    }
    /// Where an observed point is seen, m.
    fn sensor<T: Real>(&self, at: &Sight<T>, _theta: &[T]) -> [T; 2] {
        at.position
    }
    /// Time since release of an instant of the recording, s.
    fn clock<T: Real>(&self, recorded: T, _theta: &[T]) -> T {
        recorded
    }
    /// Pressure in the rod, Pa, and its rate, Pa/s.
    fn line<T: Real>(&self, at: &Line<T>, _theta: &[T]) -> [T; 2] {
        [at.command + at.command_rate * at.time, at.command_rate]
    }
    /// Time after which it begins to follow its command, s.
    fn dead_time<T: Real>(&self, _theta: &[T]) -> T {
        T::from(0.0)
    }
    /// What is added to the start.
    fn release<T: Real>(&self, _theta: &[T]) -> Release<T> {
        let zero = T::from(0.0);
        Release { angle: zero, angular_velocity: zero }
    }
}

/// A law of the catalogue with the text of its file, whose `//!` lines are its page.
pub struct Fixed<L> {
    source: &'static str,
    law: PhantomData<fn() -> L>,
}

impl<L: Law> Fixed<L> {
    /// A law and the text of its file.
    pub const fn new(source: &'static str) -> Self {
        Self { source, law: PhantomData }
    }
}

impl<L: Law> Instance for Fixed<L> {
    const PLACES: &'static [Place] = L::ABOUT.places;

    fn about(&self) -> &'static About {
        &L::ABOUT
    }
    fn page(&self) -> String {
        let lines = self.source.lines().map_while(|line| line.strip_prefix("//!"));
        let text: Vec<_> = lines.map(|line| line.strip_prefix(' ').unwrap_or(line)).collect();
        text.join("\n")
    }
    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        L::bend(at, theta)
    }
    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        L::bend_energy(at, theta)
    }
    fn edge<T: Real>(&self, at: &Edge<T>, theta: &[T]) -> T {
        L::edge(at, theta)
    }
    fn edge_energy<T: Real>(&self, at: &Edge<T>, theta: &[T]) -> T {
        L::edge_energy(at, theta)
    }
    fn flow<T: Real>(&self, at: &Flow<T>, theta: &[T]) -> [T; 2] {
        L::flow(at, theta)
    }
    fn mass<T: Real>(&self, at: &Mass<T>, theta: &[T]) -> MassLoad<T> {
        L::mass(at, theta)
    }
    fn tip<T: Real>(&self, at: &Tip<T>, theta: &[T]) -> TipLoad<T> {
        L::tip(at, theta)
    }
    fn tip_energy<T: Real>(&self, at: &Tip<T>, theta: &[T]) -> T {
        L::tip_energy(at, theta)
    }
    fn clamp<T: Real>(&self, theta: &[T]) -> T {
        L::clamp(theta)
    }
    fn body<T: Real>(&self, theta: &[T]) -> Body<T> {
        L::body(theta)
    }
    fn shift<T: Real>(&self, theta: &[T]) -> T {
        L::shift(theta)
    }
    fn inertia<T: Real>(&self, at_release: &Rod<T>, theta: &[T]) -> LineMass<T> {
        L::inertia(at_release, theta)
    }
    fn sensor<T: Real>(&self, at: &Sight<T>, theta: &[T]) -> [T; 2] {
        L::sensor(at, theta)
    }
    fn clock<T: Real>(&self, recorded: T, theta: &[T]) -> T {
        L::clock(recorded, theta)
    }
    fn line<T: Real>(&self, at: &Line<T>, theta: &[T]) -> [T; 2] {
        L::line(at, theta)
    }
    fn dead_time<T: Real>(&self, theta: &[T]) -> T {
        L::dead_time(theta)
    }
    fn release<T: Real>(&self, theta: &[T]) -> Release<T> {
        L::release(theta)
    }
}

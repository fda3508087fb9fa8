//! The rod and its end body at one time, as laws and stencil see them.

use crate::effects::law::Body;
use crate::real::Real;
use crate::rod::Rod;
use crate::stencil::Stencil;

/// What the laws and the stencil take from the parameters at one time.
#[derive(Clone, Debug)]
pub struct Context<T> {
    /// Number of edges `N`.
    pub edges: usize,
    /// One over it.
    pub per_edges: f64,
    /// Time since release, s.
    pub time: T,
    /// The rod as it is now.
    pub rod: Rod<T>,
    /// All parameters, in the order of the model.
    pub theta: Vec<T>,
    /// Direction of the clamp.
    pub base_axis: [T; 2],
    /// The rigid end body, the last half cell of the rod included: its centre of mass is measured
    /// from the last node along the body axis.
    pub body: Body<T>,
    /// All else of the end body.
    pub fixed: Body<T>,
    /// Mass of an interior node, kg.
    pub node_mass: T,
    /// The part of it that has no weight, kg.
    pub weightless_mass: T,
    /// The same of the end body; its mass and centre alone mean anything.
    pub weightless_body: Body<T>,
    /// Rest length of an edge, m.
    pub rest_length: T,
    /// How fast it grows over itself, 1/s: a strain that is counted against it falls at that rate.
    pub rest_rate: T,
    /// One over the rest length, 1/m.
    pub per_rest_length: T,
    /// One over the Voronoi length of each bend, 1/m, shape `[N+1]`.
    pub per_voronoi: Vec<T>,
    /// From turning angles to curvatures.
    pub stencil: Stencil<T>,
}

impl<T: Real> Context<T> {
    /// Length over which the bends of the rod stand, m: the active length, and half an edge more with
    /// the paper's root.
    pub fn bent_length(&self) -> T {
        self.per_voronoi.iter().fold(T::from(0.0), |sum, per| sum + per.recip())
    }
}

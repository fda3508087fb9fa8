//! The rod and its end body at one time, as laws and stencil see them.

use crate::effects::law::Body;
use crate::line::Through;
use crate::number::Number;
use crate::pack::{Pack, RODS};
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
    /// The pressure behind a line, of a rod whose pressure is commanded over time.
    pub(crate) line: Option<Through<T>>,
}

impl<T: Number> Context<T> {
    /// Length of rod that bends, m: the active length, and half an edge more with the paper's root.
    pub fn bent_length(&self) -> T {
        self.per_voronoi.iter().fold(T::from(0.0), |sum, per| sum + per.recip())
    }
}

impl Context<Pack> {
    /// What geometry and matrices take of several rods with equal meshes; laws see each rod's own context.
    pub(crate) fn of(rods: [&Context<f64>; RODS]) -> Self {
        let each = |of: &dyn Fn(&Context<f64>) -> f64| Pack(rods.map(of));
        let body = |of: &dyn Fn(&Context<f64>) -> Body<f64>| Body {
            mass: each(&|rod| of(rod).mass),
            heavy: each(&|rod| of(rod).heavy),
            center_of_mass: each(&|rod| of(rod).center_of_mass),
            offset: each(&|rod| of(rod).offset),
            rotary_inertia: each(&|rod| of(rod).rotary_inertia),
        };
        let first = rods[0];
        Self {
            edges: first.edges,
            per_edges: first.per_edges,
            time: each(&|rod| rod.time),
            rod: Rod {
                length: each(&|rod| rod.rod.length),
                mass: each(&|rod| rod.rod.mass),
                bending_stiffness: each(&|rod| rod.rod.bending_stiffness),
                axial_stiffness: each(&|rod| rod.rod.axial_stiffness),
                diameter: each(&|rod| rod.rod.diameter),
                pressure: each(&|rod| rod.rod.pressure),
            },
            theta: Vec::new(),
            base_axis: [0, 1].map(|k| each(&|rod| rod.base_axis[k])),
            body: body(&|rod| rod.body),
            fixed: body(&|rod| rod.fixed),
            node_mass: each(&|rod| rod.node_mass),
            weightless_mass: each(&|rod| rod.weightless_mass),
            weightless_body: body(&|rod| rod.weightless_body),
            rest_length: each(&|rod| rod.rest_length),
            rest_rate: each(&|rod| rod.rest_rate),
            per_rest_length: each(&|rod| rod.per_rest_length),
            per_voronoi: (0..=first.edges).map(|bend| each(&|rod| rod.per_voronoi[bend])).collect(),
            stencil: Stencil::of(rods.map(|rod| &rod.stencil)),
            line: None,
        }
    }
}

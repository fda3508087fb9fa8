//! The points of a beam at which hidden effects act.

use super::beam::Beam;
use super::element::{FOUR, THREE, along, hermite};
use super::hidden::Hidden;

/// Which vectors of a point matter, and for what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Gradient and its derivative, for bending.
    Strain {
        /// Number among its like.
        point: usize,
        /// Distance from the clamp over the length.
        share: f64,
    },
    /// Position and gradient, for what the surroundings do.
    Flow,
    /// Position and gradient of the rod's end.
    Tip,
    /// Gradient in the clamp.
    Clamp,
}

/// A point, and how its two vectors follow from the coordinates of its element.
#[derive(Clone, Debug)]
pub struct Site {
    /// What it is for.
    pub place: Place,
    /// First coordinate of the element.
    pub begin: usize,
    /// Factors of the coordinates in each vector.
    pub shapes: [[f64; 4]; 2],
    /// Length that the point represents, m, or one.
    pub weight: f64,
}

impl Site {
    fn new(beam: &Beam, place: Place, e: usize, xi: f64, weight: f64) -> Self {
        let [shape, first, second] = hermite(xi, beam.element_length());
        let shapes = match place {
            Place::Flow | Place::Tip => [shape, first],
            Place::Strain { .. } | Place::Clamp => [first, second],
        };
        Self { place, begin: 4 * e, shapes, weight }
    }

    /// Its two vectors, from coordinates or from their rates.
    pub fn pair(&self, x: &[f64]) -> [[f64; 2]; 2] {
        let [first, second] = &self.shapes;
        [along(first, &x[self.begin..]), along(second, &x[self.begin..])]
    }
}

/// Where these effects act.
pub fn sites(beam: &Beam, hidden: &[Hidden]) -> Vec<Site> {
    let (elements, length) = (beam.elements, beam.element_length());
    let any = |acts: &dyn Fn(&Hidden) -> bool| hidden.iter().any(acts);
    let mut sites = Vec::new();
    if any(&Hidden::bends) {
        for (e, (i, (xi, weight))) in
            (0..elements).flat_map(|e| THREE.into_iter().enumerate().map(move |p| (e, p)))
        {
            let share = (e as f64 + xi) / elements as f64;
            let place = Place::Strain { point: THREE.len() * e + i, share };
            sites.push(Site::new(beam, place, e, xi, weight * length));
        }
    }
    if any(&Hidden::flows) {
        for (e, (xi, weight)) in (0..elements).flat_map(|e| FOUR.map(|point| (e, point))) {
            sites.push(Site::new(beam, Place::Flow, e, xi, weight * length));
        }
    }
    if any(&Hidden::pulls) {
        sites.push(Site::new(beam, Place::Tip, elements - 1, 1.0, 1.0));
    }
    if any(&|effect| effect.clamp_compliance() > 0.0) {
        sites.push(Site::new(beam, Place::Clamp, 0, 0.0, 1.0));
    }
    sites
}

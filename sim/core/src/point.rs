//! A point of a rod that is observed.

/// A point that a marker observes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Point {
    /// The observed tip of the model, [`models::model::Model::tip_distance`] beyond the last node.
    Tip,
    /// A point of the rod's axis, as a share of the active length, 0 at the clamp.
    Along(f64),
}

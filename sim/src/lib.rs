//! What we do with the models.

pub mod observe;

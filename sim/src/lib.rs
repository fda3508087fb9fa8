//! What we do with the models.

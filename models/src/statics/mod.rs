//! stub
#![allow(missing_docs)]
pub mod euler_bernoulli;

use crate::error::ModelError;
use crate::model::Model;
pub struct Equilibrium {
    pub q: Vec<f64>,
    pub z: Vec<f64>,
}
pub fn equilibrium(_m: &Model, _s: Option<&[f64]>) -> Result<Equilibrium, ModelError> {
    unimplemented!()
}

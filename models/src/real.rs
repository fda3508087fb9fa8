//! The scalar over which all mechanics is written.

use num_dual::DualNum;

/// The scalar that laws are written over: `f64`, or a dual number that carries derivatives.
pub trait Real: DualNum<Primitive = f64> + Copy {}
impl<T: DualNum<Primitive = f64> + Copy> Real for T {}

//! Numbers that carry their derivatives: by a few parameters at once, or by time.

use nalgebra::SVector;
use num_dual::{Derivative, Dual64};

use crate::effects::{LANES, Lanes};

/// A number with its rate.
pub type Moving = Dual64;

/// A number with its derivatives.
pub fn with_slopes(value: f64, slopes: [f64; LANES]) -> Lanes {
    Lanes::new(value, Derivative::some(slopes.into()))
}

/// The derivatives of a number.
pub fn slopes(x: &Lanes) -> [f64; LANES] {
    x.eps.0.map_or([0.0; LANES], |eps| eps.data.0[0])
}

/// Parameters that know themselves: each of the `watched`, an index into `theta`, has the derivative
/// one in each lane that is its own; all other derivatives are zero.
pub fn seeded(theta: &[f64], watched: &[Option<usize>]) -> Vec<Lanes> {
    let mut seeded: Vec<Lanes> = theta.iter().map(|value| Lanes::from(*value)).collect();
    for (lane, k) in watched.iter().enumerate() {
        if let Some(k) = *k {
            let mut unit = SVector::from(slopes(&seeded[k]));
            unit[lane] = 1.0;
            seeded[k] = Lanes::new(theta[k], Derivative::some(unit));
        }
    }
    seeded
}

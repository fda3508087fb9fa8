//! Normal random numbers.

use rand_xoshiro::rand_core::RngCore;

/// A standard normal number. Source: Box and Muller (1958).
pub fn normal(random: &mut impl RngCore) -> f64 {
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let (u, v) = (1.0 - uniform(), uniform());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

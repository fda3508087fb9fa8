//! The normal distribution, and random numbers.

use rand_xoshiro::rand_core::RngCore;

/// Its 97.5 % point: so many standard deviations to each side hold 95 %.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;

/// Its 95 % point.
pub const NORMAL_95_ONE_SIDED: f64 = 1.644_853_626_951_472_7;

/// Standard deviations from which on a difference is taken for one: one in 370 is larger by chance.
pub const CLEAR: f64 = 3.0;

/// A number from 0 to below 1, of 53 bits.
pub fn uniform(random: &mut impl RngCore) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// A standard normal number. Source: Box and Muller (1958).
pub fn normal(random: &mut impl RngCore) -> f64 {
    let (u, v) = (1.0 - uniform(random), uniform(random));
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

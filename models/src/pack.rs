//! One number of each of several rods, on which the processor works at once.

use std::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, Neg, Sub, SubAssign};

use crate::context::Context;
use crate::number::{Number, Plain};

/// Rods in a pack: two vectors of AVX2, or four of what every x86-64 has. Half of it leaves the processor waiting
/// for results of substitutions, twice as much leaves the nearest cache.
pub const RODS: usize = 8;

/// Whether models are simulated in packs: a page for a browser would carry every law twice, and runs one rod.
pub const HAS_PACKS: bool = !cfg!(target_family = "wasm");

/// A number of each of [`RODS`] rods. Each operation is that of `f64` on every rod: a rod has the same bits as alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub struct Pack(pub [f64; RODS]);

/// What laws see of the rods of a pack beside their posture: each alone, and all together.
pub struct Laid<'a> {
    /// Parameters of each rod.
    pub each: [&'a Context<f64>; RODS],
    /// What follows from them, together.
    pub all: &'a Context<Pack>,
}

impl From<f64> for Pack {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self([value; RODS])
    }
}

impl Index<usize> for Pack {
    type Output = f64;

    #[inline(always)]
    fn index(&self, rod: usize) -> &f64 {
        &self.0[rod]
    }
}

impl IndexMut<usize> for Pack {
    #[inline(always)]
    fn index_mut(&mut self, rod: usize) -> &mut f64 {
        &mut self.0[rod]
    }
}

macro_rules! operation {
    ($trait:ident, $name:ident, $sign:tt) => {
        impl $trait for Pack {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let mut result = self;
                for rod in 0..RODS {
                    result.0[rod] = self.0[rod] $sign other.0[rod];
                }
                result
            }
        }

        impl $trait<f64> for Pack {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: f64) -> Self {
                let mut result = self;
                for rod in 0..RODS {
                    result.0[rod] = self.0[rod] $sign other;
                }
                result
            }
        }
    };
}

operation!(Add, add, +);
operation!(Sub, sub, -);
operation!(Mul, mul, *);
operation!(Div, div, /);

impl AddAssign for Pack {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Pack {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Neg for Pack {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

impl Number for Pack {
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }
    #[inline(always)]
    fn recip(self) -> Self {
        self.map(f64::recip)
    }
    #[inline(always)]
    fn sin(self) -> Self {
        self.map(f64::sin)
    }
    #[inline(always)]
    fn cos(self) -> Self {
        self.map(f64::cos)
    }
}

impl Plain for Pack {
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut result = self;
        for x in &mut result.0 {
            *x = f(*x);
        }
        result
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        let mut result = self;
        for rod in 0..RODS {
            if other.0[rod] > self.0[rod] {
                result.0[rod] = other.0[rod];
            }
        }
        result
    }
    #[inline(always)]
    fn any(self, test: impl Fn(f64) -> bool) -> bool {
        let mut is_any = false;
        for x in self.0 {
            is_any |= test(x);
        }
        is_any
    }
}

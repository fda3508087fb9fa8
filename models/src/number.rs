//! Numbers that geometry and matrices are written over: of one rod or of several, with derivatives or without.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use num_dual::DualNum;

/// What kinematics needs of a number: an `f64`, a dual number, or a [`Pack`](crate::pack::Pack) of several rods.
///
/// Laws are written over [`Real`](crate::real::Real), which may branch on a value; geometry has no branches.
pub trait Number:
    Copy
    + Debug
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + AddAssign
    + SubAssign
{
    /// Square root.
    fn sqrt(self) -> Self;
    /// One over it.
    fn recip(self) -> Self;
    /// Sine.
    fn sin(self) -> Self;
    /// Cosine.
    fn cos(self) -> Self;
}

impl<T: DualNum<Primitive = f64> + Copy> Number for T {
    #[inline(always)]
    fn sqrt(self) -> Self {
        DualNum::sqrt(&self)
    }
    #[inline(always)]
    fn recip(self) -> Self {
        DualNum::recip(&self)
    }
    #[inline(always)]
    fn sin(self) -> Self {
        DualNum::sin(&self)
    }
    #[inline(always)]
    fn cos(self) -> Self {
        DualNum::cos(&self)
    }
}

/// A number without derivatives: what tangents and factors are written over.
pub trait Plain: Number + Default + Send + 'static {
    /// A function of each rod's number.
    fn map(self, f: impl Fn(f64) -> f64) -> Self;
    /// The larger of two, for each rod; the first where the second is no number.
    fn max(self, other: Self) -> Self;
    /// Whether a test holds for the number of any rod.
    fn any(self, test: impl Fn(f64) -> bool) -> bool;
}

impl Plain for f64 {
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        f(self)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
    #[inline(always)]
    fn any(self, test: impl Fn(f64) -> bool) -> bool {
        test(self)
    }
}

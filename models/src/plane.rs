//! Vectors in the plane of the rod.

use crate::number::Number;

/// A quarter turn from x towards z.
#[inline(always)]
pub(crate) fn left<T: Number>([x, z]: [T; 2]) -> [T; 2] {
    [-z, x]
}

#[inline(always)]
pub(crate) fn dot<T: Number>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[0] + a[1] * b[1]
}

#[inline(always)]
pub(crate) fn cross<T: Number>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[1] - a[1] * b[0]
}

#[inline(always)]
pub(crate) fn minus<T: Number>(a: [T; 2], b: [T; 2]) -> [T; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

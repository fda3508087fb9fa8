//! Vectors in the plane of the rod.

use crate::real::Real;

/// A quarter turn from x towards z.
pub(crate) fn left<T: Real>([x, z]: [T; 2]) -> [T; 2] {
    [-z, x]
}

pub(crate) fn dot<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[0] + a[1] * b[1]
}

pub(crate) fn cross<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[1] - a[1] * b[0]
}

pub(crate) fn minus<T: Real>(a: [T; 2], b: [T; 2]) -> [T; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

//! One element of the beam: its cubics, its points of quadrature, and what differentiates laws there.

use num_dual::{Derivative, DualNum, DualSVec64};

/// Derivatives by four numbers.
pub type Dual = DualSVec64<4>;

/// A number, or one with its derivatives.
pub trait Real: DualNum<Primitive = f64> + Copy {}
impl<T: DualNum<Primitive = f64> + Copy> Real for T {}

/// Gauss points and weights of the unit interval, for strains: with as many constraints as coordinates
/// an element that hardly stretches would lock.
pub const THREE: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];
/// The same for mass: exact.
pub const FOUR: [(f64, f64); 4] = [
    (0.069_431_844_202_973_7, 0.173_927_422_568_726_9),
    (0.330_009_478_207_571_9, 0.326_072_577_431_273_1),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_1),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_9),
];

/// Cubic Hermite functions of an element and their first and second derivatives by arc length.
#[inline]
pub fn hermite(xi: f64, length: f64) -> [[f64; 4]; 3] {
    let l = length;
    [
        [
            1.0 - xi * xi * (3.0 - 2.0 * xi),
            l * xi * (1.0 - xi).powi(2),
            xi * xi * (3.0 - 2.0 * xi),
            l * xi * xi * (xi - 1.0),
        ],
        [
            6.0 * xi * (xi - 1.0) / l,
            (1.0 - xi) * (1.0 - 3.0 * xi),
            6.0 * xi * (1.0 - xi) / l,
            xi * (3.0 * xi - 2.0),
        ],
        [
            (12.0 * xi - 6.0) / (l * l),
            (6.0 * xi - 4.0) / l,
            (6.0 - 12.0 * xi) / (l * l),
            (6.0 * xi - 2.0) / l,
        ],
    ]
}

/// A combination of an element's four pairs of coordinates.
#[inline]
pub fn along(shape: &[f64; 4], x: &[f64]) -> [f64; 2] {
    let x = &x[..8];
    [
        shape[0] * x[0] + shape[1] * x[2] + shape[2] * x[4] + shape[3] * x[6],
        shape[0] * x[1] + shape[1] * x[3] + shape[2] * x[5] + shape[3] * x[7],
    ]
}

/// Curvature of a gradient p and its derivative k by arc length, 1/m, and its derivatives by both.
#[inline]
pub fn curvature<T: Real>([p, k]: [[T; 2]; 2]) -> (T, [T; 2], [T; 2]) {
    let square = dot(p, p);
    let kappa = cross(p, k) / square;
    let by_p = [(k[1] - kappa * p[0] * 2.0) / square, (-k[0] - kappa * p[1] * 2.0) / square];
    (kappa, by_p, [-p[1] / square, p[0] / square])
}

/// Scalar product.
#[inline]
pub fn dot<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[0] + a[1] * b[1]
}

/// Component of the vector product normal to the plane, from x towards z.
#[inline]
pub fn cross<T: Real>(a: [T; 2], b: [T; 2]) -> T {
    a[0] * b[1] - a[1] * b[0]
}

/// Two pairs as dual numbers, each of them changing at `rate` with its own of four parameters.
#[inline]
pub fn seed(pairs: [[f64; 2]; 2], rate: f64) -> [[Dual; 2]; 2] {
    [0, 1].map(|s| {
        [0, 1].map(|k| {
            let mut by = [0.0; 4];
            by[2 * s + k] = rate;
            Dual::new(pairs[s][k], Derivative::some(by.into()))
        })
    })
}

/// Derivatives by the four parameters of [`seed`].
#[inline]
pub fn slopes_of(x: &Dual) -> [f64; 4] {
    x.eps.0.map_or([0.0; 4], |eps| eps.data.0[0])
}

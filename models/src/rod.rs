//! The rod of a model.

/// The rod as it is now; with a pressure that changes it follows the pressure.
#[derive(Clone, Copy, Debug)]
pub struct Rod<T> {
    /// Active length without load, m.
    pub length: T,
    /// Distributed mass in all, kg.
    pub mass: T,
    /// Bending stiffness EI, N m².
    pub bending_stiffness: T,
    /// Axial stiffness EA, N; not a number if it is not known.
    pub axial_stiffness: T,
    /// Outer diameter, m; not a number if it is not known.
    pub diameter: T,
    /// Pressure inside above ambient, as a gauge shows it, Pa; 0 where it is not known.
    pub pressure: T,
}

impl Rod<f64> {
    /// A rod that is no muscle, and of which no more is known; its axial stiffness and its diameter are not a number. A
    /// [`Model`](crate::model::Model) then chooses the axial stiffness.
    pub fn plain(length: f64, mass: f64, bending_stiffness: f64) -> Self {
        let unknown = f64::NAN;
        Rod { length, mass, bending_stiffness, axial_stiffness: unknown, diameter: unknown, pressure: 0.0 }
    }
}

impl<T: Copy> Rod<T> {
    /// The same rod over another scalar.
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> Rod<U> {
        Rod {
            length: f(self.length),
            mass: f(self.mass),
            bending_stiffness: f(self.bending_stiffness),
            axial_stiffness: f(self.axial_stiffness),
            diameter: f(self.diameter),
            pressure: f(self.pressure),
        }
    }
}

//! Small deflection of a cantilever: loads along z, curvature taken as the second derivative of z.
//!
//! Source: Young, Budynas and Sadegh (2012), Roark's formulas for stress and strain, Table 8.1,
//! cases 1a, 2a and 3a, with loads and deflection positive towards +z.

/// A uniform cantilever without mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cantilever {
    /// EI, N m², positive.
    pub bending_stiffness: f64,
    /// Length, m, positive.
    pub length: f64,
}

/// Deflection at one point of a cantilever; deflections under several loads add.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deflection {
    /// Towards +z, m.
    pub z: f64,
    /// `dz/dx`, dimensionless.
    pub slope: f64,
}

impl Cantilever {
    /// Deflection at `x`, m, under a force at the tip, N, positive towards +z.
    pub fn tip_load(&self, force: f64, x: f64) -> Deflection {
        let Self { bending_stiffness, length } = *self;
        Deflection {
            z: force * x * x * (3.0 * length - x) / (6.0 * bending_stiffness),
            slope: force * x * (2.0 * length - x) / (2.0 * bending_stiffness),
        }
    }

    /// Deflection at `x`, m, under a moment at the tip, N m, positive from x towards z.
    pub fn tip_moment(&self, moment: f64, x: f64) -> Deflection {
        let curvature = moment / self.bending_stiffness;
        Deflection { z: 0.5 * curvature * x * x, slope: curvature * x }
    }

    /// Deflection at `x`, m, under a force per length all along, N/m, positive towards +z.
    pub fn uniform_load(&self, force_per_length: f64, x: f64) -> Deflection {
        let Self { bending_stiffness, length } = *self;
        let q = force_per_length;
        Deflection {
            z: q * x * x * (x * x + 6.0 * length * length - 4.0 * length * x) / (24.0 * bending_stiffness),
            slope: q * x * (x * x + 3.0 * length * length - 3.0 * length * x) / (6.0 * bending_stiffness),
        }
    }
}

impl std::ops::Add for Deflection {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { z: self.z + other.z, slope: self.slope + other.slope }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEAM: Cantilever = Cantilever { bending_stiffness: 0.007, length: 0.2 };

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-14 * b.abs(), "{a} is not {b}");
    }

    #[test]
    fn the_tip_deflects_as_handbooks_say() {
        let Cantilever { bending_stiffness: ei, length: l } = BEAM;
        close(BEAM.tip_load(-2.0, l).z, -2.0 * l.powi(3) / (3.0 * ei));
        close(BEAM.tip_load(-2.0, l).slope, -2.0 * l.powi(2) / (2.0 * ei));
        close(BEAM.tip_moment(0.01, l).z, 0.01 * l.powi(2) / (2.0 * ei));
        close(BEAM.tip_moment(0.01, l).slope, 0.01 * l / ei);
        close(BEAM.uniform_load(-1.4, l).z, -1.4 * l.powi(4) / (8.0 * ei));
        close(BEAM.uniform_load(-1.4, l).slope, -1.4 * l.powi(3) / (6.0 * ei));
    }

    /// A uniform load is a row of tip loads, each bending the part of the beam behind it:
    /// beyond its load, a beam runs on straight.
    #[test]
    fn a_uniform_load_is_a_row_of_point_loads() {
        let (pieces, x, q) = (2000, 0.13_f64, 3.0);
        let piece = BEAM.length / pieces as f64;
        let mut sum = Deflection::default();
        for i in 0..pieces {
            let at = (i as f64 + 0.5) * piece;
            let behind = Cantilever { length: at, ..BEAM };
            let under = behind.tip_load(q * piece, x.min(at));
            let beyond = (x - at).max(0.0);
            sum = sum + Deflection { z: under.z + under.slope * beyond, ..under };
        }
        let expected = BEAM.uniform_load(q, x);
        let tolerance = (1.0 / pieces as f64).powi(2); // midpoint rule, second order
        assert!((sum.z / expected.z - 1.0).abs() < tolerance);
        assert!((sum.slope / expected.slope - 1.0).abs() < tolerance);
    }
}

//! Postures of the beam: straight or along given gradients, and at rest under its weight.

use super::beam::{Beam, Slopes};

impl Beam {
    /// Coordinates of the posture whose gradient is `gradient(share)`. The clamp keeps its slope: an
    /// angle there is turned within the first element.
    pub fn along(&self, gradient: impl Fn(f64) -> [f64; 2]) -> Vec<f64> {
        let n = self.elements as f64;
        let [x, z] = gradient(0.0);
        let mut q = vec![0.0, 0.0, x.hypot(z), 0.0];
        for i in 1..=self.elements {
            let at = i as f64 / n;
            let (begin, middle, end) = (gradient(at - 1.0 / n), gradient(at - 0.5 / n), gradient(at));
            let before = &q[q.len() - 4..];
            // Simpson's rule.
            let [x, z] =
                [0, 1].map(|k| before[k] + self.length / n * (begin[k] + 4.0 * middle[k] + end[k]) / 6.0);
            q.extend([x, z, end[0], end[1]]);
        }
        q
    }

    /// Coordinates of the straight posture at an angle, rad.
    pub fn straight(&self, angle: f64) -> Vec<f64> {
        self.along(|_| [angle.cos(), angle.sin()])
    }

    /// Coordinates at rest: Newton's method, the weight put on in `STEPS` shares.
    /// # Panics
    /// If Newton's method does not come to an end.
    pub fn at_rest(&self) -> Vec<f64> {
        const STEPS: usize = 40;
        let mass = self.mass_matrix();
        let still = vec![0.0; self.dof()];
        let mut q = self.straight(0.0);
        for k in 1..=STEPS {
            let share = k as f64 / STEPS as f64;
            let loaded = Beam { gravity: share * self.gravity, ..self.clone() };
            let slopes = Slopes { velocity: 0.0, acceleration: 0.0 };
            let solved = (0..50).any(|_| {
                let mut change = loaded.imbalance(&mass, &q, &still, &still);
                loaded.tangent(&mass, &q, &still, &still, slopes).factorize().solve(&mut change);
                q.iter_mut().zip(&change).for_each(|(q, change)| *q -= change);
                change.iter().all(|change| change.abs() < 1e-11)
            });
            assert!(solved, "no rest at {share} of the weight");
        }
        q
    }
}

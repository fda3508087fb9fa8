//! Matrices of the beam: a node couples with its two neighbours, four coordinates each.

/// Half the band beside the diagonal.
const HALF: usize = 7;
const WIDTH: usize = 2 * HALF + 1;

/// A square matrix whose entries vanish more than seven places off the diagonal.
#[derive(Clone, Debug)]
pub struct Band(Vec<[f64; WIDTH]>);

impl Band {
    /// Zeros, shape `[n, n]`.
    pub fn zeros(n: usize) -> Self {
        Self(vec![[0.0; WIDTH]; n])
    }

    /// Adds to an entry.
    /// # Panics
    /// If it lies outside the band.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        self.0[row][column + HALF - row] += value;
    }

    /// All entries times a number.
    pub fn times(&self, factor: f64) -> Self {
        Self(self.0.iter().map(|row| row.map(|x| factor * x)).collect())
    }

    /// Empties a row and its column and leaves one on the diagonal: the coordinate stands still.
    pub fn hold(&mut self, i: usize) {
        self.0[i] = [0.0; WIDTH];
        for row in i.saturating_sub(HALF)..(i + HALF + 1).min(self.0.len()) {
            self.0[row][i + HALF - row] = 0.0;
        }
        self.0[i][HALF] = 1.0;
    }

    /// The matrix times a vector.
    pub fn apply(&self, x: &[f64]) -> Vec<f64> {
        let entry =
            |i: usize, k: usize| (i + k).checked_sub(HALF).and_then(|j| x.get(j)).copied().unwrap_or(0.0);
        let row = |(i, row): (usize, &[f64; WIDTH])| (0..WIDTH).map(|k| row[k] * entry(i, k)).sum();
        self.0.iter().enumerate().map(row).collect()
    }

    /// Factors L and U, one over the other. Rows are not exchanged: mass, or a stable posture, keeps
    /// the pivots away from zero.
    pub fn factorize(mut self) -> Factors {
        let n = self.0.len();
        for k in 0..n {
            let pivot = self.0[k];
            for i in k + 1..(k + HALF + 1).min(n) {
                let at = k + HALF - i;
                let factor = self.0[i][at] / pivot[HALF];
                self.0[i][at] = factor;
                (1..=HALF).for_each(|m| self.0[i][at + m] -= factor * pivot[HALF + m]);
            }
        }
        Factors(self)
    }
}

/// Factors of a [`Band`].
#[derive(Clone, Debug)]
pub struct Factors(Band);

impl Factors {
    /// What the matrix takes to `x`, in the place of `x`.
    pub fn solve(&self, x: &mut [f64]) {
        let (rows, n) = (&self.0.0, x.len());
        for i in 0..n {
            x[i] -= (i.saturating_sub(HALF)..i).map(|j| rows[i][j + HALF - i] * x[j]).sum::<f64>();
        }
        for i in (0..n).rev() {
            x[i] -= (i + 1..(i + HALF + 1).min(n)).map(|j| rows[i][j + HALF - i] * x[j]).sum::<f64>();
            x[i] /= rows[i][HALF];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_is_solved_and_a_held_coordinate_stands_still() {
        let n = 20;
        let mut band = Band::zeros(n);
        for (i, j) in (0..n * n).map(|m| (m / n, m % n)).filter(|(i, j)| i.abs_diff(*j) <= HALF) {
            band.add(i, j, if i == j { 9.0 } else { ((7 * i + 3 * j) % 5) as f64 * 0.3 - 0.5 });
        }
        band.hold(3);
        let x: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut y = band.apply(&x);
        assert_eq!(y[3], x[3]);
        band.factorize().solve(&mut y);
        assert!(x.iter().zip(&y).all(|(x, y)| (x - y).abs() < 1e-14), "{y:?}");
    }
}

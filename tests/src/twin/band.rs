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

    /// Adds what a point of an element has: forces conjugate to two vectors change with these vectors by
    /// `by`, and the vectors with the element's coordinates, the first being `begin`, by `shapes`.
    pub fn add_element(&mut self, begin: usize, shapes: &[[f64; 4]; 2], by: &[[f64; 4]; 4], weight: f64) {
        // Forces by coordinates.
        let mut by_x = [[0.0; 8]; 4];
        for (row, by) in by_x.iter_mut().zip(by) {
            for (j, x) in row.iter_mut().enumerate() {
                *x = weight * (by[j % 2] * shapes[0][j / 2] + by[2 + j % 2] * shapes[1][j / 2]);
            }
        }
        for i in 0..8 {
            let row = &mut self.0[begin + i][HALF - i..HALF - i + 8];
            let [first, second] = [&by_x[i % 2], &by_x[2 + i % 2]];
            for (j, x) in row.iter_mut().enumerate() {
                *x += shapes[0][i / 2] * first[j] + shapes[1][i / 2] * second[j];
            }
        }
    }

    /// All entries times a number.
    pub fn times(&self, factor: f64) -> Self {
        Self(self.0.iter().map(|row| row.map(|x| factor * x)).collect())
    }

    /// Empties a row and its column and leaves one on the diagonal: the coordinate is held.
    pub fn hold(&mut self, i: usize) {
        self.0[i] = [0.0; WIDTH];
        for row in i.saturating_sub(HALF)..(i + HALF + 1).min(self.0.len()) {
            self.0[row][i + HALF - row] = 0.0;
        }
        self.0[i][HALF] = 1.0;
    }

    /// The matrix times a vector.
    pub fn apply(&self, x: &[f64]) -> Vec<f64> {
        let row = |(i, row): (usize, &[f64; WIDTH])| {
            let (from, to) = (i.saturating_sub(HALF), (i + HALF + 1).min(x.len()));
            row[from + HALF - i..].iter().zip(&x[from..to]).map(|(entry, x)| entry * x).sum()
        };
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
                let row = &mut self.0[i][at..=at + HALF];
                row[0] /= pivot[HALF];
                let factor = row[0];
                row[1..].iter_mut().zip(&pivot[HALF + 1..]).for_each(|(x, above)| *x -= factor * above);
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
        let product = |row: &[f64], x: &[f64]| row.iter().zip(x).map(|(entry, x)| entry * x).sum::<f64>();
        for i in 0..n {
            let from = i.saturating_sub(HALF);
            x[i] -= product(&rows[i][from + HALF - i..HALF], &x[from..i]);
        }
        for i in (0..n).rev() {
            x[i] -= product(&rows[i][HALF + 1..], &x[i + 1..(i + HALF + 1).min(n)]);
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

//! Slopes of what one release shows by the unknowns that act on it: some twenty of a hundred, for each release has a setup of
//! its own.

use nalgebra::{DMatrix, DVector};

/// A matrix with a column for each unknown that acts.
#[derive(Clone, Debug)]
pub struct Slopes {
    /// Places of these unknowns among all.
    pub places: Vec<usize>,
    pub matrix: DMatrix<f64>,
}

impl Slopes {
    /// The column of an unknown; none where it does not act.
    pub fn by(&self, unknown: usize) -> Option<DVector<f64>> {
        let column = self.places.iter().position(|place| *place == unknown)?;
        Some(self.matrix.column(column).into_owned())
    }

    /// With each column times a factor of its unknown, and with one more.
    pub fn extended(&self, factors: &[f64], more: Option<(usize, &DVector<f64>)>) -> Self {
        let mut places = self.places.clone();
        let mut matrix =
            self.matrix.clone().resize_horizontally(places.len() + usize::from(more.is_some()), 0.0);
        places.iter().enumerate().for_each(|(k, place)| matrix.column_mut(k).scale_mut(factors[*place]));
        if let Some((place, column)) = more {
            matrix.column_mut(places.len()).copy_from(column);
            places.push(place);
        }
        Self { places, matrix }
    }
}

/// The numbers at the given places.
pub fn chosen(all: &DVector<f64>, places: &[usize]) -> DVector<f64> {
    DVector::from_iterator(places.len(), places.iter().map(|place| all[*place]))
}

/// Adds numbers, times a weight, to those at the given places.
pub fn add(all: &mut DVector<f64>, places: &[usize], weight: f64, more: &DVector<f64>) {
    places.iter().zip(more).for_each(|(place, own)| all[*place] += weight * own);
}

/// The same of a square matrix.
pub fn add_square(all: &mut DMatrix<f64>, places: &[usize], weight: f64, more: &DMatrix<f64>) {
    for (column, place) in places.iter().enumerate() {
        for (row, other) in places.iter().enumerate() {
            all[(*other, *place)] += weight * more[(row, column)];
        }
    }
}

/// Trace of the product of two symmetric matrices, of which the second has the rows and columns at places alone.
pub fn trace_of_product(all: &DMatrix<f64>, places: &[usize], own: &DMatrix<f64>) -> f64 {
    let column = |(column, place): (usize, &usize)| -> f64 {
        places.iter().enumerate().map(|(row, other)| all[(*other, *place)] * own[(row, column)]).sum()
    };
    places.iter().enumerate().map(column).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the same with columns of zeros for unknowns that do not act.
    #[test]
    fn few_columns_do_what_all_do() {
        let places = [3, 1];
        let own =
            Slopes { places: places.to_vec(), matrix: DMatrix::from_fn(5, 2, |r, c| (r + 3 * c) as f64) };
        let mut all = DMatrix::zeros(5, 4);
        places.iter().for_each(|place| all.set_column(*place, &own.by(*place).unwrap()));
        let (square, whole) = (own.matrix.tr_mul(&own.matrix), all.tr_mul(&all));
        let mut added = DMatrix::identity(4, 4);
        add_square(&mut added, &places, 2.0, &square);
        assert_eq!(added, DMatrix::identity(4, 4) + 2.0 * &whole);
        let weights = DMatrix::from_fn(4, 4, |r, c| (1 + r + c) as f64);
        assert_eq!(trace_of_product(&weights, &places, &square), weights.dot(&whole));
        let left = DVector::from_fn(5, |r, _| r as f64);
        let mut sum = DVector::zeros(4);
        add(&mut sum, &places, 1.0, &own.matrix.tr_mul(&left));
        assert_eq!(sum, all.tr_mul(&left));
        assert_eq!(chosen(&sum, &places).as_slice(), [sum[3], sum[1]]);
        assert_eq!(own.by(0), None);
        let more = own.extended(&[1.0, 2.0, 3.0, 4.0], Some((4, &left)));
        assert_eq!(more.by(3), own.by(3).map(|own| own * 4.0));
        assert_eq!((more.by(4), more.places), (Some(left), vec![3, 1, 4]));
    }
}

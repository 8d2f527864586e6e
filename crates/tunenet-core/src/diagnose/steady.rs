//! Whether an effect is the same in every recording, as a share of itself.

use nalgebra::{DMatrix, DVector};

use super::columns::orthonormal;
use super::joint::{Which, dot};
use super::study::{Model, Study};

/// A share of the information below which a direction of the coefficients says nothing.
const SILENT: f64 = 1e-9;

impl Study<'_> {
    /// How far each recording alone would move the coefficients of the effects of `model`, as a share of the coefficients
    /// (root of the weighted mean square, what noise alone moves taken off). Something that is only like the effect, a fan
    /// like a wind, is stronger here and weaker there.
    pub fn unsteadiness(&self, model: &Model) -> f64 {
        let residuals = &model.fit.residuals;
        let columns = self.joint(&model.structure).columns(&model.fit.point, residuals, Which::ALL);
        let (mut moved, mut whole) = (0.0, 0.0);
        for (one, residual) in columns.iter().zip(residuals) {
            let own = orthonormal(one.own.clone());
            let globals = &model.structure.globals;
            let mine: Vec<usize> = (0..one.places.len()).filter(|&i| globals[one.places[i]].effect.is_some()).collect();
            let reduced: Vec<Vec<f64>> = mine
                .iter()
                .map(|&i| {
                    let mut column = one.shared[i].clone();
                    for direction in own.iter().chain(&own) {
                        let part = dot(direction, &column);
                        column.iter_mut().zip(direction).for_each(|(c, d)| *c -= part * d);
                    }
                    column
                })
                .collect();
            let normal = DMatrix::from_fn(mine.len(), mine.len(), |i, j| dot(&reduced[i], &reduced[j]));
            let right = DVector::from_fn(mine.len(), |i, _| -dot(&reduced[i], residual));
            let size = DVector::from_fn(mine.len(), |i, _| {
                let place = one.places[mine[i]];
                model.fit.point.globals[place] - globals[place].absent.map_or(0.0, |a| a.0)
            });
            whole += size.dot(&(&normal * &size));
            let eigen = normal.symmetric_eigen();
            let largest = eigen.eigenvalues.max().max(0.0);
            for (k, value) in eigen.eigenvalues.iter().enumerate().filter(|(_, v)| **v > SILENT * largest) {
                let by_noise = self.independent.recip();
                moved += eigen.eigenvectors.column(k).dot(&right).powi(2) / value - by_noise;
            }
        }
        if whole > 0.0 { (moved.max(0.0) / whole).sqrt() } else { 0.0 }
    }
}

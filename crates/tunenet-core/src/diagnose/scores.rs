//! What each recording alone asks of the free numbers: the scores of the fit.

use nalgebra::{DMatrix, DVector};

use super::columns::orthonormal;
use super::derivatives::Which;
use super::joint::dot;
use super::study::{Model, Study};

/// The normal equations of one recording, its own unknowns eliminated.
pub(super) struct Score {
    /// Its position among the recordings given; several pieces may share one.
    pub recording: usize,
    /// Which free numbers it touches.
    pub places: Vec<usize>,
    /// What it knows of them, shape `[places, places]`.
    pub normal: DMatrix<f64>,
    /// Where it pulls them, shape `[places]`: 0 summed over all recordings where the fit has arrived.
    pub pull: DVector<f64>,
}

impl Study<'_> {
    /// The scores of all recordings at `model`.
    pub fn scores(&self, model: &Model) -> Vec<Score> {
        let residuals = &model.fit.residuals;
        let columns = self.joint(&model.structure).columns(&model.fit.point, residuals, Which::ALL);
        let one = |((set, one), residual): ((&super::sets::Set, super::derivatives::Columns), &Vec<f64>)| {
            let own = orthonormal(one.own);
            let mut reduced = one.shared;
            for column in &mut reduced {
                // Twice, since once leaves rounding of the size of what was taken out.
                for direction in own.iter().chain(&own) {
                    let part = dot(direction, column);
                    column.iter_mut().zip(direction).for_each(|(c, d)| *c -= part * d);
                }
            }
            let normal = DMatrix::from_fn(reduced.len(), reduced.len(), |i, j| dot(&reduced[i], &reduced[j]));
            let pull = DVector::from_fn(reduced.len(), |i, _| -dot(&reduced[i], residual));
            Score { recording: set.recording, places: one.places, normal, pull }
        };
        self.sets.iter().zip(columns).zip(residuals).map(one).collect()
    }
}

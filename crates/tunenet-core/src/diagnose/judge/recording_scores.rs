//! Scores of each recording: gradient and information of the shared parameters, nuisances eliminated.

use nalgebra::{DMatrix, DVector};

use crate::diagnose::columns::orthonormal;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::joint::Which;
use crate::statistics::dot;

/// The normal equations of one recording, its nuisance parameters eliminated.
pub(in crate::diagnose) struct Score {
    /// Its position among the recordings given; several pieces may share one.
    pub recording: usize,
    /// Which shared parameters it touches.
    pub places: Vec<usize>,
    /// What it knows of them, shape `[places, places]`.
    pub normal: DMatrix<f64>,
    /// Where it pulls them, shape `[places]`: 0 summed over all recordings where the fit has arrived.
    pub pull: DVector<f64>,
}

/// The scores of all recordings at `model`.
pub(in crate::diagnose) fn recording_scores(context: &Context<'_>, model: &Hypothesis) -> Vec<Score> {
    let residuals = &model.fit.residuals;
    let columns = context.joint(&model.structure).columns(&model.fit.point, residuals, Which::ALL);
    let one = |((set, one), residual): (
        (&crate::diagnose::evidence::recording::Set, crate::estimate::jacobian::Columns),
        &Vec<f64>,
    )| {
        let nuisances = orthonormal(one.nuisances);
        let mut reduced = one.shared;
        for column in &mut reduced {
            // Twice, since once leaves rounding of the size of what was taken out.
            for direction in nuisances.iter().chain(&nuisances) {
                let part = dot(direction, column);
                column.iter_mut().zip(direction).for_each(|(c, d)| *c -= part * d);
            }
        }
        let normal = DMatrix::from_fn(reduced.len(), reduced.len(), |i, j| dot(&reduced[i], &reduced[j]));
        let pull = DVector::from_fn(reduced.len(), |i, _| -dot(&reduced[i], residual));
        Score { recording: set.recording, places: one.places, normal, pull }
    };
    context.sets().iter().zip(columns).zip(residuals).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::in_swings;

    use crate::diagnose::hypothesis::multistart::fit_without_effects;

    #[test]
    fn scores_of_all_recordings_cancel_where_the_fit_has_arrived() {
        in_swings(&[], 4, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let scores = recording_scores(context, &base);
            assert_eq!(scores.iter().map(|s| s.recording).collect::<Vec<_>>(), [0, 1, 2, 3]);
            let known: f64 = scores.iter().map(|s| s.normal[(0, 0)]).sum();
            let step = scores.iter().map(|s| s.pull[0]).sum::<f64>() / known;
            assert!(step.abs() < 0.3 / known.sqrt(), "{step} of {}", known.sqrt().recip());
        });
    }
}

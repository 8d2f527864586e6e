//! Scores of each recording: gradient and information of the shared parameters, nuisances eliminated.

use nalgebra::DVector;

use crate::Result;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::context::{Context, Hypothesis};
use crate::diagnose::hypothesis::joint::Which;
use crate::estimate::cluster_robust::{Score, stretches};
use crate::estimate::jacobian::Columns;
use crate::estimate::projection::orthonormal;
use crate::statistics::{NORMAL_95, dot};

/// Derivatives of one recording's white residuals by the shared parameters, the nuisance parameters that are fitted projected out.
struct Reduced {
    indices: Vec<usize>,
    columns: Vec<Vec<f64>>,
    nuisances: Vec<Vec<f64>>,
}

fn reduced(context: &Context<'_>, model: &Hypothesis) -> Vec<Reduced> {
    let columns = context.joint(&model.structure).columns(&model.fit.point, &model.fit.residuals, Which::ALL);
    let one = |(recording, one): (&PreparedRecording, Columns)| {
        let fitted = one.nuisances.into_iter().enumerate().filter(|(i, _)| recording.is_fitted(*i));
        let nuisances = orthonormal(fitted.map(|(_, column)| column).collect());
        let mut columns = one.shared;
        for column in &mut columns {
            project(&nuisances, column);
        }
        Reduced { indices: one.indices, columns, nuisances }
    };
    context.recordings().iter().zip(columns).map(one).collect()
}

/// Takes these directions out of `column`.
fn project(directions: &[Vec<f64>], column: &mut [f64]) {
    // Twice, since once leaves rounding of the size of what was taken out.
    for direction in directions.iter().chain(directions) {
        let part = dot(direction, column);
        column.iter_mut().zip(direction).for_each(|(c, d)| *c -= part * d);
    }
}

/// The scores of all recordings at `model`.
pub(in crate::diagnose) fn recording_scores(context: &Context<'_>, model: &Hypothesis) -> Vec<Score> {
    scores_and_nuisances(context, model).0
}

/// The same, and orthonormal directions in which the nuisance parameters of each recording move its white residuals: shape
/// `[recording][direction][value]`.
pub(in crate::diagnose) fn scores_and_nuisances(
    context: &Context<'_>,
    model: &Hypothesis,
) -> (Vec<Score>, Vec<Vec<Vec<f64>>>) {
    let all = context.recordings().iter().zip(reduced(context, model)).zip(&model.fit.residuals);
    let one = |((recording, one), residual): ((&PreparedRecording, Reduced), &Vec<f64>)| {
        let columns: Vec<&[f64]> = one.columns.iter().map(Vec::as_slice).collect();
        (Score::new(recording.index, &one.indices, &columns, residual), one.nuisances)
    };
    all.map(one).unzip()
}

/// The same of stretches of the recordings, numbered through.
pub(in crate::diagnose) fn stretch_scores(context: &Context<'_>, model: &Hypothesis) -> Vec<Score> {
    let mut scores = Vec::new();
    for ((recording, one), residual) in
        context.recordings().iter().zip(reduced(context, model)).zip(&model.fit.residuals)
    {
        for range in stretches(residual.len(), recording.width()) {
            let columns: Vec<&[f64]> = one.columns.iter().map(|c| &c[range.clone()]).collect();
            scores.push(Score::new(scores.len(), &one.indices, &columns, &residual[range]));
        }
    }
    scores
}

/// How far each shared parameter moves as a parameter that stays fixed and is not exact (a calibrated gain, say) moves by its
/// standard deviation: one list for each such parameter.
///
/// # Errors
/// Where the simulator refuses.
pub(in crate::diagnose) fn calibration_moves(context: &Context<'_>, model: &Hypothesis) -> Result<Vec<Vec<f64>>> {
    let objects =
        (0..context.subjects.len()).filter(|&o| context.recordings().iter().any(|recording| recording.object == o));
    let uncertain: Vec<(usize, usize, f64)> = objects
        .flat_map(|object| {
            let all = context.subjects[object].simulator.parameters().iter().enumerate().filter(|(_, p)| !p.tune);
            all.filter_map(move |(i, p)| {
                let sd = p.known95.map(|(low, high)| (high - low) / (2.0 * NORMAL_95))?;
                // Inward where a bound is near: the fit is taken for linear.
                Some((object, i, if p.value + sd > p.max { p.value - sd } else { p.value + sd }))
            })
        })
        .collect();
    if uncertain.is_empty() {
        return Ok(Vec::new());
    }
    let reduced = reduced(context, model);
    let one = |(object, i, value): (usize, usize, f64)| -> Result<Vec<f64>> {
        let structure = context.structure(&model.structure.effects)?.with_value(object, i, value);
        let there = context.joint(&structure).residuals(&model.fit.point, 1.0)?;
        let mut right = DVector::zeros(model.structure.shared.len());
        for ((moved, here), one) in there.into_iter().zip(&model.fit.residuals).zip(&reduced) {
            let mut column: Vec<f64> = moved.iter().zip(here).map(|(a, b)| a - b).collect();
            project(&one.nuisances, &mut column);
            for (&index, shared) in one.indices.iter().zip(&one.columns) {
                right[index] += dot(shared, &column);
            }
        }
        let finite = model.fit.covariance.map(|v| if v.is_finite() { v } else { 0.0 });
        Ok((finite * right).iter().copied().collect())
    };
    uncertain.into_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::tests::zoo::{in_levers, in_swings};
    use crate::testing::Levers;

    use crate::diagnose::hypothesis::multistart::fit_without_effects;

    /// τ = I q'' + W cos q: an error of W moves I by −Σ q'' cos q / Σ q''² times that error.
    #[test]
    fn a_calibration_error_moves_what_is_fitted_with_it() {
        let levers = Levers::new().unwrap().with_weight_known_to((2.8, 3.2));
        in_levers(&levers, &[], |context| {
            let base = fit_without_effects(context).unwrap();
            let moves = calibration_moves(context, &base).unwrap();
            let known = context.recordings()[0].prepared.circumstances.clone().unwrap();
            let input = known.inputs[0].series();
            let (mut product, mut square) = (0.0, 0.0);
            for k in 0..context.recordings()[0].clock().len() {
                let row = input.row(k);
                product += row[2] * row[0].cos();
                square += row[2] * row[2];
            }
            let expected = (product / square * 0.4 / (2.0 * NORMAL_95)).abs();
            assert!((moves[0][0].abs() / expected - 1.0).abs() < 0.02, "{moves:?} {expected}");
            assert_eq!(stretch_scores(context, &base).len(), 15);
        });
        in_levers(&Levers::new().unwrap(), &[], |context| {
            let base = fit_without_effects(context).unwrap();
            assert!(calibration_moves(context, &base).unwrap().is_empty(), "the weight is exact");
        });
    }

    #[test]
    fn scores_of_all_recordings_cancel_where_the_fit_has_arrived() {
        in_swings(&[], 4, 0, |context| {
            let base = fit_without_effects(context).unwrap();
            let scores = recording_scores(context, &base);
            assert_eq!(scores.iter().map(|s| s.cluster).collect::<Vec<_>>(), [0, 1, 2, 3]);
            let known: f64 = scores.iter().map(|s| s.normal[(0, 0)]).sum();
            let step = scores.iter().map(|s| s.gradient[0]).sum::<f64>() / known;
            assert!(step.abs() < 0.3 / known.sqrt(), "{step} of {}", known.sqrt().recip());
        });
    }
}

//! What the recordings cannot tell apart.

use nalgebra::DMatrix;

use super::joint::dot;
use super::stage::Trial;
use super::study::{Model, Study};

/// Two effects whose projected columns share this much (squared canonical correlation) are the same to these recordings,
/// whatever small difference a fit finds.
pub(super) const TWINS: f64 = 0.9999;

/// The largest squared canonical correlation of two column spaces, each given by an orthonormal basis (Hotelling 1936): the
/// greatest squared singular value of the products.
pub(super) fn canonical_correlation(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    if a.is_empty() || b.is_empty() {
        return 0.0;
    }
    let products = DMatrix::from_fn(a.len(), b.len(), |i, j| dot(&a[i], &b[j]));
    products.singular_values().max().powi(2).min(1.0)
}

/// What could stand in the place of `entry` in `model`, with how far it falls behind, nearest first. `without` is the model
/// without `entry`, and `trials` are the candidates beside it.
pub(super) fn others(
    study: &Study,
    without: &Model,
    model: &Model,
    entry: usize,
    trials: &[Trial],
) -> Vec<(usize, f64)> {
    let scale = model.scale();
    let best = study.gain(without, model, scale);
    let own = trials.iter().find(|t| t.entry == entry).map_or(&[][..], |t| t.span.as_slice());
    let each = trials.iter().filter(|t| t.entry != entry && t.excluded.is_none());
    let gap = |t: &Trial| {
        let twin = t.span.len() == own.len() && canonical_correlation(own, &t.span) > TWINS;
        let gap = t.model.as_ref().map(|other| best - study.gain(without, other, scale));
        match gap {
            Some(gap) => Some((t.entry, gap)),
            None if twin => Some((t.entry, 0.0)),
            None => None,
        }
    };
    let mut all: Vec<(usize, f64)> = each.filter_map(gap).collect();
    all.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_correlation_is_the_squared_cosine_of_the_angle() {
        let (sin, cos) = 0.3f64.sin_cos();
        let found = canonical_correlation(&[vec![1.0, 0.0, 0.0]], &[vec![cos, sin, 0.0]]);
        assert!((found - cos * cos).abs() < 1e-15);
        let plane = [vec![1.0, 0.0, 0.0], vec![0.0, 1.0, 0.0]];
        assert!((canonical_correlation(&plane, &[vec![cos, sin, 0.0]]) - 1.0).abs() < 1e-12);
    }
}

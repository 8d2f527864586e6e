//! Canonical correlation of two column spaces (Hotelling 1936): how far one effect can do what another does.

use nalgebra::DMatrix;

use crate::statistics::dot;

/// The largest squared canonical correlation of two column spaces, each given by an orthonormal basis (Hotelling 1936): the
/// greatest squared singular value of the products.
pub(crate) fn canonical_correlation(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    if a.is_empty() || b.is_empty() {
        return 0.0;
    }
    let products = DMatrix::from_fn(a.len(), b.len(), |i, j| dot(&a[i], &b[j]));
    products.singular_values().max().powi(2).min(1.0)
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

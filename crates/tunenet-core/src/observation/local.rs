//! Inverse-variance weighted mean, widened by the excess scatter (Birge 1932), of estimates from parts of the data.

use serde::Serialize;

use crate::statistics::{NORMAL_95, UPPER_95, student_quantile};

/// A number read off a part of the data, with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LocalEstimate {
    /// The estimate.
    pub value: f64,
    /// Its standard deviation, widened where it is itself little known: ± 1.96 of it hold 95 %.
    pub sd: f64,
}

impl LocalEstimate {
    /// The mean of `each`, weighted by certainty. Where they scatter more than they say, that excess counts, with Student's
    /// quantile of so few. `None` of none.
    #[must_use]
    pub fn mean(each: &[Self]) -> Option<Self> {
        let weight: f64 = each.iter().map(|e| e.sd.powi(-2)).sum();
        let value = each.iter().map(|e| e.value * e.sd.powi(-2)).sum::<f64>() / weight;
        let variance = weight.recip();
        let others = each.len() as f64 - 1.0;
        let scatter: f64 = each.iter().map(|e| ((e.value - value) / e.sd).powi(2)).sum();
        let excess = if others > 0.0 { (scatter / others - 1.0).max(0.0) } else { 0.0 };
        let sd = variance.sqrt().hypot(widened((excess * variance).sqrt(), others));
        value.is_finite().then_some(Self { value, sd })
    }
}

/// A standard deviation known from `degrees_of_freedom`, such that ± 1.96 of it hold 95 % as for one that is known.
#[must_use]
pub fn widened(sd: f64, degrees_of_freedom: f64) -> f64 {
    sd * (student_quantile(UPPER_95, degrees_of_freedom.max(1.0)) / NORMAL_95).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scatter_counts_where_it_is_more_than_stated() {
        let of = |values: &[f64]| {
            let each: Vec<_> = values.iter().map(|&value| LocalEstimate { value, sd: 0.01 }).collect();
            LocalEstimate::mean(&each).unwrap()
        };
        // Two that agree: the mean is √2 surer.
        assert!((of(&[0.8, 0.8]).sd - 0.01 / 2f64.sqrt()).abs() < 1e-12);
        // Two that lie 0.1 apart: 0.05 for the mean, nearly all of it from one degree of freedom (12.706 instead of 1.96).
        let apart = of(&[0.75, 0.85]);
        assert!((apart.value - 0.8).abs() < 1e-12);
        assert!((apart.sd * 1.96 / (12.706 * 0.05) - 1.0).abs() < 0.02, "{apart:?}");
        assert_eq!(LocalEstimate::mean(&[]), None);
    }
}

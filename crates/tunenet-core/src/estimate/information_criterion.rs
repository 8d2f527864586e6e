//! Bayesian information criterion (Schwarz 1978) and likelihood-ratio test (Wilks 1938).

use crate::statistics::upper_chi_squared;

/// A residual below this share of the stated noise's variance is not read as an ever better fit: the noise is an estimate.
const LEAST_VARIANCE: f64 = 0.3;

/// Twice the gain in logarithmic likelihood between two nested fits of `count` values with unknown noise,
/// n ln(D₀/D₁), D being the (robust) sum of squares in units of the noise.
pub(crate) fn likelihood_gain(count: usize, before: f64, after: f64) -> f64 {
    let n = count as f64;
    let gain = n * (before.max(f64::MIN_POSITIVE) / after.max(f64::MIN_POSITIVE)).ln();
    if gain > 0.0 { gain.min((before - after) / LEAST_VARIANCE) } else { gain.max((before - after) / LEAST_VARIANCE) }
}

/// A gain in twice the logarithmic likelihood less what `coefficients` more numbers have to earn: the fall of the Bayesian
/// information criterion (Schwarz 1978) of `count` independent values.
///
/// `coefficients` is how many more numbers the later fit has; negative where it has fewer.
pub(crate) fn bic_gain(likelihood_gain: f64, count: f64, coefficients: f64) -> f64 {
    likelihood_gain - coefficients * count.max(std::f64::consts::E).ln()
}

/// The probability that chance alone gains as much (Wilks 1938).
pub(crate) fn p_value(likelihood_gain: f64, coefficients: usize) -> f64 {
    upper_chi_squared(likelihood_gain, coefficients as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coefficient_has_to_earn_the_logarithm_of_the_count() {
        let n = 1000;
        let after = 1000.0;
        let before = after * (20.0 / 1000.0f64).exp();
        assert!((bic_gain(likelihood_gain(n, before, after), 1000.0, 1.0) - (20.0 - 1000f64.ln())).abs() < 1e-9);
        assert!((p_value(3.841_458_820_694_124, 1) - 0.05).abs() < 1e-9);
    }
}

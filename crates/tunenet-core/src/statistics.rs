//! Sample statistics and quantiles: what every other wing takes its medians, products and probabilities from.
//!
//! Robust ones are by order (a median of an even number of values is the upper of the two in the middle, so that it is one of
//! the values); tails and quantiles are those of `statrs`.

use nalgebra::DVectorView;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal, StudentsT};

/// Half the width of a 95 % interval of a normal distribution, in standard deviations: Φ⁻¹(0.975).
pub const NORMAL_95: f64 = 1.959_963_984_540_054;
/// The upper end of a two-sided interval of 95 %, as a probability.
pub const UPPER_95: f64 = 0.975;
/// The standard deviation of a normal distribution over its median absolute deviation: 1/Φ⁻¹(0.75).
pub const SD_PER_MAD: f64 = 1.4826;
/// More degrees of freedom change no quantile of Fisher's F in its fourth digit.
const MOST_FREEDOM: f64 = 1e5;

/// Σ aᵢ bᵢ, up to the end of the shorter.
///
/// ```
/// assert_eq!(tunenet_core::statistics::dot(&[1.0, 2.0], &[3.0, 4.0]), 11.0);
/// ```
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let length = a.len().min(b.len());
    // It sums in eight places at a time, four times as fast as one after the other.
    DVectorView::from_slice(a, length).dot(&DVectorView::from_slice(b, length))
}

/// The arithmetic mean; 0 of none.
#[must_use]
pub fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
    sum / f64::max(count, 1.0)
}

/// The value at this share of the sorted values, the upper neighbour where it falls between two; `None` of none.
#[must_use]
pub fn quantile(values: impl IntoIterator<Item = f64>, share: f64) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
    let at = ((share * values.len() as f64) as usize).min(values.len().checked_sub(1)?);
    Some(*values.select_nth_unstable_by(at, f64::total_cmp).1)
}

/// The median; `None` of none.
///
/// ```
/// # use tunenet_core::statistics::median;
/// assert_eq!(median([3.0, 1.0, 2.0, 9.0]), Some(3.0));
/// ```
#[must_use]
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    quantile(values, 0.5)
}

/// The standard deviation of a normal distribution around 0 by the median of absolute values (Hampel 1974); 0 of none.
#[must_use]
pub fn mad_sd(values: impl IntoIterator<Item = f64>) -> f64 {
    SD_PER_MAD * median(values.into_iter().map(f64::abs)).unwrap_or(0.0)
}

/// The root mean square; 0 of none.
#[must_use]
pub fn root_mean_square(values: impl IntoIterator<Item = f64>) -> f64 {
    mean(values.into_iter().map(|v| v * v)).sqrt()
}

/// The least and the greatest value; ∞ and −∞ of none.
#[must_use]
pub fn extent(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    values.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// The greatest value less the least; −∞ of none.
#[must_use]
pub fn range(values: impl IntoIterator<Item = f64>) -> f64 {
    let (low, high) = extent(values);
    high - low
}

/// Σ rᵢ rᵢ₊ₖ / Σ rᵢ² over the mean-free values, for lags `k` from 0 to `lags`; 0 where all are equal.
#[must_use]
pub fn autocorrelation(values: &[f64], lags: usize) -> Vec<f64> {
    let mean = mean(values.iter().copied());
    let square: f64 = values.iter().map(|r| (r - mean).powi(2)).sum();
    let at = |k: usize| values.iter().zip(&values[k..]).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    (0..=lags).map(|k| if square > 0.0 { at(k) / square } else { 0.0 }).collect()
}

/// The quantile of Student's t at probability `level`; infinite without a degree of freedom.
#[must_use]
pub fn student_quantile(level: f64, freedom: f64) -> f64 {
    if freedom > MANY_FREEDOM {
        // Expansion about the normal quantile (Abramowitz and Stegun 26.7.5): the search for the exact value never ends there.
        let z = Normal::standard().inverse_cdf(level);
        let first = (z.powi(3) + z) / 4.0;
        let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
        return z + first / freedom + second / freedom.powi(2);
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(level))
}

/// Degrees of freedom beyond which Student's quantile is expanded about the normal one; the error there is below 1e-11.
const MANY_FREEDOM: f64 = 1e4;

/// The quantile of Fisher's F at probability `level`; infinite without degrees of freedom.
#[must_use]
pub fn fisher_quantile(level: f64, above: f64, below: f64) -> f64 {
    FisherSnedecor::new(above, below.min(MOST_FREEDOM)).map_or(f64::INFINITY, |f| f.inverse_cdf(level))
}

/// The quantile of χ² at probability `level`; infinite without a degree of freedom.
#[must_use]
pub fn chi_squared_quantile(level: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(f64::INFINITY, |d| d.inverse_cdf(level))
}

/// P(χ² > `value`).
#[must_use]
pub fn upper_chi_squared(value: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom.max(1e-9)).map_or(1.0, |d| d.sf(value.max(0.0)))
}

/// P(F > `value`).
#[must_use]
pub fn upper_f(value: f64, above: f64, below: f64) -> f64 {
    FisherSnedecor::new(above.max(1.0), below.max(1.0)).map_or(1.0, |d| d.sf(value.max(0.0)))
}

/// Wilson's 95 % interval of a probability of which `hits` of `count` trials were seen (Wilson 1927), as shares from 0 to 1;
/// (0, 1) without a trial.
///
/// ```
/// let (low, high) = tunenet_core::statistics::wilson_interval(1, 100);
/// assert!((low - 0.00177).abs() < 1e-5 && (high - 0.05449).abs() < 1e-5);
/// ```
#[must_use]
pub fn wilson_interval(hits: usize, count: usize) -> (f64, f64) {
    if count == 0 {
        return (0.0, 1.0);
    }
    let (n, z2) = (count as f64, NORMAL_95 * NORMAL_95);
    let share = hits as f64 / n;
    let middle = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let reach = NORMAL_95 / (1.0 + z2 / n) * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt();
    ((middle - reach).max(0.0), (middle + reach).min(1.0))
}

/// At most `most` of the positions below `count`, at equal distances.
#[must_use]
pub fn evenly(count: usize, most: usize) -> Vec<usize> {
    let taken = count.min(most);
    (0..taken).map(|k| (2 * k + 1) * count / (2 * taken)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_statistics_are_values_of_the_sample() {
        assert_eq!(median([1.0, 2.0, 3.0]), Some(2.0));
        assert_eq!(median([]), None);
        assert_eq!(quantile([4.0, 3.0, 2.0, 1.0], 1.0), Some(4.0));
        assert_eq!(quantile([4.0, 3.0, 2.0, 1.0], 0.25), Some(2.0));
        assert!((mad_sd([-1.0, 1.0, -1.0]) - 1.4826).abs() < 1e-15);
        assert_eq!((range([2.0, -1.0, 0.5]), mean([]), mean([1.0, 3.0])), (3.0, 0.0, 2.0));
    }

    #[test]
    fn alternating_values_are_their_own_opposite() {
        let found = autocorrelation(&[1.0, -1.0, 1.0, -1.0, 1.0, -1.0], 2);
        assert!(found.iter().zip([1.0, -5.0 / 6.0, 4.0 / 6.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        assert_eq!(autocorrelation(&[2.0; 4], 1), [0.0, 0.0]);
    }

    #[test]
    fn quantiles_and_tails_are_those_of_tables() {
        assert!((student_quantile(UPPER_95, 10.0) - 2.228_139).abs() < 1e-6);
        assert!((student_quantile(UPPER_95, 1e9) - NORMAL_95).abs() < 1e-8);
        // Both formulas agree where they change over.
        let [below, above] = [0.999, 1.001].map(|share| student_quantile(UPPER_95, share * MANY_FREEDOM));
        let slope = (NORMAL_95.powi(3) + NORMAL_95) / 4.0;
        assert!((below - above - slope * (1.0 / 0.999 - 1.0 / 1.001) / MANY_FREEDOM).abs() < 1e-9, "{below} {above}");
        assert!((fisher_quantile(0.95, 2.0, 10.0) - 4.102_821).abs() < 1e-5);
        assert!((chi_squared_quantile(0.95, 1.0) - NORMAL_95.powi(2)).abs() < 1e-9);
        assert!((upper_chi_squared(NORMAL_95.powi(2), 1.0) - 0.05).abs() < 1e-9);
        assert!((upper_f(4.102_821, 2.0, 10.0) - 0.05).abs() < 1e-6);
        assert_eq!(student_quantile(UPPER_95, 0.0), f64::INFINITY);
    }

    #[test]
    fn even_positions_have_equal_distances() {
        assert_eq!(evenly(30, 3), [5, 15, 25]);
        assert_eq!(evenly(2, 3), [0, 1]);
        assert!(evenly(0, 3).is_empty());
    }
}

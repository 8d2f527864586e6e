//! A parabola through samples, by least squares.

/// `value = level + slope t + acceleration t²/2` about the middle of the samples.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parabola {
    pub acceleration: f64,
    /// Its standard deviation from the residuals.
    pub acceleration_sd: f64,
    /// RMS of the residuals, with 3 values spent.
    pub residual: f64,
}

impl Parabola {
    /// `None` for fewer than four samples, or where they lie at fewer than three instants.
    pub fn fit(times: &[f64], values: &[f64]) -> Option<Self> {
        let n = times.len() as f64;
        if times.len() < 4 || times.len() != values.len() {
            return None;
        }
        let middle = times.iter().sum::<f64>() / n;
        let mean = values.iter().sum::<f64>() / n;
        let square = times.iter().map(|t| (t - middle).powi(2)).sum::<f64>() / n;
        // Polynomials that are orthogonal over the samples: 1, t, and t² less its part along both.
        let skew = times.iter().map(|t| (t - middle).powi(3)).sum::<f64>() / (n * square);
        let bend = |t: f64| (t - middle).powi(2) - square - skew * (t - middle);
        let along = |of: &dyn Fn(f64) -> f64| {
            let (mut product, mut norm) = (0.0, 0.0);
            for (t, v) in times.iter().zip(values) {
                product += of(*t) * (v - mean);
                norm += of(*t) * of(*t);
            }
            (product / norm, norm)
        };
        let (slope, _) = along(&|t| t - middle);
        let (curvature, norm) = along(&bend);
        let squares: f64 = times
            .iter()
            .zip(values)
            .map(|(t, v)| (v - mean - slope * (t - middle) - curvature * bend(*t)).powi(2))
            .sum();
        let residual = (squares / (n - 3.0).max(1.0)).sqrt();
        let found = Self { acceleration: 2.0 * curvature, acceleration_sd: 2.0 * residual / norm.sqrt(), residual };
        found.acceleration.is_finite().then_some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uneven_samples_of_a_parabola_give_its_acceleration() {
        let times = [0.0, 0.1, 0.15, 0.4, 0.7];
        let values = times.map(|t: f64| 3.0 - 2.0 * t + 9.81 / 2.0 * t * t);
        let found = Parabola::fit(&times, &values).unwrap();
        assert!((found.acceleration - 9.81).abs() < 1e-9 && found.residual < 1e-9);
        assert!(Parabola::fit(&times[..3], &values[..3]).is_none());
        assert!(Parabola::fit(&[1.0; 5], &values).is_none());
    }
}

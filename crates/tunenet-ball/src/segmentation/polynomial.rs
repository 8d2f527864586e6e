//! Least-squares polynomials of degree one and two over a few samples.

/// A polynomial `c0 + c1·s + c2·s²` in `s = t − origin`, with the covariance of its coefficients for unit noise.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Polynomial {
    /// Where `s` is zero, s.
    pub origin: f64,
    /// `[c0, c1, c2]`.
    pub coefficients: [f64; 3],
    /// Standard deviation of the residual, with the degrees of freedom taken off; 0 where none are left.
    pub residual_sd: f64,
    covariance: nalgebra::Matrix3<f64>,
}

impl Polynomial {
    /// Fits `values` over `time`, with `c2` fixed to `curvature` where it is given. `None` for fewer samples than
    /// coefficients, or instants that coincide.
    pub fn fit(time: &[f64], values: &[f64], origin: f64, curvature: Option<f64>) -> Option<Self> {
        let terms = if curvature.is_some() { 2 } else { 3 };
        if time.len() < terms {
            return None;
        }
        let fixed = curvature.unwrap_or(0.0);
        let mut normal = nalgebra::Matrix3::zeros();
        let mut right = nalgebra::Vector3::zeros();
        for (&t, &v) in time.iter().zip(values) {
            let s = t - origin;
            let row = nalgebra::Vector3::new(1.0, s, if terms == 3 { s * s } else { 0.0 });
            normal += row * row.transpose();
            right += row * (v - fixed * s * s);
        }
        if terms == 2 {
            normal[(2, 2)] = 1.0;
        }
        let mut covariance = normal.try_inverse()?;
        let solution = covariance * right;
        if terms == 2 {
            covariance[(2, 2)] = 0.0;
        }
        let coefficients = [solution[0], solution[1], if terms == 3 { solution[2] } else { fixed }];
        let mut fitted = Self { origin, coefficients, residual_sd: 0.0, covariance };
        let squares: f64 = time.iter().zip(values).map(|(&t, &v)| (v - fitted.at(t)).powi(2)).sum();
        if time.len() > terms {
            fitted.residual_sd = (squares / (time.len() - terms) as f64).sqrt();
        }
        coefficients.iter().all(|c| c.is_finite()).then_some(fitted)
    }

    /// Its value at `time`.
    pub fn at(&self, time: f64) -> f64 {
        let s = time - self.origin;
        let [c0, c1, c2] = self.coefficients;
        c0 + s * (c1 + s * c2)
    }

    /// Its slope at `time`.
    pub fn slope(&self, time: f64) -> f64 {
        self.coefficients[1] + 2.0 * self.coefficients[2] * (time - self.origin)
    }

    /// Standard deviation of `c2` for noise of standard deviation 1.
    pub fn curvature_gain(&self) -> f64 {
        self.covariance[(2, 2)].max(0.0).sqrt()
    }

    /// Standard deviation of [`at`](Self::at) for noise of standard deviation 1.
    pub fn value_gain(&self, time: f64) -> f64 {
        let s = time - self.origin;
        let row = nalgebra::Vector3::new(1.0, s, s * s);
        row.dot(&(self.covariance * row)).max(0.0).sqrt()
    }

    /// Standard deviation of [`slope`](Self::slope) for noise of standard deviation 1.
    pub fn slope_gain(&self, time: f64) -> f64 {
        let row = nalgebra::Vector3::new(0.0, 1.0, 2.0 * (time - self.origin));
        row.dot(&(self.covariance * row)).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::Polynomial;

    #[test]
    fn a_parabola_is_found_exactly() {
        let time = [0.0, 0.1, 0.2, 0.3, 0.4];
        let values = time.map(|t: f64| 1.0 + 2.0 * t - 4.905 * t * t);
        let free = Polynomial::fit(&time, &values, 0.2, None).unwrap();
        let known = Polynomial::fit(&time, &values, 0.2, Some(-4.905)).unwrap();
        for fitted in [free, known] {
            assert!((fitted.at(0.0) - 1.0).abs() < 1e-12 && (fitted.slope(0.4) - (2.0 - 9.81 * 0.4)).abs() < 1e-11);
            assert!(fitted.residual_sd < 1e-12);
        }
        assert!(known.slope_gain(0.4) < free.slope_gain(0.4), "a known curvature must help");
    }

    #[test]
    fn too_few_samples_are_refused() {
        assert!(Polynomial::fit(&[0.0, 1.0], &[0.0, 1.0], 0.0, None).is_none());
        assert!(Polynomial::fit(&[1.0, 1.0], &[0.0, 1.0], 0.0, Some(0.0)).is_none());
    }
}

//! Several smooth functions of time on one interval, by Chebyshev's polynomials.

/// Functions on `[0, duration]`, each with its coefficients.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chebyshev {
    duration: f64,
    degree: usize,
    functions: usize,
    /// Row-major `[degree + 1, function]`.
    coefficients: Vec<f64>,
}

/// The instants within `[0, duration]`, rising, at which [`Chebyshev::through`] wants values.
pub(super) fn nodes(count: usize, duration: f64) -> Vec<f64> {
    let angle = |j: usize| std::f64::consts::PI * (count - 1 - j) as f64 / count as f64;
    let half = std::f64::consts::FRAC_PI_2 / count as f64;
    (0..count).map(|j| 0.5 * duration * (1.0 + (angle(j) + half).cos())).collect()
}

impl Chebyshev {
    /// The polynomials of `degree` nearest to `values`, row-major `[node, function]`, at [`nodes`]: there the polynomials
    /// are orthogonal, so each coefficient is one sum.
    pub fn through(values: &[f64], functions: usize, duration: f64, degree: usize) -> Self {
        let count = values.len() / functions;
        let mut coefficients = vec![0.0; (degree + 1) * functions];
        for (j, time) in nodes(count, duration).into_iter().enumerate() {
            let angle = (2.0 * time / duration - 1.0).clamp(-1.0, 1.0).acos();
            for k in 0..=degree {
                let weight = (k as f64 * angle).cos() * if k == 0 { 1.0 } else { 2.0 } / count as f64;
                for f in 0..functions {
                    coefficients[k * functions + f] += weight * values[j * functions + f];
                }
            }
        }
        Self { duration, degree, functions, coefficients }
    }

    /// Values, first and second derivatives at `time`, each slice one number for each function.
    pub fn at(&self, time: f64, values: &mut [f64], first: &mut [f64], second: &mut [f64]) {
        let scale = 2.0 / self.duration;
        let x = scale * time - 1.0;
        for out in [&mut *values, &mut *first, &mut *second] {
            out[..self.functions].fill(0.0);
        }
        // The polynomial and its derivatives by the recurrence, two steps back and one.
        let (mut before, mut now) = ([1.0, 0.0, 0.0], [x, 1.0, 0.0]);
        for k in 0..=self.degree {
            for f in 0..self.functions {
                let c = self.coefficients[k * self.functions + f];
                values[f] += c * before[0];
                first[f] += c * before[1] * scale;
                second[f] += c * before[2] * scale * scale;
            }
            let next = [
                2.0 * x * now[0] - before[0],
                2.0 * (now[0] + x * now[1]) - before[1],
                4.0 * now[1] + 2.0 * x * now[2] - before[2],
            ];
            (before, now) = (now, next);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_and_its_derivatives_are_met() {
        let (duration, count) = (5.0, 64);
        let values: Vec<f64> = nodes(count, duration).iter().flat_map(|t| [(1.2 * t).sin(), 3.0]).collect();
        let fit = Chebyshev::through(&values, 2, duration, 24);
        let (mut v, mut d, mut dd) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        for t in [0.0, 0.3, 2.5, 5.0] {
            fit.at(t, &mut v, &mut d, &mut dd);
            let (s, c) = (1.2 * t).sin_cos();
            assert!((v[0] - s).abs() < 1e-13 && (d[0] - 1.2 * c).abs() < 1e-11 && (dd[0] + 1.44 * s).abs() < 1e-9);
            assert!((v[1] - 3.0).abs() < 1e-13 && d[1].abs() < 1e-11);
        }
    }
}

//! Profile likelihood at given values of one parameter, with their posterior shares (Student's t): the range of a parameter
//! that the recordings do not determine.

use super::channel_weights;
use crate::estimate::{Fit, Point, Problem, RolloutLog, ScaleEstimate, free, weights};
use crate::observation::Observation;
use crate::simulator::{Preparation, Simulator};
use crate::{Error, Origin, Result};

/// The fit with one parameter fixed.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedValueFit {
    /// The fixed value.
    pub value: f64,
    /// The other parameters, fitted: name, value and 95 % interval by the curvature, within the bounds.
    pub fitted: Vec<(String, f64, (f64, f64))>,
    /// Likelihood of the recordings at this value, normalised: the shares of all values add up to 1.
    pub share: f64,
}

/// Fixes the parameter `name` at each of `values` in turn and fits everything else again, from where the fit before it ended;
/// the first starts at the simulator's own values, which should be tuned ones.
///
/// A share is the density of Student's t at the distance from the best of them in standard deviations, with the
/// scale estimate of the residuals at that best one.
///
/// # Errors
/// [`Error::Setting`] if there is no such parameter; what the simulator refuses. Empty where no recording can be used.
pub fn fit_at_fixed_values(
    simulator: &dyn Simulator,
    observations: &[Observation],
    name: &str,
    values: &[f64],
) -> Result<Vec<FixedValueFit>> {
    let parameters = simulator.parameters();
    let Some(position) = parameters.iter().position(|p| p.name == name) else {
        let expected = parameters.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", ");
        return Err(Error::Setting { origin: Origin::Caller, name: "parameter", expected, found: format!("`{name}`") });
    };
    let mut recordings = Vec::new();
    for seen in observations {
        if let Preparation::Usable(prepared) = simulator.prepare(seen)? {
            recordings.push(*prepared);
        }
    }
    if recordings.is_empty() {
        return Ok(Vec::new());
    }
    let mut others = free(parameters, &recordings);
    others.retain(|i| *i != position);
    let log = RolloutLog::default();
    channel_weights::weigh(simulator, &mut recordings, &others, &log)?;
    let noise: Vec<Vec<f64>> = recordings.iter().map(weights).collect();
    let problem = Problem { simulator, recordings: &recordings, noise: &noise, free: &others, log: Some(&log) };
    let mut point = Point::start(simulator, &recordings);
    let mut fits: Vec<Fit> = Vec::with_capacity(values.len());
    for &value in values {
        point.parameters[position] = value;
        let fit = problem.fit(point, 1.0)?;
        point = fit.point.clone();
        fits.push(fit);
    }
    let Some(best) = fits.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)) else { return Ok(Vec::new()) };
    // What lies between two of the values leaves residuals that look as if errors added up.
    let scale = ScaleEstimate::of_single_errors(&problem, best, &problem.linearise(best)?);
    let density = |fit: &Fit| {
        let excess = scale.excess(fit.cost - best.cost);
        (-0.5 * (scale.degrees_of_freedom + 1.0) * (excess / scale.degrees_of_freedom).ln_1p()).exp()
    };
    let total: f64 = fits.iter().map(density).sum();
    let at_value = |fit: &Fit| {
        let each = others.iter().enumerate().map(|(k, &i)| {
            let (p, value) = (&parameters[i], fit.point.parameters[i]);
            let half_width = scale.quantile() * scale.sd(fit.covariance[(k, k)]);
            let half_width = if half_width.is_finite() { half_width } else { p.span() };
            (p.name.clone(), value, ((value - half_width).max(p.min), (value + half_width).min(p.max)))
        });
        FixedValueFit { value: fit.point.parameters[position], fitted: each.collect(), share: density(fit) / total }
    };
    Ok(fits.iter().map(at_value).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::{Channel, Kind};
    use crate::simulator::{Parameter, RolloutResult};

    /// y = a + b t.
    struct Line(Vec<Parameter>, Vec<Channel>);

    impl Simulator for Line {
        fn parameters(&self) -> &[Parameter] {
            &self.0
        }

        fn channels(&self) -> &[Channel] {
            &self.1
        }

        fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
            clock.iter().zip(values).for_each(|(t, v)| *v = p[0] + p[1] * t);
            Ok(())
        }
    }

    /// For a line with white noise the profile over the slope is Student's t around the least-squares slope, and the intercept
    /// at a slope is the mean of the residual.
    #[test]
    fn the_profile_of_a_line_is_the_closed_form() {
        let channel = Channel::new("y", "m");
        let parameter = |name: &str| Parameter::new(name, "m", 0.0, -10.0, 10.0).unwrap();
        let line = Line(vec![parameter("a"), parameter("b")], vec![channel.clone()]);
        let clock: Vec<f64> = (0..24).map(|i| 0.1 * f64::from(i)).collect();
        // Errors without correlation between neighbours.
        let errors =
            [0.03, -0.05, 0.01, 0.04, -0.02, -0.03, 0.06, -0.01, 0.02, -0.04, 0.0, 0.05, -0.06, 0.01, 0.03, -0.03];
        let y: Vec<f64> = clock.iter().enumerate().map(|(i, t)| 1.0 - 0.5 * t + errors[i % 16]).collect();
        let n = clock.len() as f64;
        let (mean_t, mean_y) = (clock.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
        let stt: f64 = clock.iter().map(|t| (t - mean_t).powi(2)).sum();
        let slope = clock.iter().zip(&y).map(|(t, y)| (t - mean_t) * (y - mean_y)).sum::<f64>() / stt;
        let seen = Observation::new(Kind::Other, vec![channel], clock.clone(), y.clone()).unwrap();
        let values: Vec<f64> = (-4..=4).map(|i| slope + 0.02 * f64::from(i)).collect();
        let found = fit_at_fixed_values(&line, &[seen], "b", &values).unwrap();
        // At the best slope only the intercept was fitted.
        let degrees_of_freedom = n - 1.0;
        let rest = |b: f64| -> f64 { clock.iter().zip(&y).map(|(t, y)| (y - mean_y - b * (t - mean_t)).powi(2)).sum() };
        let variance = rest(slope) / degrees_of_freedom;
        let density = |b: f64| {
            (1.0 + (rest(b) - rest(slope)) / variance / degrees_of_freedom).powf(-0.5 * (degrees_of_freedom + 1.0))
        };
        let total: f64 = values.iter().map(|b| density(*b)).sum();
        for (one, b) in found.iter().zip(&values) {
            assert!((one.share - density(*b) / total).abs() < 0.01, "{b}: {} {}", one.share, density(*b) / total);
            assert!((one.fitted[0].1 - (mean_y - b * mean_t)).abs() < 1e-6, "{one:?}");
        }
        assert!((found.iter().map(|h| h.share).sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_name_that_is_none_is_refused() {
        let line = Line(vec![Parameter::new("a", "m", 0.0, -1.0, 1.0).unwrap()], vec![Channel::new("y", "m")]);
        let error = fit_at_fixed_values(&line, &[], "c", &[0.0]).unwrap_err().to_string();
        assert!(error.contains('a') && error.contains("`c`"), "{error}");
    }
}

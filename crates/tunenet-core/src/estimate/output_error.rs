//! Output-error method (Ljung 1999, section 7.2): the parameters of one simulator and the nuisance parameters of each recording
//! by the residuals of whole rollouts, measured − predicted in units of the noise.

use nalgebra::{DMatrix, DVector};

use super::huber::huber_cost;
use super::jacobian::{Columns, jacobian};
use super::levenberg_marquardt::{Settings, full_step, minimise};
use super::normal_equations::normal_equations;
use super::problem::{LeastSquares, Point, leading_samples, prior_cost, residuals, robust_scale};
use super::rollout_log::RolloutLog;
use crate::simulator::{Parameter, Prepared, Simulator, predict};
use crate::{Error, Result};

/// Shares of a recording over which its initial state is fitted one after the other, before the whole of it: a state that is guessed from a
/// tight orbit leads to another minimum than the true one.
pub(crate) const GROWING_SHARES: [f64; 5] = [0.1, 0.2, 0.35, 0.5, 0.75];

/// What a fit ended with.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The best point.
    pub point: Point,
    /// Weighted residuals there, shape `[recording][sample · channel]`.
    pub residuals: Vec<Vec<f64>>,
    /// Half the robust sum of squares.
    pub cost: f64,
    /// Covariance of the free parameters for noise as stated, the nuisance parameters marginalised; bounds ignored.
    pub covariance: DMatrix<f64>,
    /// How many rollouts it took.
    pub rollouts: usize,
    /// The free parameters after every accepted step with [`Problem::rmse`] there, the start first.
    pub trace: Vec<(Vec<f64>, f64)>,
    /// Whether it ended before it had arrived, because no more rollouts were allowed.
    pub cut_short: bool,
    /// Derivatives that were measured within half a standard deviation of the point.
    pub(super) linear: Option<Linearisation>,
}

/// What is fitted to what.
pub struct Problem<'a> {
    /// The simulator.
    pub simulator: &'a dyn Simulator,
    /// The recordings, prepared by it.
    pub recordings: &'a [Prepared],
    /// Noise of each recording's channels, shape `[recording][channel]`.
    pub noise: &'a [Vec<f64>],
    /// Positions of the free parameters.
    pub free: &'a [usize],
    /// What was simulated already, and how much more may be; without one, every rollout is simulated.
    pub log: Option<&'a RolloutLog>,
}

/// A problem over the first share of each recording.
struct Window<'a> {
    problem: &'a Problem<'a>,
    recordings: Vec<usize>,
    horizon: f64,
}

impl LeastSquares for Window<'_> {
    fn free(&self) -> &[usize] {
        self.problem.free
    }

    fn recordings(&self) -> &[usize] {
        &self.recordings
    }

    fn parameter(&self, position: usize) -> &Parameter {
        &self.problem.simulator.parameters()[position]
    }

    fn nuisances(&self, recording: usize) -> &[Parameter] {
        &self.problem.recordings[recording].nuisances
    }

    fn prior_sd(&self, recording: usize, i: usize) -> f64 {
        self.problem.recordings[recording].prior_sd(i)
    }

    fn residual(&self, recording: usize, parameters: &[f64], nuisances: &[f64]) -> Result<Vec<f64>> {
        let prepared = &self.problem.recordings[recording];
        let samples = leading_samples(prepared.seen.len(), self.horizon);
        let noise = &self.problem.noise[recording];
        let Some(log) = self.problem.log else {
            return weighted(self.problem.simulator, prepared, noise, parameters, nuisances, samples);
        };
        let predicted = log.predict(self.problem.simulator, (recording, prepared), parameters, nuisances, samples)?;
        Ok(in_noise(predicted, prepared, noise))
    }

    fn affords(&self, rollouts: usize) -> bool {
        self.problem.log.is_none_or(|log| log.affords(rollouts))
    }

    fn allowance(&self) -> Option<usize> {
        self.problem.log.and_then(RolloutLog::allowance)
    }

    fn spent(&self) -> usize {
        self.problem.log.map_or(0, RolloutLog::count)
    }
}

/// The residuals at a fit, linear in every parameter: a column of derivatives for each.
#[derive(Debug, Clone)]
pub struct Linearisation {
    pub(super) columns: Vec<Columns>,
    /// Whether it took rollouts of its own, besides those of the fit.
    rollouts: bool,
}

impl Linearisation {
    /// How many rollouts it took besides those of the fit: one for each column of each recording, or none.
    #[must_use]
    pub fn rollouts(&self) -> usize {
        if self.rollouts { self.columns.iter().map(Columns::count).sum() } else { 0 }
    }

    /// Of columns that are known without rollouts.
    pub(crate) fn known(columns: Vec<Columns>) -> Self {
        Self { columns, rollouts: false }
    }

    /// The columns of each recording.
    pub(crate) fn columns(&self) -> &[Columns] {
        &self.columns
    }

    /// The columns of these shared parameters, and of all nuisance parameters.
    pub(crate) fn of(&self, free: &[usize]) -> Vec<Columns> {
        let kept = |one: &Columns| {
            let both = || one.indices.iter().zip(&one.shared).filter(|(index, _)| free.contains(index));
            Columns {
                indices: both().map(|(index, _)| *index).collect(),
                shared: both().map(|(_, column)| column.clone()).collect(),
                nuisances: one.nuisances.clone(),
            }
        };
        self.columns.iter().map(kept).collect()
    }
}

impl Problem<'_> {
    fn window(&self, horizon: f64) -> Window<'_> {
        Window { problem: self, recordings: (0..self.recordings.len()).collect(), horizon }
    }

    /// How many rollouts the first step takes at most.
    pub(crate) fn first_step(&self) -> usize {
        self.window(1.0).first_step()
    }

    /// What is wrong where a first step takes more rollouts than are allowed.
    pub(crate) fn unaffordable(&self) -> Error {
        self.window(1.0).unaffordable()
    }

    /// Weighted residuals of every recording, over the first share `horizon` of each.
    ///
    /// # Errors
    /// Where the simulator refuses.
    pub fn residuals(&self, point: &Point, horizon: f64) -> Result<Vec<Vec<f64>>> {
        let window = self.window(horizon);
        if !window.affords(self.recordings.len()) {
            return Err(window.unaffordable());
        }
        residuals(&window, point)
    }

    /// Root mean square of measured − predicted in the unit of all channels, a sample of several channels counted once; where units
    /// differ, of residuals over the noise of their channels ([`gap_unit`](crate::observation::gap_unit)).
    #[must_use]
    pub fn rmse(&self, residuals: &[Vec<f64>]) -> f64 {
        residual_gap(self.recordings, self.noise, residuals)
    }

    /// Derivatives of the residuals at `fit`: those that its last step measured, where it has them.
    ///
    /// # Errors
    /// Where the simulator refuses both sides of a direction.
    pub fn linearise(&self, fit: &Fit) -> Result<Linearisation> {
        match &fit.linear {
            Some(known) => Ok(known.clone()),
            None => {
                Ok(Linearisation { columns: jacobian(&self.window(1.0), &fit.point, &fit.residuals)?, rollouts: true })
            }
        }
    }

    /// Derivatives of the residuals at `point`, where they are `residuals`.
    ///
    /// # Errors
    /// Where the simulator refuses both sides of a direction.
    pub(crate) fn derivatives(&self, point: &Point, residuals: &[Vec<f64>]) -> Result<Linearisation> {
        Ok(Linearisation { columns: jacobian(&self.window(1.0), point, residuals)?, rollouts: true })
    }

    /// As [`linearise`](Problem::linearise); `fit` keeps them.
    ///
    /// # Errors
    /// Where the simulator refuses both sides of a direction.
    pub(crate) fn settle(&self, fit: &mut Fit) -> Result<Linearisation> {
        let linear = self.linearise(fit)?;
        fit.linear = Some(linear.clone());
        Ok(linear)
    }

    /// Fits from `start` over the first share `horizon` of each recording.
    ///
    /// # Errors
    /// Where the simulator refuses the start; a refused step is only shortened.
    pub fn fit(&self, start: Point, horizon: f64) -> Result<Fit> {
        self.fit_with(start, horizon, None, &Settings::RESOLVED)
    }

    /// Two steps from `start`, which are enough to see a local minimum; `near` are derivatives of a point not far from it.
    pub(crate) fn fit_briefly(&self, start: Point, near: Option<&Linearisation>) -> Result<Fit> {
        let settings = Settings { steps: 2, ends_measured: false, ..Settings::RESOLVED };
        self.fit_with(start, 1.0, near, &settings)
    }

    /// At most so many steps from `start`, and derivatives measured so often: enough to rank it, where it is one of many. `near` are
    /// derivatives of a point not far from the start.
    pub(crate) fn fit_steps(
        &self,
        start: Point,
        near: Option<&Linearisation>,
        steps: usize,
        derivatives: usize,
    ) -> Result<Fit> {
        let settings = Settings { steps, derivatives, ends_measured: false, tolerance: 0.05, ..Settings::RESOLVED };
        self.fit_with(start, 1.0, near, &settings)
    }

    /// A few steps from `start` over the first share `horizon` of each recording, enough to go on from over a longer one.
    pub(crate) fn fit_share(&self, start: Point, horizon: f64) -> Result<Fit> {
        let settings =
            Settings { steps: 8, derivatives: 4, ends_measured: false, tolerance: 0.5, ..Settings::RESOLVED };
        self.fit_with(start, horizon, None, &settings)
    }

    /// Where these derivatives lead to from `point` if `residuals` are left there.
    pub(crate) fn stepped(&self, point: &Point, columns: &[Columns], residuals: &[Vec<f64>]) -> Point {
        full_step(&self.window(1.0), point, residuals, columns, robust_scale(residuals))
    }

    /// As [`fit`](Problem::fit), but ends as well where no more than `enough` of the cost is left to gain: a profile needs its
    /// cost, not the place in full precision. `near` are derivatives of a point not far from the start.
    pub(crate) fn fit_until(&self, start: Point, near: Option<&Linearisation>, enough: f64) -> Result<Fit> {
        let settings = Settings { tolerance: enough, ends_measured: false, ..Settings::RESOLVED };
        self.fit_with(start, 1.0, near, &settings)
    }

    fn fit_with(&self, start: Point, horizon: f64, near: Option<&Linearisation>, settings: &Settings) -> Result<Fit> {
        if let Some(log) = self.log {
            log.trim();
        }
        let window = self.window(horizon);
        let first = self.residuals(&start, horizon)?;
        let mut trace = vec![(start.at(self.free), self.rmse(&first))];
        let settings = Settings { first_measured: near.is_none(), ..*settings };
        let near = near.map(|near| near.of(self.free));
        let found = minimise(&window, start, first, near, &settings, &mut |point, residuals| {
            let gap = self.rmse(residuals);
            if let Some(log) = self.log {
                log.gap(gap);
            }
            trace.push((point.at(self.free), gap));
        })?;
        let (point, residuals) = (found.point, found.residuals);
        let cost = huber_cost(&residuals, robust_scale(&residuals)) + prior_cost(&window, &point);
        let rollouts = self.recordings.len() + found.rollouts;
        let linear = found.derivatives.map(|columns| Linearisation { columns, rollouts: false });
        let (covariance, cut_short) = (found.equations.covariance(), found.cut_short);
        Ok(Fit { point, residuals, cost, covariance, rollouts, trace, cut_short, linear })
    }

    /// `point` as it stands, judged and linearised but not moved.
    ///
    /// # Errors
    /// Where the simulator refuses it.
    pub fn evaluate(&self, point: Point) -> Result<Fit> {
        self.fit_with(point, 1.0, None, &Settings { steps: 0, ..Settings::EXACT })
    }

    /// Where the derivatives at `fit` lead to with these `values` of the parameters at `positions`: the least squares of everything
    /// else.
    ///
    /// # Errors
    /// Where derivatives that are not known yet are refused.
    pub(super) fn led_to(&self, fit: &Fit, positions: &[usize], values: &[f64]) -> Result<Point> {
        let linear = self.linearise(fit)?;
        let mut point = fit.point.clone();
        let mut residuals = fit.residuals.clone();
        for (&position, value) in positions.iter().zip(values) {
            let p = &self.simulator.parameters()[position];
            let moved = value.clamp(p.min, p.max);
            let step = moved - point.parameters[position];
            point.parameters[position] = moved;
            for (residual, one) in residuals.iter_mut().zip(&linear.columns) {
                let Some(column) = one.indices.iter().position(|&index| index == position) else { continue };
                residual.iter_mut().zip(&one.shared[column]).for_each(|(r, slope)| *r += slope * step);
            }
        }
        let others: Vec<usize> = self.free.iter().copied().filter(|f| !positions.contains(f)).collect();
        let problem = Problem { free: &others, ..*self };
        Ok(full_step(&problem.window(1.0), &point, &residuals, &linear.of(&others), robust_scale(&fit.residuals)))
    }

    /// What the data say of the free parameters at `fit`, each recording's nuisance parameters fitted: the Schur complement of the
    /// normal equations (the inverse of a covariance for noise as stated), the slope of −cost along each parameter,
    /// and the diagonal before the nuisance parameters took their share. Bounds are ignored.
    pub(crate) fn curvature(&self, fit: &Fit, linear: &Linearisation) -> (DMatrix<f64>, DVector<f64>, DVector<f64>) {
        let scale = robust_scale(&fit.residuals);
        let equations = normal_equations(&self.window(1.0), &linear.columns, &fit.residuals, &fit.point, scale);
        let (schur, slope) = equations.reduced();
        (schur, slope, equations.shared.diagonal())
    }
}

/// The root mean square of residuals in units of the `noise`, as [`Problem::rmse`] has it.
pub(crate) fn residual_gap(recordings: &[Prepared], noise: &[Vec<f64>], residuals: &[Vec<f64>]) -> f64 {
    let (mut squares, mut samples) = (0.0, 0.0);
    for ((residual, noise), recording) in residuals.iter().zip(noise).zip(recordings) {
        let width = noise.len();
        let one_unit = recording.seen.common_unit().is_some();
        let unit = |i: usize| if one_unit { noise[i % width] } else { 1.0 };
        squares += residual.iter().enumerate().map(|(i, r)| (r * unit(i)).powi(2)).sum::<f64>();
        samples += if one_unit { residual.len() / width } else { residual.len() } as f64;
    }
    (squares / samples).sqrt()
}

/// (measured − predicted) / noise for one recording, row-major `[sample, channel]`, over its first `samples` samples.
///
/// # Errors
/// Where the simulator refuses these values.
pub(crate) fn weighted(
    simulator: &dyn Simulator,
    recording: &Prepared,
    noise: &[f64],
    parameters: &[f64],
    nuisances: &[f64],
    samples: usize,
) -> Result<Vec<f64>> {
    let predicted = predict(simulator, recording, parameters, nuisances, &recording.seen.clock()[..samples])?;
    Ok(in_noise(predicted, recording, noise))
}

/// Predicted values as residuals.
fn in_noise(mut predicted: Vec<f64>, recording: &Prepared, noise: &[f64]) -> Vec<f64> {
    for (i, (value, seen)) in predicted.iter_mut().zip(recording.seen.values()).enumerate() {
        *value = (seen - *value) / noise[i % noise.len()];
    }
    predicted
}

/// The positions of the parameters that may be tuned and about which at least one recording says something.
#[must_use]
pub fn free(parameters: &[Parameter], recordings: &[Prepared]) -> Vec<usize> {
    let informative = |i: usize| recordings.iter().any(|r| r.silent[i].is_none());
    (0..parameters.len()).filter(|&i| parameters[i].tune && informative(i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::Preparation;
    use crate::testing::{Decay, Exact};

    /// Of y₀ exp(−k t) with the start fitted, the variance of k for noise as stated is the Schur complement of the two by two
    /// normal equations.
    #[test]
    fn a_decay_is_found_with_the_variance_of_its_closed_form() {
        let (simulator, sd) = (Exact::new(Decay), 1e-4);
        let name = simulator.parameters()[0].name.clone();
        let seen = simulator.observe(&[(name.as_str(), 1.3)], &[2.0], sd, 3).unwrap();
        let Preparation::Usable(prepared) = simulator.prepare(&seen).unwrap() else { panic!("refused") };
        let (recordings, noise) = ([*prepared], [vec![sd]]);
        let free = free(simulator.parameters(), &recordings);
        let problem = Problem { simulator: &simulator, recordings: &recordings, noise: &noise, free: &free, log: None };
        let fit = problem.fit(Point::start(&simulator, &recordings), 1.0).unwrap();
        let (mut kk, mut ks, mut ss) = (0.0, 0.0, 0.0);
        for t in seen.clock() {
            let (dk, ds) = (-2.0 * t * (-1.3 * t).exp() / sd, (-1.3 * t).exp() / sd);
            (kk, ks, ss) = (kk + dk * dk, ks + dk * ds, ss + ds * ds);
        }
        let variance = 1.0 / (kk - ks * ks / ss);
        assert!((fit.covariance[(0, 0)] / variance - 1.0).abs() < 1e-2, "{} {variance}", fit.covariance);
        assert!((fit.point.parameters[0] - 1.3).abs() < 4.0 * variance.sqrt(), "{:?}", fit.point);
        let stood = problem.evaluate(fit.point.clone()).unwrap();
        assert_eq!((stood.point, stood.cost, stood.rollouts), (fit.point, fit.cost, 3));
    }
}

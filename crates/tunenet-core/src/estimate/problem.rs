//! Nonlinear least squares with parameters that recordings share and nuisance parameters of each recording (Bates and Watts
//! 1988, chapter 3; the split by recordings as in Triggs et al. 2000, section 6).

use rayon::prelude::*;
use serde::Serialize;

use crate::observation::FEWEST_SAMPLES;
use crate::simulator::{Parameter, Prepared, Simulator, every};
use crate::statistics::mad_sd;
use crate::{Error, Origin, Result};

/// Forward-difference step, as a share of a parameter's bounds: far above rounding (1e-14 of a trajectory), far below
/// anything that bends.
pub(crate) const DIFFERENCE_STEP: f64 = 1e-6;

/// A point of the search: the shared parameters, free and fixed ones, and the nuisance parameters of every recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// All shared parameters, in the order of the simulator or of the hypothesis.
    pub parameters: Vec<f64>,
    /// The nuisance parameters, shape `[recording][nuisance parameter]`.
    pub nuisances: Vec<Vec<f64>>,
}

impl Point {
    /// The parameters as they stand in the simulator, and the recordings' first guesses.
    #[must_use]
    pub fn start(simulator: &dyn Simulator, recordings: &[Prepared]) -> Self {
        let parameters = simulator.parameters().iter().map(|p| p.value).collect();
        Self { parameters, nuisances: recordings.iter().map(Prepared::nuisance_values).collect() }
    }

    /// The same point with the parameters at `positions` replaced.
    #[must_use]
    pub fn with(&self, positions: &[usize], values: &[f64]) -> Self {
        let mut changed = self.clone();
        for (&position, &value) in positions.iter().zip(values) {
            changed.parameters[position] = value;
        }
        changed
    }

    /// The parameters at `positions`.
    #[must_use]
    pub fn at(&self, positions: &[usize]) -> Vec<f64> {
        positions.iter().map(|&i| self.parameters[i]).collect()
    }
}

/// What is fitted to what.
///
/// Lists of residuals and of columns follow the order of [`recordings`](LeastSquares::recordings).
pub(crate) trait LeastSquares: Sync {
    /// Positions of the free parameters in [`Point::parameters`].
    fn free(&self) -> &[usize];

    /// Positions of the fitted recordings in [`Point::nuisances`].
    fn recordings(&self) -> &[usize];

    /// The shared parameter at this position: its bounds.
    fn parameter(&self, position: usize) -> &Parameter;

    /// The free parameters that a recording depends on; the others cost it no rollout.
    fn touched(&self, _recording: usize) -> Vec<usize> {
        self.free().to_vec()
    }

    /// The nuisance parameters of a recording; the values are the means of their priors.
    fn nuisances(&self, recording: usize) -> &[Parameter];

    /// The standard deviation of a nuisance parameter's prior: its bounds unless more is known. That is too weak to matter
    /// where the data speak, and keeps a direction that they are silent on in place.
    fn prior_sd(&self, recording: usize, i: usize) -> f64 {
        self.nuisances(recording)[i].span()
    }

    /// Measured − predicted of a recording in units of the noise.
    ///
    /// # Errors
    /// Where the simulator refuses these values.
    fn residual(&self, recording: usize, parameters: &[f64], nuisances: &[f64]) -> Result<Vec<f64>>;

    /// The scale estimate of residuals, 1 at least.
    fn scale(&self, residuals: &[Vec<f64>]) -> f64 {
        robust_scale(residuals)
    }

    /// The difference step of a shared parameter.
    fn step(&self, position: usize) -> f64 {
        DIFFERENCE_STEP * self.parameter(position).span()
    }

    /// How many channels the recordings have.
    fn width(&self) -> usize {
        1
    }

    /// Whether parameters that act directly on channels of their own do so little to the others that a rollout shows the derivatives by
    /// several of them.
    fn is_separable(&self) -> bool {
        false
    }

    /// Curvature that is added to a shared parameter, so that one on which the data are silent stays put.
    fn ridge(&self, _position: usize) -> f64 {
        0.0
    }

    /// Where a step takes a shared parameter.
    fn stepped(&self, position: usize, value: f64, step: f64) -> f64 {
        let p = self.parameter(position);
        (value + step).clamp(p.min, p.max)
    }

    /// Whether so many more rollouts are allowed.
    fn affords(&self, _rollouts: usize) -> bool {
        true
    }

    /// How many rollouts are allowed in all; `None` where there is no limit.
    fn allowance(&self) -> Option<usize> {
        None
    }

    /// How many rollouts were made so far.
    fn spent(&self) -> usize {
        0
    }

    /// How many rollouts the first step takes at most.
    fn first_step(&self) -> usize {
        let columns: usize = self.recordings().iter().map(|&d| self.touched(d).len() + self.nuisances(d).len()).sum();
        2 * (self.recordings().len() + columns)
    }

    /// What is wrong where a first step takes more rollouts than are allowed.
    fn unaffordable(&self) -> Error {
        let step = self.first_step();
        // Where that many are allowed, other work took some of them.
        let least = if self.allowance().is_some_and(|allowed| allowed >= step) { self.spent() + step } else { step };
        let expected = format!("at least {least} rollouts, which the first step takes");
        let found = self.allowance().map_or_else(|| "fewer".into(), |allowed| allowed.to_string());
        Error::Setting { origin: Origin::Flag, name: "max_rollouts", expected, found }
    }

    /// Whether a direction that the simulator refuses on both sides is taken for one without slope, instead of an error.
    fn flat_where_refused(&self) -> bool {
        false
    }
}

/// Residuals of every recording.
///
/// # Errors
/// Where the simulator refuses.
pub(crate) fn residuals(problem: &dyn LeastSquares, point: &Point) -> Result<Vec<Vec<f64>>> {
    let each = |&d: &usize| problem.residual(d, &point.parameters, &point.nuisances[d]);
    every(problem.recordings().par_iter().map(each))
}

/// How many of `all` samples the first share `horizon` holds, enough for an observation where there are.
pub(crate) fn leading_samples(all: usize, horizon: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
    let share = (all as f64 * horizon).ceil() as usize;
    share.clamp(FEWEST_SAMPLES.min(all), all)
}

/// Half the squared distance of the nuisance parameters from the means of their priors, in standard deviations.
pub(crate) fn prior_cost(problem: &dyn LeastSquares, point: &Point) -> f64 {
    let each = problem.recordings().iter().flat_map(|&d| {
        let values = problem.nuisances(d).iter().zip(&point.nuisances[d]).enumerate();
        values.map(move |(i, (p, v))| 0.5 * ((v - p.value) / problem.prior_sd(d, i)).powi(2))
    });
    each.sum()
}

/// The greatest distance of two points in any free or nuisance parameter, as a share of its bounds.
pub(crate) fn distance(problem: &dyn LeastSquares, a: &Point, b: &Point) -> f64 {
    let shared = problem.free().iter();
    let shared = shared.map(|&i| (a.parameters[i] - b.parameters[i]).abs() / problem.parameter(i).span());
    let nuisances = problem.recordings().iter().flat_map(|&d| {
        let both = a.nuisances[d].iter().zip(&b.nuisances[d]);
        problem.nuisances(d).iter().zip(both).map(|(p, (a, b))| (a - b).abs() / p.span())
    });
    shared.chain(nuisances).fold(0.0, f64::max)
}

/// The residuals' own scale estimate where it exceeds the stated noise, so that a misfit of the whole is not taken for outliers.
pub(crate) fn robust_scale(residuals: &[Vec<f64>]) -> f64 {
    mad_sd(residuals.iter().flatten().copied()).max(1.0)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// `y = a + b t + u_d`: two shared parameters and a level of each recording, which differs from `a` only by its
    /// prior. Linear, so that every answer has a closed form.
    pub struct Lines {
        pub parameters: Vec<Parameter>,
        pub levels: Vec<Vec<Parameter>>,
        pub clock: Vec<f64>,
        pub seen: Vec<Vec<f64>>,
        pub free: Vec<usize>,
        pub recordings: Vec<usize>,
    }

    impl Lines {
        /// Recordings of `a + b t + level` without noise, at 0 s, 1 s, 2 s and 3 s; `a` is fixed at 0.
        pub fn new(b: f64, levels: &[f64]) -> Self {
            let clock: Vec<f64> = (0..4).map(f64::from).collect();
            let parameter = |name: &str, span: f64| Parameter::new(name, "m", 0.0, -span, span).unwrap();
            Self {
                parameters: vec![parameter("a", 10.0), parameter("b", 10.0)],
                levels: levels.iter().map(|_| vec![parameter("level", 1e4)]).collect(),
                seen: levels.iter().map(|level| clock.iter().map(|t| b * t + level).collect()).collect(),
                clock,
                free: vec![1],
                recordings: (0..levels.len()).collect(),
            }
        }

        pub fn start(&self) -> Point {
            Point { parameters: vec![0.0; 2], nuisances: vec![vec![0.0]; self.levels.len()] }
        }
    }

    impl LeastSquares for Lines {
        fn free(&self) -> &[usize] {
            &self.free
        }

        fn recordings(&self) -> &[usize] {
            &self.recordings
        }

        fn parameter(&self, position: usize) -> &Parameter {
            &self.parameters[position]
        }

        fn nuisances(&self, recording: usize) -> &[Parameter] {
            &self.levels[recording]
        }

        fn residual(&self, recording: usize, p: &[f64], nuisances: &[f64]) -> Result<Vec<f64>> {
            if p[1] > 9.0 {
                return Err(crate::Error::Simulator { at: "b".into(), message: "too steep".into() });
            }
            let seen = self.seen[recording].iter().zip(&self.clock);
            Ok(seen.map(|(y, t)| y - (p[0] + p[1] * t + nuisances[0])).collect())
        }
    }

    #[test]
    fn a_prior_costs_half_the_square_of_its_distance() {
        let lines = Lines::new(1.0, &[0.0, 0.0]);
        let point = Point { nuisances: vec![vec![2e4], vec![4e4]], ..lines.start() };
        assert_eq!(prior_cost(&lines, &point), 0.5 + 2.0);
        assert_eq!(distance(&lines, &point, &lines.start()), 2.0);
    }

    #[test]
    fn a_horizon_is_a_share_of_the_samples_and_never_too_few() {
        assert_eq!((leading_samples(200, 0.45), leading_samples(200, 0.0), leading_samples(2, 0.1)), (90, 3, 2));
    }

    #[test]
    fn a_scale_below_the_stated_noise_counts_as_the_noise() {
        assert_eq!(robust_scale(&[vec![0.1, -0.1, 0.2]]), 1.0);
    }
}

//! What tuning ends with.

use crate::estimate::matrix_rows::rows;
use crate::estimate::{Point, Region};
use crate::observation::Check;
use crate::observation::Note;
use crate::simulator::{Parameter, Prepared};
use crate::tune::channel_gaps::ChannelGap;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// The answer in one word. Each is a result, none an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The simulator now does what was measured, up to the noise.
    Tuned,
    /// No recording could be used.
    Rejected,
    /// The best parameters leave more than the noise explains, or end on a bound that the data push against.
    PoorFit,
    /// At least one parameter is not determined by the data.
    NotIdentifiable,
}

/// How a parameter stands after tuning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// The data determine it. On a bound, where the truth may lie, its interval is one-sided.
    Pinned,
    /// It has an influence, but its interval says no more than its bounds do, or is open towards one of them.
    Weak,
    /// It ends on a bound, and the data push significantly beyond it: the bound is wrong, or the simulation is.
    AtBound,
    /// It changes nothing in these recordings, so it keeps its value.
    NoEffect,
    /// Only a combination of it with others is determined: see the note `parameter.direction`.
    Direction,
}

impl Status {
    /// Whether the data determine the parameter.
    #[must_use]
    pub fn identified(self) -> bool {
        matches!(self, Self::Pinned | Self::AtBound)
    }
}

/// One tuned parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Its value before.
    pub before: f64,
    /// Its value now; the one before where nothing depends on it.
    pub value: f64,
    /// Its 95 % interval.
    pub interval95: (f64, f64),
    /// Its least and greatest allowed value.
    pub bounds: (f64, f64),
    /// Whether the data determine it.
    pub identified: bool,
    /// How it stands, and why it is not determined where it is not.
    pub status: Status,
}

/// One iteration: where the parameters stood, and how far the rollout there lay from the data.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Iteration {
    /// Its number, 0 for the start.
    pub k: usize,
    /// The fitted parameters, in the order of [`Outcome::free`].
    pub parameters: Vec<f64>,
    /// Root mean square of measured − predicted, in [`Gap::unit`].
    pub rmse: f64,
}

/// How far simulation and measurement lie apart, as a root mean square.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gap {
    /// The unit of all three: that of the channels, or σ ([`gap_unit`](crate::observation::gap_unit)).
    pub unit: String,
    /// With the parameters as they were, each recording's nuisance parameters fitted.
    pub before: f64,
    /// With the answer: of all parameters those that fit best, or those read off the events only (`fit.local`), which
    /// lie farther away.
    pub after: f64,
    /// What noise alone leaves.
    pub noise_floor: f64,
}

/// Why the iterations ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    /// All iterations that were asked for are done.
    Iterations,
    /// No step improves any more.
    Converged,
    /// No more rollouts were allowed.
    Limit,
    /// There was nothing to iterate on.
    Nothing,
}

/// Everything that tuning found. Numbers that are not finite become null in JSON.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// The answer.
    pub verdict: Verdict,
    /// The tuned parameters; empty where rejected.
    pub parameters: Vec<Estimate>,
    /// The names of those that were fitted: the order of [`Iteration::parameters`] and of the correlations. A parameter on
    /// which no recording has any bearing is not among them.
    pub free: Vec<String>,
    /// Names of numbers that are tied, group by group: parameters, and numbers that the simulation states, of which the recordings
    /// determine a combination only.
    pub tied: Vec<Vec<String>>,
    /// Correlations between the fitted ones, shape `[parameter, parameter]`.
    #[serde(serialize_with = "rows")]
    pub correlation: DMatrix<f64>,
    /// The joint 95 % region of those that the data bear on; absent with fewer than two, with a poor fit, and where the
    /// fit was not finished.
    pub region95: Option<Region>,
    /// Every iteration, the start first.
    pub iterations: Vec<Iteration>,
    /// The gap; absent where rejected.
    pub gap: Option<Gap>,
    /// The same for each recording used and each of its channels; empty where rejected.
    pub gaps: Vec<ChannelGap>,
    /// How many rollouts it took in all.
    pub rollouts: usize,
    /// Why it stopped.
    pub stop: Stop,
    /// What a user should know.
    pub notes: Vec<Note>,
    /// The start parameters with the nuisance parameters fitted to them: where [`Gap::before`] was taken.
    pub before: Option<Point>,
    /// The recordings used, as they were prepared for the fit.
    pub recordings: Vec<Prepared>,
    /// All parameters and nuisance parameters at the end.
    pub point: Option<Point>,
    /// For each recording used: its nuisance parameters as they were fitted, `value` being the answer; without those that it does
    /// not show, such as the height of a surface that it never touches.
    pub nuisances: Vec<Vec<Parameter>>,
    /// For each recording given: whether it was used.
    pub used: Vec<bool>,
    /// For each recording given: every check that was made of it.
    pub preflight: Vec<Vec<Check>>,
}

/// Posterior share of each of several fits to the same recordings; in their order, adding up to 1, and 0 for one that
/// fitted nothing. Gaussian errors of unknown variance, with the variance integrated out: Student's t. Each parameter more than
/// the least costs half the logarithm of the number of samples (Schwarz 1978).
#[must_use]
pub fn shares(fits: &[Outcome]) -> Vec<f64> {
    let parameter_count = |o: &Outcome| o.free.len() + o.nuisances.iter().map(Vec::len).sum::<usize>();
    let samples = |o: &Outcome| o.recordings.iter().map(|r| r.seen.len() * r.seen.channels().len()).sum::<usize>();
    let gap = |o: &Outcome| Some(o.gap.as_ref().filter(|_| o.verdict != Verdict::Rejected)?.after);
    let fitted = || fits.iter().filter(|o| gap(o).is_some());
    let most = fitted().map(parameter_count).max().unwrap_or(0);
    let log = |o: &Outcome| {
        let left = samples(o).saturating_sub(most) as f64;
        let cost = 0.5 * parameter_count(o) as f64 * (samples(o).max(1) as f64).ln();
        gap(o).map_or(f64::NEG_INFINITY, |gap| -left * gap.max(f64::MIN_POSITIVE).ln() - cost)
    };
    let logs: Vec<f64> = fits.iter().map(log).collect();
    let best = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let each: Vec<f64> = logs.iter().map(|log| if log.is_finite() { (log - best).exp() } else { 0.0 }).collect();
    let total: f64 = each.iter().sum();
    each.into_iter().map(|share| if total > 0.0 { share / total } else { 0.0 }).collect()
}

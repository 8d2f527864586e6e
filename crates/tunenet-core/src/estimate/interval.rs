//! Confidence intervals: Laplace approximation where the misfit is quadratic, profile likelihood otherwise (Bates and Watts 1988,
//! chapter 6).

use super::misfit_grid::GridPoint;
use super::output_error::{Fit, Linearisation, Problem};
use super::problem::{Point, robust_scale};
use crate::Result;
use crate::simulator::{Parameter, Prepared};
use crate::statistics::{UPPER_95, fisher_quantile, student_quantile};

/// The level of every interval that is stated.
pub const LEVEL: f64 = 0.95;
/// An interval as wide as this share of the bounds says no more than the bounds do: a value drawn evenly from them has a
/// 95 % interval of 0.95.
pub(crate) const UNINFORMATIVE_SHARE: f64 = 0.9;
/// Residuals that follow each other (ρ above 2/√n, where white noise stays below) carry less than they count.
const WORST_CORRELATION: f64 = 0.95;
/// A channel whose squared residuals are below this share of the largest channel's is exact.
const EXACT_SHARE: f64 = 1e-4;
/// Steps of the profile, as a share of the standard deviation and of the bounds.
const PROFILE_STEP_SD: f64 = 0.25;
const PROFILE_STEP_SPAN: f64 = 1.0 / 160.0;
/// The profile is flat while it lies this few standard deviations above the best; there the steps grow up to a share of the
/// bounds ...
const FLAT: f64 = 0.05;
const FLAT_STEP_SPAN: f64 = 1.0 / 40.0;
/// ... and a rise by more standard deviations than this in one step is gone through in quarters, down to a share of the
/// bounds.
const LARGEST_RISE: f64 = 1.0;
const LEAST_STEP_SPAN: f64 = 1e-7;
/// A step that raises the misfit by less than this many standard deviations was too short: the next is twice as long. The
/// curvature at a kink says nothing of what lies beyond it.
const SMALL_RISE: f64 = 0.25;
/// A fit along a profile may leave this much of the misfit, in squares of standard deviations.
const MISFIT_TOLERANCE: f64 = 1e-4;
/// The misfit at the ends of an interval from the curvature may stray from what the curvature says by this share of its quantile ...
const QUADRATIC: f64 = 0.2;
/// ... and to compare the two, a fit of everything else may leave this share of it.
pub(super) const COARSE: f64 = 0.02;
/// A bound farther from the estimate than this share of the bounds, and as good, leaves the estimate open.
const OPEN_SHARE: f64 = 0.25;

/// Residuals below the square root of this share of the noise of the recording itself are rounding: an interval of width 0 has no
/// ends to search for.
const LEAST_VARIANCE: f64 = 1e-8;

/// Scale estimate of a fit's residuals: their variance, its inflation by correlation, and the degrees of freedom.
#[derive(Debug, Clone, Copy)]
pub struct ScaleEstimate {
    /// Variance of the residuals in units of the stated noise, degrees of freedom taken off.
    pub variance: f64,
    /// By how much correlated residuals widen the variance of an estimate: (1 + ρ)/(1 − ρ), 1 where white.
    pub inflation: f64,
    /// Degrees of freedom left.
    pub degrees_of_freedom: f64,
}

impl ScaleEstimate {
    /// The scale estimate of `fit`'s residuals; for event times, whose errors may add up, from two variance components.
    #[must_use]
    pub fn of(problem: &Problem, fit: &Fit, linear: &Linearisation) -> Self {
        let alone = Self::of_single_errors(problem, fit, linear);
        match problem.accumulated_inflation(fit, linear, alone.variance) {
            Some(accumulated) => Self { inflation: accumulated.max(alone.inflation), ..alone },
            None => alone,
        }
    }

    /// As [`of`](ScaleEstimate::of) where no errors add up: for recordings that an input drove, from stretches of them.
    #[must_use]
    pub(crate) fn of_single_errors(problem: &Problem, fit: &Fit, linear: &Linearisation) -> Self {
        let alone = Self::of_residuals(problem, fit);
        match problem.robust_scale(fit, linear, alone.variance) {
            Some(blocks) => Self {
                variance: alone.variance,
                inflation: alone.inflation.max(blocks.inflation),
                degrees_of_freedom: alone.degrees_of_freedom.min(blocks.degrees_of_freedom),
            },
            None => alone,
        }
    }

    /// From the residuals alone: their size and their lag-one autocorrelation.
    #[must_use]
    pub(crate) fn of_residuals(problem: &Problem, fit: &Fit) -> Self {
        let width = problem.simulator.channels().len();
        let count = fit.residuals.iter().map(|r| moving(r, width) * r.len() / width).sum::<usize>();
        let fitted = problem.free.len() + fit.point.nuisances.iter().map(Vec::len).sum::<usize>();
        let degrees_of_freedom = count as f64 - fitted as f64;
        if degrees_of_freedom < 1.0 {
            return Self { variance: 1.0, inflation: 1.0, degrees_of_freedom: 1e6 };
        }
        let limit = 4.0 * robust_scale(&fit.residuals);
        let squares: f64 = fit.residuals.iter().flatten().map(|r| r.abs().min(limit).powi(2)).sum();
        let correlations = fit.residuals.iter().flat_map(|r| (0..width).map(move |c| correlation(r, c, width)));
        // Channels that carry next to nothing of the residual do not matter for its autocorrelation.
        let (top, bottom) = correlations.fold((0.0, 0.0), |(t, b), (product, square)| (t + product, b + square));
        let rho = if bottom > 0.0 { top / bottom } else { 0.0 };
        let rho = if rho > 2.0 / (count as f64).sqrt() { rho.min(WORST_CORRELATION) } else { 0.0 };
        let variance = (squares / degrees_of_freedom).max(LEAST_VARIANCE);
        Self { variance, inflation: (1.0 + rho) / (1.0 - rho), degrees_of_freedom }
    }

    /// Half-width of an interval of [`LEVEL`], in standard deviations.
    #[must_use]
    pub fn quantile(&self) -> f64 {
        self.one_sided(UPPER_95)
    }

    /// One-sided quantile of Student's t at this probability, in standard deviations.
    #[must_use]
    pub fn one_sided(&self, level: f64) -> f64 {
        student_quantile(level, self.degrees_of_freedom)
    }

    /// How far a cost lies above the least one, as a square of standard deviations: twice the difference over the variance
    /// of what the residuals are worth.
    #[must_use]
    pub fn excess(&self, cost_above_best: f64) -> f64 {
        (2.0 * cost_above_best / (self.variance * self.inflation)).max(0.0)
    }

    /// The cost that makes no difference to an [`excess`](ScaleEstimate::excess).
    pub(crate) fn negligible(&self) -> f64 {
        self.cost(MISFIT_TOLERANCE)
    }

    /// The cost above the least one of this [`excess`](ScaleEstimate::excess).
    pub(super) fn cost(&self, excess: f64) -> f64 {
        0.5 * excess * self.variance * self.inflation
    }

    /// The greatest [`excess`](ScaleEstimate::excess) within a joint region of this level for `count` parameters: `count` times the
    /// quantile of Fisher's F (Beale 1960).
    #[must_use]
    pub fn joint_quantile(&self, count: usize, level: f64) -> f64 {
        count as f64 * fisher_quantile(level, count as f64, self.degrees_of_freedom)
    }

    /// The standard deviation of an estimate whose variance for noise as stated is `variance`.
    #[must_use]
    pub fn sd(&self, variance: f64) -> f64 {
        (variance * self.variance * self.inflation).sqrt()
    }
}

/// How many channels have residuals at all. One that is exact (a body that falls straight down in simulated data) says
/// nothing of the noise of the others.
fn moving(residuals: &[f64], width: usize) -> usize {
    let size = |channel: usize| residuals.iter().skip(channel).step_by(width).map(|r| r * r).sum::<f64>();
    let sizes: Vec<f64> = (0..width).map(size).collect();
    let greatest = sizes.iter().copied().fold(0.0, f64::max);
    sizes.iter().filter(|s| **s > EXACT_SHARE * greatest).count().max(1)
}

/// Lag-one product and square sum of one channel's residuals.
fn correlation(residuals: &[f64], channel: usize, width: usize) -> (f64, f64) {
    let column = || residuals.iter().skip(channel).step_by(width);
    let product: f64 = column().zip(column().skip(1)).map(|(a, b)| a * b).sum();
    (product, column().map(|r| r * r).sum())
}

/// One end of an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// Where it lies.
    pub value: f64,
    /// Whether it is the bound because the data allow everything up to there; or the last value that the simulator does not
    /// refuse.
    pub bound: bool,
    /// How many standard deviations the misfit at this end lies above the best: the quantile where the data drew it.
    pub misfit: f64,
}

/// The two ends of a 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The lower end.
    pub low: End,
    /// The upper end.
    pub high: End,
}

impl Interval {
    /// Whether a bound this far from `value`, as a share of the bounds, fits within one standard deviation: the data say
    /// on which side the value lies, not where.
    #[must_use]
    pub fn open(&self, value: f64, span: f64) -> bool {
        let far = |end: End| end.bound && end.misfit < 1.0 && (end.value - value).abs() > OPEN_SHARE * span;
        far(self.low) || far(self.high)
    }
}

/// The 95 % interval of each free parameter, and the rollouts that it took beyond the fit.
///
/// From the curvature (Laplace) where the misfit at both ends is what the curvature says and the interval stays well inside
/// the bounds; otherwise the values whose misfit is within the quantile of the best, everything else fitted again (profile
/// likelihood). Where the simulator refuses what lies beyond a value, that value stands for the bound.
#[must_use]
pub fn ends(problem: &Problem, fit: &Fit, scale: &ScaleEstimate) -> (Vec<Interval>, usize) {
    ends_with(problem, fit, scale, &[])
}

/// The 95 % interval of each free parameter from the curvature alone, as far as the bounds reach.
pub(crate) fn curved(problem: &Problem, fit: &Fit, scale: &ScaleEstimate) -> Vec<Interval> {
    let of = |(i, &position): (usize, &usize)| {
        let p = &problem.simulator.parameters()[position];
        let sd = scale.sd(fit.covariance[(i, i)]).min(p.span());
        Profile { problem, fit, i, scale, sd }.within(p)
    };
    problem.free.iter().enumerate().map(of).collect()
}

/// As [`ends`]; an interval also includes those points of `grid` (for each free parameter) whose misfit is within the quantile.
pub(crate) fn ends_with(
    problem: &Problem,
    fit: &Fit,
    scale: &ScaleEstimate,
    grid: &[Vec<GridPoint>],
) -> (Vec<Interval>, usize) {
    let mut rollouts = 0;
    let mut all = Vec::with_capacity(problem.free.len());
    for (i, &position) in problem.free.iter().enumerate() {
        let p = &problem.simulator.parameters()[position];
        // Where the slope vanishes (impacts that return next to nothing) the curvature says nothing, but the profile still does.
        let sd = scale.sd(fit.covariance[(i, i)]).min(p.span());
        let value = fit.point.parameters[position];
        let profile = Profile { problem, fit, i, scale, sd };
        let places = grid.get(i).map_or(&[][..], Vec::as_slice);
        let alone = places.iter().all(|p| scale.excess(p.cost - fit.cost) > scale.quantile().powi(2));
        // For driven recordings the scale estimate is cluster-robust; a profile of the squares does not contain it.
        if problem.recordings.iter().all(|recording| recording.memoryless) && sd < p.span() {
            all.push(profile.curved());
            continue;
        }
        // Events are seen or not as a parameter nears its bound, so that the misfit may bend there beyond the interval.
        let near = if problem.recordings.iter().any(Prepared::has_events) {
            value - 3.0 * sd < p.min + 0.1 * p.span() || value + 3.0 * sd > p.max
        } else {
            sd >= p.span() || value <= p.min || value >= p.max
        };
        // Values that the simulator refuses cannot be compared with the curvature.
        if !near && alone && profile.is_quadratic(p, &mut rollouts).unwrap_or(true) {
            all.push(profile.within(p));
            continue;
        }
        all.push(profile.interval(places, &mut rollouts));
    }
    (all, rollouts)
}

/// Everything but the parameters at `positions` fitted from `start`, as closely as a misfit needs it.
///
/// # Errors
/// Where the simulator refuses.
pub(super) fn fit_with_fixed(
    problem: &Problem,
    mut start: Point,
    positions: &[usize],
    scale: &ScaleEstimate,
) -> Result<Fit> {
    // A value computed from a bound may exceed it by a rounding error.
    for &position in positions {
        let p = &problem.simulator.parameters()[position];
        start.parameters[position] = start.parameters[position].clamp(p.min, p.max);
    }
    let others: Vec<usize> = problem.free.iter().copied().filter(|f| !positions.contains(f)).collect();
    Problem { free: &others, ..*problem }.fit_until(start, None, scale.negligible())
}

/// As [`fit_with_fixed`] with these `values` at `positions`, from where the derivatives at `fit` lead to and by these derivatives:
/// where the misfit is quadratic, one rollout of each recording.
///
/// # Errors
/// Where the simulator refuses.
pub(super) fn fit_along(
    problem: &Problem,
    fit: &Fit,
    (positions, values): (&[usize], &[f64]),
    enough: f64,
) -> Result<Fit> {
    let others: Vec<usize> = problem.free.iter().copied().filter(|f| !positions.contains(f)).collect();
    let start = problem.led_to(fit, positions, values)?;
    Problem { free: &others, ..*problem }.fit_until(start, Some(&problem.linearise(fit)?), enough)
}

/// The misfit over one parameter, all else fitted.
struct Profile<'a> {
    problem: &'a Problem<'a>,
    fit: &'a Fit,
    i: usize,
    scale: &'a ScaleEstimate,
    sd: f64,
}

impl Profile<'_> {
    /// The interval of the curvature.
    fn curved(&self) -> Interval {
        let value = self.fit.point.parameters[self.problem.free[self.i]];
        let end = |side: f64| {
            let value = value + side * self.scale.quantile() * self.sd;
            End { value, bound: false, misfit: self.scale.quantile() }
        };
        Interval { low: end(-1.0), high: end(1.0) }
    }

    /// The interval of the curvature as far as the bounds reach.
    fn within(&self, p: &Parameter) -> Interval {
        let value = self.fit.point.parameters[self.problem.free[self.i]];
        let cut = |end: End, bound: f64, beyond: bool| {
            if !beyond {
                return end;
            }
            End { value: bound, bound: true, misfit: (bound - value).abs() / self.sd }
        };
        let Interval { low, high } = self.curved();
        Interval { low: cut(low, p.min, low.value < p.min), high: cut(high, p.max, high.value > p.max) }
    }

    /// Whether the misfit at both ends of the interval of the curvature is what the curvature says. At a kink it is not.
    fn is_quadratic(&self, p: &Parameter, rollouts: &mut usize) -> Result<bool> {
        let position = self.problem.free[self.i];
        let Interval { low, high } = self.within(p);
        let square = self.scale.quantile().powi(2);
        let is = |there: &Fit, end: End| {
            (self.scale.excess(there.cost - self.fit.cost) - end.misfit.powi(2)).abs() <= QUADRATIC * square
        };
        for end in [low, high] {
            let enough = self.scale.cost(COARSE * square);
            let there = fit_along(self.problem, self.fit, (&[position], &[end.value]), enough)?;
            *rollouts += there.rollouts;
            if is(&there, end) {
                continue;
            }
            // By derivatives at the end itself, in case those of the estimate mislead.
            let start = self.fit.point.with(&[position], &[end.value]);
            let there = fit_with_fixed(self.problem, start, &[position], self.scale)?;
            *rollouts += there.rollouts;
            if !is(&there, end) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Both ends.
    fn interval(&self, places: &[GridPoint], rollouts: &mut usize) -> Interval {
        let ((low, left), (high, right)) = (self.outermost(-1.0, places), self.outermost(1.0, places));
        *rollouts += left + right;
        Interval { low, high }
    }

    /// The edge in one direction, of the stretch around the estimate or of the farthest one that has one of `places`.
    fn outermost(&self, direction: f64, places: &[GridPoint]) -> (End, usize) {
        let position = self.problem.free[self.i];
        let (mut end, mut rollouts) = self.edge(direction, &self.fit.point, 0.0);
        let limit = self.scale.quantile();
        let mut beyond: Vec<&GridPoint> = places.iter().filter(|p| (p.value - end.value) * direction > 0.0).collect();
        // The farthest first.
        beyond.sort_by(|a, b| (b.value * direction).total_cmp(&(a.value * direction)));
        for place in beyond {
            // The place itself was fitted in two steps only.
            let Ok(there) = fit_with_fixed(self.problem, place.point.clone(), &[position], self.scale) else {
                continue;
            };
            rollouts += there.rollouts;
            let misfit = self.scale.excess(there.cost - self.fit.cost).sqrt();
            if misfit < limit {
                let (farther, used) = self.edge(direction, &there.point, misfit);
                rollouts += used;
                end = farther;
                break;
            }
        }
        (end, rollouts)
    }

    /// Walks from a point with this misfit towards a bound until the misfit exceeds the quantile; returns where, or the
    /// bound. Where the simulator refuses what lies beyond, the last value that it takes is the bound.
    fn edge(&self, direction: f64, from: &Point, misfit: f64) -> (End, usize) {
        let position = self.problem.free[self.i];
        let p = &self.problem.simulator.parameters()[position];
        let bound = if direction < 0.0 { p.min } else { p.max };
        let mut step =
            (PROFILE_STEP_SD * self.sd).max(PROFILE_STEP_SPAN * p.span() * 1e-3).min(PROFILE_STEP_SPAN * p.span());
        let (mut point, mut rollouts) = (from.clone(), 0);
        let (mut before, mut misfit_before) = (point.parameters[position], misfit);
        let limit = self.scale.quantile();
        loop {
            let value = before + direction * step;
            let value = if (bound - value) * direction <= 0.0 { bound } else { value };
            let mut moved = point.clone();
            moved.parameters[position] = value;
            let Ok(there) = fit_with_fixed(self.problem, moved, &[position], self.scale) else {
                rollouts += self.problem.recordings.len();
                if step <= LEAST_STEP_SPAN * p.span() {
                    return (End { value: before, bound: true, misfit: misfit_before }, rollouts);
                }
                step = (value - before).abs() / 4.0;
                continue;
            };
            rollouts += there.rollouts;
            let misfit = self.scale.excess(there.cost - self.fit.cost).sqrt();
            // A jump is looked at more closely before it is interpolated.
            if misfit >= limit && misfit - misfit_before > LARGEST_RISE && step > LEAST_STEP_SPAN * p.span() {
                step = (value - before).abs() / 4.0;
                continue;
            }
            if misfit >= limit {
                let share = (limit - misfit_before) / (misfit - misfit_before).max(f64::MIN_POSITIVE);
                let value = before + share.clamp(0.0, 1.0) * (value - before);
                return (End { value, bound: false, misfit: limit }, rollouts);
            }
            if value == bound {
                return (End { value: bound, bound: true, misfit }, rollouts);
            }
            if misfit - misfit_before < SMALL_RISE {
                step *= 2.0;
            }
            // Where nothing changes there is nothing to step over.
            let longest = if misfit < FLAT { FLAT_STEP_SPAN } else { PROFILE_STEP_SPAN };
            step = step.min(longest * p.span());
            (before, misfit_before, point) = (value, misfit, there.point);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::{Preparation, Simulator};
    use crate::statistics::NORMAL_95;
    use crate::testing::{Exact, Line};

    /// Of y = y₀ + b t the half-width of b is the quantile of Student's t times σ/√Σ(t − mean)².
    #[test]
    fn the_interval_of_a_slope_is_the_closed_form() {
        let (simulator, sd) = (Exact::new(Line), 0.01);
        let seen = simulator.observe(&[("slope", 2.0)], &[0.5], sd, 11).unwrap();
        let Preparation::Usable(prepared) = simulator.prepare(&seen).unwrap() else { panic!("refused") };
        let (recordings, noise) = ([*prepared], [vec![sd]]);
        let problem = Problem { simulator: &simulator, recordings: &recordings, noise: &noise, free: &[0], log: None };
        let fit = problem.fit(Point::start(&simulator, &recordings), 1.0).unwrap();
        let scale = ScaleEstimate::of(&problem, &fit, &problem.linearise(&fit).unwrap());
        let (found, _) = ends(&problem, &fit, &scale);
        let n = seen.len() as f64;
        let mean = seen.clock().iter().sum::<f64>() / n;
        let squares: f64 = seen.clock().iter().map(|t| (t - mean).powi(2)).sum();
        let half = scale.quantile() * sd * (scale.variance * scale.inflation / squares).sqrt();
        let (low, high) = (found[0].low.value, found[0].high.value);
        assert!(((high - low) / 2.0 / half - 1.0).abs() < 1e-3, "{low} {high} {half}");
        assert!(low < 2.0 && 2.0 < high && (scale.quantile() / NORMAL_95 - 1.0).abs() < 0.02);
    }

    #[test]
    fn a_far_bound_that_fits_as_well_leaves_an_estimate_open() {
        let end = |value, misfit| End { value, bound: true, misfit };
        let interval = Interval { low: end(0.0, 0.2), high: end(1.0, 1.9) };
        assert!(interval.open(0.5, 1.0) && !interval.open(0.2, 1.0));
    }
}

//! Levenberg–Marquardt with multiplicative damping (Marquardt 1963), within bounds, in its secant version (Madsen, Nielsen and Tingleff 2004,
//! section 3.5): between derivatives that are measured, those in use [follow](super::derivatives) the residuals.

use nalgebra::DVector;

use super::block_arrow::Arrow;
use super::derivatives::{Exact, Origin, column_count, derivatives, secant};
use super::huber::huber_cost;
use super::jacobian::Columns;
use super::normal_equations::{hold_at_bounds, normal_equations};
use super::problem::{LeastSquares, Point, distance, prior_cost, residuals as residuals_at};
use crate::{Error, Result};

/// A step that gains this share of gradient times step, of which a quadratic gains 0.5, leaves derivatives that are worth following.
const TRUSTED: f64 = 0.3;
/// Derivatives are those of a point that is within this many standard deviations of the one where they were measured.
const NEAR_SDS: f64 = 0.5;
/// The step that is still to go is computed with no more damping than this: a strong one would hide it.
const LIGHT_DAMPING: f64 = 1e-6;
/// After derivatives were measured so many times, a fit shows whether it is hopeless.
const PATIENCE: usize = 2;
/// Where derivatives are off by more than what a step gains, as next to a kink or where much is left that the model cannot explain,
/// steps go on for long. So many in a row end the fit, ...
const SLOW_STEPS: usize = 3;
/// ... if each gains less than this share of the residuals' mean square, which is what 0.03 standard deviations are worth.
const SLOW_GAIN: f64 = 5e-4;
/// Mean squares of residuals below this share of the noise are rounding.
const LEAST_SQUARE: f64 = 1e-8;

/// How far a fit goes. What callers set differently stands here by name.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Settings {
    /// Most steps.
    pub steps: usize,
    /// Most times that derivatives are measured.
    pub derivatives: usize,
    /// The damping of the first step, as a share of the diagonal; a tenth of it after a success, ten times after a failure.
    pub damping: f64,
    /// It never falls below this ...
    pub least_damping: f64,
    /// ... and beyond this no step is tried.
    pub greatest_damping: f64,
    /// A step that moves everything by less than this share of the bounds has arrived.
    pub still: f64,
    /// A step that gains less than this share of the cost ends the fit.
    pub tolerance_share: f64,
    /// Steps in a row that each gain no more cost than this end the fit; 0.5 is what the noise of one sample is worth.
    pub tolerance: f64,
    /// How many such steps.
    pub small_steps: usize,
    /// Whether a worse step is not shortened where the linear model promises less than `tolerance` by it.
    pub predicts: bool,
    /// Whether the last step has to be one by derivatives that were measured, as its normal equations then are.
    pub ends_measured: bool,
    /// A step of fewer standard deviations of the estimate than this is not taken, and ends the fit; 0 takes every step.
    pub resolution: f64,
    /// A fit that costs more than this when its derivatives have to be measured once more ends after the second time.
    pub hopeless: f64,
    /// Whether derivatives that are given are those at the start, instead of those of a point not far from it.
    pub first_measured: bool,
}

impl Settings {
    /// To the last digit: an interval is cut from differences of the cost.
    pub const EXACT: Self = Self {
        steps: 120,
        derivatives: 40,
        damping: 1e-3,
        least_damping: 1e-12,
        greatest_damping: 1e12,
        still: 1e-12,
        tolerance_share: 1e-12,
        tolerance: 0.0,
        small_steps: 2,
        predicts: false,
        ends_measured: true,
        resolution: 0.0,
        hopeless: f64::INFINITY,
        first_measured: true,
    };

    /// To a thousandth of a standard deviation, which is more than an answer shows.
    pub const RESOLVED: Self = Self { resolution: 1e-3, ..Self::EXACT };
}

/// What a fit ended with.
pub(crate) struct Minimum {
    pub point: Point,
    /// Residuals there, in the order of the problem's recordings.
    pub residuals: Vec<Vec<f64>>,
    /// The normal equations of the last step, those at the start where none was taken.
    pub equations: Arrow,
    /// The derivatives that were measured last, where that was near enough to `point`.
    pub derivatives: Option<Vec<Columns>>,
    /// The derivatives in use at the end, of a point that is not far from `point`.
    pub nearby: Option<Vec<Columns>>,
    /// Whether it ended because no more rollouts are allowed.
    pub cut_short: bool,
    /// Whether it ended without hope, and may not be a minimum.
    pub abandoned: bool,
    /// Rollouts that were asked for.
    pub rollouts: usize,
}

/// Fits from `start`, whose residuals are `residuals`; `first` are the derivatives there where they are known. Every accepted
/// point is shown to `seen`.
///
/// # Errors
/// Where the simulator fails, or refuses a direction on both sides and that does not count as flat. A refused step is shortened.
pub(crate) fn minimise(
    problem: &dyn LeastSquares,
    start: Point,
    mut residuals: Vec<Vec<f64>>,
    first: Option<Vec<Columns>>,
    settings: &Settings,
    seen: &mut dyn FnMut(&Point, &[Vec<f64>]),
) -> Result<Minimum> {
    let mut point = start;
    let (mut damping, mut small_steps, mut rollouts, mut steps) = (settings.damping, SmallSteps::default(), 0, 0);
    let resolves = settings.resolution > 0.0;
    let mut exact = Exact::none();
    if settings.first_measured && resolves {
        exact.columns.clone_from(&first);
        exact.moved_sds = 0.0;
    }
    let mut columns = first;
    let mut origin = if settings.first_measured { Origin::Measured } else { Origin::Followed };
    let (mut confirms, mut derived, mut cut_short, mut abandoned) = (false, 0, false, false);
    let (mut equations, mut last) = (None, None);
    while steps < settings.steps {
        let scale = problem.scale(&residuals);
        let cost = huber_cost(&residuals, scale) + prior_cost(problem, &point);
        let known = match columns.take() {
            Some(known) => known,
            None if derived == settings.derivatives => break,
            None if derived >= PATIENCE && cost > settings.hopeless => {
                abandoned = true;
                break;
            }
            None if !problem.affords(column_count(problem)) => {
                cut_short = true;
                break;
            }
            None => {
                origin = if problem.is_separable() && !confirms { Origin::Grouped } else { Origin::Measured };
                derived += 1;
                let known = derivatives(problem, &point, &residuals, origin, &mut rollouts)?;
                if resolves && origin == Origin::Measured {
                    exact = Exact { columns: Some(known.clone()), moved_sds: 0.0 };
                }
                known
            }
        };
        let ends = origin.may_end(settings.ends_measured);
        let linear = linearised(problem, &point, &residuals, &known, scale);
        let square = mean_square(&residuals, cost);
        let negligible = (settings.resolution.powi(2) * square).max(2.0 * settings.tolerance);
        if resolves && Step::damped(&linear, damping.min(LIGHT_DAMPING)).promised <= negligible {
            (equations, last) = (Some(linear), Some(known));
            if ends || !settings.ends_measured {
                break;
            }
            confirms = true;
            continue;
        }
        let followed = origin == Origin::Followed;
        let trial = Trial { problem, point: &point, linear: &linear, cost, scale, negligible, settings, followed };
        let (improved, short) = trial.improved(&mut damping, &mut rollouts)?;
        cut_short |= short;
        equations = Some(linear);
        let Some(Improved { point: candidate, residuals: new, gain, promised }) = improved else {
            last = Some(known);
            if ends || cut_short {
                break;
            }
            confirms |= origin == Origin::Grouped;
            continue;
        };
        let still = distance(problem, &point, &candidate) < settings.still;
        let small = small_steps.after(gain, square, settings);
        let arrived = still || gain <= settings.tolerance_share * cost || small;
        let trusted = gain >= TRUSTED * promised;
        exact.moved_sds += (promised / square).sqrt();
        // So near, derivatives that were measured are better than those that follow the noise of a step.
        let holds = resolves && exact.moved_sds < NEAR_SDS;
        if holds {
            columns.clone_from(&exact.columns);
        } else if !arrived && trusted {
            columns = Some(secant(problem, known, (&point, &candidate), (&residuals, &new)));
        } else {
            last = Some(known);
        }
        (point, residuals) = (candidate, new);
        seen(&point, &residuals);
        steps += 1;
        damping = (damping / 10.0).max(settings.least_damping);
        if arrived && (ends || trusted && !settings.ends_measured) {
            break;
        }
        confirms |= arrived;
        origin = if holds { Origin::Measured } else { Origin::Followed };
    }
    let nearby = columns.or(last);
    let equations = match (equations, &nearby) {
        (Some(known), _) => known,
        (None, Some(known)) => linearised(problem, &point, &residuals, known, problem.scale(&residuals)),
        (None, None) if cut_short => return Err(problem.unaffordable()),
        (None, None) => {
            let known = derivatives(problem, &point, &residuals, Origin::Measured, &mut rollouts)?;
            linearised(problem, &point, &residuals, &known, problem.scale(&residuals))
        }
    };
    let derivatives = exact.columns.filter(|_| cut_short || exact.moved_sds < NEAR_SDS);
    Ok(Minimum { point, residuals, equations, derivatives, nearby, cut_short, abandoned, rollouts })
}

/// Steps in a row that gained next to nothing.
#[derive(Default)]
struct SmallSteps {
    /// By the tolerance of the settings.
    tolerated: usize,
    /// By [`SLOW_GAIN`].
    slow: usize,
}

impl SmallSteps {
    /// Takes what a step gained, where residuals have this mean square; whether so many were enough.
    fn after(&mut self, gain: f64, square: f64, settings: &Settings) -> bool {
        self.tolerated = if gain <= settings.tolerance { self.tolerated + 1 } else { 0 };
        let slow = settings.resolution > 0.0 && gain <= SLOW_GAIN * square;
        self.slow = if slow { self.slow + 1 } else { 0 };
        self.tolerated >= settings.small_steps || self.slow >= SLOW_STEPS
    }
}

/// One linearisation from which damped steps are tried.
struct Trial<'a> {
    problem: &'a dyn LeastSquares,
    point: &'a Point,
    linear: &'a Arrow,
    cost: f64,
    scale: f64,
    /// A promise of no more than this is not worth a rollout.
    negligible: f64,
    settings: &'a Settings,
    /// Whether the derivatives followed the steps, instead of being measured at the point.
    followed: bool,
}

/// A step that did not make the cost worse.
struct Improved {
    point: Point,
    residuals: Vec<Vec<f64>>,
    gain: f64,
    promised: f64,
}

impl Trial<'_> {
    /// The first step of rising damping that improves the cost, where there is any; and whether the allowance of rollouts ended the
    /// search.
    ///
    /// # Errors
    /// Where the simulator failed.
    fn improved(&self, damping: &mut f64, rollouts: &mut usize) -> Result<(Option<Improved>, bool)> {
        let Self { problem, settings, .. } = *self;
        let resolves = settings.resolution > 0.0;
        let mut growth = 10.0;
        while *damping < settings.greatest_damping {
            if !problem.affords(problem.recordings().len()) {
                return Ok((None, true));
            }
            let step = Step::damped(self.linear, *damping);
            let candidate = step.from(problem, self.point);
            *rollouts += problem.recordings().len();
            // A refused or worse step is a step too long; or the derivatives mislead.
            let moved = residuals_at(problem, &candidate);
            if let Err(broken @ Error::SimulatorBroken { .. }) = moved {
                return Err(broken);
            }
            if let Ok(residuals) = moved {
                let cost = huber_cost(&residuals, self.scale) + prior_cost(problem, &candidate);
                if cost <= self.cost {
                    let (gain, promised) = (self.cost - cost, step.promised);
                    return Ok((Some(Improved { point: candidate, residuals, gain, promised }), false));
                }
                // Nothing worth having is left in this direction.
                let little = settings.predicts && step.promised < settings.tolerance;
                if little || resolves && step.promised <= self.negligible {
                    break;
                }
            }
            if self.followed {
                break;
            }
            *damping *= growth;
            if resolves {
                growth *= 10.0;
            }
        }
        Ok((None, false))
    }
}

/// The mean square of the residuals at this cost.
fn mean_square(residuals: &[Vec<f64>], cost: f64) -> f64 {
    let count: usize = residuals.iter().map(Vec::len).sum();
    (2.0 * cost / count.max(1) as f64).max(LEAST_SQUARE)
}

/// The normal equations at a point, what pushes against a bound held there.
fn linearised(
    problem: &dyn LeastSquares,
    point: &Point,
    residuals: &[Vec<f64>],
    columns: &[Columns],
    scale: f64,
) -> Arrow {
    let mut equations = normal_equations(problem, columns, residuals, point, scale);
    hold_at_bounds(problem, point, &mut equations);
    equations
}

/// Where a step without damping leads.
pub(super) fn full_step(
    problem: &dyn LeastSquares,
    point: &Point,
    residuals: &[Vec<f64>],
    columns: &[Columns],
    scale: f64,
) -> Point {
    Step::damped(&linearised(problem, point, residuals, columns, scale), Settings::EXACT.least_damping)
        .from(problem, point)
}

/// A damped step.
struct Step {
    shared: DVector<f64>,
    nuisances: Vec<DVector<f64>>,
    /// Gradient times step: twice what a quadratic gains in cost by the undamped step.
    promised: f64,
}

impl Step {
    fn damped(equations: &Arrow, damping: f64) -> Self {
        let (shared, nuisances) = equations.solve(damping);
        let own: f64 = equations.blocks.iter().zip(&nuisances).map(|(b, step)| b.nuisance_right.dot(step)).sum();
        let promised = shared.dot(&equations.right) + own;
        Self { shared, nuisances, promised }
    }

    /// Where it leads, within the bounds.
    fn from(&self, problem: &dyn LeastSquares, point: &Point) -> Point {
        let mut moved = point.clone();
        for (&index, step) in problem.free().iter().zip(self.shared.iter()) {
            moved.parameters[index] = problem.stepped(index, point.parameters[index], *step);
        }
        for (&d, steps) in problem.recordings().iter().zip(&self.nuisances) {
            for ((value, step), p) in moved.nuisances[d].iter_mut().zip(steps.iter()).zip(problem.nuisances(d)) {
                *value = (*value + step).clamp(p.min, p.max);
            }
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::jacobian::tests::Coupled;
    use crate::estimate::problem::tests::Lines;
    use crate::simulator::Parameter;

    fn fitted(lines: &Lines, settings: &Settings) -> (Minimum, usize) {
        let start = lines.start();
        let left = residuals_at(lines, &start).unwrap();
        let mut accepted = 0;
        let found = minimise(lines, start, left, None, settings, &mut |_, _| accepted += 1).unwrap();
        (found, accepted)
    }

    #[test]
    fn a_line_is_found_with_the_level_of_each_recording() {
        let (found, accepted) = fitted(&Lines::new(1.5, &[2.0, -1.0]), &Settings::EXACT);
        assert!((found.point.parameters[1] - 1.5).abs() < 1e-6, "{:?}", found.point);
        assert!((found.point.nuisances[0][0] - 2.0).abs() < 1e-6, "{:?}", found.point);
        assert!(accepted > 0 && found.rollouts >= accepted * 2);
        // The derivatives in use at the end begin another fit as well as those that are measured.
        let (problem, start) = (Lines::new(1.5, &[2.0, -1.0]), Lines::new(1.5, &[2.0, -1.0]).start());
        let left = residuals_at(&problem, &start).unwrap();
        let few = Settings { derivatives: 0, ends_measured: false, first_measured: false, ..Settings::EXACT };
        let again = minimise(&problem, start, left, found.nearby, &few, &mut |_, _| {}).unwrap();
        assert!((again.point.parameters[1] - 1.5).abs() < 1e-6 && again.rollouts < found.rollouts);
    }

    #[test]
    fn a_bound_holds_and_what_is_refused_is_only_a_step_too_long() {
        // The slope that fits best, −12, lies beyond the bound at −10; above 9 the simulator refuses.
        let (low, _) = fitted(&Lines::new(-12.0, &[0.0]), &Settings::EXACT);
        assert_eq!(low.point.parameters[1], -10.0);
        let (high, _) = fitted(&Lines::new(9.5, &[0.0]), &Settings::EXACT);
        assert!((8.5..=9.0).contains(&high.point.parameters[1]), "{:?}", high.point);
    }

    #[test]
    fn without_a_step_the_equations_are_those_of_the_start() {
        let (found, accepted) = fitted(&Lines::new(1.0, &[0.0]), &Settings { steps: 0, ..Settings::EXACT });
        assert_eq!((accepted, found.point.parameters[1]), (0, 0.0));
        assert!((found.equations.covariance()[(0, 0)] - 0.2).abs() < 1e-6);
    }

    /// The residuals of Rosenbrock's function (Rosenbrock 1960), which no secant follows for long.
    struct Rosenbrock([Parameter; 2]);

    impl LeastSquares for Rosenbrock {
        fn free(&self) -> &[usize] {
            &[0, 1]
        }

        fn recordings(&self) -> &[usize] {
            &[0]
        }

        fn parameter(&self, position: usize) -> &Parameter {
            &self.0[position]
        }

        fn nuisances(&self, _recording: usize) -> &[Parameter] {
            &[]
        }

        fn residual(&self, _recording: usize, parameters: &[f64], _nuisances: &[f64]) -> Result<Vec<f64>> {
            let [x, y] = [parameters[0], parameters[1]];
            Ok(vec![10.0 * (y - x * x), 1.0 - x])
        }
    }

    /// It needs derivatives many times; what costs more than is hoped for ends when they would be measured for the third time.
    #[test]
    fn a_fit_without_hope_ends_early() {
        let problem = Rosenbrock(["x", "y"].map(|name| Parameter::new(name, "1", 0.0, -3.0, 3.0).unwrap()));
        let fitted = |hopeless: f64| {
            let start = Point { parameters: vec![-1.2, 1.0], nuisances: vec![Vec::new()] };
            let left = residuals_at(&problem, &start).unwrap();
            let settings = Settings { hopeless, ..Settings::EXACT };
            minimise(&problem, start, left, None, &settings, &mut |_, _| {}).unwrap()
        };
        let (whole, cut) = (fitted(f64::INFINITY), fitted(0.0));
        assert!((whole.point.parameters[0] - 1.0).abs() < 1e-3, "{:?}", whole.point);
        assert!(cut.rollouts < whole.rollouts / 2, "{} of {}", cut.rollouts, whole.rollouts);
        assert!(cut.abandoned && !whole.abandoned);
    }

    /// With derivatives that leave out what crosses, a fit ends where one with all of them does, by fewer rollouts, and the last are measured.
    #[test]
    fn grouped_derivatives_lead_to_the_same_minimum() {
        for share in [0.0, 0.2] {
            let problem = Coupled::new(share);
            let left = residuals_at(&problem, &Coupled::start()).unwrap();
            let found = minimise(&problem, Coupled::start(), left, None, &Settings::EXACT, &mut |_, _| {}).unwrap();
            let near = |(found, truth): (&f64, f64)| (found - truth).abs() < 1e-6;
            assert!(found.point.parameters.iter().zip(Coupled::TRUE).all(near), "{share}: {:?}", found.point);
            let counted = problem.rollouts.load(std::sync::atomic::Ordering::Relaxed);
            assert_eq!(found.rollouts + 1, counted);
        }
    }

    /// Only steps in a row count, and only in a fit that is resolved no farther than answers show.
    #[test]
    fn slow_steps_end_a_resolved_fit_alone() {
        let after = |settings: &Settings, gains: &[f64]| {
            let mut steps = SmallSteps::default();
            gains.iter().map(|gain| steps.after(*gain, 1.0, settings)).collect::<Vec<_>>()
        };
        assert_eq!(
            after(&Settings::RESOLVED, &[1e-4, 1e-4, 1.0, 1e-4, 1e-4, 1e-4]),
            [false, false, false, false, false, true]
        );
        assert_eq!(after(&Settings::EXACT, &[1e-4; 4]), [false; 4]);
    }

    #[test]
    fn it_ends_at_the_given_step_tolerance() {
        let two = Settings { tolerance: f64::INFINITY, ends_measured: false, ..Settings::EXACT };
        assert_eq!(fitted(&Lines::new(1.5, &[2.0]), &two).1, 2);
        // The second step follows the derivatives of the first, so that a third has to confirm it.
        assert_eq!(fitted(&Lines::new(1.5, &[2.0]), &Settings { ends_measured: true, ..two }).1, 3);
        assert_eq!(fitted(&Lines::new(1.5, &[2.0]), &Settings { small_steps: 1, ..two }).1, 1);
    }

    #[test]
    fn a_line_needs_its_derivatives_twice() {
        let lines = Lines::new(1.5, &[2.0, -1.0]);
        let (found, accepted) = fitted(&lines, &Settings::EXACT);
        assert_eq!(
            found.rollouts,
            2 * 2 * 2 + 2 * accepted,
            "two columns of two recordings, at the start and at the end"
        );
    }
}

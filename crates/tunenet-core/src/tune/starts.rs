//! Multistart: several starting points, so that neither a poor guess in the file nor a plateau decides the answer.

use super::Tuning;
use crate::estimate::problem::robust_scale;
use crate::estimate::{Fit, MisfitGrid, Phase, Point, Problem};
use crate::observation::LocalEstimate;
use crate::simulator::Prepared;
use crate::{Error, Result};

/// A fit whose residual exceeds the noise this many times may sit in a wrong local minimum and is repeated from other starts.
const SUSPICIOUS_SCALE: f64 = 3.0;
/// ... and one whose mean square does so this many times, where the median is blind: a channel or two may be far off while
/// the others fit.
const SUSPICIOUS_SQUARE: f64 = 2.0;
/// A fit that ends within this share of the bounds from one of them is looked at again ...
const NEAR_BOUND: f64 = 0.1;
/// ... or within this share where the misfit is smooth and nothing but noise is left ...
const ON_BOUND: f64 = 1e-4;
/// ... from these shares away from it.
const BOUND_STARTS: [f64; 10] = [0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.09, 0.1];
/// Starts across the bounds, for the case that neither the file nor the data suggest a good one. Small ones lie closer: where
/// friction is large enough to stop the slip, more of it changes nothing.
const GRID_STARTS: [f64; 7] = [0.02, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9];
/// Places across the bounds, denser towards the lower one, for parameters that the events say nothing of.
const STARTS_AROUND_LOCAL: u32 = 24;
/// The nearest starts with what the events suggest that are fitted before any other.
const LOCAL_FITS: usize = 2;
/// Starts across the bounds that are fitted briefly, and the steps of such a fit: enough to see to which local minimum it leads.
const BRIEF_FITS: usize = 4;
const BRIEF_STEPS: usize = 8;
/// Another minimum is lower by at least so much in cost; fits of the same minimum end farther apart than rounding.
const LOWER: f64 = 1.0;

/// Two misfits closer than this share of them are the same.
const SAME_MISFIT: f64 = 1e-9;
/// Places across the bounds, denser towards the lower one, at which a parameter without influence is looked for one.
const FLAT_STARTS: u32 = 40;

impl Tuning<'_> {
    /// The recordings' nuisance parameters fitted at `start`, or their first guesses where a limit leaves too few rollouts for that besides
    /// the first step of the fit.
    ///
    /// # Errors
    /// Where the limit does not even leave these, and where the simulator refuses.
    pub(super) fn fit_nuisances(&self, start: &Point) -> Result<Fit> {
        let problem = self.problem();
        let first_step = problem.first_step();
        if self.log.allowance().is_some_and(|allowed| allowed < first_step) {
            return Err(problem.unaffordable());
        }
        let log = self.log.reserving(first_step);
        let nuisances = Problem { free: &[], log: Some(&log), ..self.problem() };
        let none = self.recordings.iter().all(|recording| recording.nuisances.is_empty());
        if none || log.affords(nuisances.first_step()) {
            return Problem { log: Some(if none { self.log } else { &log }), ..nuisances }.fit(start.clone(), 1.0);
        }
        Problem { log: Some(self.log), ..nuisances }.evaluate(start.clone())
    }

    /// The best fit, and the places that were looked at around it.
    ///
    /// Where the misfit is smooth, a fit that leaves no more than noise and lies within the bounds is the answer. Otherwise the best
    /// of several starts, `near` and `also` among them, more of them where the first leaves too much; then what lies along
    /// bounds, past flats and in neighbouring local minima.
    pub(super) fn best_fit(&self, near: &Point, also: Option<Point>) -> Result<(Fit, MisfitGrid)> {
        let problem = self.problem();
        self.log.phase(Phase::Fit);
        // A driven thing does not go its own way after a bad start: what it shows is nearly linear in its parameters.
        if self.free.is_empty() || self.settings.quick || self.recordings.iter().all(|recording| recording.memoryless) {
            return Ok((problem.fit(near.clone(), 1.0)?, Vec::new()));
        }
        if self.recordings.iter().all(|recording| recording.discrepancy) {
            let starts = std::iter::once(near.clone()).chain(also).chain(self.nearest_across_bounds(near));
            return Ok((self.best_of_brief_fits(starts, None)?, Vec::new()));
        }
        if self.has_events() {
            let found = self.best_of_starts(near, also, None)?;
            let found = self.look_past_flats(self.look_along_bounds(found, NEAR_BOUND));
            return Ok(self.search_local_minima(found));
        }
        let first = match problem.fit(near.clone(), 1.0) {
            Err(refused) if self.log.was_short() => return Err(refused),
            first => first.ok(),
        };
        let driven = self.recordings.iter().all(Prepared::has_inputs);
        let found = match first {
            Some(first) if Self::settled(&first) => first,
            // Inputs hold a driven thing near its motion from any start, so that a few brief fits show whether another minimum is lower.
            Some(first) if driven => {
                let starts = also.into_iter().chain(self.nearest_across_bounds(near));
                return Ok((self.best_of_brief_fits(starts, Some(first))?, Vec::new()));
            }
            first => self.best_of_starts(near, also, first)?,
        };
        let settled = Self::settled(&found);
        let found = self.look_past_flats(self.look_along_bounds(found, if settled { ON_BOUND } else { NEAR_BOUND }));
        // Over a lone parameter the grid takes a rollout for each place.
        let alone = self.free.len() == 1 && self.recordings.iter().all(|r| r.nuisances.is_empty());
        if settled && !alone {
            return Ok((found, Vec::new()));
        }
        Ok(self.search_local_minima(found))
    }

    /// The best of `first` and of fits from these starts, which are brief where they do not lead to a lower minimum.
    fn best_of_brief_fits(&self, starts: impl Iterator<Item = Point>, first: Option<Fit>) -> Result<Fit> {
        let problem = self.problem();
        let mut best: Option<Fit> = None;
        let mut refused = None;
        for start in starts {
            match problem.fit_steps(start, None, BRIEF_STEPS, BRIEF_STEPS / 2) {
                Ok(fit) if best.as_ref().is_none_or(|best| fit.cost < best.cost) => best = Some(fit),
                Ok(_) => {}
                Err(error) => refused = Some(error),
            }
        }
        match (best, first, refused) {
            (Some(best), Some(first), _) if best.cost >= first.cost - LOWER => Ok(first),
            (None, Some(first), _) => Ok(first),
            (Some(best), _, _) => problem.fit(best.point, 1.0),
            (None, None, Some(error)) => Err(error),
            (None, None, None) => Err(nowhere()),
        }
    }

    /// The starts across the bounds that lie nearest to the data.
    fn nearest_across_bounds(&self, near: &Point) -> Vec<Point> {
        self.ranked(self.across_bounds(near)).into_iter().map(|(_, start)| start).take(BRIEF_FITS).collect()
    }

    fn has_events(&self) -> bool {
        self.recordings.iter().any(Prepared::has_events)
    }

    /// Whether a fit leaves no more than noise.
    fn settled(fit: &Fit) -> bool {
        let count = fit.residuals.iter().map(Vec::len).sum::<usize>() as f64;
        robust_scale(&fit.residuals) < SUSPICIOUS_SCALE && 2.0 * fit.cost < SUSPICIOUS_SQUARE * count
    }

    /// The best of several starts, and of the fit `first`.
    fn best_of_starts(&self, near: &Point, also: Option<Point>, first: Option<Fit>) -> Result<Fit> {
        let problem = self.problem();
        self.log.phase(Phase::Search);
        let mut best = first;
        let networked = also.is_some();
        // A network's start is always fitted, even if others lie nearer by rollouts alone: short records have several local minima.
        if networked {
            let fit = problem.fit(near.clone(), 1.0)?;
            best = best.filter(|best| best.cost <= fit.cost).or(Some(fit));
        }
        // What the events suggest comes before what lies nearer by rollouts alone: where they are right, start and surface
        // are right too, and what is left (friction) can be a long way off and still lie in the same local minimum.
        let locals: Vec<Point> = self.local_start(near).iter().flat_map(|l| self.around_local(l)).collect();
        let mut first = self.ranked(locals.clone());
        first.truncate(LOCAL_FITS);
        for (_, start) in first {
            self.try_start(start, &[1.0], &mut best);
            if best.as_ref().is_some_and(Self::settled) {
                return best.ok_or_else(nowhere);
            }
        }
        let mut starts = vec![near.clone()];
        // One parameter at a time across its bounds, the others where the file, a network or the events have them.
        starts.extend(self.across_bounds(near));
        starts.extend(locals);
        starts.extend(also);
        for start in starts.clone() {
            // The recordings' first guesses as well, where the start carries nuisance parameters fitted to other parameters.
            starts.push(Point { nuisances: self.recordings.iter().map(Prepared::nuisance_values).collect(), ..start });
        }
        for (tried, (_, start)) in self.ranked(starts).into_iter().enumerate() {
            self.try_start(start, if tried >= 2 { &[0.45, 0.7, 1.0] } else { &[1.0] }, &mut best);
            if best.as_ref().is_some_and(Self::settled) || tried >= 5 {
                break;
            }
        }
        best.ok_or_else(|| if self.log.was_short() { problem.unaffordable() } else { nowhere() })
    }

    /// Fits from `start` over growing shares of the record, and keeps the result where it is better.
    fn try_start(&self, start: Point, horizons: &[f64], best: &mut Option<Fit>) {
        let problem = self.problem();
        let (mut point, mut fitted) = (start, None);
        for horizon in horizons {
            // What suits the beginning of a record may be refused for the whole of it: that start leads nowhere.
            fitted = problem.fit(point.clone(), *horizon).ok();
            let Some(fit) = &fitted else { break };
            point.clone_from(&fit.point);
        }
        let Some(fit) = fitted else { return };
        if best.as_ref().is_none_or(|b| fit.cost < b.cost) {
            *best = Some(fit);
        }
    }

    /// `base` with one free parameter at a time across its bounds.
    fn across_bounds(&self, base: &Point) -> Vec<Point> {
        let of = |&i: &usize| {
            let p = &self.simulator.parameters()[i];
            GRID_STARTS.map(|share| base.with(&[i], &[p.min + share * p.span()]))
        };
        self.free.iter().flat_map(of).collect()
    }

    /// `local`, with every parameter that the events say nothing of across its bounds, one at a time.
    fn around_local(&self, local: &Point) -> Vec<Point> {
        let mut starts = vec![local.clone()];
        for &i in self.free.iter().filter(|&&i| local_estimate(self.recordings, i).is_none()) {
            let p = &self.simulator.parameters()[i];
            let share = |n: u32| p.min + (f64::from(n) / f64::from(STARTS_AROUND_LOCAL)).powi(3) * p.span();
            starts.extend((1..STARTS_AROUND_LOCAL).map(|n| local.with(&[i], &[share(n)])));
        }
        starts.extend(self.across_bounds(local));
        starts
    }

    /// The starts that can be simulated, each with its distance from the data, the nearest first; where so many rollouts are not
    /// allowed, the first of them.
    fn ranked(&self, mut starts: Vec<Point>) -> Vec<(f64, Point)> {
        let problem = self.problem();
        if !self.log.affords(starts.len() * self.recordings.len()) {
            starts.truncate(1);
        }
        let distance = |start: Point| Some((problem.rmse(&problem.residuals(&start, 1.0).ok()?), start));
        let mut ranked: Vec<_> = starts.into_iter().filter_map(distance).collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Where a parameter changes nothing, one start is as good as the next: only the first of them counts.
        ranked.dedup_by(|next, kept| (next.0 - kept.0).abs() <= SAME_MISFIT * kept.0);
        ranked
    }

    /// Near a bound the slope may vanish (impacts that return a few hundredths leave next to no rebound), so that a step which
    /// overshoots never comes back: tries the neighbourhood of a bound that is within this share of the bounds by plain
    /// rollouts, and fits again from the best.
    fn look_along_bounds(&self, found: Fit, near: f64) -> Fit {
        let problem = self.problem();
        let mut best: Option<(f64, Point)> = None;
        let level = problem.rmse(&found.residuals);
        for &i in self.free {
            let p = &self.simulator.parameters()[i];
            let value = found.point.parameters[i];
            let (bound, inward) = if value - p.min <= near * p.span() {
                (p.min, 1.0)
            } else if p.max - value <= near * p.span() {
                (p.max, -1.0)
            } else {
                continue;
            };
            for share in BOUND_STARTS {
                let point = found.point.with(&[i], &[bound + inward * share * p.span()]);
                let rmse = problem.residuals(&point, 1.0).map_or(f64::INFINITY, |r| problem.rmse(&r));
                if rmse < best.as_ref().map_or(level, |b| b.0) {
                    best = Some((rmse, point));
                }
            }
        }
        let Some(Ok(again)) = best.map(|(_, start)| problem.fit(start, 1.0)) else { return found };
        if again.cost < found.cost { again } else { found }
    }

    /// Where a parameter has no influence at all, no step leaves the place (friction that grips, however great): looks for
    /// values that do matter by plain rollouts, and fits again from the best of them.
    fn look_past_flats(&self, mut found: Fit) -> Fit {
        let problem = self.problem();
        for (k, &i) in self.free.iter().enumerate() {
            if found.covariance.get((k, k)).is_none_or(|v| v.is_finite()) {
                continue;
            }
            let p = &self.simulator.parameters()[i];
            let level = problem.rmse(&found.residuals);
            let places = (1..=FLAT_STARTS).map(|n| p.min + (f64::from(n) / f64::from(FLAT_STARTS)).powi(2) * p.span());
            let mut other: Option<(f64, Point)> = None;
            for value in places {
                let point = found.point.with(&[i], &[value]);
                let Ok(residuals) = problem.residuals(&point, 1.0) else { continue };
                let rmse = problem.rmse(&residuals);
                if (rmse - level).abs() > SAME_MISFIT * level && other.as_ref().is_none_or(|o| rmse < o.0) {
                    other = Some((rmse, point));
                }
            }
            let Some(Ok(again)) = other.map(|(_, start)| problem.fit(start, 1.0)) else { continue };
            if again.cost < found.cost {
                found = again;
            }
        }
        found
    }

    /// The parameters that the recordings' events suggest.
    fn local_start(&self, near: &Point) -> Option<Point> {
        let local = |&i: &usize| {
            let p = &self.simulator.parameters()[i];
            local_estimate(self.recordings, i).map_or(near.parameters[i], |(value, _)| value.clamp(p.min, p.max))
        };
        let values: Vec<f64> = self.free.iter().map(local).collect();
        let nuisances = self.recordings.iter().map(Prepared::nuisance_values).collect();
        self.free
            .iter()
            .any(|&i| local_estimate(self.recordings, i).is_some())
            .then(|| Point { nuisances, ..near.with(self.free, &values) })
    }
}

fn nowhere() -> Error {
    Error::Simulator { at: "every start".into(), message: "no start within the bounds could be simulated".into() }
}

/// What the events of all recordings together say of parameter `i`: the mean weighted by certainty, and its standard
/// deviation, the scatter between recordings included.
pub(super) fn local_estimate(recordings: &[Prepared], i: usize) -> Option<(f64, f64)> {
    let each: Vec<LocalEstimate> = recordings.iter().filter_map(|r| r.local[i]).collect();
    LocalEstimate::mean(&each).map(|l| (l.value, l.sd))
}

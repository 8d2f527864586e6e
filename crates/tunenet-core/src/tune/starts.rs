//! Multistart: several starting points, so that neither a poor guess in the file nor a plateau decides the answer.

use super::Tuning;
use crate::estimate::problem::robust_scale;
use crate::estimate::{Fit, MisfitGrid, Point};
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
/// ... from these shares away from it.
const BOUND_STARTS: [f64; 10] = [0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.09, 0.1];
/// Starts across the bounds, for the case that neither the file nor the data suggest a good one. Small ones lie closer: where
/// friction is large enough to stop the slip, more of it changes nothing.
const GRID_STARTS: [f64; 7] = [0.02, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9];
/// Places across the bounds, denser towards the lower one, for parameters that the events say nothing of.
const STARTS_AROUND_LOCAL: u32 = 24;
/// The nearest starts with what the events suggest that are fitted before any other.
const LOCAL_FITS: usize = 2;

/// Two misfits closer than this share of them are the same.
const SAME_MISFIT: f64 = 1e-9;
/// Places across the bounds, denser towards the lower one, at which a parameter without influence is looked for one.
const FLAT_STARTS: u32 = 40;

impl Tuning<'_> {
    /// The best of several starts, `near` and `also` among them, more of them where the first leaves too much; the places
    /// that were looked at around it; and the rollouts it took.
    pub(super) fn best_fit(&self, near: &Point, also: Option<Point>) -> Result<(Fit, MisfitGrid, usize)> {
        let problem = self.problem();
        // A driven thing does not go its own way after a bad start: what it shows is nearly linear in its parameters.
        if self.free.is_empty() || self.recordings.iter().all(|recording| recording.memoryless) {
            let fit = problem.fit(near.clone(), 1.0)?;
            let rollouts = fit.rollouts;
            return Ok((fit, Vec::new(), rollouts));
        }
        let mut starts = vec![near.clone()];
        // One parameter at a time across its bounds, the others where the file, a network or the events have them.
        starts.extend(self.across_bounds(near));
        let locals: Vec<Point> = self.local_start(near).iter().flat_map(|l| self.around_local(l)).collect();
        starts.extend(locals.iter().cloned());
        let networked = also.is_some();
        starts.extend(also);
        for start in starts.clone() {
            // The recordings' first guesses as well, where the start carries nuisance parameters fitted to other parameters.
            starts.push(Point { nuisances: self.recordings.iter().map(Prepared::nuisance_values).collect(), ..start });
        }
        let mut rollouts = starts.len() * self.recordings.len();
        // A network's start is always fitted, even if others lie nearer by rollouts alone: short records have several local minima.
        let mut best: Option<Fit> = None;
        if networked {
            let fit = problem.fit(near.clone(), 1.0)?;
            rollouts += fit.rollouts;
            best = Some(fit);
        }
        let mut ranked = self.ranked(starts);
        // What the events suggest comes before what lies nearer by rollouts alone: where they are right, release and surface
        // are right too, and what is left (friction) can be a long way off and still lie in the same local minimum.
        let mut locals = self.ranked(locals);
        locals.truncate(LOCAL_FITS);
        let first = locals.len();
        ranked.splice(0..0, locals);
        for (tried, (_, start)) in ranked.into_iter().enumerate() {
            let horizons: &[f64] = if tried >= first + 2 { &[0.45, 0.7, 1.0] } else { &[1.0] };
            let mut fitted = None;
            let mut point = start;
            for horizon in horizons {
                // What suits the beginning of a record may be refused for the whole of it: that start leads nowhere.
                fitted = problem.fit(point.clone(), *horizon).ok();
                let Some(fit) = &fitted else { break };
                rollouts += fit.rollouts;
                point.clone_from(&fit.point);
            }
            let Some(fit) = fitted else { continue };
            if best.as_ref().is_none_or(|b| fit.cost < b.cost) {
                best = Some(fit);
            }
            let settled = best.as_ref().is_some_and(|b| {
                let count = b.residuals.iter().map(Vec::len).sum::<usize>() as f64;
                robust_scale(&b.residuals) < SUSPICIOUS_SCALE && 2.0 * b.cost < SUSPICIOUS_SQUARE * count
            });
            if settled || tried >= first + 5 {
                break;
            }
        }
        let found = best.ok_or_else(|| Error::Simulator {
            at: "every start".into(),
            message: "no start within the bounds could be simulated".into(),
        })?;
        let (found, along) = self.look_along_bounds(found);
        let (found, past) = self.look_past_flats(found);
        let (found, grid, across) = self.search_local_minima(found);
        Ok((found, grid, rollouts + along + past + across))
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

    /// The starts that can be simulated, each with its distance from the data, the nearest first.
    fn ranked(&self, starts: Vec<Point>) -> Vec<(f64, Point)> {
        let problem = self.problem();
        let distance = |start: Point| Some((problem.rmse(&problem.residuals(&start, 1.0).ok()?), start));
        let mut ranked: Vec<_> = starts.into_iter().filter_map(distance).collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Where a parameter changes nothing, one start is as good as the next: only the first of them counts.
        ranked.dedup_by(|next, kept| (next.0 - kept.0).abs() <= SAME_MISFIT * kept.0);
        ranked
    }

    /// Near a bound the slope may vanish (impacts that return a few hundredths leave next to no rebound), so that a step which
    /// overshoots never comes back: tries the neighbourhood of the bound by plain rollouts, and fits again from the best.
    fn look_along_bounds(&self, found: Fit) -> (Fit, usize) {
        let problem = self.problem();
        let mut rollouts = 0;
        let mut best: Option<(f64, Point)> = None;
        let level = problem.rmse(&found.residuals);
        for &i in self.free {
            let p = &self.simulator.parameters()[i];
            let value = found.point.parameters[i];
            let (bound, inward) = if value - p.min < NEAR_BOUND * p.span() {
                (p.min, 1.0)
            } else if p.max - value < NEAR_BOUND * p.span() {
                (p.max, -1.0)
            } else {
                continue;
            };
            for share in BOUND_STARTS {
                let point = found.point.with(&[i], &[bound + inward * share * p.span()]);
                rollouts += self.recordings.len();
                let rmse = problem.residuals(&point, 1.0).map_or(f64::INFINITY, |r| problem.rmse(&r));
                if rmse < best.as_ref().map_or(level, |b| b.0) {
                    best = Some((rmse, point));
                }
            }
        }
        let Some(Ok(again)) = best.map(|(_, start)| problem.fit(start, 1.0)) else { return (found, rollouts) };
        rollouts += again.rollouts;
        (if again.cost < found.cost { again } else { found }, rollouts)
    }

    /// Where a parameter has no influence at all, no step leaves the place (friction that grips, however great): looks for
    /// values that do matter by plain rollouts, and fits again from the best of them.
    fn look_past_flats(&self, found: Fit) -> (Fit, usize) {
        let problem = self.problem();
        let (mut rollouts, mut found) = (0, found);
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
                rollouts += self.recordings.len();
                let Ok(residuals) = problem.residuals(&point, 1.0) else { continue };
                let rmse = problem.rmse(&residuals);
                if (rmse - level).abs() > SAME_MISFIT * level && other.as_ref().is_none_or(|o| rmse < o.0) {
                    other = Some((rmse, point));
                }
            }
            let Some(Ok(again)) = other.map(|(_, start)| problem.fit(start, 1.0)) else { continue };
            rollouts += again.rollouts;
            if again.cost < found.cost {
                found = again;
            }
        }
        (found, rollouts)
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

/// What the events of all recordings together say of parameter `i`: the mean weighted by certainty, and its standard
/// deviation, the scatter between recordings included.
pub(super) fn local_estimate(recordings: &[Prepared], i: usize) -> Option<(f64, f64)> {
    let each: Vec<LocalEstimate> = recordings.iter().filter_map(|r| r.local[i]).collect();
    LocalEstimate::mean(&each).map(|l| (l.value, l.sd))
}

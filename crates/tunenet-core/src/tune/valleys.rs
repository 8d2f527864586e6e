//! The misfit far from a fit, where an impact may slip that gripped: each such change is a kink, and beyond it may lie
//! another valley, as deep or nearly so.

use super::Tuning;
use super::fit::{Fit, Problem};
use super::interval::Spread;
use super::starts::local_estimate;
use super::unknowns::Point;
use crate::Result;

/// Places at which the misfit is looked at, as multiples of the parameter's distance from its lower bound.
const BELOW: [f64; 5] = [0.85, 0.7, 0.5, 0.35, 0.2];
const ABOVE: [f64; 6] = [1.18, 1.4, 2.0, 2.8, 4.0, 8.0];
/// A fit near the lower bound is looked at from this share of the bounds instead.
const LEAST_SHARE: f64 = 1e-3;
/// Another valley is fitted where its misfit, in squares of standard deviations, exceeds the least by no more than this: the
/// place is coarse, and the fit there was cut short.
const WORTH_A_FIT: f64 = 100.0;
/// Misfits closer than this share are the same: a plateau.
const SAME_COST: f64 = 1e-9;

/// A place far from the fit: one parameter there, everything else fitted to it.
#[derive(Debug, Clone)]
pub(super) struct Place {
    pub value: f64,
    pub cost: f64,
    pub point: Point,
}

impl Tuning<'_> {
    /// The best valley near `found`, and for each free parameter the places that were looked at around it. A parameter that
    /// the events tell is not looked for elsewhere.
    pub(super) fn look_across(&self, mut found: Fit) -> Result<(Fit, Vec<Vec<Place>>, usize)> {
        let problem = self.problem();
        let (mut rollouts, mut all) = (0, vec![Vec::new(); self.free.len()]);
        for k in 0..self.free.len() {
            if local_estimate(self.recordings, self.free[k]).is_some() {
                continue;
            }
            let (places, used) = places(&problem, &found, k)?;
            rollouts += used;
            let spread = Spread::of(&problem, &found);
            for place in valleys(&places, &found, self.free[k]) {
                if spread.excess(place.cost - found.cost) > WORTH_A_FIT {
                    continue;
                }
                let again = problem.fit(place.point.clone(), 1.0)?;
                rollouts += again.rollouts;
                if again.cost < found.cost {
                    found = again;
                }
            }
            all[k] = places;
        }
        Ok((found, all, rollouts))
    }
}

/// Looks at the misfit over free parameter number `k` outwards from `fit`, each place fitted from the one before.
fn places(problem: &Problem, fit: &Fit, k: usize) -> Result<(Vec<Place>, usize)> {
    let position = problem.free[k];
    let p = &problem.simulator.parameters()[position];
    let others: Vec<usize> = problem.free.iter().copied().filter(|&f| f != position).collect();
    let problem = Problem { free: &others, ..*problem };
    let reach = (fit.point.parameters[position] - p.min).max(LEAST_SHARE * p.span());
    let (mut found, mut rollouts) = (Vec::new(), 0);
    for side in [&BELOW[..], &ABOVE[..]] {
        let (mut point, mut cost) = (fit.point.clone(), fit.cost);
        for ratio in side {
            let value = (p.min + ratio * reach).min(p.max);
            if value == point.parameters[position] {
                break;
            }
            // Two steps are enough to see a valley.
            let there = problem.fit_until(point.with(&[position], &[value]), 1.0, f64::INFINITY)?;
            rollouts += there.rollouts;
            let flat = (there.cost - cost).abs() <= SAME_COST * cost;
            (point, cost) = (there.point, there.cost);
            if flat {
                break;
            }
            found.push(Place { value, cost, point: point.clone() });
        }
    }
    found.sort_by(|a, b| a.value.total_cmp(&b.value));
    Ok((found, rollouts))
}

/// The places that are deeper than both their neighbours, the fit itself among the neighbours, and those deeper than the fit.
fn valleys<'a>(places: &'a [Place], fit: &Fit, position: usize) -> Vec<&'a Place> {
    let own = places.partition_point(|p| p.value < fit.point.parameters[position]);
    let mut costs: Vec<f64> = places.iter().map(|p| p.cost).collect();
    costs.insert(own, fit.cost);
    let deep = |i: usize| {
        let at = i + usize::from(i >= own);
        let (before, after) = (at.checked_sub(1).map_or(f64::INFINITY, |b| costs[b]), costs.get(at + 1));
        costs[at] < fit.cost || costs[at] < before && after.is_none_or(|&after| costs[at] < after)
    };
    places.iter().enumerate().filter(|(i, _)| deep(*i)).map(|(_, place)| place).collect()
}

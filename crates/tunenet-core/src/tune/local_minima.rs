//! Multistart over one parameter at a time by a grid of profiled misfits.
//!
//! The misfit has kinks where an impact changes from grip to slip, or where weak rebounds are too short to be seen; beyond
//! each kink another local minimum may be as deep.

use super::Tuning;
use super::starts::local_estimate;
use crate::estimate::{Fit, GridPoint, MisfitGrid, Phase, Problem, ScaleEstimate};

/// Grid over a parameter, as multiples of its distance from its lower bound.
const BELOW: [f64; 5] = [0.85, 0.7, 0.5, 0.35, 0.2];
const ABOVE: [f64; 6] = [1.18, 1.4, 2.0, 2.8, 4.0, 8.0];
/// A fit near the lower bound is looked at from this share of the bounds instead.
const LEAST_SHARE: f64 = 1e-3;
/// A parameter that the events determine is searched only this near to its lower bound, as a share of the bounds: a weak
/// rebound is no event. The grid is even then.
const WEAK_SHARE: f64 = 0.3;
const WEAK_PLACES: u32 = 12;
/// Another local minimum is fitted where its misfit, in squares of standard deviations, exceeds the least by no more than this: the
/// place is coarse, and the fit there was cut short.
const WORTH_A_FIT: f64 = 100.0;
/// Misfits closer than this share are the same: a plateau.
const SAME_COST: f64 = 1e-9;

impl Tuning<'_> {
    /// The best local minimum near `found`, and the grid around it.
    pub(super) fn search_local_minima(&self, mut found: Fit) -> (Fit, MisfitGrid) {
        let problem = self.problem();
        self.log.phase(Phase::Search);
        let mut all = vec![Vec::new(); self.free.len()];
        for (k, kept) in all.iter_mut().enumerate() {
            let p = &self.simulator.parameters()[self.free[k]];
            let share = (found.point.parameters[self.free[k]] - p.min) / p.span();
            let local = local_estimate(self.recordings, self.free[k]).is_some();
            if local && share > WEAK_SHARE {
                continue;
            }
            let shares = if local { even(share) } else { around(share) };
            let mut places = places(&problem, &found, k, shares);
            let scale = ScaleEstimate::of_residuals(&problem, &found);
            let mut bottoms = Vec::new();
            for place in local_minima(&places, &found, self.free[k]) {
                if scale.excess(place.cost - found.cost) > WORTH_A_FIT {
                    continue;
                }
                let Ok(again) = problem.fit(place.point.clone(), 1.0) else { continue };
                // The bottom of the other local minimum is a place as well.
                let (best, other) = if again.cost < found.cost { (again, found) } else { (found, again) };
                found = best;
                let value = other.point.parameters[self.free[k]];
                bottoms.push(GridPoint { value, cost: other.cost, point: other.point });
            }
            places.extend(bottoms);
            *kept = places;
        }
        (found, all)
    }
}

/// Places around this share of the bounds, outwards on either side, as shares.
fn around(share: f64) -> [Vec<f64>; 2] {
    let from = share.max(LEAST_SHARE);
    [BELOW.map(|r| r * from).to_vec(), ABOVE.map(|r| r * from).to_vec()]
}

/// Even places near the lower bound, outwards on either side of this share of the bounds, as shares.
fn even(share: f64) -> [Vec<f64>; 2] {
    let all = (0..=WEAK_PLACES).map(|n| WEAK_SHARE * f64::from(n) / f64::from(WEAK_PLACES));
    let (mut below, above): (Vec<f64>, Vec<f64>) = all.filter(|s| *s != share).partition(|s| *s < share);
    below.reverse();
    [below, above]
}

/// The misfit over free parameter number `k` at these shares of its bounds, outwards from `fit` on either side, each place
/// fitted from the one before.
fn places(problem: &Problem, fit: &Fit, k: usize, shares: [Vec<f64>; 2]) -> Vec<GridPoint> {
    let position = problem.free[k];
    let p = &problem.simulator.parameters()[position];
    let others: Vec<usize> = problem.free.iter().copied().filter(|&f| f != position).collect();
    let problem = Problem { free: &others, ..*problem };
    let mut found = Vec::new();
    for side in shares {
        let (mut point, mut cost) = (fit.point.clone(), fit.cost);
        for share in side {
            let value = (p.min + share * p.span()).min(p.max);
            if value == point.parameters[position] {
                break;
            }
            // Two steps are enough to see a local minimum. What the simulator refuses has none.
            let start = point.with(&[position], &[value]);
            let Ok(there) = problem.fit_briefly(start, None) else { break };
            let flat = (there.cost - cost).abs() <= SAME_COST * cost;
            (point, cost) = (there.point, there.cost);
            if flat {
                break;
            }
            found.push(GridPoint { value, cost, point: point.clone() });
        }
    }
    found.sort_by(|a, b| a.value.total_cmp(&b.value));
    found
}

/// The places that are deeper than both their neighbours, the fit itself among the neighbours, and those deeper than the fit.
fn local_minima<'a>(places: &'a [GridPoint], fit: &Fit, position: usize) -> Vec<&'a GridPoint> {
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

#[cfg(test)]
mod tests {
    use crate::observation::{Channel, Kind, Observation};
    use crate::simulator::{Parameter, RolloutResult, Simulator};
    use crate::tune::{Settings, tune};

    /// A line whose slope rises with the parameter up to 4 and falls beyond: two values for each slope.
    struct Roof(Vec<Parameter>, Vec<Channel>);

    impl Simulator for Roof {
        fn parameters(&self) -> &[Parameter] {
            &self.0
        }

        fn channels(&self) -> &[Channel] {
            &self.1
        }

        fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], out: &mut [f64]) -> RolloutResult {
            let slope = 2.0 - (p[0] - 4.0).abs() / if p[0] < 4.0 { 2.0 } else { 4.0 };
            clock.iter().zip(out).for_each(|(t, v)| *v = slope * t);
            Ok(())
        }
    }

    #[test]
    fn an_interval_reaches_to_the_other_local_minimum() {
        let roof = Roof(vec![Parameter::new("p", "1", 1.5, 0.0, 20.0).unwrap()], vec![Channel::new("y", "1")]);
        let clock: Vec<f64> = (0..200).map(|i| f64::from(i) / 200.0).collect();
        // A slope of 1, which 2 and 8 have, and something like noise.
        let noise = |i: usize| 0.4 * ((i * 7919 % 101) as f64 / 50.0 - 1.0);
        let values = clock.iter().enumerate().map(|(i, t)| t + noise(i)).collect();
        let seen = Observation::new(Kind::Other, roof.channels().to_vec(), clock, values).unwrap();
        let outcome = tune(&roof, &[seen], None, &Settings::default()).unwrap();
        let (low, high) = outcome.parameters[0].interval95;
        assert!((1.7..2.0).contains(&low) && (8.0..8.5).contains(&high), "{:?}", outcome.parameters);
    }
}

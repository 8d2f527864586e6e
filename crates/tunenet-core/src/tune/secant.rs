//! Secant variant of Gauss–Newton for one parameter (Ralston and Jennrich 1978): the slope comes from the two nearest rollouts
//! made so far; a restart where that leads no further.

/// Two rollouts farther apart than this share of the bounds give a chord, not a slope, so no secant step is taken; nor does
/// any step exceed it.
pub(super) const LONGEST_SECANT: f64 = 0.03;
/// ... and closer than this the rollouts differ by rounding alone.
const SHORTEST_SECANT: f64 = 1e-9;
/// So many rollouts in a row that are no better than the best before end the trust in slopes.
const PATIENCE: usize = 2;

/// A rollout that has been made: where, what it gave, and how far off.
struct Rolled {
    at: f64,
    values: Vec<f64>,
    rmse: f64,
}

/// All rollouts so far.
pub(super) struct Made {
    bounds: (f64, f64),
    rolled: Vec<Rolled>,
}

impl Made {
    /// None yet, of a parameter between these bounds.
    pub(super) fn within(bounds: (f64, f64)) -> Self {
        Self { bounds, rolled: Vec::new() }
    }

    /// One more.
    pub(super) fn push(&mut self, at: f64, values: Vec<f64>, rmse: f64) {
        self.rolled.push(Rolled { at, values, rmse });
    }

    fn span(&self) -> f64 {
        self.bounds.1 - self.bounds.0
    }

    /// The best rollout, and how many came after it.
    fn best(&self) -> Option<(&Rolled, usize)> {
        let best = self.rolled.iter().enumerate().min_by(|a, b| a.1.rmse.total_cmp(&b.1.rmse));
        best.map(|(place, best)| (best, self.rolled.len() - 1 - place))
    }

    /// Where the Gauss–Newton step from the best rollout leads, its slope the difference to the nearest other. At the end it
    /// is the maximum of the likelihood for white noise. `None` where no other is near enough.
    ///
    /// All others are worse, so the best value lies nearer to the best rollout than to any of them: a step goes at most half
    /// the way to the next. This prevents large steps where the slope nearly vanishes (impacts that return next to nothing).
    pub(super) fn step(&self, seen: &[f64]) -> Option<f64> {
        let (best, span) = (self.best()?.0, self.span());
        let distance = |other: &Rolled| (other.at - best.at).abs() / span;
        let others = || self.rolled.iter().filter(|other| distance(other) > SHORTEST_SECANT);
        let near =
            others().min_by(|a, b| distance(a).total_cmp(&distance(b))).filter(|o| distance(o) < LONGEST_SECANT)?;
        let (mut square, mut product) = (0.0, 0.0);
        for ((new, old), seen) in best.values.iter().zip(&near.values).zip(seen) {
            let slope = (new - old) / (best.at - near.at);
            square += slope * slope;
            product += slope * (seen - new);
        }
        let step = (square > 0.0).then(|| product / square)?;
        let ahead = others().map(|other| (other.at - best.at) * step.signum()).filter(|way| *way > 0.0);
        let longest = ahead.fold(LONGEST_SECANT * span, |least, way| least.min(0.5 * way));
        Some(best.at + step.clamp(-longest, longest))
    }

    /// Where to look once slopes lead no further: as far as possible from every rollout, within the longest step of the best. `None`
    /// while they do. Where a curve has several local minima, the slopes in the wrong one never leave it.
    pub(super) fn restart(&self) -> Option<f64> {
        let (best, since) = self.best()?;
        if since < PATIENCE {
            return None;
        }
        let longest = LONGEST_SECANT * self.span();
        let (low, high) = (self.bounds.0.max(best.at - longest), self.bounds.1.min(best.at + longest));
        let mut known: Vec<f64> = self.rolled.iter().map(|r| r.at).filter(|at| (low..=high).contains(at)).collect();
        known.sort_by(f64::total_cmp);
        let between = known.windows(2).map(|pair| (0.5 * (pair[1] - pair[0]), f64::midpoint(pair[0], pair[1])));
        // None where the best lies outside the bounds, as a start may.
        let (first, last) = (*known.first()?, *known.last()?);
        let ends = [(first - low, low), (high - last, high)];
        let (far, place) = between.chain(ends).max_by(|a, b| a.0.total_cmp(&b.0))?;
        (far > SHORTEST_SECANT * self.span()).then_some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing happens below 0.01; a straight line above.
    fn rolled(at: f64) -> Vec<f64> {
        vec![(at - 0.01).max(0.0)]
    }

    fn push(made: &mut Made, at: f64, seen: &[f64]) {
        let values = rolled(at);
        let rmse = (values[0] - seen[0]).abs();
        made.push(at, values, rmse);
    }

    #[test]
    fn a_slope_leads_to_the_best_value_of_a_straight_line() {
        let (mut made, seen) = (Made::within((0.0, 1.0)), rolled(0.5));
        push(&mut made, 0.49, &seen);
        push(&mut made, 0.48, &seen);
        assert!(made.restart().is_none());
        assert!((made.step(&seen).unwrap() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn where_nothing_changes_the_gaps_are_filled_until_a_slope_is_found() {
        let (mut made, seen) = (Made::within((0.0, 1.0)), rolled(0.016));
        for at in [0.001, 0.002] {
            push(&mut made, at, &seen);
            assert!(made.restart().is_none(), "one failure is none yet");
        }
        push(&mut made, 0.0015, &seen);
        let far = made.restart().unwrap();
        assert!((far - 0.031).abs() < 1e-12, "the longest step, {far}");
        push(&mut made, far, &seen);
        let between = made.restart().unwrap();
        assert!((between - 0.0165).abs() < 1e-12, "the widest gap, {between}");
        push(&mut made, between, &seen);
        assert!(made.restart().is_none(), "it is better than all before");
        assert!((made.step(&seen).unwrap() - 0.016).abs() < 1e-12);
    }

    #[test]
    fn a_best_rollout_outside_the_bounds_has_no_surroundings_within() {
        let (mut made, seen) = (Made::within((0.0, 1.0)), vec![0.0]);
        for _ in 0..4 {
            push(&mut made, -5.0, &seen);
        }
        assert!(made.restart().is_none());
    }

    #[test]
    fn it_ends_where_no_gap_is_left_and_never_leaves_the_bounds() {
        let (mut made, seen) = (Made::within((0.0, 1e-9)), vec![0.0]);
        for _ in 0..4 {
            push(&mut made, 0.0, &seen);
        }
        assert!(made.restart().is_none_or(|at| (0.0..=1e-9).contains(&at)));
    }
}

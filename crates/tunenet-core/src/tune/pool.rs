//! Test of a pool of short lists: the variance between recordings against that within them (analysis of variance, Fisher 1925; of
//! regressions, Chow 1960).
//!
//! A list of a few event times is too short to know its own noise, so its residual is no test. Several lists of the same thing are:
//! each fitted by itself leaves what is noise, and what all together leave beyond that is a difference between them.

use super::Tuning;
use crate::Result;
use crate::estimate::{Fit, Point, Problem, ScaleEstimate};
use crate::findings;
use crate::observation::{Kind, Note, with_decimals};
use crate::statistics::{dot, mean, upper_f};

/// Recordings differ where chance explains as much less often than this.
const PROBABLE: f64 = 1e-3;
/// What is left of exact lists is rounding: below this share of their duration.
const ROUNDING: f64 = 1e-6;

/// Squared residuals of one recording fitted by itself.
struct Alone {
    squares: f64,
    /// Values less fitted numbers.
    degrees_of_freedom: f64,
    /// By how much errors that add up widen an estimate.
    inflation: f64,
}

impl Tuning<'_> {
    /// Whether lists of events fitted together leave more than each by itself; what is to be said then.
    ///
    /// # Errors
    /// Where the simulator refuses.
    pub(super) fn disagreement(&self, fit: &Fit) -> Result<Option<Note>> {
        let lists = self.recordings.iter().all(|r| r.seen.kind() == Kind::EventTimes);
        if !lists || self.recordings.len() < 2 || self.free.is_empty() {
            return Ok(None);
        }
        let all = (0..self.recordings.len()).map(|d| self.alone(fit, d)).collect::<Result<Vec<_>>>()?;
        let together: f64 = fit.residuals.iter().map(|r| dot(r, r)).sum();
        let longest = self.recordings.iter().map(|r| r.seen.values()).filter_map(|v| Some(v.last()? - v.first()?));
        let exact = self.problem().rmse(&fit.residuals) <= ROUNDING * longest.fold(0.0, f64::max);
        let between = (self.recordings.len() - 1) * self.free.len();
        let ratio = variance_ratio(&all, together, between as f64);
        let found = ratio.filter(|(_, probability)| *probability < PROBABLE && !exact).map(|(ratio, _)| {
            let text = format!(
                "{} recordings differ {} times as much from each other as their own scatter explains",
                self.recordings.len(),
                with_decimals(ratio.sqrt(), 1)
            );
            Note::new(
                findings::RECORDINGS_DISAGREE,
                text,
                "tune each by itself, and look for what differs between them",
            )
        });
        Ok(found)
    }

    /// Recording `d` fitted by itself from where all together stand.
    fn alone(&self, fit: &Fit, d: usize) -> Result<Alone> {
        let (recordings, noise) = (&self.recordings[d..=d], &self.noise[d..=d]);
        // The log knows recordings by their number among all.
        let problem = Problem { recordings, noise, log: None, ..self.problem() };
        let start = Point { parameters: fit.point.parameters.clone(), nuisances: vec![fit.point.nuisances[d].clone()] };
        let own = problem.fit(start, 1.0)?;
        let linear = problem.linearise(&own)?;
        let fitted = self.free.len() + recordings[0].nuisances.len();
        let alone = Alone {
            squares: own.residuals.iter().map(|r| dot(r, r)).sum(),
            degrees_of_freedom: (recordings[0].seen.len() as f64 - fitted as f64).max(0.0),
            inflation: ScaleEstimate::of(&problem, &own, &linear).inflation,
        };
        self.log.add(own.rollouts + linear.rollouts());
        Ok(alone)
    }
}

/// Variance between recordings over that within them, as wide as errors that add up make an estimate, and the probability of it by
/// chance; `None` where nothing is known of the variance within.
fn variance_ratio(all: &[Alone], together: f64, between: f64) -> Option<(f64, f64)> {
    let apart: f64 = all.iter().map(|one| one.squares).sum();
    let within: f64 = all.iter().map(|one| one.degrees_of_freedom).sum();
    if within < 1.0 || apart <= 0.0 {
        return None;
    }
    let inflation = mean(all.iter().filter(|one| one.degrees_of_freedom > 0.0).map(|one| one.inflation));
    let ratio = ((together - apart).max(0.0) / between) / (inflation * apart / within);
    Some((ratio, upper_f(ratio, between, within)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alone(squares: f64) -> Alone {
        Alone { squares, degrees_of_freedom: 3.0, inflation: 1.0 }
    }

    /// Five lists of variance 1 with 15 degrees of freedom within, 4 between: an excess of 4 is a ratio of 1, one of 100 is 25.
    #[test]
    fn a_difference_between_lists_is_held_against_their_scatter() {
        let all = [3.0; 5].map(alone);
        let (ratio, probability) = variance_ratio(&all, 19.0, 4.0).unwrap();
        assert!((ratio - 1.0).abs() < 1e-12 && probability > 0.3);
        let (ratio, probability) = variance_ratio(&all, 115.0, 4.0).unwrap();
        assert!((ratio - 25.0).abs() < 1e-12 && probability < PROBABLE);
        let wide = all.map(|one| Alone { inflation: 25.0, ..one });
        assert!(variance_ratio(&wide, 115.0, 4.0).unwrap().1 > 0.3, "errors that add up explain as much");
        let exact = [0.0; 2].map(|squares| Alone { degrees_of_freedom: 0.0, ..alone(squares) });
        assert!(variance_ratio(&exact, 5.0, 1.0).is_none(), "nothing is known of their scatter");
    }
}

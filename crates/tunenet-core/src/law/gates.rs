//! What a law has to pass, and what casts a doubt on it: limits of its tests, which `judge` and `ahead` measure.

use serde::Serialize;

use super::reason::Reason;
use crate::statistics::upper_chi_squared;

/// Residual force of a law, in nats: by Markov's inequality odds of twenty to one have at most a probability of one in twenty by chance.
pub const MOST_FORCE_NATS: f64 = 3.0;
/// The same of a law that stands alone, and of recordings in which nothing is missing: odds of two to one.
pub const LIKELY_FORCE_NATS: f64 = 0.7;
/// A law whose recordings differ so much, or whose held-out recordings leave so much, is refused where that has a smaller probability by
/// chance: four tests refuse a true law in one case of 2,500.
pub const LEAST_PROBABILITY: f64 = 1e-4;
/// The same of a law that stands alone.
pub const CHANCE: f64 = 0.01;
/// The same of a parameter beyond its bound, in standard deviations (one side).
const BEYOND: f64 = 2.326;
/// Held-out recordings that leave no more than so many times the noise, what the uncertainty of the law's constants explains aside, pass in
/// any case.
pub const MOST_HELD_OUT: f64 = 1.05;
/// Residual force on held-out recordings, in nats: odds of a thousand to one. Of a law that stands alone [`MOST_FORCE_NATS`].
pub const MOST_HELD_OUT_FORCE_NATS: f64 = 6.9;

/// What the tests of a law measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gates {
    /// Evidence of a force that is left, in nats; at most 3.
    pub residual_force_nats: f64,
    /// Probability that recordings differ so much by chance; at least 0.0001. `None` of a single recording.
    pub heterogeneity_p: Option<f64>,
    /// Error on held-out recordings over the noise. `None` without any.
    pub held_out_ratio: Option<f64>,
    /// The same of the model without the law, which it must not exceed.
    pub held_out_base: Option<f64>,
    /// Root mean square of what held-out recordings leave, without the law and with it, in the unit of the channels where they have one,
    /// else over the noise.
    pub held_out_gap: Option<(f64, f64)>,
    /// Error on held-out recordings over the noise, what the uncertainty of the constants explains aside.
    pub held_out_left: Option<f64>,
    /// Probability that held-out recordings leave so much more than the fitted ones by chance (F test).
    pub held_out_p: Option<f64>,
    /// Evidence of a force that is left on held-out recordings, in nats, what the uncertainty of the constants explains aside; at most 6.9.
    pub held_out_force_nats: Option<f64>,
    /// Probability that held-out recordings ask for so different constants by chance; at least 0.0001.
    pub held_out_differ_p: Option<f64>,
    /// Logarithm of the predictive density of held-out recordings, in nats, but for what is the same for all laws. `None` where rollouts
    /// are not linear enough in the constants to know it.
    pub held_out_nats: Option<f64>,
    /// How far the recordings favour values beyond the bound at which a parameter of the simulation lies, in standard deviations: the greatest
    /// of all parameters. 0 where none does.
    pub beyond_bound: f64,
}

/// A test that a law fails, with what it measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Failure {
    /// Recordings differ.
    Heterogeneity {
        /// The probability by chance.
        p: f64,
    },
    /// A force is left.
    ResidualForce {
        /// Its evidence.
        nats: f64,
    },
    /// Held-out recordings are predicted worse than without the law.
    Worse {
        /// The error over the noise.
        ratio: f64,
        /// The same without the law.
        without: f64,
    },
    /// A force is left on held-out recordings.
    HeldOutForce {
        /// Its evidence.
        nats: f64,
    },
    /// Held-out recordings leave more than fitted ones.
    LeavesMore {
        /// The error over the noise, what uncertain constants explain aside.
        left: f64,
        /// The probability by chance.
        p: f64,
    },
    /// Held-out recordings ask for other constants.
    Differ {
        /// The probability by chance.
        p: f64,
    },
}

impl Failure {
    /// The reason that it is.
    #[must_use]
    pub const fn reason(self) -> Reason {
        match self {
            Self::Heterogeneity { .. } => Reason::Heterogeneity,
            Self::ResidualForce { .. } => Reason::ResidualForce,
            Self::Worse { .. } | Self::HeldOutForce { .. } | Self::LeavesMore { .. } | Self::Differ { .. } => {
                Reason::HeldOut
            }
        }
    }
}

impl Gates {
    /// The tests that fail. What differs between recordings says more than what is left, and comes first.
    #[must_use]
    pub fn failures(&self) -> Vec<Failure> {
        let unlikely = |p: &f64| *p < LEAST_PROBABILITY;
        let heterogeneity = self.heterogeneity_p.filter(unlikely).map(|p| Failure::Heterogeneity { p });
        let nats = self.residual_force_nats;
        let force = (nats > MOST_FORCE_NATS).then_some(Failure::ResidualForce { nats });
        let held_out = self.held_out_ratio.zip(self.held_out_base);
        let worse = held_out.filter(|(ratio, without)| ratio > without);
        let worse = worse.map(|(ratio, without)| Failure::Worse { ratio, without });
        let ahead = self.held_out_force_nats.filter(|nats| *nats > MOST_HELD_OUT_FORCE_NATS);
        let ahead = ahead.map(|nats| Failure::HeldOutForce { nats });
        // Where they leave no more than the noise that all recordings show, fitted ones left less by chance.
        let much = self.held_out_ratio.is_none_or(|ratio| ratio > MOST_HELD_OUT);
        let more = self.leaves_more(LEAST_PROBABILITY).filter(|_| much);
        let more = more.map(|(left, p)| Failure::LeavesMore { left, p });
        let differ = self.held_out_differ_p.filter(unlikely).map(|p| Failure::Differ { p });
        [heterogeneity, force, worse, ahead, more, differ].into_iter().flatten().collect()
    }

    /// Why it fails, if it does.
    #[must_use]
    pub fn failed(&self) -> Option<Reason> {
        self.failures().first().map(|failure| failure.reason())
    }

    /// What speaks against a law that stands alone: what comes by chance in less than one case of a hundred, and a force that is likely left.
    #[must_use]
    pub fn doubt(&self) -> Option<Reason> {
        let differ = [self.heterogeneity_p, self.held_out_differ_p].into_iter().flatten().any(|p| p < CHANCE);
        let more = self.leaves_more(CHANCE).map(|_| Reason::LeavesMore);
        let bound = (self.beyond_bound > BEYOND).then_some(Reason::ParameterBound);
        let ahead = self.held_out_force_nats.is_some_and(|nats| nats > MOST_FORCE_NATS);
        let force = (self.residual_force_nats > LIKELY_FORCE_NATS || ahead).then_some(Reason::LeavesForce);
        let together = (self.together_p() < CHANCE).then_some(Reason::Together);
        if differ { Some(Reason::Differ) } else { more.or(bound).or(force).or(together) }
    }

    /// The probability that the tests of how recordings differ and of what held-out ones leave come out so badly together by chance (Fisher
    /// 1932). What these leave counts only where it matters.
    fn together_p(&self) -> f64 {
        let more = self.held_out_p.filter(|_| self.held_out_left.is_some_and(|left| left > MOST_HELD_OUT));
        let tests = || [self.heterogeneity_p, self.held_out_differ_p, more].into_iter().flatten();
        let sum: f64 = tests().map(|p| -2.0 * p.max(f64::MIN_POSITIVE).ln()).sum();
        match tests().count() {
            0 => 1.0,
            count => upper_chi_squared(sum, 2.0 * count as f64),
        }
    }

    /// What held-out recordings leave more than the fitted ones, over the noise, where that has a smaller probability by chance; and the
    /// probability.
    fn leaves_more(&self, probability: f64) -> Option<(f64, f64)> {
        self.held_out_left.zip(self.held_out_p).filter(|(left, p)| *left > MOST_HELD_OUT && *p < probability)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gates(force: f64, ahead: f64) -> Gates {
        Gates {
            residual_force_nats: force,
            heterogeneity_p: Some(0.5),
            held_out_ratio: Some(1.07),
            held_out_base: Some(2.0),
            held_out_gap: None,
            held_out_left: Some(1.06),
            held_out_p: Some(0.02),
            held_out_force_nats: Some(ahead),
            held_out_differ_p: Some(0.5),
            held_out_nats: None,
            beyond_bound: 0.0,
        }
    }

    #[test]
    fn a_law_whose_recordings_differ_stands_but_not_alone() {
        let differ = |p: f64| Gates { held_out_differ_p: Some(p), held_out_p: Some(0.5), ..gates(0.0, 0.0) };
        assert_eq!(
            [0.02, 0.002].map(|p| (differ(p).failed(), differ(p).doubt())),
            [(None, None), (None, Some(Reason::Differ))]
        );
        let leaves = |p: f64| Gates { held_out_p: Some(p), ..gates(0.0, 0.0) };
        assert_eq!(
            [0.02, 0.002].map(|p| (leaves(p).failed(), leaves(p).doubt())),
            [(None, None), (None, Some(Reason::LeavesMore))]
        );
    }

    /// Three tests at 0.03 each: −2 Σ ln p is 21.0, which χ² of six degrees of freedom exceeds with probability 0.0018; at 0.1 each 0.032.
    #[test]
    fn tests_that_nearly_fail_together_cast_a_doubt() {
        let of = |p: f64| Gates {
            heterogeneity_p: Some(p),
            held_out_differ_p: Some(p),
            held_out_p: Some(p),
            ..gates(0.0, 0.0)
        };
        assert!((of(0.03).together_p() / 0.0018 - 1.0).abs() < 0.02, "{}", of(0.03).together_p());
        assert!((of(0.1).together_p() / 0.032 - 1.0).abs() < 0.02, "{}", of(0.1).together_p());
        assert_eq!([0.03, 0.1].map(|p| of(p).doubt()), [Some(Reason::Together), None]);
        let close = Gates { held_out_left: Some(1.04), held_out_p: Some(1e-9), ..of(0.1) };
        assert_eq!(close.doubt(), None);
    }

    #[test]
    fn every_test_that_fails_is_listed_with_what_it_measured() {
        let all = Gates {
            heterogeneity_p: Some(5e-5),
            held_out_base: Some(0.9),
            held_out_p: Some(1e-5),
            held_out_differ_p: Some(1e-6),
            ..gates(3.5, 7.5)
        };
        let wanted = [
            Failure::Heterogeneity { p: 5e-5 },
            Failure::ResidualForce { nats: 3.5 },
            Failure::Worse { ratio: 1.07, without: 0.9 },
            Failure::HeldOutForce { nats: 7.5 },
            Failure::LeavesMore { left: 1.06, p: 1e-5 },
            Failure::Differ { p: 1e-6 },
        ];
        assert_eq!(all.failures(), wanted);
        assert_eq!(gates(2.9, 6.8).failures(), []);
    }

    #[test]
    fn a_law_that_likely_leaves_a_force_stands_but_not_alone() {
        let of = |force: f64, ahead: f64| Gates { held_out_p: Some(0.5), ..gates(force, ahead) };
        assert_eq!([of(0.6, 2.9), of(0.8, 0.0), of(0.0, 3.1)].map(|g| g.failed()), [None; 3]);
        let doubt = Some(Reason::LeavesForce);
        assert_eq!([of(0.6, 2.9), of(0.8, 0.0), of(0.0, 3.1)].map(|g| g.doubt()), [None, doubt, doubt]);
    }

    /// Odds of 20 to 1 on fitted recordings, of 1,000 to 1 on held-out ones as of their other tests.
    #[test]
    fn a_law_fails_the_first_test_whose_limit_it_exceeds() {
        assert_eq!(gates(2.9, 6.8).failed(), None);
        assert_eq!(gates(2.9, 7.0).failed(), Some(Reason::HeldOut));
        assert_eq!(gates(3.1, 7.0).failed(), Some(Reason::ResidualForce));
        assert_eq!(Gates { heterogeneity_p: Some(9e-5), ..gates(3.1, 7.0) }.failed(), Some(Reason::Heterogeneity));
        assert_eq!(Gates { held_out_p: Some(9e-5), ..gates(0.0, 0.0) }.failed(), Some(Reason::HeldOut));
        let close = Gates { held_out_p: Some(9e-5), held_out_left: Some(1.04), ..gates(0.0, 0.0) };
        assert_eq!((close.failed(), close.doubt()), (None, None), "so little is no error");
        let as_noise = Gates { held_out_p: Some(9e-5), held_out_ratio: Some(1.04), ..gates(0.0, 0.0) };
        assert_eq!((as_noise.failed(), as_noise.doubt()), (None, Some(Reason::LeavesMore)), "as all recordings show");
        assert_eq!(Gates { held_out_base: Some(0.99), ..gates(0.0, 0.0) }.failed(), Some(Reason::HeldOut));
    }
}

//! What a search for a law ends with.

use serde::Serialize;

use super::course::Course;
use super::shape::Role;
use super::space::Carried;
use super::term::Term;
use crate::observation::Observation;
use crate::statistics::upper_chi_squared;

/// Residual force, in nats: odds of twenty to one.
pub const MOST_FORCE_NATS: f64 = 3.0;
/// A law whose recordings differ so much, or whose held-out recordings leave so much, is refused where that has a smaller probability by
/// chance, and does not stand alone below the second one.
pub(super) const LEAST_PROBABILITY: f64 = 1e-3;
const CHANCE: f64 = 0.01;
/// The same of a parameter beyond its bound, in standard deviations (one side).
const BEYOND: f64 = 2.326;
/// Held-out recordings that leave no more than so many times the noise, what the uncertainty of the law's constants explains aside, pass in
/// any case.
pub const MOST_HELD_OUT: f64 = 1.05;
/// A constant lies at an end of its range within this share of it.
const AT_BOUND: f64 = 1e-3;
/// Residual force on held-out recordings, in nats: by Markov's inequality odds of a thousand to one have at most that probability.
pub const MOST_HELD_OUT_FORCE_NATS: f64 = 6.9;

/// The answer in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing is missing that these recordings could show.
    None,
    /// One law, which held-out recordings confirm.
    Law,
    /// Several laws, or one without held-out recordings.
    OneOf,
    /// What the catalogue names explains the recordings as well, or is the law.
    Named,
    /// Something is missing, and no law of the table explains it.
    Unknown,
}

/// Why a law is not the answer, or not alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// Held-out recordings are predicted worse than noise allows.
    HeldOut,
    /// There are no held-out recordings.
    NoHeldOut,
    /// More than noise is left.
    ResidualForce,
    /// Recordings differ: something unmeasured.
    Heterogeneity,
    /// It depends on the time, and fails a test.
    Time,
    /// The allowance of rollouts ended the search.
    Rollouts,
    /// Several laws explain the recordings.
    Several,
    /// It has two terms, whose rivals were not compared.
    Terms,
    /// It fits any smooth force: a bump of which one flank was seen only, less than half a period of an oscillation, or a product of two
    /// factors with two constants each, or of one variable.
    Flexible,
    /// A constant of it lies at the end of the range that is searched.
    Bound,
    /// A parameter of the simulation lies at a bound other than 0, or at one beyond which the recordings favour values.
    ParameterBound,
    /// Rollouts are not linear enough in its constants to compare it with other laws by held-out recordings.
    NotLinear,
    /// So few recordings do not show whether something unmeasured differs between them.
    Few,
    /// Recordings ask for constants that differ more than in one case of a hundred by chance.
    Differ,
    /// Held-out recordings leave more than fitted ones, so much more that it comes in less than one case of a hundred by chance.
    LeavesMore,
    /// Its tests come out so badly together that it comes in less than one case of a hundred by chance, though each alone does not.
    Together,
    /// No shape of the table gains what it costs.
    Grammar,
    /// An effect of the catalogue explains the recordings as well.
    Catalogue,
}

/// What the tests of a law measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gates {
    /// Evidence of a force that is left, in nats; at most 3.
    pub residual_force_nats: f64,
    /// Probability that recordings differ so much by chance; at least 0.001. `None` of a single recording.
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
    /// Probability that held-out recordings ask for so different constants by chance; at least 0.001.
    pub held_out_differ_p: Option<f64>,
    /// Logarithm of the predictive density of held-out recordings, in nats, but for what is the same for all laws. `None` where rollouts
    /// are not linear enough in the constants to know it.
    pub held_out_nats: Option<f64>,
    /// How far the recordings favour values beyond the bound at which a parameter of the simulation lies, in standard deviations: the greatest
    /// of all parameters. 0 where none does.
    pub beyond_bound: f64,
}

impl Gates {
    /// The first test that fails.
    #[must_use]
    pub fn failed(&self) -> Option<Reason> {
        let unlikely = |p: Option<f64>| p.is_some_and(|p| p < LEAST_PROBABILITY);
        let worse = self.held_out_ratio.is_some_and(|ratio| self.held_out_base.is_some_and(|base| ratio > base));
        let beyond = self.leaves_more(LEAST_PROBABILITY);
        let forced = self.held_out_force_nats.is_some_and(|nats| nats > MOST_HELD_OUT_FORCE_NATS);
        // What fails on held-out recordings, and what differs between recordings, says more than what is left.
        if unlikely(self.heterogeneity_p) {
            Some(Reason::Heterogeneity)
        } else if self.residual_force_nats > MOST_FORCE_NATS {
            Some(Reason::ResidualForce)
        } else if worse || forced || beyond || unlikely(self.held_out_differ_p) {
            Some(Reason::HeldOut)
        } else {
            None
        }
    }

    /// What speaks against a law that stands alone: what comes by chance in less than one case of a hundred.
    #[must_use]
    pub fn doubt(&self) -> Option<Reason> {
        let differ = [self.heterogeneity_p, self.held_out_differ_p].into_iter().flatten().any(|p| p < CHANCE);
        let more = self.leaves_more(CHANCE).then_some(Reason::LeavesMore);
        let bound = (self.beyond_bound > BEYOND).then_some(Reason::ParameterBound);
        let together = (self.together_p() < CHANCE).then_some(Reason::Together);
        if differ { Some(Reason::Differ) } else { more.or(bound).or(together) }
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

    /// Whether held-out recordings leave more than the fitted ones, and so much more that it has a smaller probability by chance.
    fn leaves_more(&self, probability: f64) -> bool {
        self.held_out_left.is_some_and(|left| left > MOST_HELD_OUT) && self.held_out_p.is_some_and(|p| p < probability)
    }
}

/// One number of a law.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Number {
    /// Its key in the formula.
    pub key: String,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Its 95 % interval, wider by what the choice of the form leaves open.
    pub interval95: (f64, f64),
    /// What it is inside a factor; `None` of a coefficient.
    #[serde(skip)]
    pub role: Option<Role>,
}

/// An exponent that was rounded, with its interval before.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rounded {
    /// The rounded value.
    pub value: f64,
    /// The interval of the fitted one.
    pub interval95: (f64, f64),
}

/// A term of a law.
#[derive(Debug, Clone, Serialize)]
pub struct FoundTerm {
    /// The term.
    #[serde(skip)]
    pub term: Term,
    /// The product of its factors as a formula; empty of a constant.
    pub formula: String,
    /// The names of its components.
    pub components: Vec<String>,
    /// Its numbers.
    pub numbers: Vec<Number>,
    /// Of each factor, its rounded constant.
    pub rounded: Vec<Option<Rounded>>,
    /// The variables that its factors use: their positions and names.
    #[serde(skip)]
    pub variables: Vec<(usize, String)>,
    /// How the host carries it: the bounds of its numbers.
    #[serde(skip)]
    pub carried: Carried,
}

/// A law.
#[derive(Debug, Clone, Serialize)]
pub struct Member {
    /// Its terms.
    pub terms: Vec<FoundTerm>,
    /// The effect of the catalogue that it is.
    pub alias: Option<&'static str>,
    /// Gain of the information criterion.
    pub bic_gain: f64,
    /// The same less the price of its structure.
    pub score: f64,
    /// How far its gain is behind the best.
    pub behind_best: f64,
    /// The length of its description.
    pub bits: f64,
    /// What its tests measured.
    pub gates: Gates,
    /// Between which values of each variable that it uses it was seen: position of the variable, and the range.
    pub valid: Vec<(String, (f64, f64))>,
    /// Whether it depends on the clock.
    pub depends_on_time: bool,
    /// Whether rollouts over one and a half times that range stay finite.
    pub bounded: bool,
    /// Root mean square of what fitted recordings leave, without the law and with it, as [`Gates::held_out_gap`].
    pub gap: (f64, f64),
    /// Its force along each variable that it uses.
    pub courses: Vec<Course>,
    /// The parameters of the simulator with it, in its order, and their 95 % intervals.
    pub parameters: Vec<(f64, (f64, f64))>,
}

/// A law that a test refused.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refused {
    /// The law in words.
    pub text: String,
    /// Its gain of the information criterion.
    pub bic_gain: f64,
    /// The test that it failed.
    pub gate: Reason,
}

/// How a recording was followed without a law and with the best one, the parameters fitted in both.
#[derive(Debug, Clone)]
pub struct Followed {
    /// What was used of it.
    pub seen: Observation,
    /// Noise of each channel in its unit.
    pub noise: Vec<f64>,
    /// Measured − predicted without a law, in units of the noise, shape `[sample · channel]`.
    pub without: Vec<f64>,
    /// The same with the law.
    pub with: Vec<f64>,
    /// When something sudden happened, s.
    pub events: Vec<f64>,
    /// Its nuisance parameters with the law: name, value, unit.
    pub nuisances: Vec<(String, f64, String)>,
}

/// The answer.
#[derive(Debug, Clone, Serialize)]
pub struct Answer {
    /// In one word.
    pub verdict: Verdict,
    /// Why not more than that.
    pub reason: Option<Reason>,
    /// The laws, best first.
    pub members: Vec<Member>,
    /// Laws within the margin that a test refused.
    pub refused: Vec<Refused>,
    /// Evidence of a missing force about the model without a law, nats.
    pub base_force_nats: f64,
    /// What the catalogue's answer gains in the information criterion on the same recordings.
    pub rival_bic_gain: Option<f64>,
    /// Whether a test on held-out recordings refused the law that is the catalogue's answer.
    pub rival_refused: bool,
    /// How many recordings were held out.
    pub held_out: usize,
    /// Root mean square of the residuals in units of the noise, without a law and with the best.
    pub left: (f64, f64),
    /// How the fitted recordings were followed, in their order; none without a law.
    #[serde(skip)]
    pub followed: Vec<Followed>,
    /// Rollouts in all.
    pub rollouts: usize,
}

impl Member {
    /// Whether a constant inside a factor lies at an end of the range that is searched, where its interval says nothing.
    #[must_use]
    pub fn is_at_bound(&self) -> bool {
        self.terms.iter().any(|term| {
            let each = term.numbers.iter().zip(&term.carried.effect.coefficients);
            each.filter(|(number, _)| number.role.is_some()).any(|(number, of)| {
                let room = AT_BOUND * (of.max - of.min);
                number.value <= of.min + room || number.value >= of.max - room
            })
        })
    }

    /// The law in words: coefficients, formulas and directions.
    #[must_use]
    pub fn text(&self) -> String {
        self.terms.iter().map(FoundTerm::text).collect::<Vec<_>>().join(" + ")
    }
}

impl FoundTerm {
    /// The term in words: `a * speed^p along v`.
    #[must_use]
    pub fn text(&self) -> String {
        let along = self.components.join(", ");
        let sign = if self.components.len() == 1 { "a" } else { "(a)" };
        if self.formula.is_empty() {
            format!("{sign} along {along}")
        } else {
            format!("{sign} * {} along {along}", self.formula)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gates(force: f64, ahead: f64) -> Gates {
        Gates {
            residual_force_nats: force,
            heterogeneity_p: Some(0.5),
            held_out_ratio: Some(1.0),
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

    /// Odds of 20 to 1 on fitted recordings, of 1,000 to 1 on held-out ones as of their other tests.
    #[test]
    fn a_law_fails_the_first_test_whose_limit_it_exceeds() {
        assert_eq!(gates(2.9, 6.8).failed(), None);
        assert_eq!(gates(2.9, 7.0).failed(), Some(Reason::HeldOut));
        assert_eq!(gates(3.1, 7.0).failed(), Some(Reason::ResidualForce));
        assert_eq!(Gates { heterogeneity_p: Some(9e-4), ..gates(3.1, 7.0) }.failed(), Some(Reason::Heterogeneity));
        assert_eq!(Gates { held_out_p: Some(9e-4), ..gates(0.0, 0.0) }.failed(), Some(Reason::HeldOut));
        let close = Gates { held_out_p: Some(9e-4), held_out_left: Some(1.04), ..gates(0.0, 0.0) };
        assert_eq!((close.failed(), close.doubt()), (None, None), "so little is no error");
        assert_eq!(Gates { held_out_base: Some(0.99), ..gates(0.0, 0.0) }.failed(), Some(Reason::HeldOut));
    }
}

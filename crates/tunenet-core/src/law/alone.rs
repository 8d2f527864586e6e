//! Which laws a law has to surpass before it stands alone (Burnham and Anderson 2002, sections 2.2 and 6.4): the Schwarz criterion ranks
//! laws and prefers the simpler one where both explain as much, which is no evidence against the other. Laws of as many factors are
//! therefore compared by Akaike's criterion as well, and those with as many fitted constants by likelihood alone: which exponent is the
//! rounder one is no evidence either. What claims more than was visited takes no part in that: a bump of which one flank was seen only, or
//! less than half a period of an oscillation, is any smooth function that rises. Nor is a law a rival of one that it holds as a special
//! case where it predicts held-out recordings no better: tens of further factors are tried on the fitted ones, and the best of them gains
//! there by chance (Geisser 1975).

use std::f64::consts::PI;

use super::answer::Member;
use super::forms::{is_same, nests, rounds_off};
use super::gates::MOST_HELD_OUT;
use super::price::{self, WIDER};
use super::refit::{Law, Session};
use super::response::Response;
use super::shape::{Range, Role, Shape};
use super::term::{Factor, Term};
use crate::statistics::NORMAL_95;

/// Models within so much of the best have substantial support.
const SUBSTANTIAL: f64 = 2.0;

/// A simpler law than the best one is tested within so many margins of it.
const WITHIN: f64 = 2.0;

/// The criterion of Akaike, in twice the logarithmic likelihood, the greater the better.
fn akaike(session: &Session, law: &Law) -> f64 {
    session.gain(law) - price::AKAIKE * price::chosen(&law.terms) as f64
}

/// How many factors a law of one term has: none is the factor x⁰, and what `between` compares with one factor counts as one.
fn factors(law: &Law) -> Option<usize> {
    let [one] = law.terms.as_slice() else { return None };
    Some(if is_comprehensive(one) { 1 } else { one.factors.len().max(1) })
}

/// Whether this is a whole power times an exponential or a saturation of the same variable, as x⁻¹ exp(-x/c) and x/(1 + x/c): it has as many
/// fitted constants as the one factor with which it is compared, and its whole power was not chosen among many.
fn is_comprehensive(term: &Term) -> bool {
    let [one, other] = term.factors.as_slice() else { return false };
    let whole = |factor: &Factor| factor.shape == Shape::Power && factor.rounded.is_some_and(|p| p.fract() == 0.0);
    let falls = |factor: &Factor| matches!(factor.shape, Shape::Exp | Shape::Saturation);
    one.variable == other.variable && (whole(one) && falls(other) || whole(other) && falls(one))
}

/// Forms between which a rounder exponent is no evidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    /// A whole power times an exponential or a saturation of the same variable.
    Comprehensive,
    /// A power with a rounded exponent that is not whole: the data chose it as they choose a constant.
    HalfPower,
    Other,
}

impl Form {
    fn of(law: &Law) -> Self {
        let [one] = law.terms.as_slice() else { return Self::Other };
        match one.factors.as_slice() {
            _ if is_comprehensive(one) => Self::Comprehensive,
            [factor] if factor.rounded.is_some_and(|p| p.fract() != 0.0) => Self::HalfPower,
            _ => Self::Other,
        }
    }
}

/// What recordings say for a law, in twice the logarithmic likelihood.
#[derive(Debug, Clone, Copy)]
struct Support {
    /// By the criterion of Schwarz, by that of Akaike, and without a price.
    schwarz: f64,
    akaike: f64,
    likelihood: f64,
    /// Of one term: how many factors it has.
    factors: Option<usize>,
    /// How many constants are fitted, and how many numbers the data chose.
    constants: usize,
    chosen: usize,
    form: Form,
    /// Whether the middle of every bump and half a period of every oscillation were visited.
    visited: bool,
}

impl Support {
    /// By fitted recordings, and by held-out ones of which its predictive density has this logarithm (nats).
    fn of(session: &Session, response: &Response, law: &Law, held_out_nats: f64) -> Self {
        let more = 2.0 * held_out_nats;
        let visited = visits_shapes(&law.terms, &law.numbers(), &law.deviations(), &response.ranges);
        Self {
            schwarz: law.bic + more,
            akaike: akaike(session, law) + more,
            likelihood: session.gain(law) + more,
            factors: factors(law),
            constants: price::constants(&law.terms),
            chosen: price::chosen(&law.terms),
            form: Form::of(law),
            visited,
        }
    }

    /// Whether recordings do not decide between this law and `lead`: it lies within `margin` of `best` by the criterion of Schwarz, or has,
    /// where `lead` does, as many factors, at most one number more, no unvisited middle, and either substantial support by Akaike's or a
    /// likelihood within `margin` by as many constants.
    fn is_near(&self, lead: &Self, best: f64, margin: f64) -> bool {
        let leads = lead.schwarz >= best - margin;
        let as_simple = lead.factors.is_some() && self.factors == lead.factors && self.chosen <= lead.chosen + 1;
        let as_simple = as_simple && leads && self.visited;
        let supported = self.akaike >= lead.akaike - SUBSTANTIAL;
        let as_chosen =
            self.form == Form::Comprehensive && lead.form == Form::HalfPower && self.constants == lead.chosen;
        let as_many = self.constants == lead.constants || as_chosen;
        let as_likely = as_many && self.likelihood >= lead.likelihood - margin;
        self.schwarz >= best - margin || as_simple && (supported || as_likely)
    }
}

/// Which of these laws are near the best of them; `best` is the support of the best one by the criterion of Schwarz, their own where it is
/// not given.
fn nearest(all: &[Support], best: Option<f64>, margin: f64) -> Vec<bool> {
    let Some(lead) = all.iter().max_by(|a, b| a.schwarz.total_cmp(&b.schwarz)) else { return Vec::new() };
    let best = best.unwrap_or(lead.schwarz);
    all.iter().map(|one| one.is_near(lead, best, margin)).collect()
}

fn kept<T>(all: Vec<T>, keep: Vec<bool>) -> Vec<T> {
    all.into_iter().zip(keep).filter_map(|(one, keep)| keep.then_some(one)).collect()
}

/// Whether the recordings visited what makes the shape of every factor: the 95 % interval of the middle of a bump, and half a period of an
/// oscillation even at the lower end of its interval.
fn visits_shapes(terms: &[Term], numbers: &[Vec<f64>], deviations: &[f64], ranges: &[Range]) -> bool {
    let mut before = 0;
    terms.iter().zip(numbers).all(|(term, values)| {
        let mut at = term.components;
        let visited = term.factors.iter().all(|factor| {
            let range = &ranges[factor.variable];
            let mut each = factor.open().iter().enumerate();
            let whole = each.all(|(i, role)| {
                let (value, half) = (values[at + i], NORMAL_95 * WIDER * deviations[before + at + i]);
                match role {
                    Role::Place => range.low <= value - half && value + half <= range.high,
                    Role::Frequency => (value - half) * (range.high - range.low) >= PI,
                    _ => true,
                }
            });
            at += factor.constants();
            whole
        });
        before += values.len();
        visited
    })
}

/// Whether a law fits any smooth force: a bump of which a flank was seen only, less than half a period of an oscillation, two factors with two
/// constants each, or two factors of one variable that fit any smooth curve of it.
pub(super) fn is_flexible(response: &Response, law: &Law) -> bool {
    let shapes = visits_shapes(&law.terms, &law.numbers(), &law.deviations(), &response.ranges);
    !shapes || law.terms.iter().any(|term| is_product_of_four_constants(term) || is_any_curve(term))
}

/// Bumps and oscillations have two constants.
fn is_product_of_four_constants(term: &Term) -> bool {
    term.factors.len() > 1 && term.factors.iter().all(|factor| factor.constants() > 1)
}

/// Two factors of one variable of which both have a fitted constant, or which have three numbers in all: `abs(x)^p * cos(k*x)`,
/// `x^2 * exp(-((x - h)/w)^2)`.
fn is_any_curve(term: &Term) -> bool {
    let [one, other] = term.factors.as_slice() else { return false };
    let numbers = |factor: &Factor| factor.constants() + usize::from(factor.rounded.is_some());
    let both_open = one.constants() > 0 && other.constants() > 0;
    one.variable == other.variable && (both_open || numbers(one) + numbers(other) > 2)
}

/// The laws between which fitted recordings do not decide, and simpler ones that held-out recordings may favour by as much as the fitted
/// ones speak against them.
pub(super) fn near(session: &Session, response: &Response, laws: Vec<Law>, best: f64, margin: f64) -> Vec<Law> {
    let support: Vec<Support> = laws.iter().map(|law| Support::of(session, response, law, 0.0)).collect();
    let near = nearest(&support, Some(best), margin);
    let simpler = simpler(&support, best, WITHIN * margin);
    let tested = near.into_iter().zip(simpler).map(|(near, simpler)| near || simpler).collect();
    kept(laws, tested)
}

/// Which of these laws have fewer constants than the best of them and lie within `margin` of `best` by the criterion of Schwarz.
fn simpler(all: &[Support], best: f64, margin: f64) -> Vec<bool> {
    let Some(lead) = all.iter().max_by(|a, b| a.schwarz.total_cmp(&b.schwarz)) else { return Vec::new() };
    all.iter().map(|one| one.constants < lead.constants && one.schwarz >= best - margin).collect()
}

/// The members between which fitted and held-out recordings together do not decide, best first: the evidence of all recordings is that of
/// the fitted ones times the predictive density of the held-out ones (Geisser and Eddy 1979).
pub(super) fn undecided(
    session: &Session,
    response: &Response,
    members: Vec<(Law, Member)>,
    margin: f64,
) -> Vec<(Law, Member)> {
    // Without the density of one there is nothing to compare that of the others with.
    let known = members.iter().all(|(_, member)| member.gates.held_out_nats.is_some());
    let nats = |member: &Member| member.gates.held_out_nats.filter(|_| known).unwrap_or(0.0);
    let support = members.iter().map(|(law, member)| Support::of(session, response, law, nats(member)));
    let support: Vec<Support> = support.collect();
    let fitted = members.iter().map(|(law, _)| Support::of(session, response, law, 0.0));
    let near_fitted = nearest(&fitted.collect::<Vec<_>>(), None, margin);
    let ratios: Vec<Option<f64>> = members.iter().map(|(_, member)| member.gates.held_out_ratio).collect();
    let better = predict_better(&support, &ratios);
    let near = nearest(&support, None, margin).into_iter().zip(near_fitted).zip(better);
    let near = near.map(|((near, near_fitted), better)| near || near_fitted && better).collect();
    let left = kept(members.into_iter().zip(&support).collect(), near);
    let space = session.host.space();
    let unconfirmed = |((large, ahead), _): &((Law, Member), &Support)| {
        let by = |((small, of), _): &((Law, Member), &Support)| {
            let holds = nests(space, &large.terms, &small.terms) && !rounds_off(large, small, &response.ranges);
            holds && predicts_no_better(ahead, of)
        };
        known && left.iter().any(by)
    };
    let keep = left.iter().map(|one| !unconfirmed(one)).collect();
    let mut left = kept(left, keep);
    let best = left.iter().map(|(_, one)| one.schwarz).fold(f64::NEG_INFINITY, f64::max);
    left.sort_by(|a, b| {
        let score = |(law, member): &(Law, Member)| law.score + 2.0 * nats(member);
        score(&b.0).total_cmp(&score(&a.0))
    });
    let behind = |((law, member), support): ((Law, Member), &Support)| {
        (law, Member { behind_best: best - support.schwarz, ..member })
    };
    left.into_iter().map(behind).collect()
}

/// Which laws predict held-out recordings, as they stand, far better than the best one by the criterion of Schwarz, whose uncertain constants
/// explain its errors there: certainty speaks against none of them. The errors are over the noise.
fn predict_better(all: &[Support], errors: &[Option<f64>]) -> Vec<bool> {
    let lead = (0..all.len()).max_by(|&a, &b| all[a].schwarz.total_cmp(&all[b].schwarz));
    let most = lead.and_then(|lead| errors[lead]);
    let far = |own: &Option<f64>| own.zip(most).is_some_and(|(own, most)| MOST_HELD_OUT * own < most);
    errors.iter().map(far).collect()
}

/// Whether held-out recordings are not predicted better by the first; without any there is nothing to say.
fn predicts_no_better(large: &Member, small: &Member) -> bool {
    large.gates.held_out_nats.zip(small.gates.held_out_nats).is_some_and(|(large, small)| large <= small)
}

/// The members without those that are another one with its exponents free, where these leave no other multiple of one half open: both are
/// one law, whose exponent is known to that precision.
pub(super) fn merged(members: Vec<(Law, Member)>) -> Vec<(Law, Member)> {
    let is_said = |(free, member): &(Law, Member)| {
        let ([free], [found]) = (free.terms.as_slice(), member.terms.as_slice()) else { return false };
        let intervals: Vec<(f64, f64)> = found.numbers.iter().map(|number| number.interval95).collect();
        members.iter().any(|(one, _)| one.terms.len() == 1 && rounds(&one.terms[0], free, &intervals))
    };
    let keep = members.iter().map(|one| !is_said(one)).collect();
    kept(members, keep)
}

/// Whether `rounded` is `free` with exponents rounded to the only multiples of one half that the intervals of the numbers of `free` hold.
fn rounds(rounded: &Term, free: &Term, intervals: &[(f64, f64)]) -> bool {
    if !is_same(&[rounded.opened()], &[free.opened()]) {
        return false;
    }
    let mut at = free.components;
    let mut differs = false;
    for factor in &free.factors {
        let other = rounded.factors.iter().find(|f| (f.shape, f.variable) == (factor.shape, factor.variable));
        match (factor.rounded, other.and_then(|f| f.rounded)) {
            (None, Some(value)) => {
                let (low, high) = intervals[at];
                let (first, last) = ((2.0 * low).ceil(), (2.0 * high).floor());
                if first != last || first != 2.0 * value {
                    return false;
                }
                differs = true;
            }
            (own, other) if own != other => return false,
            _ => {}
        }
        at += factor.constants();
    }
    differs
}

#[cfg(test)]
mod tests {
    use super::*;

    fn support(schwarz: f64, akaike: f64, factors: usize, chosen: usize) -> Support {
        let likelihood = akaike + price::AKAIKE * chosen as f64;
        Support {
            schwarz,
            akaike,
            likelihood,
            factors: Some(factors),
            constants: chosen,
            chosen,
            form: Form::Other,
            visited: true,
        }
    }

    #[test]
    fn what_predicts_far_better_as_it_stands_is_no_worse_for_its_certainty() {
        let all = [support(90.0, 92.0, 1, 1), support(100.0, 102.0, 1, 1), support(80.0, 82.0, 1, 1)];
        assert_eq!(predict_better(&all, &[Some(1.03), Some(1.22), Some(1.2)]), [true, false, false]);
        assert_eq!(predict_better(&all, &[Some(1.03), None, Some(1.2)]), [false; 3]);
        assert!(predict_better(&[], &[]).is_empty());
    }

    /// x^-1.5 leads by 11: x⁻¹ exp(-x/c) explains 5 less and has a constant for the exponent that was rounded.
    #[test]
    fn a_half_power_is_no_evidence_against_a_power_times_a_decay() {
        let lead = Support { constants: 1, form: Form::HalfPower, ..support(100.0, 104.0, 1, 2) };
        let product = Support { constants: 2, form: Form::Comprehensive, ..support(89.0, 97.0, 1, 3) };
        assert_eq!(nearest(&[lead, product], None, 6.0), [true, true]);
        assert_eq!(nearest(&[lead, Support { likelihood: 101.0, ..product }], None, 6.0), [true, false]);
        assert_eq!(nearest(&[Support { form: Form::Other, ..lead }, product], None, 6.0), [true, false]);
    }

    #[test]
    fn a_whole_power_times_a_decay_of_its_variable_counts_as_one_factor() {
        let power = |p: f64, variable: usize| Factor { rounded: Some(p), ..Factor::new(Shape::Power, variable) };
        let of = |factors: Vec<Factor>| is_comprehensive(&Term::new(0, 1, factors));
        assert!(of(vec![power(-1.0, 0), Factor::new(Shape::Exp, 0)]));
        assert!(of(vec![Factor::new(Shape::Saturation, 0), power(1.0, 0)]));
        assert!(!of(vec![power(-1.5, 0), Factor::new(Shape::Exp, 0)]));
        assert!(!of(vec![power(-1.0, 1), Factor::new(Shape::Exp, 0)]));
        assert!(!of(vec![power(-1.0, 0), Factor::new(Shape::Tanh, 0)]));
        assert!(!of(vec![power(-1.0, 0)]));
    }

    /// One law leads by 8; a second with one number more has lost only what BIC takes for that; a third has two factors.
    #[test]
    fn laws_of_the_size_of_the_best_are_near_by_akaikes_criterion_as_well() {
        let lead = support(100.0, 104.0, 1, 2);
        let all = [lead, support(92.0, 103.0, 1, 3), support(92.0, 103.0, 2, 3), support(92.0, 101.0, 1, 3)];
        assert_eq!(nearest(&all, None, 6.0), [true, true, false, false]);
        assert_eq!(nearest(&all, None, 9.0), [true; 4]);
        // What was not visited is no rival by Akaike's criterion alone.
        let unvisited = Support { visited: false, ..all[1] };
        assert_eq!(nearest(&[lead, unvisited], None, 6.0), [true, false]);
        assert_eq!(nearest(&[lead, unvisited], None, 9.0), [true; 2]);
        // Where an effect of the catalogue leads by more than the margin, none is near.
        assert_eq!(nearest(&all, Some(110.0), 6.0), [false; 4]);
        assert!(nearest(&[], None, 6.0).is_empty());
    }

    /// Of two laws with one constant, x⁰ and x^½, the second explains 5 less and lost 6 more for its bits; a third explains 7 less.
    #[test]
    fn laws_with_as_many_constants_are_near_by_likelihood_as_well() {
        let lead = Support { constants: 1, ..support(100.0, 102.0, 1, 1) };
        let half = |less: f64| Support { constants: 1, ..support(94.0 - less, 100.0 - less, 1, 2) };
        assert_eq!(half(5.0).likelihood, lead.likelihood - 5.0);
        assert_eq!(nearest(&[lead, half(5.0), half(7.0)], None, 6.0), [true, true, false]);
        let more = Support { constants: 2, ..half(5.0) };
        assert_eq!(nearest(&[lead, more], None, 6.0), [true, false]);
    }

    /// A law with one constant less is tested 11 behind the best, one with as many is not.
    #[test]
    fn a_simpler_law_is_tested_within_twice_the_margin() {
        let lead = support(100.0, 104.0, 2, 3);
        let of = |schwarz, constants| Support { constants, ..support(schwarz, 90.0, 2, 3) };
        let all = [lead, of(89.0, 2), of(89.0, 3), of(87.0, 2)];
        assert_eq!(simpler(&all, 100.0, WITHIN * 6.0), [false, true, false, false]);
        assert_eq!(nearest(&all, Some(100.0), 6.0), [true, false, false, false]);
        assert!(simpler(&[], 100.0, 12.0).is_empty());
    }

    /// A bump about 2 ± 0.5 where 1 to 4 was visited, and where only 1 to 2.2 was.
    #[test]
    fn the_middle_of_a_bump_is_visited_within_its_interval() {
        let bump = [Term::new(0, 1, vec![Factor::new(Shape::Bump, 0)])];
        let range = |high| [Range { low: 1.0, high, least: 1.0, greatest: high }];
        let of = |deviation: f64, high: f64| {
            visits_shapes(&bump, &[vec![9.0, 2.0, 0.7]], &[0.1, deviation, 0.1], &range(high))
        };
        let deviation = 0.5 / (NORMAL_95 * WIDER);
        assert!(of(deviation, 4.0) && of(0.1 * deviation, 2.2));
        assert!(!of(deviation, 2.2) && !of(2.1 * deviation, 4.0));
        assert!(visits_shapes(&[power(None)], &[vec![1.0, 9.0]], &[0.1, 9.0], &range(2.0)));
    }

    /// cos(k t + f) over 3 s: half a period is π = 3 k, which k = 1.2 ± 0.1 passes, and 1.2 ± 0.2 and 1.0 do not. A rounded one is known.
    #[test]
    fn half_a_period_of_an_oscillation_is_visited() {
        let wave = [Term::new(0, 1, vec![Factor::new(Shape::Wave, 0)])];
        let range = [Range { low: 0.0, high: 3.0, least: 0.0, greatest: 3.0 }];
        let of = |k: f64, half: f64| {
            visits_shapes(&wave, &[vec![9.0, k, 0.5]], &[0.1, half / (NORMAL_95 * WIDER), 0.1], &range)
        };
        assert!(of(1.2, 0.1) && !of(1.2, 0.2) && !of(1.0, 0.0));
        let whole = [Term::new(0, 1, vec![Factor { rounded: Some(1.0), ..Factor::new(Shape::Cos, 0) }])];
        assert!(visits_shapes(&whole, &[vec![9.0]], &[0.1], &range));
    }

    #[test]
    fn two_factors_with_two_constants_each_fit_any_smooth_force() {
        let bump = |variable| Factor::new(Shape::Bump, variable);
        let of = |factors| is_product_of_four_constants(&Term::new(0, 1, factors));
        assert!(of(vec![bump(0), bump(1)]) && of(vec![bump(0), Factor::new(Shape::Wave, 1)]));
        assert!(!of(vec![bump(0)]) && !of(vec![bump(0), Factor::new(Shape::Power, 1)]) && !of(vec![]));
    }

    #[test]
    fn two_factors_of_one_variable_fit_any_curve_of_it_where_both_are_open() {
        let of = |shape, variable, rounded| Factor { rounded, ..Factor::new(shape, variable) };
        let any = |one: &Factor, other: &Factor| is_any_curve(&Term::new(0, 1, vec![one.clone(), other.clone()]));
        let (screen, wave) = (of(Shape::Exp, 0, None), of(Shape::Cos, 0, None));
        assert!(!any(&screen, &of(Shape::Power, 0, Some(-1.0))) && any(&screen, &of(Shape::Power, 0, None)));
        assert!(any(&of(Shape::OddPower, 0, None), &wave) && !any(&of(Shape::OddPower, 1, None), &wave));
        assert!(any(&of(Shape::Bump, 0, None), &of(Shape::OddPower, 0, Some(2.0))));
        assert!(!any(&of(Shape::Sign, 0, None), &wave));
    }

    fn power(rounded: Option<f64>) -> Term {
        Term::new(0, 1, vec![Factor { rounded, ..Factor::new(Shape::Power, 0) }])
    }

    /// x^p with p from 1.8 to 2.1 is x²; from 1.4 to 2.1 it may be x^1.5 as well, and from 2.1 to 2.3 it is neither.
    #[test]
    fn a_free_exponent_is_the_rounded_one_where_it_leaves_no_other_open() {
        let (free, square) = (power(None), power(Some(2.0)));
        let of = |low, high| [(0.1, 0.2), (low, high)];
        assert!(rounds(&square, &free, &of(1.8, 2.1)));
        assert!(!rounds(&square, &free, &of(1.4, 2.1)) && !rounds(&square, &free, &of(2.1, 2.3)));
        assert!(!rounds(&power(Some(1.0)), &free, &of(1.8, 2.1)));
        assert!(!rounds(&square, &square, &[(0.1, 0.2)]) && !rounds(&free, &free, &of(1.8, 2.1)));
        assert!(!rounds(&square, &power(Some(1.0)), &[(0.1, 0.2)]));
        let sine = Term::new(0, 1, vec![Factor::new(Shape::Exp, 0)]);
        assert!(!rounds(&square, &sine, &of(1.8, 2.1)));
    }
}

//! Order among laws: which are the same form, and which hold others as special cases (nested models; Burnham and Anderson 2002, section 2.2).
//! A further factor of another variable is the best of all that were tried: it has to gain more than the best of so many gains by chance
//! (Bonferroni's correction of the likelihood ratio test of Wilks 1938).

use super::price::WIDER;
use super::refit::{Law, Session};
use super::shape::{Range, Shape};
use super::space::Space;
use super::term::{Factor, Term};
use crate::statistics::{NORMAL_95, chi_squared_quantile};

/// Twice the logarithmic likelihood that one more constant has to gain to predict better (Akaike 1974).
const WORTH: f64 = 2.0;
/// How often the best of all further factors may gain so much by chance.
const BY_CHANCE: f64 = 0.05;
/// tanh(x/c) and sign(x) differ by 20 % (root mean square) over values from 0 to x where c is this share of x: √(c (2 ln 2 − 1)/x) = 0.2.
const ROUND: f64 = 0.1;

/// Best first.
pub(super) fn ranked(mut laws: Vec<Law>) -> Vec<Law> {
    laws.retain(|law| law.score.is_finite());
    laws.sort_by(|a, b| b.score.total_cmp(&a.score));
    laws
}

/// Each form once, the order of factors and terms aside. A rounded constant makes a form of its own.
pub(super) fn distinct(laws: Vec<Law>) -> Vec<Law> {
    let mut kept: Vec<Law> = Vec::new();
    for law in laws {
        if !kept.iter().any(|other| is_same(&other.terms, &law.terms)) {
            kept.push(law);
        }
    }
    kept
}

/// Whether these are the same form.
pub(super) fn is_same(one: &[Term], other: &[Term]) -> bool {
    type Key = Vec<(usize, Vec<(usize, Shape, Option<u64>)>)>;
    let key = |terms: &[Term]| -> Key {
        let of = |term: &Term| {
            let factor = |f: &Factor| (f.variable, f.shape, f.rounded.map(f64::to_bits));
            let mut factors: Vec<_> = term.factors.iter().map(factor).collect();
            factors.sort_unstable();
            (term.direction, factors)
        };
        let mut key: Key = terms.iter().map(of).collect();
        key.sort_unstable();
        key
    };
    key(one) == key(other)
}

/// Whether these are the same form where every exponent of both is free.
pub(super) fn is_same_open(one: &[Term], other: &[Term]) -> bool {
    is_same(&opened(one), &opened(other))
}

fn opened(terms: &[Term]) -> Vec<Term> {
    terms.iter().map(Term::opened).collect()
}

/// Whether some constants of `large`, or limits of them, make it `small`.
fn holds(space: &Space, large: &Term, small: &Term) -> bool {
    let components = |term: &Term| &space.directions[term.direction].components;
    let is = |small: &Factor, large: &Factor| {
        small.variable == large.variable
            && small.shape == large.shape
            && (large.rounded.is_none() || large.rounded == small.rounded)
    };
    let same = |found: &[Factor]| {
        let straight = || small.factors.iter().zip(found).all(|(a, b)| is(a, b));
        let turned = || small.factors.iter().zip(found.iter().rev()).all(|(a, b)| is(a, b));
        found.len() == small.factors.len() && (straight() || turned())
    };
    let mut found: Vec<Vec<Factor>> = vec![Vec::new()];
    for factor in &large.factors {
        let limits = factor.limits();
        found = found.iter().flat_map(|before| limits.iter().map(|one| multiplied(before, one.as_ref()))).collect();
    }
    let parts = components(small).iter().all(|name| components(large).contains(name));
    parts && (found.iter().any(|one| same(one)) || is_turned_bump(large, small))
}

/// Whether `large` is a bump that turns over with its variable, which about 0 is the decay of `small`: exp(-(x/c)²) sign(x).
fn is_turned_bump(large: &Term, small: &Term) -> bool {
    let [one] = small.factors.as_slice() else { return false };
    let of = |shape| large.factors.iter().any(|f| f.shape == shape && f.variable == one.variable);
    one.shape == Shape::Stribeck && of(Shape::Bump) && (of(Shape::Sign) || of(Shape::Tanh))
}

/// These factors with one more, powers of one variable as one.
fn multiplied(before: &[Factor], more: Option<&Factor>) -> Vec<Factor> {
    let mut all = before.to_vec();
    let Some(more) = more else { return all };
    match all
        .iter_mut()
        .find(|one| one.variable == more.variable && one.shape == Shape::Power && more.shape == Shape::Power)
    {
        Some(one) => one.rounded = one.rounded.zip(more.rounded).map(|(a, b)| a + b),
        None => all.push(more.clone()),
    }
    all.retain(|one| one.rounded != Some(0.0));
    all
}

/// Whether `large` holds `small` as a special case.
pub(super) fn nests(space: &Space, large: &[Term], small: &[Term]) -> bool {
    !is_same(large, small) && small.iter().all(|one| large.iter().any(|other| holds(space, other, one)))
}

/// Whether `large` explains, by this gain, too little more than a law that it holds as a special case to predict better than that one. A
/// product with rounded constants counts with them free: there is no need of a second factor where the first explains as much with any
/// constant.
pub(super) fn is_needless(space: &Space, large: &[Term], small: &[Term], more: f64) -> bool {
    more <= WORTH * further(large, small) && holds_open(space, large, small)
}

/// Whether `large` is `small` times a factor of a variable that `small` does not depend on, and explains, by this gain, no more than the
/// best of `tried` such factors does by chance.
fn is_by_chance(space: &Space, large: &[Term], small: &[Term], more: f64, tried: usize) -> bool {
    let ([product], [single]) = (large, small) else { return false };
    let depends = |factor: &Factor| single.factors.iter().any(|own| own.variable == factor.variable);
    let other = !single.factors.is_empty() && product.factors.iter().any(|factor| !depends(factor));
    let level = 1.0 - BY_CHANCE / tried.max(1) as f64;
    other && more <= chi_squared_quantile(level, further(large, small)) && holds_open(space, large, small)
}

/// How many constants `large` has more than `small`, at least one.
fn further(large: &[Term], small: &[Term]) -> f64 {
    let constants = |terms: &[Term]| terms.iter().map(Term::constants).sum::<usize>();
    constants(large).saturating_sub(constants(small)).max(1) as f64
}

/// Whether `large` holds `small` as a special case, a product also with the constants of both free.
fn holds_open(space: &Space, large: &[Term], small: &[Term]) -> bool {
    let factors = |terms: &[Term]| terms.iter().map(|term| term.factors.len()).max().unwrap_or(0);
    let product = || factors(large) > 1 && factors(small) < 2 && nests(space, &opened(large), &opened(small));
    nests(space, large, small) || product()
}

/// Whether `large` rounds a jump of `small` off, tanh(x/c) for sign(x), and its c may be so large that the forces differ where the recordings
/// went: then neither is the other one in simpler words, however little the recordings say which it is.
pub(super) fn rounds_off(large: &Law, small: &Law, ranges: &[Range]) -> bool {
    let ([round], [sharp]) = (large.terms.as_slice(), small.terms.as_slice()) else { return false };
    let (numbers, deviations) = (large.numbers(), large.deviations());
    let mut at = round.components;
    round.factors.iter().any(|factor| {
        let first = at;
        at += factor.constants();
        let jumps = |other: &Factor| other.variable == factor.variable && other.shape == Shape::Sign;
        let width = || numbers[0][first].abs() + NORMAL_95 * WIDER * deviations[first];
        let is_round = || width() > ROUND * ranges[factor.variable].greatest;
        factor.shape == Shape::Tanh && sharp.factors.iter().any(jumps) && is_round()
    })
}

/// Laws, those apart that another one makes needless.
pub(super) fn by_need(session: &Session, ranges: &[Range], laws: Vec<Law>) -> (Vec<Law>, Vec<Law>) {
    let space = session.host.space();
    let by = |law: &Law, small: &Law| {
        let more = session.gain(law) - session.gain(small);
        let needless = is_needless(space, &law.terms, &small.terms, more)
            || is_by_chance(space, &law.terms, &small.terms, more, session.factors);
        needless && !rounds_off(law, small, ranges)
    };
    let needed: Vec<bool> = laws.iter().map(|law| !laws.iter().any(|small| by(law, small))).collect();
    let (needed, needless): (Vec<_>, Vec<_>) = laws.into_iter().zip(needed).partition(|(_, needed)| *needed);
    let laws = |all: Vec<(Law, bool)>| all.into_iter().map(|(law, _)| law).collect();
    (laws(needed), laws(needless))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Direction;

    fn space() -> Space {
        let direction = |names: &[&str]| Direction { components: names.iter().map(ToString::to_string).collect() };
        Space {
            directions: vec![direction(&["x"]), direction(&["x", "y"])],
            variables: vec![],
            axes: vec![0],
            taken: vec![],
        }
    }

    fn term(direction: usize, factors: &[(Shape, usize, Option<f64>)]) -> Term {
        let factor = |&(shape, variable, rounded): &(Shape, usize, Option<f64>)| Factor { shape, variable, rounded };
        Term::new(direction, direction + 1, factors.iter().map(factor).collect())
    }

    /// `x^p` holds 1, x and x²; x does not hold 1, nor x² or `x^p`.
    #[test]
    fn an_open_exponent_holds_every_rounded_one_and_a_constant() {
        let space = space();
        let power = |rounded| [term(0, &[(Shape::Power, 0, rounded)])];
        let constant = [term(0, &[])];
        assert!(is_same_open(&power(None), &power(Some(2.0))) && !is_same_open(&power(None), &constant));
        for small in [&constant, &power(Some(1.0)), &power(Some(2.0))] {
            assert!(nests(&space, &power(None), small));
            assert!(!nests(&space, small, &power(None)));
        }
        assert!(!nests(&space, &power(Some(1.0)), &constant) && !nests(&space, &constant, &power(Some(1.0))));
        assert!(!nests(&space, &power(Some(1.0)), &power(Some(2.0))) && !nests(&space, &power(None), &power(None)));
    }

    /// exp(−z/h) → 1 for h → ∞, but tanh and sin are never constant.
    #[test]
    fn a_product_holds_what_is_left_where_a_factor_vanishes() {
        let space = space();
        let drag = (Shape::Power, 0, Some(2.0));
        let (thinning, turning) = ((Shape::Exp, 1, None), (Shape::Tanh, 1, None));
        let single = [term(0, &[drag])];
        assert!(nests(&space, &[term(0, &[thinning, drag])], &single));
        assert!(nests(&space, &[term(1, &[drag, thinning])], &single));
        assert!(!nests(&space, &[term(0, &[drag, turning])], &single));
        // ln(1 + x/c) → x and 1/(1 + x/c) → 1/x, and x ln(1 + x/c) → x² with them.
        let linear = (Shape::Power, 0, Some(1.0));
        let (log, inverse) = ((Shape::Log, 0, None), (Shape::Saturation, 0, None));
        assert!(nests(&space, &[term(0, &[log])], &[term(0, &[linear])]));
        assert!(nests(&space, &[term(0, &[inverse])], &[term(0, &[(Shape::Power, 0, Some(-1.0))])]));
        assert!(nests(&space, &[term(0, &[linear, log])], &single));
        assert!(!nests(&space, &[term(0, &[log])], &single) && !nests(&space, &[term(0, &[inverse])], &single));
        // exp(−((x − h)/w)²) sign(x) → exp(−(x/c)²) sign(x) for h → 0.
        let stribeck = [term(0, &[(Shape::Stribeck, 1, None)])];
        let bump = |variable| [term(0, &[(Shape::Sign, 1, None), (Shape::Bump, variable, None)])];
        assert!(nests(&space, &bump(1), &stribeck) && !nests(&space, &bump(0), &stribeck));
        // A second factor is needless where another exponent explains as much.
        let other = [term(0, &[(Shape::Power, 0, Some(1.0)), thinning])];
        assert!(is_needless(&space, &other, &single, 1.0) && !is_needless(&space, &other, &single, 9.0));
        assert!(!is_needless(&space, &single, &[term(0, &[])], 1.0));
        assert!(is_same(&[term(0, &[drag, thinning])], &[term(0, &[thinning, drag])]));
    }

    /// Of 50 factors the best gains 10.8 in one case of 20 (χ² of one degree of freedom at 1 − 0.05/50); of one alone 3.8.
    #[test]
    fn a_further_factor_has_to_gain_more_than_the_best_of_all_that_were_tried() {
        let space = space();
        let drag = (Shape::Power, 0, Some(2.0));
        let single = [term(0, &[drag])];
        let of = |more| [term(0, &[drag, more])];
        let thinning = of((Shape::Exp, 1, None));
        let by_chance = |large: &[Term], small: &[Term], more, tried| is_by_chance(&space, large, small, more, tried);
        assert!(by_chance(&thinning, &single, 10.7, 50) && !by_chance(&thinning, &single, 11.0, 50));
        assert!(by_chance(&thinning, &single, 3.8, 1) && !by_chance(&thinning, &single, 3.9, 1));
        // Two constants: 13.8.
        assert!(by_chance(&of((Shape::Bump, 1, None)), &single, 13.7, 50));
        assert!(!by_chance(&of((Shape::Bump, 1, None)), &single, 13.9, 50));
        // Another shape of the same variable is a form of its own, as is the first factor of all; tanh is never constant.
        assert!(!by_chance(&of((Shape::Exp, 0, None)), &single, 1.0, 50));
        assert!(!by_chance(&single, &[term(0, &[])], 1.0, 50));
        assert!(!by_chance(&of((Shape::Tanh, 1, None)), &single, 1.0, 50));
    }
}

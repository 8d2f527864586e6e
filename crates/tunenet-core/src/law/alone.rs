//! Which laws a law has to surpass before it stands alone (Burnham and Anderson 2002, sections 2.2 and 6.4): the Schwarz criterion ranks
//! laws and prefers the simpler one where both explain as much, which is no evidence against the other. Laws of as many factors are
//! therefore compared by Akaike's criterion as well.

use super::answer::Member;
use super::forms::is_same;
use super::price;
use super::refit::{Law, Session};
use super::term::Term;

/// Akaike's price of a number, in twice the logarithmic likelihood.
const NUMBER: f64 = 2.0;
/// Models within so much of the best have substantial support.
const SUBSTANTIAL: f64 = 2.0;

/// How many numbers the data chose: constants, and exponents that were rounded.
fn chosen(law: &Law) -> usize {
    let rounded = law.terms.iter().flat_map(|term| &term.factors).filter(|factor| factor.rounded.is_some()).count();
    price::constants(&law.terms) + rounded
}

/// The criterion of Akaike, in twice the logarithmic likelihood, the greater the better.
fn akaike(session: &Session, law: &Law) -> f64 {
    session.gain(law) - NUMBER * chosen(law) as f64
}

/// How many factors a law of one term has.
fn factors(law: &Law) -> Option<usize> {
    let [one] = law.terms.as_slice() else { return None };
    Some(one.factors.len())
}

/// The laws that lie within `margin` of the best by the criterion of Schwarz, `best`, or have substantial support by Akaike's with as many
/// factors and at most one number more: those between which recordings do not decide.
pub(super) fn near(session: &Session, laws: Vec<Law>, best: f64, margin: f64) -> Vec<Law> {
    let Some(lead) = laws.iter().max_by(|a, b| a.bic.total_cmp(&b.bic)) else { return laws };
    let (leads, size, most) = (lead.bic >= best - margin, factors(lead), chosen(lead) + 1);
    let least = akaike(session, lead) - SUBSTANTIAL;
    let as_simple = |law: &Law| leads && size.is_some() && factors(law) == size && chosen(law) <= most;
    let within = |law: &Law| law.bic >= best - margin || as_simple(law) && akaike(session, law) >= least;
    laws.into_iter().filter(within).collect()
}

/// The members without those that are another one with its exponents free, where these leave no other multiple of one half open: both are
/// one law, whose exponent is known to that precision.
pub(super) fn merged(members: Vec<(Law, Member)>) -> Vec<(Law, Member)> {
    let is_said = |(free, member): &(Law, Member)| {
        let ([free], [found]) = (free.terms.as_slice(), member.terms.as_slice()) else { return false };
        let intervals: Vec<(f64, f64)> = found.numbers.iter().map(|number| number.interval95).collect();
        members.iter().any(|(one, _)| one.terms.len() == 1 && rounds(&one.terms[0], free, &intervals))
    };
    let kept: Vec<bool> = members.iter().map(|one| !is_said(one)).collect();
    members.into_iter().zip(kept).filter_map(|(one, kept)| kept.then_some(one)).collect()
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
    use super::super::shape::Shape;
    use super::super::term::Factor;
    use super::*;

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

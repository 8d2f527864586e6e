//! Profile of the exponent of a power law (Bates and Watts 1988, section 6.1): in a unit in which a variable is far from 1, as a temperature in
//! K, a x^p with another p needs an a of another order of magnitude, and a fit stops on the way.

use super::forms::is_same;
use super::refit::{Law, Session};
use super::response::Response;
use super::shape::Range;
use super::term::Term;

/// A variable is far from 1 where its logarithm is this large.
const FAR: f64 = 2.0;
/// How far a step changes the exponent, how many steps there are at most, and what each has to gain.
const STEP: f64 = 0.5;
const MOST: usize = 12;
const ENOUGH: f64 = 0.05;
/// How many multiples of one half on each side of an exponent are always compared with it.
const NEIGHBOURS: i32 = 3;

/// The law with the exponent to which the information criterion rises.
pub(super) fn profiled(session: &Session, response: &Response, law: Law) -> Law {
    let mut best = law;
    for _ in 0..MOST {
        let numbers = best.numbers();
        let fit = |by: f64| {
            let moved = moved(&best.terms, &numbers, &response.ranges, by)?;
            session.on(response, &best.terms, &moved, best.fit.point.clone())
        };
        let found = [-STEP, STEP].into_iter().filter_map(fit).max_by(|a, b| a.bic.total_cmp(&b.bic));
        match found.filter(|found| found.bic > best.bic + ENOUGH) {
            Some(found) => best = found,
            None => break,
        }
    }
    best
}

/// Of laws near the best with a power of a variable that is far from 1: the law with that exponent free, with every multiple of one half
/// near the best one, and with whole numbers further off that explain as much. A linear search sees little of other exponents there.
pub(super) fn profile(session: &Session, response: &Response, laws: &[Law], margin: f64) -> Vec<Law> {
    let best = laws.iter().map(|law| law.bic).fold(f64::NEG_INFINITY, f64::max);
    let mut found: Vec<Law> = Vec::new();
    for law in laws.iter().filter(|law| law.bic >= best - margin) {
        if !session.within() {
            break;
        }
        let Some((term, numbers)) = opened(law) else { continue };
        let is_known = |all: &[Law], term: &Term| {
            all.iter().any(|one| is_same(&one.terms, std::slice::from_ref(term)) && one.bic >= best - margin)
        };
        // Whether its variable is far from 1 at all, and each form once.
        if moved(std::slice::from_ref(&term), std::slice::from_ref(&numbers), &response.ranges, 0.0).is_none()
            || is_known(&found, &term)
        {
            continue;
        }
        let Some(free) = session.on(response, &[term], &[numbers], law.fit.point.clone()) else { continue };
        let free = profiled(session, response, free);
        let (term, numbers) = (&free.terms[0], &free.numbers()[0]);
        let at = |value: f64| rounded(term, numbers, &response.ranges, value).filter(|(term, _)| !is_known(laws, term));
        let fit = |(term, numbers): (Term, Vec<f64>)| session.on(response, &[term], &[numbers], free.fit.point.clone());
        let Some((_, place)) = far_exponent(term, &response.ranges) else { continue };
        found.extend(multiples(numbers[place]).filter_map(at).filter_map(fit));
        // Whole exponents further off, as long as they explain as much.
        for up in [false, true] {
            let is_near = |law: &Law| law.bic >= free.bic - margin;
            found.extend(wholes(numbers[place], up).filter_map(at).map_while(fit).take_while(is_near));
        }
        found.push(free);
    }
    found
}

/// A law of one term with every exponent free, and its numbers; nothing where it has two.
fn opened(law: &Law) -> Option<(Term, Vec<f64>)> {
    let [term] = law.terms.as_slice() else { return None };
    let mut numbers = law.numbers()[0].clone();
    let mut at = term.components;
    for factor in &term.factors {
        if let Some(value) = factor.rounded {
            numbers.insert(at, value);
        }
        at += factor.shape.roles().len();
    }
    Some((term.opened(), numbers))
}

/// Where a term has its first open exponent of a variable far from 1: the place of the factor, and of the number.
fn far_exponent(term: &Term, ranges: &[Range]) -> Option<(usize, usize)> {
    let mut at = term.components;
    for (f, factor) in term.factors.iter().enumerate() {
        if factor.shape.is_power() && factor.rounded.is_none() && is_far(&ranges[factor.variable]) {
            return Some((f, at));
        }
        at += factor.constants();
    }
    None
}

/// A term with that exponent at a value; nothing at 0, beyond its bounds, and without one.
fn rounded(term: &Term, numbers: &[f64], ranges: &[Range], value: f64) -> Option<(Term, Vec<f64>)> {
    let (f, at) = far_exponent(term, ranges)?;
    let (low, high) = term.factors[f].shape.bounds(0, &ranges[term.factors[f].variable]);
    if value == 0.0 || !(low..=high).contains(&value) {
        return None;
    }
    let mut moved = moved(std::slice::from_ref(term), &[numbers.to_vec()], ranges, value - numbers[at])?.remove(0);
    moved.remove(at);
    let mut term = term.clone();
    term.factors[f].rounded = Some(value);
    Some((term, moved))
}

/// Multiples of one half near an exponent.
fn multiples(exponent: f64) -> impl Iterator<Item = f64> {
    let nearest = (2.0 * exponent).round();
    (-NEIGHBOURS..=NEIGHBOURS).map(move |k| 0.5 * (nearest + f64::from(k)))
}

/// Whole numbers beyond these on one side, the nearest first.
fn wholes(exponent: f64, up: bool) -> impl Iterator<Item = f64> {
    let last = 0.5 * ((2.0 * exponent).round() + f64::from(if up { NEIGHBOURS } else { -NEIGHBOURS }));
    (1..=MOST).map(move |k| if up { last.floor() + k as f64 } else { last.ceil() - k as f64 })
}

/// The middle of what was visited.
fn middle(range: &Range) -> f64 {
    if range.low > 0.0 { (range.low * range.high).sqrt() } else { 0.5 * range.greatest }
}

fn is_far(range: &Range) -> bool {
    middle(range).ln().abs() > FAR
}

/// The numbers with the first open exponent of a variable far from 1 moved, and its coefficients so that the force in the middle stays;
/// nothing without one.
fn moved(terms: &[Term], numbers: &[Vec<f64>], ranges: &[Range], by: f64) -> Option<Vec<Vec<f64>>> {
    let mut all = numbers.to_vec();
    for (term, own) in terms.iter().zip(&mut all) {
        let mut at = term.components;
        for factor in &term.factors {
            let range = &ranges[factor.variable];
            if factor.shape.is_power() && factor.rounded.is_none() && is_far(range) {
                let (low, high) = factor.shape.bounds(0, range);
                let exponent = (own[at] + by).clamp(low, high);
                let scale = middle(range).powf(own[at] - exponent);
                own[at] = exponent;
                own[..term.components].iter_mut().for_each(|coefficient| *coefficient *= scale);
                return scale.is_normal().then_some(all);
            }
            at += factor.constants();
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::shape::Shape;
    use super::super::term::Factor;
    use super::*;

    /// In the middle of 400 and 625, 500, 2e-11 x^4 is 1.25; so is 2e-11 · √500 x^3.5.
    #[test]
    fn a_moved_exponent_keeps_the_force_in_the_middle() {
        let range = |low: f64, high: f64| [Range { low, high, least: low, greatest: high }];
        let power = [Term::new(0, 1, vec![Factor::new(Shape::Power, 0)])];
        let found = moved(&power, &[vec![2e-11, 4.0]], &range(400.0, 625.0), -0.5).unwrap();
        assert!((found[0][0] * 500.0_f64.powf(3.5) - 1.25).abs() < 1e-12 && found[0][1] == 3.5, "{found:?}");
        // Near 1 nothing is moved, and a rounded exponent stays.
        assert!(moved(&power, &[vec![2.0, 4.0]], &range(0.5, 3.0), 0.5).is_none());
        let rounded = Factor { rounded: Some(2.0), ..Factor::new(Shape::Power, 0) };
        let rounded = [Term::new(0, 1, vec![rounded])];
        assert!(moved(&rounded, &[vec![2.0]], &range(400.0, 625.0), 0.5).is_none());
    }

    /// Of 3.9, whose force in the middle is 1.25: 2.5 to 5.5, each with the same.
    #[test]
    fn neighbours_are_multiples_of_one_half_with_the_force_in_the_middle() {
        let range = [Range { low: 400.0, high: 625.0, least: 400.0, greatest: 625.0 }];
        let power = Term::new(0, 1, vec![Factor::new(Shape::Power, 0)]);
        let exponents: Vec<f64> = multiples(3.9).collect();
        assert_eq!(exponents, [2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5]);
        for p in exponents {
            let (term, numbers) = rounded(&power, &[1.25 * 500.0_f64.powf(-3.9), 3.9], &range, p).unwrap();
            assert_eq!((term.factors[0].rounded, numbers.len()), (Some(p), 1));
            assert!((numbers[0] * 500.0_f64.powf(p) - 1.25).abs() < 1e-9, "{p} {numbers:?}");
        }
        let near = [Range { low: 0.5, high: 3.0, least: 0.5, greatest: 3.0 }];
        assert!(rounded(&power, &[2.0, 1.9], &near, 2.0).is_none());
        assert_eq!(wholes(3.9, false).take(2).collect::<Vec<_>>(), [2.0, 1.0]);
        assert_eq!(wholes(3.9, true).take(2).collect::<Vec<_>>(), [6.0, 7.0]);
    }
}

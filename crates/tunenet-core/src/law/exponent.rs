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

/// Laws near the best with a rounded exponent of a variable that is far from 1, with that exponent free: a linear search sees little of
/// other exponents there.
pub(super) fn opened(session: &Session, response: &Response, laws: &[Law], margin: f64) -> Vec<Law> {
    let best = laws.iter().map(|law| law.bic).fold(f64::NEG_INFINITY, f64::max);
    let near = laws.iter().filter(|law| law.bic >= best - margin);
    let one = |law: &Law| {
        let [term] = law.terms.as_slice() else { return None };
        let (numbers, free) = (law.numbers(), term.opened());
        let mut own = numbers[0].clone();
        let mut at = term.components;
        for factor in &term.factors {
            if let Some(value) = factor.rounded {
                own.insert(at, value);
            }
            at += factor.shape.roles().len();
        }
        // Whether its variable is far from 1 at all.
        moved(std::slice::from_ref(&free), std::slice::from_ref(&own), &response.ranges, 0.0)?;
        let known =
            laws.iter().any(|other| is_same(&other.terms, std::slice::from_ref(&free)) && other.bic >= best - margin);
        let fitted = (!known && free != *term).then(|| session.on(response, &[free], &[own], law.fit.point.clone()));
        fitted.flatten().map(|law| profiled(session, response, law))
    };
    near.filter_map(one).collect()
}

/// The numbers with the first open exponent of a variable far from 1 moved, and its coefficients so that the force in the middle stays;
/// nothing without one.
fn moved(terms: &[Term], numbers: &[Vec<f64>], ranges: &[Range], by: f64) -> Option<Vec<Vec<f64>>> {
    let mut all = numbers.to_vec();
    for (term, own) in terms.iter().zip(&mut all) {
        let mut at = term.components;
        for factor in &term.factors {
            let range = &ranges[factor.variable];
            let middle = if range.low > 0.0 { (range.low * range.high).sqrt() } else { 0.5 * range.greatest };
            if factor.shape.is_power() && factor.rounded.is_none() && middle.ln().abs() > FAR {
                let (low, high) = factor.shape.bounds(0, range);
                let exponent = (own[at] + by).clamp(low, high);
                let scale = middle.powf(own[at] - exponent);
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
}

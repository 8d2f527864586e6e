//! Backward elimination (Draper and Smith 1998, section 15.2): limits, omitted factors and rounded exponents, kept where the price falls.

use super::around::Around;
use super::linear::Candidate;
use super::refit::{Law, Session};
use super::response::Response;
use super::shape::Shape;
use super::space::Space;
use super::term::{Factor, Term};

/// Most simplifications of one law.
const MOST: usize = 5;
/// Steps of the fit after one.
const STEPS: usize = 6;
/// A scale beyond so many times the greatest value has no effect of its own.
const BEYOND: f64 = 3.0;
/// Beyond so many times the greatest value a saturation may be a straight line: a bend is fitted to noise and to what another factor misses.
const STRAIGHT: f64 = 0.5;
/// An exponent below this is none.
const NO_EXPONENT: f64 = 0.12;

/// The simplest form of `law` whose score is not lower.
pub(super) fn simplify(session: &Session, around: &Around, law: Law) -> Law {
    let mut best = law;
    for _ in 0..MOST {
        let tried = simpler(session.host.space(), &around.response, &best);
        let start = &best.fit.point;
        let fits = tried.iter().filter_map(|c| session.from(around, &c.terms, &c.numbers, start.clone(), (STEPS, 1)));
        let Some(found) = fits.max_by(|a, b| a.score.total_cmp(&b.score)).filter(|f| f.score > best.score) else {
            break;
        };
        best = found;
    }
    best
}

/// What may stand in the place of a factor.
enum Instead {
    Nothing,
    Other(Factor, Vec<f64>),
}

/// Simpler forms near a law.
fn simpler(space: &Space, response: &Response, law: &Law) -> Vec<Candidate> {
    let (numbers, mut deviations) = (law.numbers(), law.deviations());
    let mut found = Vec::new();
    let whole = |terms: Vec<Term>, numbers: Vec<Vec<f64>>| Candidate { terms, numbers, score: 0.0 };
    for (t, term) in law.terms.iter().enumerate() {
        let own: Vec<f64> = deviations.drain(..term.constants()).collect();
        if law.terms.len() > 1 {
            let (mut terms, mut rest) = (law.terms.clone(), numbers.clone());
            terms.remove(t);
            rest.remove(t);
            found.push(whole(terms, rest));
        }
        let mut at = term.components;
        for (f, factor) in term.factors.iter().enumerate() {
            let end = at + factor.constants();
            let (values, sd) = (&numbers[t][at..end], &own[at..end]);
            for instead in instead_of(space, response, factor, values, sd) {
                let (mut terms, mut all) = (law.terms.clone(), numbers.clone());
                match instead {
                    Instead::Nothing => {
                        terms[t].factors.remove(f);
                        all[t].drain(at..end);
                        // What the factor was in the middle of the data, the coefficients take over.
                        let mut seen = response.factor(factor, values);
                        seen.sort_by(f64::total_cmp);
                        let middle = seen[seen.len() / 2];
                        all[t][..term.components].iter_mut().for_each(|c| *c *= middle);
                    }
                    Instead::Other(other, constants) => {
                        let scale = match (factor.shape, other.shape) {
                            (Shape::Tanh | Shape::Log, Shape::Power | Shape::OddPower) => 1.0 / values[0],
                            _ => 1.0,
                        };
                        all[t][..term.components].iter_mut().for_each(|c| *c *= scale);
                        terms[t].factors[f] = other;
                        all[t].splice(at..end, constants);
                    }
                }
                found.push(whole(terms, all));
            }
            at = end;
        }
        found.extend(merged(law, t, &numbers).map(|(terms, numbers)| whole(terms, numbers)));
    }
    found
}

/// What may stand in the place of a factor with these constants, known to these standard deviations.
fn instead_of(space: &Space, response: &Response, factor: &Factor, values: &[f64], sd: &[f64]) -> Vec<Instead> {
    let range = &response.ranges[factor.variable];
    let mut found = vec![Instead::Nothing];
    let linear = if range.least > 0.0 { Shape::Power } else { Shape::OddPower };
    let first_power = Factor { shape: linear, variable: factor.variable, rounded: Some(1.0) };
    match factor.shape {
        Shape::Tanh | Shape::Log if values[0] > STRAIGHT * range.greatest => {
            found.push(Instead::Other(first_power, Vec::new()));
        }
        // Where motion does not stop at 0, nothing jumps there.
        Shape::Tanh if space.variables[factor.variable].nature.may_jump() && values[0] < 0.06 * range.greatest => {
            let shape = Shape::Sign;
            found.push(Instead::Other(Factor { shape, variable: factor.variable, rounded: None }, Vec::new()));
        }
        Shape::Stribeck if values[0] > BEYOND * range.greatest => {
            let shape = Shape::Sign;
            found.push(Instead::Other(Factor { shape, variable: factor.variable, rounded: None }, Vec::new()));
        }
        Shape::Power | Shape::OddPower if factor.rounded.is_none() && values[0].abs() >= NO_EXPONENT => {
            found.extend(rounded(factor, values[0], sd[0], 0.5));
        }
        Shape::Sin | Shape::Cos if factor.rounded.is_none() && space.variables[factor.variable].unit == "rad" => {
            found.extend(rounded(factor, values[0], sd[0], 1.0));
        }
        _ => {}
    }
    found
}

/// The factor with its constant at the only multiple of `unit` that its 95 % interval holds.
fn rounded(factor: &Factor, value: f64, sd: f64, unit: f64) -> Option<Instead> {
    let half = 1.96 * sd;
    let (low, high) = (((value - half) / unit).ceil(), ((value + half) / unit).floor());
    let only = low == high && low != 0.0;
    only.then(|| Instead::Other(Factor { rounded: Some(low * unit), ..factor.clone() }, Vec::new()))
}

/// Two factors of one variable as one: powers, and a sign with a bump about 0.
pub(super) fn merged(law: &Law, t: usize, numbers: &[Vec<f64>]) -> Option<(Vec<Term>, Vec<Vec<f64>>)> {
    let term = &law.terms[t];
    let [a, b] = term.factors.as_slice() else { return None };
    if a.variable != b.variable {
        return None;
    }
    let inner = term.inner(&numbers[t]);
    let (of_a, of_b) = (inner[0], inner[1]);
    let exponent = |f: &Factor, own: &[f64]| f.rounded.unwrap_or_else(|| own[0]);
    let (shape, constant) = match (a.shape, b.shape) {
        (Shape::Power, Shape::Power) => (Shape::Power, exponent(a, of_a) + exponent(b, of_b)),
        (Shape::Sign | Shape::Tanh, Shape::Bump) => (Shape::Stribeck, of_b[1]),
        (Shape::Bump, Shape::Sign | Shape::Tanh) => (Shape::Stribeck, of_a[1]),
        _ => return None,
    };
    let (mut terms, mut all) = (law.terms.clone(), numbers.to_vec());
    terms[t].factors = vec![Factor::new(shape, a.variable)];
    all[t].truncate(term.components);
    all[t].push(constant);
    Some((terms, all))
}

//! A law with its intervals (Wald 1943, wider for the choice of the form) and the range in which it was seen.

use super::answer::{FoundTerm, Member, Number, Rounded};
use super::course::courses;
use super::gates::Gates;
use super::price::{self, WIDER};
use super::refit::{Law, Session};
use super::response::{Response, ranges};
use super::shape::Shape;
use super::space::{Nature, Visit};
use super::term::Term;
use crate::Result;
use crate::simulator::{Prepared, predict};
use crate::statistics::NORMAL_95;

/// How far beyond the range in which a law was seen its rollouts have to stay finite.
const BEYOND: f64 = 1.5;
/// A value beyond so many times the greatest that was measured is no longer bounded.
const GREATEST: f64 = 1e4;

/// The law as a member of an answer whose best gain is `best`.
pub(super) fn member(session: &Session, response: &Response, law: &Law, gates: Gates, best: f64) -> Result<Member> {
    let space = session.host.space();
    let (numbers, deviations) = (law.numbers(), law.deviations());
    let mut at = 0;
    let mut terms = Vec::new();
    for (i, (term, values)) in law.terms.iter().zip(&numbers).enumerate() {
        let sd = &deviations[at..at + values.len()];
        at += values.len();
        let most = values[..term.components].iter().fold(0.0_f64, |most, c| most.max(c.abs()));
        let carried = term.carried(session.host, &response.ranges, i, 10.0 * if most > 0.0 { most } else { 1e-9 });
        let units = carried.effect.coefficients.iter().map(|c| c.unit.to_string());
        let each = term.keys(space).into_iter().zip(units).zip(values.iter().zip(sd));
        let found = each.map(|(((key, role), unit), (value, sd))| {
            let half = NORMAL_95 * WIDER * sd;
            Number { key, value: *value, unit, interval95: (value - half, value + half), role }
        });
        let numbers: Vec<Number> = found.collect();
        let rounded = term.factors.iter().map(|f| open(session, response, law, i, f.rounded)).collect();
        terms.push(FoundTerm {
            formula: term.formula(space),
            components: space.directions[term.direction].components.clone(),
            numbers,
            rounded,
            variables: term.factors.iter().map(|f| (f.variable, space.variables[f.variable].name.clone())).collect(),
            carried,
            term: term.clone(),
        });
    }
    let simulator = session.carrying(response, &law.terms, &numbers)?;
    let (point, mut visits) = (&law.fit.point, Vec::new());
    for (recording, nuisances) in session.recordings.iter().zip(&point.nuisances) {
        let clock = recording.seen.clock();
        visits.push(simulator.visits(recording, &point.parameters, nuisances, clock)?);
        session.log.add(1);
    }
    let visited: Vec<&[Visit]> = visits.iter().map(Vec::as_slice).collect();
    let seen = ranges(&visited, space.variables.len());
    let used = |v: &usize| law.terms.iter().any(|t| t.factors.iter().any(|f| f.variable == *v));
    let valid = (0..space.variables.len()).filter(used);
    let clocks = || session.recordings.iter().map(|recording| recording.seen.clock());
    let range = |v: usize| match space.variables[v].nature {
        // Every recording visits its clock from the first to the last sample.
        Nature::Clock => {
            let first = clocks().map(|clock| clock[0]).fold(f64::INFINITY, f64::min);
            (first, clocks().map(|clock| clock[clock.len() - 1]).fold(f64::NEG_INFINITY, f64::max))
        }
        _ => (seen[v].low, seen[v].high),
    };
    let valid = valid.map(|v| (space.variables[v].name.clone(), range(v))).collect();
    let bits = price::bits(space, session.factors, &law.terms);
    let own = session.free.iter().enumerate().map(|(i, &index)| {
        let half = NORMAL_95 * WIDER * law.fit.covariance[(i, i)].max(0.0).sqrt();
        (index, half)
    });
    let halves: Vec<(usize, f64)> = own.collect();
    let parameter = |(i, value): (usize, &f64)| {
        let half = halves.iter().find(|(index, _)| *index == i).map_or(0.0, |(_, half)| *half);
        (*value, (value - half, value + half))
    };
    Ok(Member {
        alias: alias(session, &terms),
        terms,
        bic_gain: law.bic,
        score: law.score,
        behind_best: best - law.bic,
        bits,
        gates,
        valid,
        depends_on_time: law.terms.iter().any(Term::depends_on_time),
        bounded: bounded(session, law, &*simulator),
        gap: (session.gap(&session.base.residuals), session.gap(&law.fit.residuals)),
        courses: courses(session, response, law),
        parameters: point.parameters[..law.first].iter().enumerate().map(parameter).collect(),
    })
}

/// What a rounded exponent was before, with its interval.
fn open(session: &Session, response: &Response, law: &Law, t: usize, rounded: Option<f64>) -> Option<Rounded> {
    let value = rounded?;
    let (mut terms, mut numbers) = (law.terms.clone(), law.numbers());
    let mut at = terms[t].components;
    for factor in &mut terms[t].factors {
        if factor.rounded == Some(value) {
            factor.rounded = None;
            numbers[t].insert(at, value);
            break;
        }
        at += factor.constants();
    }
    let before: usize = terms[..t].iter().map(Term::constants).sum();
    let fitted = session.on(response, &terms, &numbers, law.fit.point.clone());
    let interval95 = fitted.map_or((value, value), |fitted| {
        let (found, half) = (fitted.numbers()[t][at], NORMAL_95 * WIDER * fitted.deviations()[before + at]);
        (found - half, found + half)
    });
    Some(Rounded { value, interval95 })
}

/// The effect of the catalogue that a law of one term is, within the interval of its exponent.
fn alias(session: &Session, terms: &[FoundTerm]) -> Option<&'static str> {
    let [one] = terms else { return None };
    let powers = one.term.factors.iter().all(|f| matches!(f.shape, Shape::Power | Shape::OddPower));
    match one.term.factors.as_slice() {
        [] => session.host.alias(&one.term, None),
        [factor] if powers => {
            let interval = match (factor.rounded, one.rounded[0]) {
                (Some(value), _) => (value, value),
                (None, _) => one.numbers[one.term.components].interval95,
            };
            // An interval that holds several multiples of one half leaves open which of them it is.
            let (first, last) = ((2.0 * interval.0).ceil(), (2.0 * interval.1).floor());
            (first == last).then(|| session.host.alias(&one.term, Some(0.5 * first))).flatten()
        }
        _ => None,
    }
}

/// Whether rollouts from starts that are faster by half, and longer by half, stay finite.
fn bounded(session: &Session, law: &Law, simulator: &dyn super::space::Visiting) -> bool {
    session.recordings.iter().zip(&law.fit.point.nuisances).all(|(recording, own)| {
        let faster: Vec<f64> = recording
            .nuisances
            .iter()
            .zip(own)
            .map(|(p, value)| if p.unit.ends_with("/s") { BEYOND * value } else { *value })
            .collect();
        let longest = longer(recording);
        let reach = recording.seen.values().iter().fold(0.0_f64, |most, v| most.max(v.abs())).max(1e-6);
        let finite = |nuisances: &[f64], clock: &[f64]| {
            session.log.add(1);
            let values = predict(simulator, recording, &law.fit.point.parameters, nuisances, clock);
            values.is_ok_and(|values| values.iter().all(|v| v.abs() < GREATEST * reach))
        };
        finite(&faster, recording.seen.clock()) && finite(own, &longest)
    })
}

/// The clock of a recording, longer by half where no input ends with it.
fn longer(recording: &Prepared) -> Vec<f64> {
    let clock = recording.seen.clock();
    let driven = recording.circumstances.as_ref().is_some_and(|known| !known.inputs.is_empty());
    let (first, last) = (clock[0], clock[clock.len() - 1]);
    let more = if driven { 0 } else { clock.len() / 2 };
    let step = (last - first) / (clock.len() - 1) as f64;
    clock.iter().copied().chain((1..=more).map(|i| last + step * i as f64)).collect()
}

//! The first stage of a search (forward selection, Miller 2002): forms that are best in the linearised response, fitted through rollouts.

use rayon::prelude::*;

use super::around::Around;
use super::forms::{distinct, ranked};
use super::linear::{self, Candidate, Search};
use super::refit::{Law, Session};

/// How many forms are fitted through rollouts: of one factor, of two, and how many of these are fitted further.
const SINGLES: usize = 25;
const PRODUCTS: usize = 10;
const FURTHER: usize = 5;
/// Forms that gain less than this share of what the best gains in the linearised response are not fitted.
const LEAST_SHARE: f64 = 0.5;

/// Steps of the first fits; of those that are fitted further, with measured derivatives.
const FIRST: (usize, usize) = (4, 1);
const FIRST_OF_OTHERS: (usize, usize) = (4, 0);
/// How many of the best get measured derivatives already there.
const BEST: usize = 12;
const FURTHER_STEPS: (usize, usize) = (10, 4);

/// Single forms of the search about the base model, and laws that begin with these and their products, best first.
pub(super) fn begun(session: &mut Session, base: &Around) -> (Vec<Candidate>, Vec<Law>) {
    let search = Search::new(session.host.space(), &base.response);
    session.factors = search.kinds;
    let session = &*session;
    let singles = search.singles();
    let products = search.products(&singles);
    let best = singles.iter().chain(&products).map(|one| one.score).fold(0.0, f64::max);
    let promises = |one: &&Candidate| one.score >= LEAST_SHARE * best;
    let begun = singles.iter().take(SINGLES).chain(products.iter().take(PRODUCTS));
    let begun = linear::ranked(begun.filter(promises).cloned().collect());
    let (best, others) = begun.split_at(BEST.min(begun.len()));
    let mut laws = session.fits(base, best, FIRST);
    laws.extend(session.fits(base, others, FIRST_OF_OTHERS));
    let mut laws = ranked(laws);
    let further = |law: &Law| {
        let (numbers, start) = (law.numbers(), law.fit.point.clone());
        let found = session.fitted(&base.response, (&law.terms, &numbers), start, None, FURTHER_STEPS);
        found.unwrap_or_else(|| law.clone())
    };
    let few = if session.within() { FURTHER } else { 0 };
    let better: Vec<Law> = laws.par_iter().take(few).map(further).collect();
    laws.splice(..better.len(), better);
    (singles, distinct(ranked(laws)))
}

//! The first stage of a search (forward selection, Miller 2002): forms that are best in the linearised response, fitted through rollouts.

use rayon::prelude::*;

use super::around::Around;
use super::forms::{distinct, ranked};
use super::linear::{Candidate, Search};
use super::refit::{Law, Session};

/// How many forms are fitted through rollouts.
#[derive(Clone, Copy)]
pub(super) struct Breadth {
    /// Of one factor.
    pub singles: usize,
    /// Of two factors.
    pub products: usize,
    /// How many of these are fitted further.
    pub further: usize,
}

/// About the base model of the whole recordings.
pub(super) const WHOLE: Breadth = Breadth { singles: 25, products: 10, further: 5 };

/// Steps of the first fits; of those that are fitted further, with measured derivatives.
const FIRST_STEPS: usize = 4;
const FURTHER_STEPS: (usize, usize) = (10, 4);

/// Single forms of the search about the base model, and laws that begin with these and their products, best first.
pub(super) fn begun(session: &mut Session, base: &Around, breadth: Breadth) -> (Vec<Candidate>, Vec<Law>) {
    let search = Search::new(session.host.space(), &base.response);
    session.factors = search.kinds;
    let session = &*session;
    let singles = search.singles();
    let products = if breadth.products > 0 { search.products(&singles) } else { Vec::new() };
    let begun = singles.iter().take(breadth.singles).chain(products.iter().take(breadth.products));
    let begun: Vec<Candidate> = begun.cloned().collect();
    let mut laws = ranked(session.fits(base, &begun, FIRST_STEPS));
    let further = |law: &Law| {
        let (numbers, start) = (law.numbers(), law.fit.point.clone());
        let found = session.fitted(&base.response, (&law.terms, &numbers), start, None, FURTHER_STEPS);
        found.unwrap_or_else(|| law.clone())
    };
    let few = if session.within() { breadth.further } else { 0 };
    let better: Vec<Law> = laws.par_iter().take(few).map(further).collect();
    laws.splice(..better.len(), better);
    (singles, distinct(ranked(laws)))
}

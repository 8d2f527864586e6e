//! From a linear search to laws that were fitted through rollouts (stepwise, as in Miller 2002), with every form near the best as its rival.

use rayon::prelude::*;

use super::around::Around;
use super::begin::begun;
use super::forms::{distinct, is_same, ranked};
use super::linear::{Candidate, Search};
use super::refit::{Law, Session};
use super::second;
use super::simplify::simplify;
use super::smoothed::smoothed;
use super::term::Term;

/// How many laws are simplified.
const SIMPLIFIED: usize = 6;
/// Steps and measured derivatives of rivals.
const RIVAL_EFFORT: (usize, usize) = (6, 1);
/// How often the best law is fitted on, and which gain ends that.
const SETTLED: usize = 4;
const ENOUGH: f64 = 0.1;
/// How often the response is measured anew about the best law.
const ROUNDS: usize = 3;

/// These terms with free exponents: about a rounded one recordings answer as about the free one.
fn opened(terms: &[Term]) -> Vec<Term> {
    terms.iter().map(Term::opened).collect()
}

/// A law fitted until it gains no more: about another place the response says little of its rivals.
fn settled(session: &Session, around: &Around, law: &Law) -> Law {
    let mut best = law.clone();
    for _ in 0..SETTLED {
        let Some(found) = session.finish(&around.response, &best).filter(|found| found.bic > best.bic) else { break };
        let gained = found.bic - best.bic;
        best = found;
        if gained < ENOUGH {
            break;
        }
    }
    best
}

/// Laws that were fitted and simplified, by their score, best first; and the response about the best of them.
pub(super) fn explore(session: &mut Session, base: Around, margin: f64) -> (Vec<Law>, Around) {
    let (singles, mut laws) = begun(session, &base);
    let before = session.log.count();
    laws.extend(smoothed(session, &base, laws.first()));
    // What this takes is not taken from the search about the whole, which goes on as it would have without it.
    session.allowed += session.log.count() - before;
    let session = &*session;
    laws = distinct(ranked(laws));
    let mut around = base;
    let mut about: Option<Law> = None;
    for _ in 0..ROUNDS {
        let Some(best) = laws.first().filter(|best| best.terms.len() == 1 && session.within()) else { break };
        if about.as_ref().is_some_and(|law| is_same(&opened(&law.terms), &opened(&best.terms))) {
            break;
        }
        let best = settled(session, &around, best);
        laws[0] = best.clone();
        // Where no acceleration can be added to a law, the response about the last one has to do.
        if let Ok(there) = Around::law(session, &around, &best) {
            around = there;
        }
        let search = Search::fine(session.host.space(), &around.response);
        let mut rivals = search.rivals(&best.terms[0], &best.numbers()[0], margin);
        let known = |c: &Candidate, all: &[Candidate]| all.iter().any(|other| is_same(&other.terms, &c.terms));
        let kin = search.kin(&best.terms[0], &best.numbers()[0]);
        // Of powers without a constant inside one fit suffices.
        let fitted = |c: &Candidate| c.terms[0].is_closed() && laws.iter().any(|law| is_same(&law.terms, &c.terms));
        let kin: Vec<Candidate> = kin.into_iter().filter(|c| !known(c, &rivals) && !fitted(c)).collect();
        rivals.extend(kin);
        about = Some(best);
        laws.extend(session.fits(&around, &rivals, RIVAL_EFFORT));
        laws = distinct(ranked(laws));
    }
    let few = if session.within() { SIMPLIFIED } else { 0 };
    let simpler: Vec<Law> = laws.par_iter().take(few).map(|law| simplify(session, &around, law.clone())).collect();
    laws.extend(simpler);
    laws = distinct(ranked(laws));
    if session.within() && !laws.is_empty() {
        laws.extend(second::second(session, &around, &singles, &laws[0]));
        laws = distinct(ranked(laws));
    }
    (laws, around)
}

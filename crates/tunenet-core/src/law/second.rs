//! A second term where the first leaves a force: forms on what it leaves, and pairs of single forms.

use super::around::{Around, DIFFERENCE};
use super::evidence::{Shared, residual_force};
use super::gates::LIKELY_FORCE_NATS;
use super::information::scaled;
use super::linear::{Candidate, Search};
use super::refit::{Law, Session};
use super::simplify::simplify;

/// How many forms are fitted in addition to the first term, how many pairs, and of how many single forms these are.
const MORE: usize = 5;
const PAIRS: usize = 6;
const PAIRED: usize = 24;
const STEPS: usize = 6;
/// What a second term has to gain.
const LEAST_GAIN: f64 = 6.0;

/// Laws of two terms that gain enough over `first`.
pub(super) fn second(session: &Session, around: &Around, singles: &[Candidate], first: &Law) -> Vec<Law> {
    let response = &around.response;
    let Ok(linear) = session.linearise(response, first) else { return Vec::new() };
    let force = residual_force(
        response,
        &scaled(&session.cleaned(&first.fit.residuals), session.scale(first)),
        linear.columns(),
        Shared::Free,
    );
    if force <= LIKELY_FORCE_NATS || first.terms.len() > 1 {
        return Vec::new();
    }
    let mut search = Search::new(session.host.space(), response);
    let (term, numbers) = (&first.terms[0], &first.numbers()[0]);
    search.known = search.columns(term, numbers);
    for i in term.components..numbers.len() {
        let mut moved = numbers.clone();
        moved[i] += DIFFERENCE * moved[i].abs().max(1e-3);
        // The difference of two columns that lie close together spans with them what the constant changes.
        search.known.extend(search.columns(term, &moved));
    }
    let more = search.singles().into_iter().take(MORE).map(|c| Candidate {
        terms: vec![term.clone(), c.terms[0].clone()],
        numbers: vec![numbers.clone(), c.numbers[0].clone()],
        score: c.score,
    });
    let more: Vec<Candidate> = more.collect();
    let alone = Search::new(session.host.space(), response);
    let pairs = alone.pairs(&singles[..singles.len().min(PAIRED)]);
    let begun: Vec<Candidate> = more.into_iter().chain(pairs.into_iter().take(PAIRS)).collect();
    let mut found = session.fits(around, &begun, (STEPS, 1));
    found.sort_by(|a, b| b.score.total_cmp(&a.score));
    let best = found.into_iter().take(2).map(|law| simplify(session, around, law));
    best.filter(|law| law.score > first.score + LEAST_GAIN).collect()
}

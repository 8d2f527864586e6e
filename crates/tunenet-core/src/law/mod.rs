//! Symbolic regression of a missing force (Schmidt and Lipson 2009) over a table of shapes: what formula explains the recordings where
//! no known effect does.
//!
//! ```text
//! tune → linearised response → one factor, products → fits through rollouts → simplification → a second term → tests → answer
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `space` | what a simulator offers: directions, variables, further terms |
//! | `shape`, `term` | the table of shapes, evaluated natively, and their products |
//! | `response` | how recordings answer to an acceleration, by rollouts |
//! | `linear` | exhaustive search in that response |
//! | `price` | information criterion and bits |
//! | `refit` | fits through rollouts |
//! | `simplify` | limits, omitted factors, rounded exponents |
//! | `second` | a second term |
//! | `evidence`, `judge` | tests |
//! | `found` | a law with its intervals and the range in which it was seen |
//! | `answer` | what a search ends with |

mod answer;
mod evidence;
mod found;
mod judge;
mod linear;
mod price;
mod refit;
mod response;
mod second;
mod shape;
mod simplify;
mod space;
mod term;

#[cfg(test)]
mod tests;

pub use answer::{Answer, FoundTerm, Gates, Member, Number, Reason, Refused, Rounded, Verdict};
pub use shape::{Range, Role, Shape};
pub use space::{Carried, Direction, Host, Nature, Space, Variable, Visit, Visiting};
pub use term::{Factor, Term};

use rayon::prelude::*;

use crate::Result;
use crate::estimate::RolloutLog;
use crate::estimate::floor;
use crate::simulator::Prepared;
use answer::MOST_FORCE;
use evidence::residual_force;
use judge::{HeldOut, judge};
use linear::Search;
use refit::{Law, Session};
use response::{Fitted, Response};
use simplify::simplify;

/// How many forms are fitted through rollouts: of one factor, products; how many of these are fitted further and simplified.
const SINGLES: usize = 25;
const PRODUCTS: usize = 10;
const FURTHER: usize = 12;
const SIMPLIFIED: usize = 6;
/// Twice the logarithmic likelihood that a simplification may lose before the form that it came from stays among the laws.
const LOST: f64 = 4.0;
/// Steps of the first fits and of the further ones.
const FIRST_STEPS: usize = 4;
const FURTHER_STEPS: usize = 12;
/// Rollouts that are allowed for each recording, and the share of them that the search may use before its tests.
const ROLLOUTS: usize = 3_100;
const SEARCH_SHARE: f64 = 0.85;

/// How to search.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// How far apart two laws have to lie in the information criterion to be distinguished.
    pub margin: f64,
    /// Most rollouts; by default in proportion to the recordings.
    pub rollouts: Option<usize>,
    /// Effects of the catalogue that compete: those that a diagnosis named.
    pub rival: Vec<String>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { margin: 6.0, rollouts: None, rival: Vec::new() }
    }
}

/// Searches the law that `host` lacks, in recordings prepared by it and judged by those held out.
///
/// # Errors
/// Where the simulator refuses the recordings without any law.
pub fn search(host: &dyn Host, recordings: &[Prepared], held_out: &[Prepared], settings: &Settings) -> Result<Answer> {
    let noise = pooled(recordings, held_out);
    let (noise, held_noise) = noise.split_at(recordings.len());
    let most = settings.rollouts.unwrap_or(ROLLOUTS * recordings.len());
    let log = RolloutLog::new(Some(most), None, None);
    let mut session = Session::new(host, recordings, noise, &log)?;
    let of = Fitted { recordings, noise, fit: &session.base, columns: session.linear.columns() };
    let response = Response::measure(host, &of, &log)?;
    let base_force_nats = residual_force(&response, &session.base.residuals, session.linear.columns());
    let left = rms(&session.base.residuals);
    let none = |verdict, reason| Answer {
        verdict,
        reason,
        members: Vec::new(),
        refused: Vec::new(),
        base_force_nats,
        rival_bic_gain: None,
        held_out: held_out.len(),
        left: (left, left),
        rollouts: log.count(),
    };
    if base_force_nats <= MOST_FORCE {
        return Ok(none(Verdict::None, None));
    }
    let laws = explore(&mut session, &response, most);
    let rival: Vec<&str> = settings.rival.iter().map(String::as_str).collect();
    let rival_bic_gain = if rival.is_empty() { None } else { session.rival(&rival) };
    if laws.first().is_none_or(|best| best.score <= settings.margin) {
        let reason = if log.was_short() { Reason::Rollouts } else { Reason::Grammar };
        return Ok(Answer { rival_bic_gain, ..none(Verdict::Unknown, Some(reason)) });
    }
    let held_out = HeldOut { recordings: held_out, noise: held_noise };
    let mut answer = Answer { rival_bic_gain, ..none(Verdict::Unknown, None) };
    conclude(&session, &response, &held_out, laws, settings, &mut answer)?;
    answer.rollouts = log.count();
    Ok(answer)
}

/// Laws that were fitted and simplified, by their score, best first.
fn explore(session: &mut Session, response: &Response, most: usize) -> Vec<Law> {
    let search = Search::new(session.host.space(), response);
    session.factors = search.factors.len();
    let singles = search.singles();
    let products = search.products(&singles);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a count")]
    let allowed = (SEARCH_SHARE * most as f64) as usize;
    let within = |session: &Session| session.log.count() < allowed;
    let begun: Vec<_> = singles.iter().take(SINGLES).chain(products.iter().take(PRODUCTS)).collect();
    let fitted = begun.par_iter().filter_map(|c| session.fit(response, c, FIRST_STEPS)).collect();
    let mut laws = ranked(fitted);
    let further = |law: &Law| session.from(response, &law.terms, &law.numbers(), law.fit.point.clone(), FURTHER_STEPS);
    let better: Vec<Law> =
        laws.par_iter().take(FURTHER).map(|law| further(law).unwrap_or_else(|| law.clone())).collect();
    laws.splice(..better.len(), better);
    laws = ranked(laws);
    let simpler: Vec<Law> =
        laws.par_iter().take(SIMPLIFIED).map(|law| simplify(session, response, law.clone())).collect();
    // A simpler form may win by its price although the recordings are explained worse: then it does not stand alone.
    let loses = |(law, simple): &(&Law, &Law)| session.gain(law) - session.gain(simple) > LOST;
    let richer: Vec<Law> = laws.iter().zip(&simpler).filter(loses).map(|(law, _)| law.clone()).collect();
    laws.splice(..simpler.len(), simpler);
    laws.extend(richer);
    laws = distinct(ranked(laws));
    if let Some(best) = laws.first().filter(|best| best.terms.len() == 1 && within(session)) {
        let near = search.neighbours(&best.terms[0], &best.numbers()[0]);
        let size = price::constants(&best.terms);
        let rivals = near.par_iter().filter_map(|c| session.fit(response, c, FURTHER_STEPS));
        // One with more constants is a rival if it explains more than they do by chance.
        let rivals =
            rivals.filter(|law| price::constants(&law.terms) <= size || session.gain(law) - session.gain(best) > LOST);
        laws.extend(rivals.collect::<Vec<_>>());
        laws = distinct(ranked(laws));
    }
    if within(session) && !laws.is_empty() {
        laws.extend(second::second(session, response, &singles, &laws[0]));
        laws = distinct(ranked(laws));
    }
    laws
}

/// Judges what is within the margin of the best, and says what that leaves.
fn conclude(
    session: &Session,
    response: &Response,
    held_out: &HeldOut,
    laws: Vec<Law>,
    settings: &Settings,
    answer: &mut Answer,
) -> Result<()> {
    let best = laws[0].bic;
    let near = laws.into_iter().filter(|law| law.bic >= best - settings.margin);
    let near = near.map(|law| session.finish(response, &law).unwrap_or(law));
    let near = without_nested(session, distinct(ranked(near.collect())));
    let best = near.iter().map(|law| law.bic).fold(f64::NEG_INFINITY, f64::max);
    answer.left.1 = near.first().map_or(answer.left.0, |law| rms(&law.fit.residuals));
    for law in near.into_iter().filter(|law| law.bic >= best - settings.margin) {
        let gates = judge(session, response, held_out, &law)?;
        let member = found::member(session, response, &law, gates, best)?;
        match gates.failed() {
            None => answer.members.push(member),
            Some(gate) => {
                let gate = if member.depends_on_time { Reason::Time } else { gate };
                answer.refused.push(Refused { text: member.text(), bic_gain: law.bic, gate });
            }
        }
    }
    let rival = answer.rival_bic_gain.is_some_and(|gain| gain >= best - settings.margin);
    (answer.verdict, answer.reason) = match answer.members.as_slice() {
        [one] if rival && one.alias.is_some() => (Verdict::Named, Some(Reason::Catalogue)),
        [] if rival => (Verdict::Named, Some(Reason::Catalogue)),
        _ if rival => (Verdict::OneOf, Some(Reason::Catalogue)),
        [] => (Verdict::Unknown, answer.refused.first().map(|refused| refused.gate)),
        [one] if one.alias.is_some() => (Verdict::Named, Some(Reason::Catalogue)),
        [_] if held_out.recordings.is_empty() => (Verdict::OneOf, Some(Reason::NoHeldOut)),
        [_] => (Verdict::Law, None),
        _ => (Verdict::OneOf, Some(Reason::Several)),
    };
    Ok(())
}

fn rms(residuals: &[Vec<f64>]) -> f64 {
    let (count, sum) = residuals.iter().flatten().fold((0.0, 0.0), |(n, s), r| (n + 1.0, s + r * r));
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Best first.
fn ranked(mut laws: Vec<Law>) -> Vec<Law> {
    laws.retain(|law| law.score.is_finite());
    laws.sort_by(|a, b| b.score.total_cmp(&a.score));
    laws
}

/// Each form once, the order of factors and terms aside; a form with a rounded exponent and the same with an open one are equal.
fn distinct(laws: Vec<Law>) -> Vec<Law> {
    type Key = Vec<(usize, Vec<(usize, Shape)>)>;
    let key = |law: &Law| -> Key {
        let mut terms: Key = law
            .terms
            .iter()
            .map(|term| {
                let mut factors: Vec<_> = term.factors.iter().map(|f| (f.variable, f.shape)).collect();
                factors.sort_unstable();
                (term.direction, factors)
            })
            .collect();
        terms.sort_unstable();
        terms
    };
    let mut kept: Vec<Law> = Vec::new();
    for law in laws {
        if !kept.iter().any(|other| key(other) == key(&law)) {
            kept.push(law);
        }
    }
    kept
}

/// Laws without those that hold a better one as a special case and explain no more than chance does in addition.
fn without_nested(session: &Session, laws: Vec<Law>) -> Vec<Law> {
    let space = session.host.space();
    let components = |term: &Term| &space.directions[term.direction].components;
    let part_of = |small: &Term, large: &Term| {
        let held = |f: &Factor| large.factors.iter().any(|g| (f.variable, f.shape) == (g.variable, g.shape));
        components(small).iter().all(|name| components(large).contains(name)) && small.factors.iter().all(held)
    };
    let mut kept: Vec<Law> = Vec::new();
    for law in laws {
        let nested = |better: &Law| {
            let holds = better.terms.iter().all(|small| law.terms.iter().any(|large| part_of(small, large)));
            holds && session.gain(&law) - session.gain(better) <= LOST
        };
        if !kept.iter().any(nested) {
            kept.push(law);
        }
    }
    kept
}

/// How far the noise of one recording may lie from that of all for them to be one.
const ALIKE: f64 = 1.5;

/// The noise of every recording's channels: that of all recordings where they agree.
fn pooled(recordings: &[Prepared], held_out: &[Prepared]) -> Vec<Vec<f64>> {
    let each: Vec<Vec<f64>> = recordings.iter().chain(held_out).map(floor).collect();
    let mut made = each.clone();
    for channel in 0..each.first().map_or(0, Vec::len) {
        let squares: f64 = each.iter().map(|noise| noise[channel].powi(2)).sum();
        let mean = (squares / each.len() as f64).sqrt();
        if each.iter().all(|noise| noise[channel] < ALIKE * mean && mean < ALIKE * noise[channel]) {
            for noise in &mut made {
                noise[channel] = mean;
            }
        }
    }
    made
}

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
//! | `around`, `rivals` | the response about the best law, and every form that is near it there |
//! | `colour` | autocorrelated noise, and how many independent values it leaves |
//! | `outliers` | residuals that the tests leave out |
//! | `price` | information criterion and bits |
//! | `refit` | fits through rollouts |
//! | `begin` | the best forms of the linear search, fitted |
//! | `smoothed` | laws about paths that follow the recordings, whatever the force |
//! | `simplify` | limits, omitted factors, rounded exponents |
//! | `second` | a second term |
//! | `between` | products of a power and an exponential or a saturation near a law of one factor |
//! | `exponent` | exponents of variables far from 1 in their unit |
//! | `explore`, `forms` | the order of these steps; equal and nested forms |
//! | `evidence`, `information`, `judge`, `ahead` | tests |
//! | `gates` | what a law has to pass, and what casts a doubt on it |
//! | `alone` | which laws a law has to surpass before it stands alone |
//! | `decay` | a force with a hidden state that it has to surpass as well |
//! | `contest`, `drift` | whether something in no catalogue surpasses effects that were named |
//! | `found` | a law with its intervals and the range in which it was seen |
//! | `course` | its force along each variable, and what the recordings ask for there |
//! | `answer`, `reason` | what a search ends with, and why not with one law |

mod ahead;
mod alone;
mod answer;
mod around;
mod begin;
mod between;
mod colour;
mod contest;
mod course;
mod decay;
mod drift;
mod evidence;
mod explore;
mod exponent;
mod forms;
mod found;
mod gates;
mod information;
mod judge;
mod linear;
mod outliers;
mod price;
mod reason;
mod refit;
mod response;
mod rivals;
mod second;
mod shape;
mod simplify;
mod smoothed;
mod space;
mod term;

#[cfg(test)]
mod tests;

pub use answer::{Answer, Followed, FoundTerm, Member, Number, Refused, Rounded, Verdict};
pub use contest::{Contest, Strongest, contest, strongest};
pub use course::{Bin, Course, Sample};
pub use gates::{
    CHANCE, Failure, Gates, LEAST_PROBABILITY, LIKELY_FORCE_NATS, MOST_FORCE_NATS, MOST_HELD_OUT,
    MOST_HELD_OUT_FORCE_NATS,
};
pub use reason::Reason;
pub use shape::{Range, Role, Shape};
pub use space::{Carried, Direction, Host, Nature, Space, Variable, Visit, Visiting};
pub use term::{Factor, Term};

use std::sync::atomic::Ordering;

use crate::Result;
pub use crate::estimate::Point;
use crate::estimate::RolloutLog;
use crate::estimate::floor;
use crate::simulator::Prepared;
use crate::statistics::{evenly, root_mean_square};
use ahead::Ahead;
use around::Around;
use between::between;
use colour::Colour;
use evidence::{Shared, residual_force};
use explore::explore;
use forms::{by_need, distinct, is_same_open, ranked};
use judge::judge;
use refit::{Law, Rival, Session};

/// How far behind a law may lie whose fit is not finished.
const UNFINISHED: f64 = 1.0;
/// A law stands alone by so many recordings, held-out ones counted: of fewer, what differs between them passes for the law's constants.
const LEAST_RECORDINGS: usize = 4;
/// Most laws that are tested.
const MOST_JUDGED: usize = 16;
/// In so many recordings it is searched, and by so many of those held out judged.
const MOST_FITTED: usize = 10;
const MOST_CONFIRMING: usize = 5;
/// Rollouts that are allowed for each recording, and the share of them that the search may use before its tests.
const ROLLOUTS: usize = 3_000;
const SEARCH_SHARE: f64 = 0.85;

/// An effect of the catalogue that a diagnosis named.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// Its name.
    pub name: String,
    /// The values of its coefficients, in their order: a fit begins there.
    pub values: Vec<f64>,
}

/// How to search.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// How far apart two laws have to lie in the information criterion to be distinguished.
    pub margin: f64,
    /// Most rollouts; by default in proportion to the recordings.
    pub rollouts: Option<usize>,
    /// Effects of the catalogue that compete: those that a diagnosis named, together.
    pub rival: Vec<Named>,
    /// Whether they leave nothing but noise: then they are compared with a force that decays as well.
    pub rival_explains: bool,
    /// Where a fit of the simulation to these recordings ended, with the nuisance parameters of each.
    pub known: Option<Point>,
    /// Whether effects that are not fitted here, so that no law can be compared with them, explain the recordings as well.
    pub apart: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self { margin: 6.0, rollouts: None, rival: Vec::new(), rival_explains: false, known: None, apart: false }
    }
}

/// Searches the law that `host` lacks, in recordings prepared by it and judged by those held out. Of many, it takes ten of those to fit and five
/// of those held out, evenly distributed.
///
/// # Errors
/// Where the simulator refuses the recordings without any law.
pub fn search(host: &dyn Host, recordings: &[Prepared], held_out: &[Prepared], settings: &Settings) -> Result<Answer> {
    let searched = evenly(recordings.len(), MOST_FITTED);
    let chosen = |all: &[Prepared], positions: &[usize]| -> Vec<Prepared> {
        positions.iter().map(|&i| all[i].clone()).collect()
    };
    let known = settings.known.as_ref().filter(|point| point.nuisances.len() == recordings.len()).map(|point| Point {
        parameters: point.parameters.clone(),
        nuisances: searched.iter().map(|&i| point.nuisances[i].clone()).collect(),
    });
    let settings = Settings { known, ..settings.clone() };
    let confirming = chosen(held_out, &evenly(held_out.len(), MOST_CONFIRMING));
    let answer = search_in(host, &chosen(recordings, &searched), &confirming, &settings)?;
    Ok(Answer { searched, ..answer })
}

/// The same in all of these.
fn search_in(host: &dyn Host, recordings: &[Prepared], held_out: &[Prepared], settings: &Settings) -> Result<Answer> {
    let white = pooled(recordings, held_out);
    let (noise, held_noise) = white.split_at(recordings.len());
    let most = settings.rollouts.unwrap_or(ROLLOUTS * recordings.len());
    let log = RolloutLog::new(Some(most), None, None);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a count")]
    let allowed = (SEARCH_SHARE * most as f64) as usize;
    let known = settings.known.as_ref();
    let first = Session::new(host, recordings, (noise, Colour::WHITE, known), &log, allowed)?;
    let colour = Colour::of(recordings, &first.base.residuals);
    let (noise, held_noise) = (colour.slow_noise(recordings, noise), colour.slow_noise(held_out, held_noise));
    let mut session =
        if colour.is_white() { first } else { Session::new(host, recordings, (&noise, colour, known), &log, allowed)? };
    let base = Around::base(&session, &log)?;
    let left = session.cleaned(&session.base.residuals);
    let base_force_nats = residual_force(&base.response, &left, session.linear.columns(), Shared::Free);
    let (left, before) = (rms(&session.base.residuals, colour), session.before);
    let none = |verdict, reason| Answer {
        verdict,
        reason,
        members: Vec::new(),
        refused: Vec::new(),
        base_force_nats,
        rival_bic_gain: None,
        rival_refused: false,
        decay_bic_gain: None,
        searched: (0..recordings.len()).collect(),
        held_out: held_out.len(),
        left: (left, left),
        followed: Vec::new(),
        rollouts: log.count() + before,
    };
    if base_force_nats <= LIKELY_FORCE_NATS {
        return Ok(none(Verdict::None, None));
    }
    let (laws, around) = explore(&mut session, base, settings.margin);
    let rival = if settings.rival.is_empty() { None } else { session.rival(&settings.rival, laws.first()) };
    let rival_bic_gain = rival.as_ref().map(|rival| rival.bic);
    if laws.first().is_none_or(|best| best.score <= settings.margin) {
        let reason =
            if log.was_short() || session.short.load(Ordering::Relaxed) { Reason::Rollouts } else { Reason::Grammar };
        return Ok(Answer { rival_bic_gain, ..none(Verdict::Unknown, Some(reason)) });
    }
    let mut ahead = Ahead::new(held_out, &held_noise, colour);
    let mut answer = Answer { rival_bic_gain, ..none(Verdict::Unknown, None) };
    conclude(&session, &around, &mut ahead, (laws, rival.as_ref()), (settings, most), &mut answer);
    answer.rollouts = log.count() + session.before;
    Ok(answer)
}

/// Judges what is within the margin of the best, and says what that leaves.
fn conclude(
    session: &Session,
    around: &Around,
    ahead: &mut Ahead,
    (mut laws, known): (Vec<Law>, Option<&Rival>),
    (settings, most): (&Settings, usize),
    answer: &mut Answer,
) {
    let response = &around.response;
    laws.extend(exponent::profile(session, response, &laws, settings.margin));
    let best = laws.iter().map(|law| law.bic).fold(f64::NEG_INFINITY, f64::max);
    let found = alone::near(session, response, laws, best, settings.margin + UNFINISHED).into_iter().map(|law| {
        // Beyond the share of the search laws stand as they were fitted so far, and none alone.
        if !session.within() {
            session.short.store(true, Ordering::Relaxed);
            return law;
        }
        exponent::profiled(session, response, session.finish(response, &law).unwrap_or(law))
    });
    let found = distinct(ranked(found.collect()));
    let best = found.iter().map(|law| law.bic).fold(f64::NEG_INFINITY, f64::max);
    answer.left.1 = found.first().map_or(answer.left.0, |law| rms(&law.fit.residuals, session.colour));
    // What is compared with effects of the catalogue is measured about a law that explains as much.
    let is_near = |(law, known): &(&Law, &Rival)| law.bic >= known.most - settings.margin;
    let near_known = found.first().zip(known).filter(|both| settings.rival_explains && is_near(both));
    answer.decay_bic_gain = near_known.and_then(|(law, _)| decay::bic_gain(session, around, law));
    // An effect of the catalogue was known before the data were seen: what it explains better is no law.
    let best = answer.rival_bic_gain.map_or(best, |gain| best.max(gain));
    let near = |laws| alone::near(session, response, laws, best, settings.margin);
    let (needed, needless) = by_need(session, &response.ranges, found);
    let mut needed = near(needed);
    // A product that falls as one of these does is near it, whatever it costs.
    needed.extend(between(session, response, &needed));
    // A law stands alone only where all its rivals were fitted and tested ...
    let mut short = session.short.load(Ordering::Relaxed);
    let mut judged = 0;
    let mut second = false;
    let (mut members, mut failed): (Vec<(Law, Member)>, Vec<Vec<Term>>) = (Vec::new(), Vec::new());
    // One effect may be this law in the catalogue's words; several that add up to it are another explanation.
    let is_known = |law: &Law| settings.rival.len() == 1 && known.is_some_and(|known| known.is(law));
    for laws in [needed, near(needless)] {
        // What explains no more than a law that it holds says something only where that one fails, and then not alone.
        if !members.is_empty() {
            break;
        }
        second = judged > 0;
        for law in laws {
            if judged == MOST_JUDGED || judged > 0 && session.log.count() >= most {
                short = true;
                break;
            }
            judged += 1;
            // A law that no rollout follows next to its fitted constants is none.
            let Ok(gates) = judge(session, response, ahead, &law) else { continue };
            let Ok(member) = found::member(session, response, &law, gates, best) else { continue };
            match gates.failed() {
                None => members.push((law, member)),
                Some(gate) => {
                    answer.rival_refused |= gate == Reason::HeldOut && is_known(&law);
                    let gate = if member.depends_on_time { Reason::Time } else { gate };
                    answer.refused.push(Refused { text: member.text(), bic_gain: law.bic, gate, gates });
                    failed.push(law.terms);
                }
            }
        }
    }
    // The effect of the catalogue in the form of a law stands or falls with it.
    let judged_known = members.iter().any(|(law, _)| is_known(law));
    let members = alone::merged(alone::undecided(session, response, members, settings.margin));
    let same = members.iter().any(|(law, _)| is_known(law));
    let flexible = members.first().is_some_and(|(law, _)| alone::is_flexible(response, law));
    let bounded = members.first().is_some_and(|(law, _)| session.is_at_bound(law).unwrap_or(true));
    answer.followed = members.first().map_or_else(Vec::new, |(law, _)| followed(session, law));
    // ... and where no test refuses another one that explains the fitted recordings better: then one of them is not what it seems.
    let refused = members.first().and_then(|(law, _)| {
        let ahead = |(refused, terms): &(&Refused, &Vec<Term>)| {
            (second || refused.bic_gain > law.bic) && !is_same_open(terms, &law.terms)
        };
        answer.refused.iter().zip(&failed).find(ahead).map(|(refused, _)| refused.gate)
    });
    let lone = if let [(law, _)] = members.as_slice() { Some(law.clone()) } else { None };
    let decays = |law: &Law| decay::surpasses(session, around, law).is_some_and(|by| by >= 0.0);
    answer.members = members.into_iter().map(|(_, member)| member).collect();
    let explains = |gain: f64| gain >= best - settings.margin && (same || !judged_known);
    let rival = settings.apart || known.is_some_and(|rival| explains(rival.most));
    (answer.verdict, answer.reason) = match answer.members.as_slice() {
        // The effect of the catalogue, written as a formula.
        [one] if rival && !settings.apart && (same || one.alias.is_some()) => (Verdict::Named, Some(Reason::Catalogue)),
        [] if answer.rival_refused => (Verdict::Unknown, Some(Reason::HeldOut)),
        [] if rival => (Verdict::Named, Some(Reason::Catalogue)),
        _ if rival => (Verdict::OneOf, Some(Reason::Catalogue)),
        [] => (Verdict::Unknown, answer.refused.first().map(|refused| refused.gate)),
        [_] if refused.is_some() => (Verdict::OneOf, refused),
        [_] if short => (Verdict::OneOf, Some(Reason::Rollouts)),
        // Forms near a sum of two terms are not searched.
        [one] if one.terms.len() > 1 => (Verdict::OneOf, Some(Reason::Terms)),
        [one] if one.alias.is_some() => (Verdict::Named, Some(Reason::Catalogue)),
        [_] if flexible => (Verdict::OneOf, Some(Reason::Flexible)),
        [one] if one.is_without_size() => (Verdict::OneOf, Some(Reason::Size)),
        [one] if one.is_at_bound() => (Verdict::OneOf, Some(Reason::Bound)),
        [_] if bounded => (Verdict::OneOf, Some(Reason::ParameterBound)),
        [one] if one.gates.doubt().is_some() => (Verdict::OneOf, one.gates.doubt()),
        [_] if ahead.is_empty() => (Verdict::OneOf, Some(Reason::NoHeldOut)),
        [one] if one.gates.held_out_nats.is_none() => (Verdict::OneOf, Some(Reason::NotLinear)),
        [_] if session.recordings.len() + answer.held_out < LEAST_RECORDINGS => (Verdict::OneOf, Some(Reason::Few)),
        [_] if lone.as_ref().is_some_and(decays) => (Verdict::OneOf, Some(Reason::Decay)),
        [_] => (Verdict::Law, None),
        _ => (Verdict::OneOf, Some(Reason::Several)),
    };
}

/// How the recordings are followed without a law and with this one.
fn followed(session: &Session, law: &Law) -> Vec<Followed> {
    let one = |(d, recording): (usize, &Prepared)| {
        let nuisances = recording.nuisances.iter().zip(&law.fit.point.nuisances[d]);
        Followed {
            seen: recording.seen.clone(),
            noise: session.noise[d].clone(),
            without: session.base.residuals[d].clone(),
            with: law.fit.residuals[d].clone(),
            events: recording.events.clone(),
            nuisances: nuisances.map(|(p, value)| (p.name.clone(), *value, p.unit.clone())).collect(),
        }
    };
    session.recordings.iter().enumerate().map(one).collect()
}

/// In units of the noise, of which slow changes meet more than each value has.
fn rms(residuals: &[Vec<f64>], colour: Colour) -> f64 {
    colour.values_for_one().sqrt() * root_mean_square(residuals.iter().flatten().copied())
}

/// Whether the noise of a recording is known, or its differences show it: no channel of one that stands still changes.
#[must_use]
pub fn has_noise(recording: &Prepared) -> bool {
    let changes = |channel: usize| {
        let mut values = recording.seen.column(channel);
        let first = values.next();
        values.any(|value| Some(value) != first)
    };
    recording.noise.is_some() || (0..recording.seen.channels().len()).any(changes)
}

/// How far the noise of one recording may lie from that of all for them to be one, by this factor or by as many standard deviations.
const ALIKE: f64 = 1.5;
const DEVIATIONS: f64 = 4.0;
/// The standard deviation of the logarithm of a noise that third differences of n values show, times √n.
const SPREAD: f64 = 1.55;

/// The noise of every recording's channels: that of all recordings where they agree.
fn pooled(recordings: &[Prepared], held_out: &[Prepared]) -> Vec<Vec<f64>> {
    let each: Vec<Vec<f64>> = recordings.iter().chain(held_out).map(floor).collect();
    let mut made = each.clone();
    for channel in 0..each.first().map_or(0, Vec::len) {
        let squares: f64 = each.iter().map(|noise| noise[channel].powi(2)).sum();
        let mean = (squares / each.len() as f64).sqrt();
        let is_alike = |(noise, recording): (&Vec<f64>, &Prepared)| {
            let chance = (DEVIATIONS * SPREAD / (recording.seen.len() as f64).sqrt()).exp();
            (noise[channel] / mean).ln().abs() < ALIKE.max(chance).ln()
        };
        if each.iter().zip(recordings.iter().chain(held_out)).all(is_alike) {
            for noise in &mut made {
                noise[channel] = mean;
            }
        }
    }
    made
}

//! Continuation in the horizon (Allgower and Georg 2003, chapter 1): laws that are found in the first part of the recordings, fitted on over
//! growing parts. Where a force bends a motion far from the base model's, the response about that one says little of the whole motion, and
//! little error of its first part.

use rayon::prelude::*;

use super::around::Around;
use super::begin::{Breadth, begun};
use super::forms::ranked;
use super::refit::{Law, Session};
use crate::estimate::{RolloutLog, leading_samples};
use crate::simulator::Prepared;

/// How many standard deviations of the noise the best law leaves where the response did not lead to it.
const FAR: f64 = 1.1;
/// The first parts in which a search begins, one after the other.
const FIRST_SHARES: [f64; 2] = [0.35, 0.2];
/// How many forms are fitted there: those of one factor, which hold the force's most part.
const FEW: Breadth = Breadth { singles: 10, products: 0, further: 0 };
/// Over which parts how many of its laws are fitted on: fewer and fewer of the best (Jamieson and Talwalkar 2016).
const LATER: [(f64, usize); 4] = [(0.35, 4), (0.5, 3), (0.75, 2), (1.0, 2)];

/// The first parts of recordings, one share of each.
fn first_parts(recordings: &[Prepared], share: f64) -> Option<Vec<Prepared>> {
    let part = |one: &Prepared| {
        let seen = one.seen.slice(0..leading_samples(one.seen.len(), share)).ok()?;
        Some(Prepared { seen, ..one.clone() })
    };
    recordings.iter().map(part).collect()
}

/// Laws that begin in a first part of the recordings, where `best` leaves far more than the noise.
pub(super) fn continued(session: &Session, around: &Around, best: Option<&Law>) -> Vec<Law> {
    if best.is_some_and(|best| session.scale(best) < FAR) {
        return Vec::new();
    }
    let mut found: Vec<Law> = Vec::new();
    for share in FIRST_SHARES {
        if !session.within() || found.iter().any(|law| session.scale(law) < FAR) {
            break;
        }
        found.extend(from(session, around, share).unwrap_or_default());
    }
    found
}

/// Laws of the first `share` of the recordings, fitted on to the whole of them.
fn from(session: &Session, around: &Around, share: f64) -> Option<Vec<Law>> {
    let parts = first_parts(session.recordings, share)?;
    // A log of its own: rollouts of a part are not those of the whole.
    let own = RolloutLog::default();
    let begun = laws(session, &parts, &own);
    session.log.add(own.count());
    let mut laws = begun?;
    for (later, most) in LATER.into_iter().filter(|(later, _)| *later > share) {
        let longer = |law: &Law| session.longer(&around.response, law, later);
        laws = ranked(laws.par_iter().take(most).filter_map(longer).collect());
    }
    Some(laws)
}

/// Laws with which a search in these parts begins.
fn laws(session: &Session, parts: &[Prepared], log: &RolloutLog) -> Option<Vec<Law>> {
    let mut short = Session::new(session.host, parts, (session.noise, None), log, session.allowed).ok()?;
    let base = Around::base(&short, log).ok()?;
    Some(begun(&mut short, &base, FEW).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::{Channel, Kind, Observation};

    fn recording(samples: u32) -> Prepared {
        let clock: Vec<f64> = (0..samples).map(|k| f64::from(k) / 100.0).collect();
        let seen = Observation::new(Kind::Other, vec![Channel::new("x", "m")], clock.clone(), clock).unwrap();
        Prepared::whole(seen, 1)
    }

    /// A fifth of 100 and of 41 samples; a part is never shorter than a recording may be.
    #[test]
    fn a_first_part_holds_its_share_of_each_recording() {
        let lengths = |of: &[u32], share| -> Vec<usize> {
            let all: Vec<Prepared> = of.iter().map(|samples| recording(*samples)).collect();
            first_parts(&all, share).unwrap().iter().map(|part| part.seen.len()).collect()
        };
        assert_eq!(lengths(&[100, 41], 0.2), [20, 9]);
        assert_eq!(lengths(&[100, 41], 1.0), [100, 41]);
        assert_eq!(lengths(&[12], 0.01), [crate::observation::FEWEST_SAMPLES]);
    }
}

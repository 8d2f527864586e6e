//! Segments between events: the samples of each, away from the events themselves.

use std::ops::Range;

/// What is left out on either side of a contact, s and samples: it lasts, and a simulator may have found it late.
const GUARD_S: f64 = 0.02;
const GUARD: usize = 2;
/// A shorter flight says nothing of its bend.
const FEWEST: usize = 12;

/// The samples of each flight, before the first contact, between two, and after the last; `None` where they are too few.
pub(in crate::diagnose) fn free_segments(clock: &[f64], contacts: &[f64]) -> Vec<Option<Range<usize>>> {
    let mut pieces = Vec::with_capacity(contacts.len() + 1);
    let mut begin = 0;
    let long = |begin: usize, end: usize| (end >= begin + FEWEST).then_some(begin..end);
    for contact in contacts {
        let (first, after) = (clock.partition_point(|t| t < contact), clock.partition_point(|t| t <= contact));
        let early = clock.partition_point(|t| *t < contact - GUARD_S);
        pieces.push(long(begin, early.min(first.saturating_sub(GUARD))));
        begin = clock.partition_point(|t| *t <= contact + GUARD_S).max(after + GUARD);
    }
    pieces.push(long(begin, clock.len()));
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flights_keep_away_from_contacts() {
        let clock: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.01).collect();
        assert_eq!(free_segments(&clock, &[]), [Some(0..200)]);
        let contacts = [0.495, 1.205, 1.255, 1.935];
        let found = free_segments(&clock, &contacts);
        assert_eq!(found, [Some(0..48), Some(52..119), None, Some(128..192), None]);
        let far = |t: f64| contacts.iter().all(|c| (t - c).abs() >= GUARD_S);
        assert!(found.into_iter().flatten().flatten().all(|i| far(clock[i])));
    }
}

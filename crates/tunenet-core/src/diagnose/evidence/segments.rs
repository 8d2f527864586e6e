//! Segments between events: the samples of each, away from the events themselves.

use std::ops::Range;

use super::recording::PreparedRecording;

/// What is left out on either side of an event, s and samples: it lasts, and a simulator may have found it late.
const GUARD_S: f64 = 0.02;
const GUARD: usize = 2;
/// A shorter segment says nothing of its bend.
const FEWEST: usize = 12;

/// The samples of each segment, before the first event, between two, and after the last; `None` where they are too few.
fn free_segments(clock: &[f64], events: &[f64]) -> Vec<Option<Range<usize>>> {
    let mut pieces = Vec::with_capacity(events.len() + 1);
    let mut begin = 0;
    let long = |begin: usize, end: usize| (end >= begin + FEWEST).then_some(begin..end);
    for event in events {
        let (first, after) = (clock.partition_point(|t| t < event), clock.partition_point(|t| t <= event));
        let early = clock.partition_point(|t| *t < event - GUARD_S);
        pieces.push(long(begin, early.min(first.saturating_sub(GUARD))));
        begin = clock.partition_point(|t| *t <= event + GUARD_S).max(after + GUARD);
    }
    pieces.push(long(begin, clock.len()));
    pieces
}

impl PreparedRecording {
    /// The samples of each free segment, before the first event, between two, and after the last, away from the events
    /// themselves; `None` for one that is too short to say anything.
    #[must_use]
    pub fn free_segments(&self) -> Vec<Option<Range<usize>>> {
        free_segments(self.clock(), &self.events)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_keep_away_from_events() {
        let clock: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.01).collect();
        assert_eq!(free_segments(&clock, &[]), [Some(0..200)]);
        let events = [0.495, 1.205, 1.255, 1.935];
        let found = free_segments(&clock, &events);
        assert_eq!(found, [Some(0..48), Some(52..119), None, Some(128..192), None]);
        let far = |t: f64| events.iter().all(|c| (t - c).abs() >= GUARD_S);
        assert!(found.into_iter().flatten().flatten().all(|i| far(clock[i])));
    }
}

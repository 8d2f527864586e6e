//! Ranges in which candidates of equations were seen to hold, and where a rollout leaves them.

use super::Misfit;
use super::body::States;
use super::law::Quantity;
use crate::scene::{Candidate, EquationsScene};
use crate::valid_range::{Farthest, LeftRange};

/// A range of one candidate.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Range {
    name: String,
    quantity: Quantity,
    low: f64,
    high: f64,
}

/// The ranges of a candidate.
///
/// # Errors
/// Where one is of no state, or ends before it begins.
pub(crate) fn ranges(scene: &EquationsScene, name: &str, candidate: &Candidate) -> Result<Vec<Range>, Misfit> {
    let known = States::of(scene).quantities();
    let one = |(key, &(low, high)): (&String, &(f64, f64))| {
        let path = format!("candidates.{name}.valid.{key}");
        let Some((_, quantity)) = known.iter().find(|(other, _)| other == key) else {
            let names: Vec<String> = known.iter().map(|(name, _)| format!("`{name}`")).collect();
            return Err(Misfit::new(&path, format!("a range of {}", names.join(", ")), format!("one of `{key}`")));
        };
        if low >= high {
            return Err(Misfit::new(&path, "[low, high]", format!("[{low}, {high}]")));
        }
        Ok(Range { name: key.clone(), quantity: quantity.clone(), low, high })
    };
    candidate.valid.iter().map(one).collect()
}

/// Which of `ranges` states, row-major at these instants, leave farthest.
pub(crate) fn left(ranges: &[Range], clock_s: &[f64], states: &[f64]) -> Option<Farthest> {
    let count = states.len() / clock_s.len().max(1);
    Farthest::of(states.chunks_exact(count.max(1)).zip(clock_s).map(|(row, t)| {
        let values: Vec<f64> = row.iter().copied().chain([*t]).collect();
        let outside =
            |range: &Range| LeftRange::of(&range.name, range.quantity.value(&values), *t, (range.low, range.high));
        LeftRange::farthest(ranges.iter().filter_map(outside))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body on (3, 4) has the distance 5; the clock is the last value.
    #[test]
    fn the_range_that_is_left_farthest_is_found() {
        let range = |name: &str, quantity, low, high| Range { name: name.into(), quantity, low, high };
        let distance = range("r_m", Quantity::Length(vec![0, 1]), 0.0, 4.9);
        let clock = range("t_s", Quantity::Slot(2), 0.0, 1.5);
        let (instants, states) = ([0.0, 1.0, 2.0], [0.0, 1.0, 3.0, 4.0, 0.0, 0.0]);
        let found = left(std::slice::from_ref(&distance), &instants, &states).expect("it is left").left;
        assert_eq!((found.variable.as_str(), found.value, found.time_s, found.range), ("r_m", 5.0, 1.0, (0.0, 4.9)));
        let both = left(&[distance.clone(), clock], &instants, &states).expect("both are left");
        assert_eq!((both.left.variable.as_str(), both.left.value, both.share), ("t_s", 2.0, 2.0 / 3.0));
        assert_eq!(left(&[distance], &instants[..1], &states[..2]), None);
    }
}

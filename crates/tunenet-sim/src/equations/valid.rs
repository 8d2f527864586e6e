//! Ranges in which candidates of equations were seen to hold, and where a rollout leaves them.

use super::Misfit;
use super::body::States;
use super::law::Quantity;
use crate::scene::{Candidate, EquationsScene};
use crate::valid_range::LeftRange;

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

/// The first of `ranges` that states, row-major at these instants, leave.
pub(crate) fn left(ranges: &[Range], clock_s: &[f64], states: &[f64]) -> Option<LeftRange> {
    let count = states.len() / clock_s.len().max(1);
    states.chunks_exact(count.max(1)).zip(clock_s).find_map(|(row, t)| {
        let values: Vec<f64> = row.iter().copied().chain([*t]).collect();
        ranges.iter().find_map(|range| {
            let value = range.quantity.value(&values);
            let within = (range.low..=range.high).contains(&value);
            let left = || LeftRange { variable: range.name.clone(), value, time_s: *t, range: (range.low, range.high) };
            (!within).then(left)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body on (3, 4) has the distance 5; the clock is the last value.
    #[test]
    fn the_first_instant_outside_a_range_is_found() {
        let range = |name: &str, quantity, low, high| Range { name: name.into(), quantity, low, high };
        let distance = range("r_m", Quantity::Length(vec![0, 1]), 0.0, 4.9);
        let clock = range("t_s", Quantity::Slot(2), 0.0, 1.5);
        let (instants, states) = ([0.0, 1.0, 2.0], [0.0, 1.0, 3.0, 4.0, 0.0, 0.0]);
        let found = left(&[distance.clone(), clock.clone()], &instants, &states).expect("one is left");
        assert_eq!((found.variable.as_str(), found.value, found.time_s, found.range), ("r_m", 5.0, 1.0, (0.0, 4.9)));
        let found = left(&[clock], &instants, &states).expect("the clock is left");
        assert_eq!((found.value, found.time_s), (2.0, 2.0));
        assert_eq!(left(&[distance], &instants[..1], &states[..2]), None);
    }
}

//! Where the joints of a recording start: the median of the first samples of one that rests, the first of one that moves.

use std::sync::Arc;

use tunenet_core::observation::{Circumstances, Note, Observation, with_decimals};
use tunenet_core::simulator::Prepared;
use tunenet_core::statistics::median;

use super::layout::{Layout, Reading, goals};
use super::numbers::{Drive, JointNumbers};
use super::trajectory::Quantity;
use crate::findings;

/// First samples that are so many standard deviations of the noise apart show a motion.
const MOVES: f64 = 6.0;
/// The first samples whose median is the start.
const FIRST: usize = 3;
/// So many show whether a joint moves soon.
const SOON: usize = 10;
/// A command that moves by less than this many standard deviations of the noise has not moved, and a joint whose median moves by less
/// than so many rests.
const UNMOVED: f64 = 0.1;
const RESTING: f64 = 6.0;
/// The standard deviation of the start that is proposed, in those of the noise.
const PROPOSED: f64 = 3.0;

/// Puts the start of every joint where its first samples are; what is to be said of those that keep an error of it for good.
pub(super) fn at_median(layout: &Layout, joints: &[JointNumbers], prepared: &mut Prepared) -> Vec<Note> {
    let mut notes = Vec::new();
    let Some(known) = prepared.circumstances.as_deref() else { return notes };
    let mut known = Circumstances::clone(known);
    for (place, start) in layout.starts.iter().enumerate().filter(|(_, start)| !start.speed) {
        let shows = |one: &Reading| one.joint == start.joint && one.quantity == Quantity::Position;
        let Some(channel) = layout.readings.iter().position(shows) else { continue };
        let goal = goals(layout, joints, &known, start.joint);
        let noise = prepared.noise.as_ref().map(|noise| noise[channel]);
        let middle = position(&prepared.seen, channel, goal, noise);
        if let (Some(middle), Some(value)) = (middle, known.start.get_mut(place))
            && *value == prepared.seen.row(0)[channel]
        {
            *value = middle;
            let name = prepared.seen.channels()[channel].header();
            let estimated = prepared.nuisances.iter().any(|one| one.name.strip_prefix("start.") == Some(name.as_str()));
            let returns = joints.get(start.joint).is_none_or(|joint| joint.drive == Drive::Position);
            if let Some(noise) = noise.filter(|_| !returns && !estimated) {
                notes.extend(uncertain(&name, &prepared.seen, channel, noise));
            }
        }
    }
    prepared.circumstances = Some(Arc::new(known));
    notes
}

/// That a joint moves soon whose drive does not lead it back to where it was commanded.
fn uncertain(name: &str, seen: &Observation, channel: usize, noise: f64) -> Option<Note> {
    let first: Vec<f64> = seen.column(channel).take(SOON).collect();
    if (first.last()? - first.first()?).abs() <= MOVES * noise {
        return None;
    }
    let text = format!(
        "`{name}` moves from its first samples on, and its drive does not correct its position: an error of the start, which is that of \
         these samples, stays to the end"
    );
    let remedy = format!(
        "estimate the start: `[start.{name}]` with `value = \"first\"` and `sd = {}`",
        with_decimals(PROPOSED * noise, 4)
    );
    Some(Note::new(findings::ROBOT_START, text, remedy))
}

/// Where a joint starts. Where it rests: the median of its first samples, or of all before its command first moves, since a start that
/// is off by the noise stays off until the joint breaks loose. Where it moves at once: its first sample.
fn position(seen: &Observation, channel: usize, goal: Option<impl Fn(f64) -> f64>, noise: Option<f64>) -> Option<f64> {
    let values: Vec<f64> = seen.column(channel).take(FIRST).collect();
    // Of a joint that moves from the start, the middle of its first samples is a later place.
    let (begins, goes) = (*values.first()?, *values.last()?);
    let moves = noise.is_some_and(|noise| (goes - begins).abs() > MOVES * noise);
    let first = if moves { begins } else { median(values)? };
    let (Some(goal), Some(noise)) = (goal, noise) else { return Some(first) };
    let Some(begin) = seen.clock().first().map(|time| goal(*time)) else { return Some(first) };
    let waits = seen.clock().iter().take_while(|time| (goal(**time) - begin).abs() <= UNMOVED * noise).count();
    let resting = median(seen.column(channel).take(waits.max(FIRST)))?;
    Some(if (resting - first).abs() <= RESTING * noise { resting } else { first })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tunenet_core::observation::{Channel, Kind};

    fn seen(of: impl Fn(usize) -> f64) -> Observation {
        let clock = (0..50).map(|i| 0.01 * f64::from(i)).collect();
        let values = (0..50).map(of).collect();
        Observation::new(Kind::Other, vec![Channel::new("hinge", "rad")], clock, values).unwrap()
    }

    /// 0.301, 0.299 and 0.3 at rest for 20 samples; a joint that moves by 0.1 rad from sample to sample.
    #[test]
    fn a_joint_starts_at_the_median_where_it_rests_and_at_its_first_sample_where_it_moves() {
        let noisy =
            |i: usize| if i < 20 { 0.3 + 0.001 * [1.0, -1.0, 0.0][i % 3] } else { 0.3 + 0.01 * (i - 19) as f64 };
        let goal = |t: f64| if t < 0.195 { 0.3 } else { 0.8 };
        assert_eq!(position(&seen(noisy), 0, Some(goal), Some(0.001)), Some(0.3));
        assert_eq!(position(&seen(|i| 0.1 * i as f64), 0, Some(goal), Some(0.001)), Some(0.0));
    }

    #[test]
    fn a_start_in_motion_is_said_to_be_uncertain() {
        let note = uncertain("hinge_rad", &seen(|i| 0.01 * i as f64), 0, 0.001).unwrap();
        assert!(
            note.remedy.contains("`[start.hinge_rad]` with `value = \"first\"` and `sd = 0.003"),
            "{}",
            note.remedy
        );
        assert!(uncertain("hinge_rad", &seen(|_| 0.3), 0, 0.001).is_none());
    }
}

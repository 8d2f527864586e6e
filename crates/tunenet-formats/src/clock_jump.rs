//! A clock that jumps: one pause that is nearly all of a record.
//!
//! One false stamp, or a clock that was set while it ran, puts hours or years between two samples. Whoever simulates the record
//! would simulate the pause, and a clock that starts at 0 and goes on in 2026 leaves the samples few digits.

use tunenet_core::observation::{FEWEST_SAMPLES, Kind, Note, Observation};

use crate::Result;
use crate::findings;
use crate::recording::Recording;
use crate::shown::counted;

/// A pause that is a larger share of its record than this is a jump of the clock.
const JUMP: f64 = 0.999;

/// The recording without what lies beyond a jump of its clock: the part with more samples is kept, and the note says what is
/// excluded. Event times have no clock.
pub(crate) fn without_jumps(mut recording: Recording) -> Result<Recording> {
    if recording.observation.kind() == Kind::EventTimes {
        return Ok(recording);
    }
    while let Some(after) = jump(&recording.observation) {
        let (seen, samples) = (&recording.observation, recording.observation.len());
        let kept = if 2 * after >= samples { 0..after } else { after..samples };
        if kept.len() < FEWEST_SAMPLES {
            break;
        }
        let pause_s = seen.clock()[after] - seen.clock()[after - 1];
        let excluded = samples - kept.len();
        let text = format!(
            "the clock jumps by {pause_s} s after sample {after}: {} of {} ({:.1} %) excluded",
            counted(excluded, "sample"),
            samples,
            100.0 * excluded as f64 / samples as f64
        );
        let remedy = "correct the stamps; if both parts are recordings, give each as a file of its own";
        recording.notes.push(Note::new(findings::CLOCK_JUMP, text, remedy));
        recording.observation = seen.slice(kept)?;
    }
    Ok(recording)
}

/// The sample after a jump.
fn jump(seen: &Observation) -> Option<usize> {
    let clock = seen.clock();
    let whole_s = clock.last()? - clock.first()?;
    (1..clock.len()).find(|&i| clock[i] - clock[i - 1] > JUMP * whole_s && whole_s > 0.0)
}

#[cfg(test)]
mod tests {
    use tunenet_core::observation::Channel;

    use super::*;

    fn of(clock: &[f64]) -> Recording {
        let values = (0..clock.len()).map(|i| i as f64).collect();
        let observation = Observation::new(Kind::Other, vec![Channel::new("z", "m")], clock.to_vec(), values).unwrap();
        without_jumps(Recording { observation, notes: Vec::new() }).unwrap()
    }

    #[test]
    fn a_stray_stamp_at_either_end_is_excluded() {
        let even: Vec<f64> = (0..10).map(|i| f64::from(i) * 0.01).collect();
        let before = [&[-1e9], &even[..]].concat();
        assert_eq!(of(&before).observation.clock(), even);
        let after = of(&[&even[..], &[1e9]].concat());
        assert_eq!(after.observation.clock(), even);
        assert_eq!(
            after.notes[0].text,
            "the clock jumps by 999999999.91 s after sample 10: 1 sample of 11 (9.1 %) excluded"
        );
        let both = of(&[&[-1e12], &even[..], &[1e9, 1e9 + 0.01]].concat());
        assert_eq!((both.observation.clock(), both.notes.len()), (&even[..], 2));
    }

    #[test]
    fn the_longer_part_is_kept_where_the_clock_is_set_amid_a_record() {
        let clock: Vec<f64> = (0..20).map(|i| f64::from(i) * 0.01 + if i < 8 { 0.0 } else { 3600.0 }).collect();
        assert_eq!(of(&clock).observation.clock(), &clock[8..]);
    }

    #[test]
    fn pauses_and_short_records_stay() {
        let paused: Vec<f64> = (0..20).map(|i| f64::from(i) + if i < 8 { 0.0 } else { 3600.0 }).collect();
        assert!(of(&paused).notes.is_empty());
        assert!(of(&[0.0, 0.01, 1e6]).notes.is_empty());
    }
}

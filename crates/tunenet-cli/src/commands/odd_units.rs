//! Recordings whose channels or inputs are on another scale than in the others.

use tunenet_core::observation::{Note, Observation, OddScale, odd_scales, with_decimals};

use crate::findings::UNITS_DIFFER;

/// What is said of recordings of one thing, each with its name, that are on another scale than the others.
pub fn odd_units(recordings: &[(&str, &Observation)]) -> Vec<Note> {
    let seen: Vec<&Observation> = recordings.iter().map(|(_, seen)| *seen).collect();
    let note = |odd: OddScale| {
        let (times, which) = if odd.ratio > 1.0 { (odd.ratio, "as much as") } else { (odd.ratio.recip(), "less than") };
        let (name, times) = (recordings[odd.recording].0, with_decimals(times, 0));
        let text = format!("{name}: `{}` varies {times} times {which} in the other recordings", odd.header);
        Note::new(UNITS_DIFFER, text, "check its unit: degrees among radians, or milli-units, look like that")
    };
    odd_scales(&seen).into_iter().map(note).collect()
}

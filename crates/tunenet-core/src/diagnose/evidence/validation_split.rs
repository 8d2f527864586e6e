//! Validation split: which recordings, or which end of a driven one, are held out.

use super::recording::PreparedRecording;
use crate::Result;
use crate::observation::FEWEST_SAMPLES;
use crate::simulator::Prepared;

/// The share of a driven recording that is fitted where none is held out.
const FITTED: f64 = 2.0 / 3.0;
/// Of so many recordings of one object one may be set aside.
const ONE_OF: usize = 4;

/// Cuts the last third off a recording and returns it, held out; `None` where it is too short for that.
///
/// # Errors
/// Never where the recording is sound.
pub(in crate::diagnose) fn hold_end_out(recording: &mut PreparedRecording) -> Result<Option<PreparedRecording>> {
    let count = recording.prepared.seen.len();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
    let cut = (count as f64 * FITTED) as usize;
    if cut < FEWEST_SAMPLES || count - cut < FEWEST_SAMPLES {
        return Ok(None);
    }
    let part = |range, held_out| -> Result<PreparedRecording> {
        let prepared = Prepared { seen: recording.prepared.seen.slice(range)?, ..recording.prepared.clone() };
        Ok(PreparedRecording::new(recording.index, recording.object, held_out, prepared))
    };
    let end = part(cut..count, true)?;
    *recording = part(0..cut, false)?;
    Ok(Some(end))
}

/// Which recordings to set aside where none is given: of each object with enough of them every fourth, beginning where the
/// seed says. `objects` are the objects of the usable recordings.
pub(in crate::diagnose) fn set_aside(objects: &[usize], seed: u64) -> Vec<usize> {
    let mut chosen = Vec::new();
    let most = objects.iter().copied().max().map_or(0, |m| m + 1);
    for object in 0..most {
        let mine: Vec<usize> = (0..objects.len()).filter(|&i| objects[i] == object).collect();
        let count = mine.len() / ONE_OF;
        let offset = usize::try_from(seed % ONE_OF as u64).unwrap_or(0);
        chosen.extend((0..count).map(|k| mine[k * ONE_OF + offset]));
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::set_aside;
    use crate::diagnose::tests::zoo::in_levers;
    use crate::testing::Levers;

    #[test]
    fn of_a_driven_recording_the_last_third_is_held_out() {
        in_levers(&Levers::new().unwrap(), &[], |context| {
            let (fitted, held_out) = (context.recordings()[0].clock(), context.evidence.validation[0].clock());
            assert_eq!((fitted.len(), held_out.len()), (400, 200));
            assert!(fitted[399] < held_out[0] && !context.evidence.shows_one_motion());
        });
    }

    #[test]
    fn one_in_four_of_each_object_is_set_aside() {
        assert!(set_aside(&[0, 0, 0], 0).is_empty());
        assert_eq!(set_aside(&[0, 0, 0, 0, 1, 1], 2), [2]);
        assert_eq!(set_aside(&[0, 1, 0, 1, 0, 1, 0, 1], 1), [2, 3]);
    }
}

//! Camera motion: frames in which the background is displaced are left out and reported.

use tunenet_video_protocol::track::TrackFailure;
use tunenet_video_protocol::{VideoFinding, findings};

use crate::samples::Samples;
use crate::stillness::{LENIENT, STRICT, displaced};
use crate::track::answer::{Answer, Track};
use crate::track_findings;

/// A camera that is displaced in this share of the pictures is why no ball was found.
const EXPLAINS: f64 = 0.15;
/// Which pictures the others are held against, as shares of all: one of them shows the usual place.
const REFERENCES: [f64; 4] = [0.05, 0.35, 0.65, 0.95];
/// One that is displaced in more of them than this has no usual position.
const MOST: f64 = 0.5;

/// Leaves out of `answer` what was seen while the camera was displaced from its usual position; an answer without a track is the
/// camera's doing where that was often.
pub(crate) fn without_camera_motion(answer: Answer, samples: &Samples) -> opencv::Result<Answer> {
    let placed = samples.placed();
    let doubt = if matches!(answer, Answer::Tracked(_)) { STRICT } else { LENIENT };
    // A median of pictures of a camera that moved has no edges, so single ones are compared.
    let mut away = Vec::new();
    let mut count = usize::MAX;
    for share in REFERENCES {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a count")]
        let at = (share * placed.len() as f64) as usize;
        let Some((_, reference)) = placed.get(at) else { continue };
        let found = displaced(&placed, reference, doubt)?;
        let fewer = found.iter().filter(|a| **a).count();
        if fewer < count {
            (away, count) = (found, fewer);
        }
    }
    let count = count.min(away.len());
    let share = count as f64 / away.len().max(1) as f64;
    let reason = TrackFailure::CameraMoves;
    let camera = |frames| Answer::Untracked { reason, frames, finding: track_findings::untracked(reason, false, "") };
    Ok(match answer {
        Answer::Untracked { frames, reason, .. } if share > EXPLAINS && reason != TrackFailure::CameraMoves => {
            camera(frames)
        }
        Answer::Tracked(mut track) if count > 0 && share <= MOST => {
            let places: Vec<usize> = placed.iter().map(|(place, _)| *place).collect();
            leave_out(&mut track, &places, &away);
            if track.sightings.is_empty() { camera(track.frames) } else { Answer::Tracked(track) }
        }
        answer => answer,
    })
}

/// Leaves out the sightings between the undisplaced pictures on either side of displaced ones, and reports it.
fn leave_out(track: &mut Track, places: &[usize], away: &[bool]) {
    let frames = track.frames;
    let shaken = |frame: usize| {
        let next = places.partition_point(|place| *place < frame);
        let after = away.get(next).copied().unwrap_or(false);
        let exactly = places.get(next) == Some(&frame);
        let before = next.checked_sub(1).is_some_and(|i| away[i]);
        if exactly { after } else { before || after }
    };
    let moved_frames: Vec<usize> = (0..frames).filter(|&frame| shaken(frame)).collect();
    let (Some(first), Some(last)) = (moved_frames.first(), moved_frames.last()) else { return };
    let time = |frame: usize| frame as f64 / track.rate_hz;
    let back = *last + 1 < frames && *first > 0;
    let how = if back { "and came back" } else { "and did not come back" };
    let stays = |s: &crate::tracker::Sighting| moved_frames.binary_search(&s.frame).is_err();
    if 2 * track.sightings.iter().filter(|s| stays(s)).count() > track.sightings.len() {
        track.sightings.retain(stays);
    }
    let became = if track.sightings.iter().all(stays) {
        format!("{} frames are left out of the track", moved_frames.len())
    } else {
        "the ball is only seen there, which is used".to_owned()
    };
    let text = format!("the camera moved between {:.2} and {:.2} s {how}: {became}", time(*first), time(*last));
    track.notes.push(VideoFinding::new(
        findings::CAMERA_DISPLACED,
        text,
        "put the camera on a stand and do not touch it while it records",
    ));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::Window;
    use crate::tracker::Sighting;

    #[test]
    fn what_lies_between_still_pictures_is_left_out() {
        let seen = |frame: usize| Sighting {
            frame,
            time_s: frame as f64 / 10.0,
            u_px: 5.0,
            v_px: 5.0,
            radius_px: 3.0,
            cut: false,
            confidence: 1.0,
            second: None,
            off: None,
        };
        let mut track = Track {
            frames: 20,
            size_px: (10, 10),
            rate_hz: 10.0,
            colour: Window::parse("red").unwrap(),
            sightings: (0..20).map(seen).collect(),
            repeated: Vec::new(),
            dropped: 0,
            notes: Vec::new(),
        };
        leave_out(&mut track, &[0, 4, 8, 12, 16], &[false, false, true, false, false]);
        let left: Vec<usize> = track.sightings.iter().map(|s| s.frame).collect();
        assert_eq!(left, [0, 1, 2, 3, 4, 12, 13, 14, 15, 16, 17, 18, 19]);
        assert!(track.notes[0].text.contains("between 0.50 and 1.10 s and came back"), "{}", track.notes[0].text);
    }
}

//! What a person should know of a film: each with a fixed code, a sentence, and what to try.

use tunenet_core::observation::Note;

use crate::scout::Unseen;
use crate::track::Track;

/// A ball that is not seen in this many frames between two sightings was lost.
const LOST_FRAMES: usize = 3;
/// The ball has left the view where it is last seen this many radii from the border, or nearer.
const NEAR_BORDER: f64 = 2.5;

/// Why there is no track.
pub(crate) fn unseen(reason: Unseen, named: bool, found: &str) -> Note {
    let (text, remedy) = match (reason, named) {
        (Unseen::CameraMoves, _) => (
            "expected a still camera, found most of the picture moving".to_owned(),
            "put the camera on a stand, or against something",
        ),
        (Unseen::TwoBalls, _) => (
            format!("expected one ball, found two things alike {found}"),
            "leave one ball in view, or name its colour with `--color`",
        ),
        (Unseen::NoBall, false) => (
            "expected a ball, found nothing round and coloured that moves".to_owned(),
            "name its colour, as in `--color white`, or record a saturated ball before a dull background",
        ),
        (Unseen::NoBall, true) => (
            "expected a ball of the given colour, found nothing round of it that moves".to_owned(),
            "leave `--color` out, so that the colour is found by itself",
        ),
    };
    Note::new(reason.code(), text, remedy)
}

/// What was noticed of a track. `missing`: frames that decode, and frames that the file promises.
pub(crate) fn of(track: &Track, clutter: bool, missing: Option<(usize, usize)>) -> Vec<Note> {
    let mut notes = Vec::new();
    let frames = track.frames;
    if let Some((found, promised)) = missing {
        let text = format!("the film is cut off: {found} of {promised} frames decode");
        notes.push(Note::new("film.truncated", text, "copy the film again; what decodes is used"));
    }
    if !track.repeated.is_empty() {
        let numbers: Vec<String> = track.repeated.iter().take(4).map(ToString::to_string).collect();
        let more = if track.repeated.len() > 4 { ", …" } else { "" };
        let text = format!(
            "{} of {frames} frames repeat the one before: {}{more} (from 0)",
            track.repeated.len(),
            numbers.join(", ")
        );
        notes.push(Note::new("film.repeated", text, "they are left out"));
    }
    if track.dropped > 0 {
        let text = format!("{} frames are missing by the film's own clock", track.dropped);
        notes.push(Note::new("film.dropped", text, "the gaps stay in the clock"));
    }
    if clutter {
        let text = "the background holds the ball's colour, so only what moves is taken for the ball";
        notes.push(Note::new("ball.background", text, "record before another background, where the track has holes"));
    }
    let cut = track.sightings.iter().filter(|s| s.cut).count();
    if cut > 0 {
        let text = format!("the border of the picture cuts the ball in {cut} frames, which are left out of the track");
        notes.push(Note::new("ball.cut", text, "keep the whole flight in view"));
    }
    let lost: Vec<(usize, f64)> = track
        .sightings
        .windows(2)
        .filter(|w| w[1].frame - w[0].frame > LOST_FRAMES)
        .map(|w| (w[1].frame - w[0].frame - 1, w[0].time_s))
        .collect();
    if let Some((_, since)) = lost.first() {
        let count: usize = lost.iter().map(|l| l.0).sum();
        let text = format!("the ball is not seen in {count} frames in between, first after {since:.3} s");
        notes.push(Note::new("ball.lost", text, "see the overlay; more light makes for less blur"));
    }
    if let Some(last) = track.sightings.last().filter(|s| s.frame + LOST_FRAMES < frames) {
        let (width, height) = (track.size_px.0 as f64, track.size_px.1 as f64);
        let room = [last.u_px, width - last.u_px, last.v_px, height - last.v_px];
        let near = room.iter().any(|r| *r < NEAR_BORDER * last.radius_px);
        let way = if near { "it leaves the view" } else { "it is covered, or looks different" };
        let text = format!(
            "the ball is last seen at {:.3} s, {} frames before the end: {way}",
            last.time_s,
            frames - 1 - last.frame
        );
        notes.push(Note::new("ball.gone", text, "what was seen until then is used"));
    }
    notes
}

//! Findings about a video: each with a fixed code, a sentence, and what to try.

use tunenet_core::statistics::{mean, range};
use tunenet_video_protocol::track::TrackFailure;
use tunenet_video_protocol::{VideoFinding, findings};

use crate::track::answer::Track;

/// A ball that is not seen in this many frames between two sightings was lost.
const LOST_FRAMES: usize = 3;
/// The ball has left the view where it is last seen this many radii from the border, or nearer.
const NEAR_BORDER: f64 = 2.5;

/// A path this straight and this long, in radii, is none of a ball that flies ...
const MAX_DEVIATION: f64 = 0.15;
const LONG: f64 = 4.0;
/// ... nor one that rises and falls by less than this share of its length.
const LEVEL: f64 = 0.6;

/// That a ball goes along a line that is no plumb line, and so never flies.
fn rolls(track: &Track) -> Option<VideoFinding> {
    let places: Vec<(f64, f64)> = track.whole().map(|s| (s.u_px, s.v_px)).collect();
    let (u, v) = (mean(places.iter().map(|p| p.0)), mean(places.iter().map(|p| p.1)));
    let sum = |of: &dyn Fn(f64, f64) -> f64| places.iter().map(|p| of(p.0 - u, p.1 - v)).sum::<f64>();
    let slope = sum(&|x, y| x * y) / sum(&|x, _| x * x);
    let off = mean(places.iter().map(|p| (p.1 - v - slope * (p.0 - u)).powi(2))).sqrt();
    let (across, down) = (range(places.iter().map(|p| p.0)), range(places.iter().map(|p| p.1)));
    let radius = track.radius_px();
    (across > LONG * radius && down < LEVEL * across && off < MAX_DEVIATION * radius).then(|| {
        let text = format!(
            "the ball moves along a straight line, {across:.0} px across and {down:.0} px down: it rolls and never flies"
        );
        VideoFinding::new(findings::BALL_ROLLS, text, "record a ball that falls and bounces; rolling does not show restitution")
    })
}

/// Why there is no track.
pub(crate) fn untracked(reason: TrackFailure, named: bool, found: &str) -> VideoFinding {
    let (text, remedy) = match (reason, named) {
        (TrackFailure::CameraMoves, _) => (
            "expected a fixed camera, found most of the picture moving".to_owned(),
            "put the camera on a stand, or against something",
        ),
        (TrackFailure::TwoBalls, _) => (
            format!("expected one ball, found two similar things {found}"),
            "leave one ball in view, or name its colour with `--color`",
        ),
        (TrackFailure::NotRound, _) => (
            format!("expected a ball, found something that is not round: {found}"),
            "name the ball's colour with `--color`, or remove other moving things from the view",
        ),
        (TrackFailure::NoBall, false) => (
            "expected a ball, found nothing round and saturated that moves".to_owned(),
            "name its colour, as in `--color white`, or record a saturated ball in front of a dull background",
        ),
        (TrackFailure::NoBall, true) => (
            "expected a ball of the given colour, found nothing round of it that moves".to_owned(),
            "omit `--color` to detect the colour",
        ),
    };
    VideoFinding::new(reason.kind(), text, remedy)
}

/// Where a video ends before its announced end.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CutOff {
    /// Frames that decode.
    pub frames: usize,
    /// When the last of them was taken, s.
    pub last_s: f64,
    /// Frames that the file promises.
    pub promised: Option<usize>,
    /// Why the next one does not decode.
    pub why: Option<String>,
}

impl CutOff {
    fn note(&self) -> VideoFinding {
        let Self { frames, last_s, promised, why } = self;
        let promised = promised.map_or(String::new(), |n| format!(" of {n}"));
        let why = why.as_ref().map_or(String::new(), |why| format!("; then: {why}"));
        let text = format!("the video is cut off: {frames}{promised} frames can be decoded, until {last_s:.3} s{why}");
        VideoFinding::new(
            findings::VIDEO_TRUNCATED,
            text,
            "what was read is used; copy the video again if its end matters",
        )
    }
}

/// Findings about a track, and about a video that is cut off.
pub(crate) fn of(track: &Track, clutter: bool, missing: Option<&CutOff>) -> Vec<VideoFinding> {
    let mut notes = Vec::new();
    let frames = track.frames;
    notes.extend(missing.map(CutOff::note));
    notes.extend(rolls(track));
    if !track.repeated.is_empty() {
        let numbers: Vec<String> = track.repeated.iter().take(4).map(ToString::to_string).collect();
        let more = if track.repeated.len() > 4 { ", …" } else { "" };
        let text = format!(
            "{} of {frames} frames repeat the previous one: {}{more} (from 0)",
            track.repeated.len(),
            numbers.join(", ")
        );
        notes.push(VideoFinding::new(
            findings::VIDEO_REPEATED,
            text,
            "save the video at the rate at which it was taken",
        ));
    }
    if track.dropped > 0 {
        let text = format!("{} frames are missing according to the video's clock", track.dropped);
        notes.push(VideoFinding::new(findings::VIDEO_DROPPED, text, "the gaps stay in the clock"));
    }
    if clutter {
        let text = "the background contains the ball's colour, so only moving pixels count as the ball";
        notes.push(VideoFinding::new(findings::BALL_BACKGROUND, text, "use another background if the track has gaps"));
    }
    let cut = track.sightings.iter().filter(|s| s.cut).count();
    if cut > 0 {
        let text = format!("the border of the picture cuts the ball in {cut} frames, which are left out of the track");
        notes.push(VideoFinding::new(findings::BALL_CUT, text, "keep the whole flight in view"));
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
        notes.push(VideoFinding::new(findings::BALL_LOST, text, "see the overlay; more light reduces blur"));
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
        notes.push(VideoFinding::new(findings::BALL_GONE, text, ""));
    }
    notes
}

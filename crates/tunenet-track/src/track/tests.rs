//! Videos that are drawn here, so that the truth is known, and real ones.

use std::path::Path;
use tunenet_video_protocol::findings;

use super::*;
use crate::scale::Known;
use crate::test_videos::{TestVideo, disc_video};
use tunenet_ball::preflight::Expected;

fn answer(path: &Path, settings: &Settings) -> Answer {
    track(&Source::new(path, None), settings, &mut |_, _| {}).unwrap()
}

fn tracked(path: &Path, settings: &Settings) -> Track {
    match answer(path, settings) {
        Answer::Tracked(track) => *track,
        Answer::Untracked { finding, .. } => panic!("{finding:?}"),
    }
}

fn reason(path: &Path, settings: &Settings) -> TrackFailure {
    match answer(path, settings) {
        Answer::Tracked(track) => panic!("{} sightings", track.sightings.len()),
        Answer::Untracked { reason, .. } => reason,
    }
}

fn red() -> Settings {
    Settings { colour: Some(Window::parse("red").unwrap()), ..Settings::default() }
}

const RED: [f64; 3] = [40.0, 40.0, 220.0];
const GREEN: [f64; 3] = [40.0, 220.0, 40.0];

#[test]
fn a_drawn_disc_is_found_to_a_fraction_of_a_pixel() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("video.avi");
    let centres = disc_video(&path, &TestVideo { balls: vec![RED], ..TestVideo::default() });
    for settings in [Settings::default(), red()] {
        let track = tracked(&path, &settings);
        assert_eq!((track.frames, track.sightings.len()), (60, 60));
        assert!((track.rate_hz - 60.0).abs() < 1e-6, "{}", track.rate_hz);
        for s in &track.sightings {
            let (u, v) = centres[s.frame];
            assert!((s.u_px - u).hypot(s.v_px - v) < 0.1, "frame {}: {} {} for {u} {v}", s.frame, s.u_px, s.v_px);
            assert!((s.radius_px - 12.0).abs() < 0.25 && !s.cut && s.confidence > 0.9, "{s:?}");
        }
        assert_eq!(track.observation().unwrap().len(), track.whole().count());
        assert!(track.notes.is_empty(), "{:?}", track.notes);
    }
}

#[test]
fn no_ball_two_balls_and_a_wrong_colour_are_distinguished() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, video: &TestVideo| {
        let path = folder.path().join(name);
        disc_video(&path, video);
        path
    };
    let none = file("none.avi", &TestVideo::default());
    let two = file("two.avi", &TestVideo { balls: vec![GREEN, GREEN], ..TestVideo::default() });
    let one = file("one.avi", &TestVideo { balls: vec![GREEN], ..TestVideo::default() });
    let shaken = file("shaken.avi", &TestVideo { balls: vec![GREEN], shake_px: 9.0, ..TestVideo::default() });
    assert_eq!(reason(&none, &Settings::default()), TrackFailure::NoBall);
    assert_eq!(reason(&two, &Settings::default()), TrackFailure::TwoBalls);
    assert_eq!(reason(&one, &red()), TrackFailure::NoBall);
    assert_eq!(reason(&shaken, &Settings::default()), TrackFailure::CameraMoves);
}

#[test]
fn a_ball_of_the_backgrounds_hue_is_found_where_it_moves() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("video.avi");
    let centres =
        disc_video(&path, &TestVideo { balls: vec![GREEN], poster: Some([60.0, 170.0, 70.0]), ..TestVideo::default() });
    let track = tracked(&path, &Settings::default());
    assert!(track.notes.iter().any(|n| n.kind == findings::BALL_BACKGROUND), "{:?}", track.notes);
    assert!(track.sightings.len() >= 57, "{}", track.sightings.len());
    for s in &track.sightings {
        let (u, v) = centres[s.frame];
        assert!((s.u_px - u).hypot(s.v_px - v) < 1.0, "frame {}: {} {} for {u} {v}", s.frame, s.u_px, s.v_px);
    }
}

#[test]
fn repeated_frames_and_a_ball_that_leaves_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("video.avi");
    disc_video(&path, &TestVideo { balls: vec![RED], repeat: vec![20, 40], speed_px_s: 320.0, ..TestVideo::default() });
    let track = tracked(&path, &Settings::default());
    assert_eq!(track.repeated, [21, 42]);
    let kinds: Vec<_> = track.notes.iter().map(|n| n.kind).collect();
    assert_eq!(kinds, [findings::VIDEO_REPEATED, findings::BALL_CUT, findings::BALL_GONE], "{:?}", track.notes);
    assert!(track.notes[2].text.contains("leaves the view"));
    assert!(track.whole().all(|s| s.frame != 21 && s.frame != 42));
}

#[test]
fn a_rate_that_is_given_sets_the_clock() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("video.avi");
    disc_video(&path, &TestVideo { balls: vec![RED], ..TestVideo::default() });
    let track = tracked(&path, &Settings { rate_hz: Some(240.0), most_frames: Some(30), ..Settings::default() });
    assert_eq!(track.frames, 30);
    assert!((track.rate_hz - 240.0).abs() < 1e-6);
    assert!((track.sightings[29].time_s - 29.0 / 240.0).abs() < 1e-9);
    let settings = Settings { rate_hz: Some(0.0), ..Settings::default() };
    assert!(super::track(&Source::new(&path, None), &settings, &mut |_, _| {}).is_err());
}

#[test]
fn a_long_video_is_decoded_once_and_not_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("video.avi");
    let frames = WAITING_BYTES / (320 * 240 * 3) + 100;
    disc_video(&path, &TestVideo { balls: vec![RED], speed_px_s: 5.0, frames, ..TestVideo::default() });
    let mut calls = 0;
    let answer = track(&Source::new(&path, None), &Settings::default(), &mut |_, _| calls += 1).unwrap();
    let Answer::Tracked(track) = answer else { panic!("no ball") };
    assert_eq!((track.frames, track.sightings.len(), calls), (frames, frames, frames));
}

/// Frames with a ball in them, as counted by eye and listed with the videos, one more or less at the border.
#[test]
fn balls_in_real_videos_are_seen() {
    let Some(root) = std::env::var_os("TUNENET_MEASURED") else {
        eprintln!("skipped: TUNENET_MEASURED does not name a folder of measured files");
        return;
    };
    let videos = [
        ("video-redball/RedBall.mp4", 57..=60),
        ("video-throws/PV_1.mp4", 51..=53),
        ("video-throws/PV_2.mp4", 37..=39),
        ("video-tennis-throw/ball.mp4", 27..=27),
    ];
    for (name, expected) in videos {
        let path = Path::new(&root).join(name);
        if !path.exists() {
            eprintln!("skipped: {} is not there", path.display());
            continue;
        }
        let found = tracked(&path, &Settings::default());
        let metric = crate::scale::Metric::of(&found, Known::Nothing, &Expected::default()).unwrap().unwrap();
        let arcs = metric.preflight.arcs.unwrap();
        eprintln!(
            "{name}: scale {} restitution {:?} {:?} gravity {:?}",
            metric.metres_per_px,
            arcs.restitution(),
            metric.notes,
            metric.preflight.gravity
        );
        for c in &arcs.contacts {
            eprintln!("  {c:?}");
        }
        for c in metric.preflight.checks {
            eprintln!("  {c:?}");
        }
        assert!(expected.contains(&found.sightings.len()), "{name}: {} frames", found.sightings.len());
    }
}

//! From a video to a track: one position of the ball for every frame in which it is seen.

pub mod answer;

use opencv::core::{Mat, MatTraitConstManual};
use tunenet_core::Origin;
use tunenet_video_protocol::track::TrackFailure;

pub use self::answer::{Answer, Track};
use crate::ball_colour::{Scene, detect_ball};
use crate::camera_motion::without_camera_motion;
use crate::changes::Changes;
use crate::clock;
use crate::colour::{HUES, Window};
use crate::samples::{Samples, reduced};
use crate::source::Source;
use crate::stillness::moves;
use crate::track_findings::{self, CutOff};
use crate::tracker::{Sighting, Tracker};
use crate::video::{FEWEST_FRAMES, undecodable};
use crate::view::View;
use tunenet_core::statistics::{median, quantile};
use tunenet_formats::{Error, Result};

/// Whole frames up to this many bytes wait until it is known what to look for, so that a video is decoded only once.
const WAITING_BYTES: usize = 256 << 20;
/// Small pictures of the first frames that are examined.
const EARLY: usize = 24;
/// What the first frames show is looked at when these shares of the bytes have come ...
const LOOKS: [f64; 3] = [0.25, 0.5, 1.0];
/// ... and accepted, before the rest is known, if the ball is found in this share of them.
const ACCEPTED_SHARE: f64 = 0.4;
/// What was followed from the first frames on is the ball, and the whole video is not read again, where so many of all
/// frames show it so well.
const SURE: (f64, f64) = (0.8, 0.8);
/// A sighting this many times larger or smaller than usual is something else.
const OFF_SIZE: f64 = 1.8;
/// From this radius on an outline distinguishes shapes, px.
const SHAPE_RADIUS_PX: f64 = 8.0;
/// An edge that lies farther off its ellipse, as a share of the radius and in px, is that of something else: a square's lies
/// 0.08 off.
const NOT_ROUND: (f64, f64) = (0.05, 0.25);
/// What is left of a ball at the border of the picture is one from this share of its usual radius on.
const LEAST_CUT: f64 = 0.3;
/// A ball is seen twice from this share of the looks on.
const TWO_BALLS: f64 = 0.3;

/// How to track.
#[derive(Debug, Clone, Default)]
pub struct Settings {
    /// The ball's colour; found by itself where it is `None`.
    pub colour: Option<Window>,
    /// The frames per second at which the video was really taken, where the container does not know: slow motion.
    pub rate_hz: Option<f64>,
    /// Frames after which to stop; all where it is `None`.
    pub most_frames: Option<usize>,
}

/// Tracks the ball in `source`. `progress` is called with the number of frames done and how many the file promises.
///
/// Frames are decoded in a thread of their own, once where the first of them show what to look for; memory does not grow
/// with the video.
///
/// # Errors
/// [`Error::File`] where the video cannot be read; [`Setting`](tunenet_core::Error::Setting) for a rate that is none.
pub fn track(source: &Source, settings: &Settings, progress: &mut dyn FnMut(usize, Option<usize>)) -> Result<Answer> {
    if let Some(rate) = settings.rate_hz.filter(|r| !(r.is_finite() && (1e-3..=1e6).contains(r))) {
        let (expected, found) = ("frames per second from 0.001 to 1000000".into(), rate.to_string());
        return Err(
            tunenet_core::Error::Setting { origin: Origin::Caller, name: "--camera-rate", expected, found }.into()
        );
    }
    let most = settings.most_frames.unwrap_or(usize::MAX);
    let mut first =
        First { settings, waiting: Vec::new(), bytes: 0, looks: 0, samples: Samples::default(), pass: None };
    let mut last_s = 0.0;
    let frames = source.stream(most, &mut |index, time_s, image, promised| {
        last_s = time_s;
        let promised = promised.map(|p| p.min(most));
        progress(index + 1, promised);
        first.take(index, time_s, image, promised)
    })?;
    let First { waiting, samples, mut pass, .. } = first;
    if frames.count < FEWEST_FRAMES {
        let why = frames.broken.map_or(String::new(), |why| format!(" ({why})"));
        let found = format!("expected a video, found {} frames that decode{why}", frames.count);
        return Err(Error::file(source.path(), found, "record a longer one, or copy it again"));
    }
    let broken = |e: opencv::Error| undecodable(source.path(), &e);
    let fewer = settings.most_frames.is_none() && frames.promised.is_some_and(|p| p > frames.count + 1 + p / 50);
    let cut_off = (fewer || frames.broken.is_some()).then(|| CutOff {
        frames: frames.count,
        last_s,
        promised: frames.promised,
        why: frames.broken.clone(),
    });
    if let Some(pass) = pass.take_if(|pass| pass.sure()) {
        if moves(samples.telling()).map_err(broken)? {
            return Ok(untracked(TrackFailure::CameraMoves, frames.count, settings, ""));
        }
        return pass.finish(settings, cut_off.as_ref(), &samples).map_err(broken);
    }
    let scene = match detect_ball(samples.telling(), settings.colour).map_err(broken)? {
        Ok(scene) => scene,
        Err(reason) => {
            return without_camera_motion(untracked(reason, frames.count, settings, ""), &samples).map_err(broken);
        }
    };
    // What the first frames showed may be another ball than the one of the whole video.
    let pass = match pass {
        Some(pass) if pass.alike(&scene) => pass,
        _ => {
            let mut pass = Pass::new(scene);
            if waiting.len() == frames.count {
                waiting.iter().try_for_each(|(time_s, image)| pass.frame(*time_s, image)).map_err(broken)?;
            } else {
                source.stream(most, &mut |index, time_s, image, promised| {
                    progress(index + 1, promised.map(|p| p.min(most)));
                    pass.frame(time_s, &image)?;
                    Ok(vec![image])
                })?;
            }
            pass
        }
    };
    pass.finish(settings, cut_off.as_ref(), &samples).map_err(broken)
}

fn untracked(reason: TrackFailure, frames: usize, settings: &Settings, found: &str) -> Answer {
    Answer::Untracked { reason, frames, finding: track_findings::untracked(reason, settings.colour.is_some(), found) }
}

/// The first pass through a video: frames wait until it is known what to look for.
struct First<'a> {
    settings: &'a Settings,
    waiting: Vec<(f64, Mat)>,
    bytes: usize,
    /// How often they were looked at.
    looks: usize,
    samples: Samples,
    pass: Option<Pass>,
}

impl First<'_> {
    fn take(&mut self, index: usize, time_s: f64, image: Mat, promised: Option<usize>) -> opencv::Result<Vec<Mat>> {
        self.samples.push(index, &image, promised)?;
        if let Some(pass) = &mut self.pass {
            pass.frame(time_s, &image)?;
            return Ok(vec![image]);
        }
        if self.looks == LOOKS.len() {
            // The first frames did not show it, so all of them have to be seen again.
            return Ok(vec![image]);
        }
        self.bytes += image.data_bytes()?.len();
        self.waiting.push((time_s, image));
        if self.bytes as f64 > LOOKS[self.looks] * WAITING_BYTES as f64 {
            self.looks += 1;
            let every = self.waiting.len().div_ceil(EARLY);
            let early: Vec<Mat> =
                self.waiting.iter().step_by(every).map(|(_, image)| reduced(image)).collect::<opencv::Result<_>>()?;
            if let Ok(scene) = detect_ball(&early, self.settings.colour)?
                && scene.seen_share >= ACCEPTED_SHARE
            {
                let mut pass = Pass::new(scene);
                self.waiting.iter().try_for_each(|(time_s, image)| pass.frame(*time_s, image))?;
                self.pass = Some(pass);
                self.looks = LOOKS.len();
            }
            if self.looks == LOOKS.len() {
                return Ok(self.waiting.drain(..).map(|(_, image)| image).collect());
            }
        }
        Ok(Vec::new())
    }
}

/// One pass over the frames.
struct Pass {
    tracker: Tracker,
    sightings: Vec<Sighting>,
    times_s: Vec<f64>,
    changes: Changes,
    size_px: (usize, usize),
}

impl Pass {
    fn new(scene: Scene) -> Self {
        let tracker = Tracker::new(scene);
        Self { tracker, sightings: Vec::new(), times_s: Vec::new(), changes: Changes::default(), size_px: (0, 0) }
    }

    /// Whether it looked for what `scene` says as well.
    fn alike(&self, scene: &Scene) -> bool {
        let (a, b) = (&self.tracker.scene().window, &scene.window);
        let away = ((a.hue - b.hue + HUES / 2).rem_euclid(HUES) - HUES / 2).abs();
        let size = self.tracker.scene().area_share / scene.area_share;
        away <= a.half_width.min(b.half_width)
            && (!scene.clutter || self.tracker.scene().clutter)
            && (0.25..4.0).contains(&size)
    }

    /// Whether most frames show something that looks like one ball throughout.
    fn sure(&self) -> bool {
        let whole: Vec<f64> = self.sightings.iter().filter(|s| !s.cut).map(|s| s.confidence).collect();
        let confidence = whole.iter().sum::<f64>() / whole.len().max(1) as f64;
        whole.len() as f64 >= SURE.0 * self.times_s.len() as f64 && confidence >= SURE.1
    }

    fn frame(&mut self, time_s: f64, image: &Mat) -> opencv::Result<()> {
        let view = View::of(image)?;
        let frame = self.times_s.len();
        self.sightings.extend(self.tracker.look(&view)?.map(|s| Sighting { frame, time_s, ..s }));
        self.times_s.push(time_s);
        self.changes.push(&view);
        self.size_px = (view.columns(), view.rows());
        Ok(())
    }

    /// The answer, without what was seen while the camera was displaced.
    fn finish(self, settings: &Settings, cut_off: Option<&CutOff>, samples: &Samples) -> opencv::Result<Answer> {
        without_camera_motion(self.answer(settings, cut_off), samples)
    }

    fn answer(self, settings: &Settings, cut_off: Option<&CutOff>) -> Answer {
        let Self { tracker, mut sightings, mut times_s, changes, size_px } = self;
        let frames = times_s.len();
        clock::even_out(&mut times_s);
        for s in &mut sightings {
            s.time_s = times_s[s.frame];
        }
        let looks: Vec<bool> = sightings.iter().filter_map(|s| s.second).collect();
        let two = looks.iter().filter(|second| **second).count();
        if two as f64 > TWO_BALLS * looks.len() as f64 {
            return untracked(TrackFailure::TwoBalls, frames, settings, &format!("in {two} of {} frames", looks.len()));
        }
        let step_s = clock::step_s(&times_s);
        // The video's own steps keep their proportions, so that a dropped frame stays a gap.
        let slower = settings.rate_hz.map_or(1.0, |rate| 1.0 / (rate * step_s));
        for t in times_s.iter_mut().chain(sightings.iter_mut().map(|s| &mut s.time_s)) {
            *t *= slower;
        }
        let step_s = step_s * slower;
        let dropped = clock::dropped(&times_s, step_s);
        let radius = median(sightings.iter().filter(|s| !s.cut).map(|s| s.radius_px)).unwrap_or(1.0);
        // Blur, shadows and the background corrupt the outlines of most balls somewhere, but not everywhere.
        if let Some(off) = quantile(sightings.iter().filter(|s| !s.cut).filter_map(|s| s.off), 0.25)
            && radius >= SHAPE_RADIUS_PX
            && off > NOT_ROUND.0 + NOT_ROUND.1 / radius
        {
            let found = format!("its edge lies {:.0} % of its radius off an ellipse", 100.0 * off);
            return untracked(TrackFailure::NotRound, frames, settings, &found);
        }
        for s in sightings.iter_mut().filter(|s| !s.cut) {
            s.confidence *= (-((s.radius_px / radius).ln() / OFF_SIZE.ln()).powi(2)).exp();
        }
        // Something else of the ball's colour: far too large or too small, and in full view.
        sightings.retain(|s| {
            let size = s.radius_px / radius;
            if s.cut { (LEAST_CUT..OFF_SIZE).contains(&size) } else { (1.0 / OFF_SIZE..OFF_SIZE).contains(&size) }
        });
        if !sightings.iter().any(|s| !s.cut) {
            return untracked(TrackFailure::NoBall, frames, settings, "");
        }
        let mut track = Track {
            frames,
            size_px,
            rate_hz: 1.0 / step_s,
            colour: tracker.scene().window,
            sightings,
            repeated: changes.repeated(),
            dropped,
            notes: Vec::new(),
        };
        track.notes = track_findings::of(&track, tracker.scene().clutter, cut_off);
        Answer::Tracked(Box::new(track))
    }
}

#[cfg(test)]
mod tests;

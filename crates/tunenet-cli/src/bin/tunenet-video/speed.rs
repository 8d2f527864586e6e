//! How fast pictures are made, decoded and tracked: what `tunenet bench speed` prints of videos.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use tunenet_core::camera::Pinhole;
use tunenet_track::render::{Look, Renderer};
use tunenet_track::synthetic;
use tunenet_track::track::Settings;
use tunenet_track::tracker::Tracker;
use tunenet_track::view::View;
use tunenet_track::{Answer, Source, synthetic::scene, track};
use tunenet_video_protocol::speed::{DecodingSpeed, Render, Track, VideoSpeed};
use tunenet_video_protocol::synthetic::{Degradation, Take};

/// Each figure is the median of so many measurements.
const REPEATS: usize = 5;
const FRAMES: usize = 400;
const VIDEO_FRAMES: usize = 240;
const RATE_HZ: f64 = 60.0;
/// The paper's ball, m.
const RADIUS_M: f64 = 0.5;
/// What noise and compression are where they are asked for.
const DEGRADED: (f64, i32) = (6.0, 75);

/// All figures. `folder` takes the videos that are made.
pub fn run(folder: &Path) -> Result<VideoSpeed> {
    let take = Take { camera: camera((160, 120))?, heights_m: heights(FRAMES), across_m: Vec::new() };
    let clean = render(&take, 0.0, None)?;
    let degradation = render(&take, DEGRADED.0, Some(DEGRADED.1))?;
    let (tracked, off_px) = small(&take)?;
    let video = folder.join("phone.mp4");
    write(&video, (1920, 1080), VIDEO_FRAMES)?;
    let (decoded, both) = video_rates(&video)?;
    Ok(VideoSpeed {
        render: Render { clean_frames_s: clean, noise_and_jpeg_frames_s: degradation },
        track: Track { frames_s: tracked, worst_px: off_px },
        video: DecodingSpeed { decode_frames_s: decoded, track_frames_s: both, frames: VIDEO_FRAMES },
    })
}

/// Writes a video of so many frames of 4K, for the memory that tracking it takes.
pub fn long_video(path: &Path, frames: usize) -> Result<()> {
    write(path, (3840, 2160), frames)
}

fn camera(size_px: (usize, usize)) -> Result<Pinhole> {
    let camera = Pinhole::aimed([6.0, 3.0, 6.0], [0.0, 0.0, 2.0], std::f64::consts::FRAC_PI_3, size_px);
    camera.context("a camera that sees the ball")
}

/// A ball that goes up and down, ever lower.
fn heights(count: usize) -> Vec<f64> {
    let height = |i: usize| {
        let t = i as f64 / RATE_HZ;
        0.5 + 4.0 * (-0.3 * t).exp() * (2.5 * t).cos().abs()
    };
    (0..count).map(height).collect()
}

/// Frames per second of the renderer on one core.
fn render(take: &Take, noise: f64, jpeg_quality: Option<i32>) -> Result<f64> {
    let degradation = Degradation { noise, jpeg_quality, ..Degradation::default() };
    rates(take.heights_m.len(), || {
        if jpeg_quality.is_some() {
            std::hint::black_box(synthetic::pictures(take, RADIUS_M, &degradation, 1)?);
            return Ok(());
        }
        let mut renderer = Renderer::new(take.camera.clone(), RADIUS_M, Look::default(), 1);
        take.heights_m.iter().for_each(|z| {
            std::hint::black_box(renderer.frame([0.0, 0.0, *z]));
        });
        Ok(())
    })
}

/// Frames per second of the tracker on one core, pictures in memory, and its greatest distance from the projection, px.
fn small(take: &Take) -> Result<(f64, f64)> {
    let pictures = synthetic::pictures(take, RADIUS_M, &Degradation::default(), 1)?;
    let scene = scene(&pictures)?.map_err(|reason| anyhow::anyhow!("{}", reason.word()))?;
    let mut places = Vec::new();
    let rate = rates(pictures.len(), || {
        let mut tracker = Tracker::new(scene.clone());
        places = pictures.iter().map(|p| tracker.look(&View::of(p)?)).collect::<Result<Vec<_>, _>>()?;
        Ok(())
    })?;
    let mut worst = 0.0;
    for (seen, z) in places.iter().zip(&take.heights_m) {
        let disc = take.camera.disc([0.0, 0.0, *z], RADIUS_M).context("the ball before the camera")?;
        let seen = seen.as_ref().context("a frame without the ball")?;
        worst = f64::max(worst, (seen.u_px - disc.centre_px[0]).hypot(seen.v_px - disc.centre_px[1]));
    }
    Ok((rate, worst))
}

/// Frames per second of decoding a video alone, and of decoding and tracking it.
fn video_rates(path: &Path) -> Result<(f64, f64)> {
    let source = Source::new(path, None);
    let decoded = rates(VIDEO_FRAMES, || {
        source.stream(usize::MAX, &mut |_, _, image, _| Ok(vec![image]))?;
        Ok(())
    })?;
    let both = rates(VIDEO_FRAMES, || match track(&source, &Settings::default(), &mut |_, _| {})? {
        Answer::Tracked(_) => Ok(()),
        Answer::Untracked { finding, .. } => anyhow::bail!("{}", finding.text),
    })?;
    Ok((decoded, both))
}

/// A video with a sensor's noise, as a phone takes it.
fn write(path: &Path, size_px: (usize, usize), frames: usize) -> Result<()> {
    let take = Take { camera: camera(size_px)?, heights_m: heights(frames), across_m: Vec::new() };
    Ok(synthetic::write(path, &take, RADIUS_M, 3.0, RATE_HZ)?)
}

/// The median of several runs of `one`, which handles `frames` frames.
fn rates(frames: usize, mut one: impl FnMut() -> Result<()>) -> Result<f64> {
    let mut all = Vec::with_capacity(REPEATS);
    for _ in 0..REPEATS {
        let began = Instant::now();
        one()?;
        all.push(frames as f64 / began.elapsed().as_secs_f64());
    }
    all.sort_unstable_by(f64::total_cmp);
    Ok(all[REPEATS / 2])
}

//! Videos whose truth is known, rendered and tracked without a file in between.

use std::path::Path;

use opencv::core::{CV_8UC3, LogLevel, Mat, MatTraitManual, Scalar, Size, Vector, set_log_level};
use opencv::imgcodecs::{IMREAD_COLOR, IMWRITE_JPEG_QUALITY, imdecode, imencode};
use opencv::videoio::{VideoWriter, VideoWriterTrait, VideoWriterTraitConst};
use tunenet_video_protocol::synthetic::{Degradation, Places, SyntheticTrack, Take};
use tunenet_video_protocol::track::TrackFailure;

use crate::ball_colour::{Scene, detect_ball};
use crate::render::{Look, Renderer};
use crate::samples::Samples;
use crate::tracker::{Sighting, Tracker};
use crate::view::View;

/// The pictures of a take, in order.
///
/// # Errors
/// Where OpenCV fails.
pub fn pictures(take: &Take, radius_m: f64, degradation: &Degradation, seed: u64) -> opencv::Result<Vec<Mat>> {
    let look = Look { noise: degradation.noise, ..Look::default() };
    let mut renderer = Renderer::new(take.camera.clone(), radius_m, look, seed);
    let last = take.heights_m.len().saturating_sub(1);
    let all = (0..take.heights_m.len()).map(|i| {
        let (here, next) = (take.place(i), take.place((i + 1).min(last)));
        let bytes = if degradation.exposure > 0.0 {
            renderer.blurred(here, [0, 1, 2].map(|k| here[k] + degradation.exposure * (next[k] - here[k])))
        } else {
            renderer.frame(here)
        };
        let mat = picture(size(take), bytes)?;
        match degradation.jpeg_quality {
            None => Ok(mat),
            Some(quality) => through_jpeg(&mat, quality),
        }
    });
    all.collect()
}

/// Columns and rows of a take's pictures.
fn size(take: &Take) -> Size {
    let (columns, rows) = take.camera.size_px();
    let size = |n: usize| i32::try_from(n).unwrap_or(i32::MAX);
    Size::new(size(columns), size(rows))
}

/// A picture from its pixels: blue, green, red of each, row after row.
fn picture(size: Size, bytes: &[u8]) -> opencv::Result<Mat> {
    let mut mat = Mat::new_size_with_default(size, CV_8UC3, Scalar::all(0.0))?;
    mat.data_bytes_mut()?.copy_from_slice(bytes);
    Ok(mat)
}

fn through_jpeg(picture: &Mat, quality: i32) -> opencv::Result<Mat> {
    let mut bytes = Vector::<u8>::new();
    imencode(".jpg", picture, &mut bytes, &Vector::from_slice(&[IMWRITE_JPEG_QUALITY, quality]))?;
    imdecode(&bytes, IMREAD_COLOR)
}

/// What to look for in pictures, found as in a video.
///
/// # Errors
/// Where OpenCV fails.
pub fn scene(pictures: &[Mat]) -> opencv::Result<Result<Scene, TrackFailure>> {
    let mut samples = Samples::default();
    for (i, picture) in pictures.iter().enumerate() {
        samples.push(i, picture, Some(pictures.len()))?;
    }
    detect_ball(samples.telling(), None)
}

/// Tracks pictures as those of a video are: the ball's colour found by itself, then frame after frame. `None` for a frame that
/// does not show it.
///
/// # Errors
/// Where OpenCV fails.
pub fn tracked(pictures: &[Mat]) -> opencv::Result<Result<Vec<Option<Sighting>>, TrackFailure>> {
    let scene = match scene(pictures)? {
        Ok(scene) => scene,
        Err(reason) => return Ok(Err(reason)),
    };
    let mut tracker = Tracker::new(scene);
    pictures.iter().map(|p| tracker.look(&View::of(p)?)).collect::<opencv::Result<_>>().map(Ok)
}

/// Writes a take as a video at `rate_hz`, with noise of this standard deviation on every channel: H.264 as phones write it
/// where OpenCV has a coder for it, else MPEG-4.
///
/// # Errors
/// Where OpenCV fails, or writes no such video.
pub fn write(path: &Path, take: &Take, radius_m: f64, noise: f64, rate_hz: f64) -> opencv::Result<()> {
    let look = Look { noise, ..Look::default() };
    let mut renderer = Renderer::new(take.camera.clone(), radius_m, look, 1);
    let name = path.to_str().ok_or_else(|| opencv::Error::new(opencv::core::StsBadArg, "a name that is not UTF-8"))?;
    let open = |codec: [char; 4]| {
        let [a, b, c, d] = codec;
        let code = VideoWriter::fourcc(a, b, c, d)?;
        VideoWriter::new(name, code, rate_hz, size(take), true)
    };
    set_log_level(LogLevel::LOG_LEVEL_SILENT)?;
    let mut writer = open(['a', 'v', 'c', '1'])?;
    if !writer.is_opened()? {
        writer = open(['m', 'p', '4', 'v'])?;
    }
    if !writer.is_opened()? {
        return Err(opencv::Error::new(opencv::core::StsError, "OpenCV writes neither H.264 nor MPEG-4"));
    }
    for z in &take.heights_m {
        writer.write(&picture(size(take), renderer.frame([0.0, 0.0, *z]))?)?;
    }
    writer.release()
}

/// Renders and tracks a take.
///
/// # Errors
/// Where OpenCV fails.
pub fn synthetic_track(
    take: &Take,
    radius_m: f64,
    degradation: &Degradation,
    seed: u64,
) -> opencv::Result<SyntheticTrack> {
    let sightings = match tracked(&pictures(take, radius_m, degradation, seed)?)? {
        Ok(sightings) => sightings,
        Err(reason) => return Ok(SyntheticTrack::Refused(reason)),
    };
    let Some(first) = sightings.iter().flatten().next() else {
        return Ok(SyntheticTrack::Refused(TrackFailure::NoBall));
    };
    let mut last = (first.u_px, first.v_px);
    let mut places = Places { u_px: Vec::new(), v_px: Vec::new(), seen: Vec::new() };
    for sighting in &sightings {
        if let Some(seen) = sighting {
            last = (seen.u_px, seen.v_px);
        }
        places.seen.push(sighting.is_some());
        places.u_px.push(last.0);
        places.v_px.push(last.1);
    }
    Ok(SyntheticTrack::Tracked(places))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tunenet_core::camera::Pinhole;

    /// The track of a ball that every frame has to show.
    fn found(take: &Take, degradation: &Degradation) -> Places {
        match synthetic_track(take, 0.5, degradation, 3).unwrap() {
            SyntheticTrack::Tracked(places) if places.seen.iter().all(|seen| *seen) => places,
            other => panic!("{other:?}"),
        }
    }

    fn take() -> Take {
        let camera = Pinhole::aimed([6.0, 3.0, 6.0], [0.0, 0.0, 2.0], std::f64::consts::FRAC_PI_3, (160, 120)).unwrap();
        // Falls and bounces, then lies.
        let height = |i: u32| {
            let t = f64::from(i) / 60.0;
            if t < 3.0 { 0.5 + 4.0 * (1.0 - t / 3.0) * (2.5 * t).cos().abs() } else { 0.5 }
        };
        Take { camera, heights_m: (0..240).map(height).collect(), across_m: Vec::new() }
    }

    /// Errors against the projected outline, px: mean and standard deviation along `v`, and the greatest distance.
    fn errors(degradation: &Degradation, eye_m: [f64; 3]) -> (f64, f64, f64) {
        let camera = Pinhole::aimed(eye_m, [0.0, 0.0, 2.0], std::f64::consts::FRAC_PI_3, (160, 120)).unwrap();
        let take = Take { camera, ..take() };
        let track = found(&take, degradation);
        let truth: Vec<[f64; 2]> =
            take.heights_m.iter().map(|z| take.camera.disc([0.0, 0.0, *z], 0.5).unwrap().centre_px).collect();
        let off: Vec<f64> = track.v_px.iter().zip(&truth).map(|(v, t)| v - t[1]).collect();
        let across = track.u_px.iter().zip(&truth).map(|(u, t)| u - t[0]);
        let worst = off.iter().zip(across).map(|(down, across)| down.hypot(across)).fold(0.0, f64::max);
        let n = off.len() as f64;
        let mean = off.iter().sum::<f64>() / n;
        (mean, (off.iter().map(|o| (o - mean).powi(2)).sum::<f64>() / n).sqrt(), worst)
    }

    /// Lit from the side, from behind and from the front.
    #[test]
    fn every_centre_is_within_a_tenth_of_a_pixel() {
        for eye_m in [[6.0, 3.0, 6.0], [-4.0, 5.0, 3.0], [2.0, -8.0, 5.0], [-6.0, -3.0, 7.0]] {
            let (_, _, worst) = errors(&Degradation::default(), eye_m);
            assert!(worst < 0.1, "{eye_m:?}: {worst}");
        }
    }

    #[test]
    fn a_ball_that_lies_still_for_most_of_the_video_is_found() {
        let fall = |i: u32| 0.5 + 3.5 * (1.0 - f64::from(i) / 70.0).max(0.0) * (f64::from(i) / 20.0).cos().abs();
        let take = Take { heights_m: (0..400).map(fall).collect(), ..take() };
        found(&take, &Degradation::default());
    }

    /// Small and large balls of every colour, dark and bright, under noise, that fall at once or lie still before or after.
    #[test]
    fn balls_of_all_kinds_are_found() {
        let camera = Pinhole::aimed([6.0, 3.0, 6.0], [0.0, 0.0, 2.0], std::f64::consts::FRAC_PI_3, (320, 240)).unwrap();
        let colours = [[30.0, 30.0, 220.0], [40.0, 200.0, 60.0], [210.0, 90.0, 30.0], [20.0, 150.0, 230.0]];
        for (i, (radius, lies)) in
            [(0.13, 0), (0.13, 160), (0.5, -160), (0.5, 240), (1.0, 0), (1.0, 160)].into_iter().enumerate()
        {
            for (brightness, noise) in [(0.4, 3.0), (1.0, 12.0), (1.2, 0.0)] {
                let look = Look {
                    ball_bgr: colours[(i + usize::from(noise > 5.0)) % 4],
                    brightness,
                    noise,
                    ..Look::default()
                };
                let mut renderer = Renderer::new(camera.clone(), radius, look, 5);
                let mut seen = Vec::new();
                let fall = |k: i32| radius + 3.0 * (1.0 - f64::from(k) / 80.0) * (f64::from(k) / 12.0).cos().abs();
                let heights =
                    (lies.min(0)..80 + lies.max(0)).map(|k| if (0..80).contains(&k) { fall(k) } else { radius });
                for z in heights {
                    seen.push(picture(Size::new(320, 240), renderer.frame([0.0, 0.0, z])).unwrap());
                }
                let found =
                    tracked(&seen).unwrap().unwrap_or_else(|r| panic!("{radius} {lies} {brightness} {noise}: {r:?}"));
                let missed = found.iter().filter(|s| s.is_none()).count();
                assert!(missed == 0, "{radius} {lies} {brightness} {noise}: {missed} missed");
            }
        }
    }

    #[test]
    fn noise_and_compression_cost_little() {
        let degradation = Degradation { noise: 6.0, jpeg_quality: Some(80), ..Degradation::default() };
        let (mean, sd, _) = errors(&degradation, [6.0, 3.0, 6.0]);
        assert!(mean.abs() < 0.2 && sd < 0.3, "{mean} {sd}");
    }
}

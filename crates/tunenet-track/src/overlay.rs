//! The track overlaid on its video: a few frames for a sheet, and a video to watch.

use std::path::Path;

use opencv::core::{Mat, MatTraitConst, Point, Scalar, Size, Vector};
use opencv::imgcodecs::{IMWRITE_JPEG_QUALITY, imencode};
use opencv::imgproc::{INTER_AREA, LINE_AA, circle, line, resize};
use opencv::videoio::{VideoWriter, VideoWriterTrait, VideoWriterTraitConst};
use tunenet_formats::{Error, Result};

use crate::colour::{HUES, Window};
use crate::source::Source;
use crate::track::Track;
use crate::tracker::Sighting;

/// The longer side of a picture of the sheet, px.
const SHEET_PX: i32 = 360;
/// Quality of its pictures, 0 to 100.
const QUALITY: i32 = 80;
/// So many sightings before a frame are drawn as a trail.
const TRAIL: usize = 30;
/// Sixteenths of a pixel, as OpenCV's `shift`.
const SHIFT: i32 = 4;

/// A frame with the track drawn in.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Which frame, from 0.
    pub frame: usize,
    /// When it was taken, s.
    pub time_s: f64,
    /// Width and height, px.
    pub size_px: (i32, i32),
    /// The picture as JPEG.
    pub jpeg: Vec<u8>,
}

/// Draws `track` into its video: at most `most` frames in which the ball is seen, evenly chosen, come back; all frames are
/// written to `video` where one is given, at the rate at which they were taken, no faster than 60 a second.
///
/// # Errors
/// Of reading the video again; [`Error::File`] where `video` cannot be written.
pub fn overlay(
    source: &Source,
    track: &Track,
    most: usize,
    video: Option<&Path>,
    progress: &mut dyn FnMut(usize, Option<usize>),
) -> Result<Vec<Drawn>> {
    let chosen = chosen(&track.sightings, most);
    let mut writer: Option<VideoWriter> = None;
    let mut drawn = Vec::new();
    let mut refused = None;
    source.stream(track.frames, &mut |index, _, mut image, _| {
        progress(index + 1, Some(track.frames));
        let wanted = chosen.iter().find(|s| s.frame == index);
        if wanted.is_none() && video.is_none() {
            return Ok(vec![image]);
        }
        draw(&mut image, track, index)?;
        if let Some(sighting) = wanted {
            drawn.push(picture(&image, index, sighting.time_s)?);
        }
        if let Some(path) = video.filter(|_| refused.is_none()) {
            if writer.is_none() {
                writer = open(path, track.rate_hz, image.size()?)?;
            }
            match &mut writer {
                Some(writer) => writer.write(&image)?,
                None => refused = Some(path),
            }
        }
        Ok(vec![image])
    })?;
    if let Some(path) = refused {
        let message = "expected a video that OpenCV can write, found none for this name";
        return Err(Error::file(path, message, "end the name in .mp4 or .avi, in a folder that exists"));
    }
    if let (Some(mut writer), Some(path)) = (writer, video) {
        let failed = |e: opencv::Error| Error::file(path, format!("writing the video failed: {}", e.message), "");
        writer.release().map_err(failed)?;
    }
    Ok(drawn)
}

/// At most `most` of the first `frames` frames as they are, evenly chosen, for videos in which no ball is found.
///
/// # Errors
/// Of reading the video again.
pub fn plain(source: &Source, frames: usize, most: usize) -> Result<Vec<Drawn>> {
    let count = most.min(frames);
    let wanted: Vec<usize> = (0..count).map(|i| i * (frames - 1) / (count - 1).max(1)).collect();
    let mut pictures = Vec::new();
    source.stream(frames, &mut |index, time_s, image, _| {
        if wanted.contains(&index) {
            pictures.push(picture(&image, index, time_s)?);
        }
        Ok(vec![image])
    })?;
    Ok(pictures)
}

fn chosen(sightings: &[Sighting], most: usize) -> Vec<Sighting> {
    let count = most.min(sightings.len());
    (0..count).map(|i| sightings[i * (sightings.len() - 1) / (count - 1).max(1)]).collect()
}

fn open(path: &Path, rate_hz: f64, size: Size) -> opencv::Result<Option<VideoWriter>> {
    let avi = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("avi"));
    let codec = if avi { VideoWriter::fourcc('M', 'J', 'P', 'G')? } else { VideoWriter::fourcc('m', 'p', '4', 'v')? };
    let Some(name) = path.to_str() else { return Ok(None) };
    let writer = VideoWriter::new(name, codec, rate_hz.clamp(1.0, 60.0), size, true)?;
    Ok(writer.is_opened()?.then_some(writer))
}

fn picture(image: &Mat, frame: usize, time_s: f64) -> opencv::Result<Drawn> {
    let longer = image.cols().max(image.rows());
    let mut small = Mat::default();
    if longer > SHEET_PX {
        let factor = f64::from(SHEET_PX) / f64::from(longer);
        resize(image, &mut small, Size::default(), factor, factor, INTER_AREA)?;
    } else {
        small = image.try_clone()?;
    }
    let mut bytes = Vector::<u8>::new();
    imencode(".jpg", &small, &mut bytes, &Vector::from_slice(&[IMWRITE_JPEG_QUALITY, QUALITY]))?;
    let size_px = (small.cols(), small.rows());
    Ok(Drawn { frame, time_s, size_px, jpeg: bytes.as_slice().to_vec() })
}

/// Draws the ball of one frame and where it came from, in a colour that is not the ball's: a thick circle where the whole
/// ball is seen, a thin one where the border cuts it.
fn draw(image: &mut Mat, track: &Track, frame: usize) -> opencv::Result<()> {
    let sightings = &track.sightings;
    let colour = opposite(&track.colour);
    let until = sightings.partition_point(|s| s.frame <= frame);
    let width = (image.cols().max(image.rows()) / 480).max(1);
    let trail = &sightings[until.saturating_sub(TRAIL)..until];
    for pair in trail.windows(2) {
        line(image, place(&pair[0]), place(&pair[1]), colour, width, LINE_AA, SHIFT)?;
    }
    let Some(now) = trail.last().filter(|s| s.frame == frame) else { return Ok(()) };
    let thick = if now.cut { width } else { 2 * width + 1 };
    circle(image, place(now), fixed(now.radius_px).max(1), colour, thick, LINE_AA, SHIFT)?;
    circle(image, place(now), fixed(f64::from(width)), colour, -1, LINE_AA, SHIFT)
}

/// The full colour farthest from the ball's, as blue, green, red. White, which has no hue, gets magenta.
fn opposite(ball: &Window) -> Scalar {
    let hueless = ball.half_width >= HUES / 2;
    let sixths = f64::from(if hueless { 150 } else { (ball.hue + HUES / 2).rem_euclid(HUES) }) / 30.0;
    // How much each channel has at this place of the circle: red is full at 0, green at 2, blue at 4 sixths.
    let channel = |full: f64| {
        let away = (sixths - full).rem_euclid(6.0);
        255.0 * (2.0 - away.min(6.0 - away)).clamp(0.0, 1.0)
    };
    Scalar::new(channel(4.0), channel(2.0), channel(0.0), 0.0)
}

fn place(sighting: &Sighting) -> Point {
    Point::new(fixed(sighting.u_px), fixed(sighting.v_px))
}

#[expect(clippy::cast_possible_truncation, reason = "the cast saturates")]
fn fixed(px: f64) -> i32 {
    (px * f64::from(1 << SHIFT)).round().clamp(-1e6, 1e6) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_drawing_is_of_the_opposite_colour() {
        let drawn = |name: &str| opposite(&Window::parse(name).unwrap()).0;
        assert_eq!(drawn("red"), [255.0, 255.0, 0.0, 0.0]);
        assert_eq!(drawn("green"), [255.0, 0.0, 255.0, 0.0]);
        assert_eq!(drawn("white"), [255.0, 0.0, 255.0, 0.0]);
        let [blue, _, red, _] = drawn("blue");
        assert!(blue == 0.0 && red == 255.0);
    }
}

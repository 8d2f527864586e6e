//! Videos of discs, drawn for the tests of this crate.

use std::path::Path;

use opencv::core::{CV_8UC3, Mat, MatTraitConst, MatTraitManual, Rect, Scalar, Size};
use opencv::imgproc::{FILLED, LINE_8, rectangle};
use opencv::videoio::{VideoWriter, VideoWriterTrait};

/// What is drawn.
pub(crate) struct DrawnVideo {
    /// Colours of the discs (blue, green, red), 60 px apart.
    pub balls: Vec<[f64; 3]>,
    /// Colour of a poster in the middle of the wall.
    pub poster: Option<[f64; 3]>,
    /// How far the camera shakes, px.
    pub shake_px: f64,
    /// Frames that are written twice.
    pub repeat: Vec<usize>,
    /// Speed to the right.
    pub speed_px_s: f64,
    pub frames: usize,
    pub size: (i32, i32),
    pub radius_px: f64,
}

impl Default for DrawnVideo {
    fn default() -> Self {
        Self {
            balls: Vec::new(),
            poster: None,
            shake_px: 0.0,
            repeat: Vec::new(),
            speed_px_s: 150.0,
            frames: 60,
            size: (320, 240),
            radius_px: 12.0,
        }
    }
}

/// Writes a video of discs that fall and bounce before a grey wall at 60 frames per second: where the first one's centre is
/// in each frame, px.
pub(crate) fn draw_discs(path: &Path, video: &DrawnVideo) -> Vec<(f64, f64)> {
    let codec = VideoWriter::fourcc('M', 'J', 'P', 'G').unwrap();
    let size = Size::new(video.size.0, video.size.1);
    let mut writer = VideoWriter::new(path.to_str().unwrap(), codec, 60.0, size, true).unwrap();
    let mut centres = Vec::new();
    for i in 0..video.frames {
        let t = i as f64 / 60.0;
        let shake = video.shake_px * (2.3 * i as f64).sin();
        let (u, v) = (60.3 + video.speed_px_s * t + shake, 40.0 + 160.0 * (1.0 - (3.0 * t).cos().abs()));
        let frame = drawn(video, (u, v), shake);
        for _ in 0..=usize::from(video.repeat.contains(&i)) {
            writer.write(&frame).unwrap();
            centres.push((u, v));
        }
    }
    writer.release().unwrap();
    centres
}

#[expect(clippy::cast_possible_truncation, reason = "small numbers")]
fn drawn(video: &DrawnVideo, (u, v): (f64, f64), shake: f64) -> Mat {
    let (width, height) = video.size;
    let wall = Scalar::new(120.0, 125.0, 122.0, 0.0);
    let mut frame = Mat::new_rows_cols_with_default(height, width, CV_8UC3, wall).unwrap();
    let scalar = |[b, g, r]: [f64; 3]| Scalar::new(b, g, r, 0.0);
    if video.shake_px > 0.0 {
        // Stripes, so that a camera that moves is seen to.
        for x in (-40..width + 40).step_by(16) {
            let stripe = Rect::new(x + shake.round() as i32, 0, 8, height);
            rectangle(&mut frame, stripe, Scalar::all(60.0), FILLED, LINE_8, 0).unwrap();
        }
    }
    if let Some(colour) = video.poster {
        rectangle(&mut frame, Rect::new(90, 60, 110, 110), scalar(colour), FILLED, LINE_8, 0).unwrap();
    }
    for (k, colour) in video.balls.iter().enumerate() {
        disc(&mut frame, (u + 60.0 * k as f64, v), video.radius_px, *colour);
    }
    frame
}

/// Draws a disc that covers each pixel by its area in it (16 × 16 points). OpenCV's own smooth discs are half a pixel too
/// large.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small numbers")]
pub(crate) fn disc(frame: &mut Mat, (u, v): (f64, f64), radius: f64, colour: [f64; 3]) {
    let columns = frame.cols() as usize;
    for (i, pixel) in frame.data_bytes_mut().unwrap().chunks_exact_mut(3).enumerate() {
        let (column, row) = ((i % columns) as f64, (i / columns) as f64);
        let away = (column - u).hypot(row - v);
        if away > radius + 1.0 {
            continue;
        }
        let points = (0..256).map(|k| (f64::from(k % 16), f64::from(k / 16)));
        let inside = points.filter(|(a, b)| {
            let (x, y) = (column - 0.5 + (a + 0.5) / 16.0, row - 0.5 + (b + 0.5) / 16.0);
            (x - u).hypot(y - v) < radius
        });
        let share = inside.count() as f64 / 256.0;
        for (value, ball) in pixel.iter_mut().zip(colour) {
            let behind = f64::from(*value);
            *value = (behind + share * (ball - behind)).round() as u8;
        }
    }
}

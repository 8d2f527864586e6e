//! Where the ball is in one frame, to a fraction of a pixel.

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Rect, Size};
use opencv::imgproc::{COLOR_BGR2HSV, INTER_AREA, INTER_LINEAR, cvt_color_def, resize};

use super::blob::{Blob, blobs};
use super::circle::circle_through;
use super::scout::{MOVED, ROUND, Scene, difference};

/// A second patch of at least this share of the first one's area is a second ball.
const SECOND_BALL: f64 = 0.5;

/// The ball in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Which frame, from 0.
    pub frame: usize,
    /// When it was taken, s.
    pub time_s: f64,
    /// The centre, px to the right from the centre of the first pixel.
    pub u_px: f64,
    /// The centre, px downwards.
    pub v_px: f64,
    /// The radius of a disc of the same area, px.
    pub radius_px: f64,
    /// Whether the frame's border cuts the ball.
    pub cut: bool,
    /// How much it looks like the ball, 0 to 1: how well it fills a disc, and how near its size is to the usual one.
    pub confidence: f64,
    /// Whether something else in the frame looks alike.
    pub(crate) second: bool,
}

/// Reduces `frame` so that its longer side has at most `limit` px; the factor.
pub(crate) fn reduced(frame: &Mat, limit: i32) -> opencv::Result<(Mat, f64)> {
    let longer = frame.cols().max(frame.rows());
    if longer <= limit {
        return Ok((frame.clone(), 1.0));
    }
    let factor = f64::from(limit) / f64::from(longer);
    let mut small = Mat::default();
    resize(frame, &mut small, Size::default(), factor, factor, INTER_AREA)?;
    Ok((small, factor))
}

/// Looks for the ball of `scene` in `frame`, whose reduced picture is `small`.
pub(crate) fn look(scene: &Scene, frame: &Mat, small: &Mat, factor: f64) -> opencv::Result<Option<Sighting>> {
    let background = scene.clutter.then_some(&scene.background);
    let mut found = blobs(&mask(scene, small, background)?)?;
    // Crumbs of noise are no ball, but a ball that is half out of view still is.
    found.retain(|b| b.area >= (0.05 * scene.area).max(3.0));
    let round = |b: &Blob| ROUND.contains(&b.fill()) || touches(b.bounds, small.cols(), small.rows());
    let Some(coarse) = found.iter().find(|b| round(b)).or(found.first()) else { return Ok(None) };
    let second = found.iter().filter(|b| round(b) && b.area > SECOND_BALL * coarse.area).count() > 1;
    let Some(roi) = enlarged(coarse.bounds, factor, frame.cols(), frame.rows()) else { return Ok(None) };
    let crop = Mat::roi(frame, roi)?.try_clone()?;
    // The background is only known small.
    let behind = match background {
        Some(small) => Some(crop_of(small, roi, factor)?),
        None => None,
    };
    let mask = mask(scene, &crop, behind.as_ref())?;
    let Some(fine) = blobs(&mask)?.into_iter().next() else { return Ok(None) };
    let at = [fine.bounds[0] + roi.x, fine.bounds[1] + roi.y, fine.bounds[2], fine.bounds[3]];
    let cut = touches(at, frame.cols(), frame.rows());
    let outline = circle_through(&mask, (frame.cols(), frame.rows()), (roi.x, roi.y))?;
    let (u, v, radius) = match outline {
        Some(circle) if cut => (circle.u, circle.v, circle.radius),
        Some(circle) => (circle.centroid_u, circle.centroid_v, circle.area_radius),
        None => (fine.u, fine.v, (fine.area / std::f64::consts::PI).sqrt()),
    };
    let fill = if cut { 0.5 } else { (1.0 - (fine.fill() - 1.0).abs()).clamp(0.0, 1.0) };
    Ok(Some(Sighting {
        frame: 0,
        time_s: 0.0,
        u_px: u + f64::from(roi.x),
        v_px: v + f64::from(roi.y),
        radius_px: radius,
        cut,
        confidence: fill,
        second,
    }))
}

/// The pixels of the ball's colour that are not background.
fn mask(scene: &Scene, picture: &Mat, background: Option<&Mat>) -> opencv::Result<Mat> {
    let (mut hsv, mut mask, mut spare) = (Mat::default(), Mat::default(), Mat::default());
    cvt_color_def(picture, &mut hsv, COLOR_BGR2HSV)?;
    scene.window.mark(&hsv, &mut mask, &mut spare)?;
    if let Some(background) = background {
        let moved = difference(picture.data_bytes()?, background.data_bytes()?);
        for (inside, moved) in mask.data_bytes_mut()?.iter_mut().zip(moved) {
            if moved <= MOVED {
                *inside = 0;
            }
        }
    }
    Ok(mask)
}

fn touches([left, top, width, height]: [i32; 4], columns: i32, rows: i32) -> bool {
    left <= 0 || top <= 0 || left + width >= columns || top + height >= rows
}

/// The box of a small blob in the full frame, with room around it.
#[expect(clippy::cast_possible_truncation, reason = "pixels of a picture")]
fn enlarged([left, top, width, height]: [i32; 4], factor: f64, columns: i32, rows: i32) -> Option<Rect> {
    let room = 0.35 * f64::from(width.max(height)) + 2.0;
    let low = |edge: i32| ((f64::from(edge) - room) / factor).floor().max(0.0) as i32;
    let high = |edge: i32, most: i32| (((f64::from(edge) + room) / factor).ceil() as i32).min(most);
    let (x, y) = (low(left), low(top));
    let (right, bottom) = (high(left + width, columns), high(top + height, rows));
    (right > x && bottom > y).then(|| Rect::new(x, y, right - x, bottom - y))
}

/// The part of the small background behind `roi`, enlarged to its size.
#[expect(clippy::cast_possible_truncation, reason = "pixels of a picture")]
fn crop_of(small: &Mat, roi: Rect, factor: f64) -> opencv::Result<Mat> {
    let scaled = |value: i32| f64::from(value) * factor;
    let x = (scaled(roi.x).floor() as i32).clamp(0, small.cols() - 1);
    let y = (scaled(roi.y).floor() as i32).clamp(0, small.rows() - 1);
    let right = (scaled(roi.x + roi.width).ceil() as i32).clamp(x + 1, small.cols());
    let bottom = (scaled(roi.y + roi.height).ceil() as i32).clamp(y + 1, small.rows());
    let part = Mat::roi(small, Rect::new(x, y, right - x, bottom - y))?.try_clone()?;
    let mut large = Mat::default();
    resize(&part, &mut large, Size::new(roi.width, roi.height), 0.0, 0.0, INTER_LINEAR)?;
    Ok(large)
}

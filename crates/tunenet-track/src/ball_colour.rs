//! Finding out what to look for: the one saturated thing that moves before a still background.

use opencv::core::{Mat, MatTraitConst, MatTraitConstManual, MatTraitManual, Size};
use opencv::imgproc::{COLOR_BGR2HSV, blur_def, cvt_color_def};
use rayon::prelude::*;
use tunenet_core::statistics::{median, range};
use tunenet_video_protocol::track::TrackFailure;

use super::blob::{Blob, blobs};
use super::colour::{BLACK, HUES, WHITE, Window};
use super::lookup::Lookup;
use super::stillness::{MOVED, moves};

/// Frames that make the background: the median of so many is not affected by moving objects.
const BACKGROUND_FRAMES: usize = 31;
/// Bytes whose medians are taken together.
const SIDE_BY_SIDE: usize = 512;
/// As [`MOVED`], while the colour is still unknown.
const MOVED_CLEARLY: u8 = 30;
/// Saturation and value from which a hue means something.
const SATURATED: (u8, u8) = (70, 40);
/// Hues this near are one colour, on OpenCV's circle of 180.
const ONE_COLOUR: i32 = 12;
/// Colours that are tried.
const MOST_COLOURS: usize = 4;
/// A frame in which more than this share of the pixels moved is not seen by a still camera.
const STILL_SHARE: f64 = 0.3;
/// A ball without a hue is seen in more than this share of the pictures.
const PALE_SHARE: f64 = 0.5;
/// Weight of objects that never fall relative to those that do.
const LEVEL: f64 = 0.2;
/// A blob rounder than this fills its box as a disc does.
pub(crate) const ROUND: std::ops::Range<f64> = 0.55..1.4;

/// What to look for, and before what.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The ball's colour.
    pub window: Window,
    /// The still background in blue, green, red; as small as the frames that were examined.
    pub(crate) background: Mat,
    /// Whether the background itself holds the ball's colour, so that colour alone does not identify it.
    pub clutter: bool,
    /// Median area of the ball, as a share of the picture.
    pub(crate) area_share: f64,
    /// The share of the examined frames in which it was seen.
    pub(crate) seen_share: f64,
}

/// Examines `frames`, small pictures of the whole video in blue, green and red, for the ball, of colour `window` where that is
/// known.
///
/// # Errors
/// Where OpenCV fails.
pub fn detect_ball(frames: &[Mat], window: Option<Window>) -> opencv::Result<Result<Scene, TrackFailure>> {
    // Motion is detected in pictures with less noise; colours are the ball's own.
    let smooth: Vec<Mat> = frames.par_iter().map(smoothed).collect::<opencv::Result<_>>()?;
    let background = median_picture(frames)?;
    let behind = median_picture(&smooth)?;
    let still = behind.data_bytes()?;
    let hsv: Vec<Mat> = frames.par_iter().map(to_hsv).collect::<opencv::Result<_>>()?;
    let moved: Vec<Vec<u8>> =
        smooth.par_iter().map(|f| Ok(difference(f.data_bytes()?, still))).collect::<opencv::Result<_>>()?;
    let shares = moved.iter().map(|m| m.iter().filter(|d| **d > MOVED_CLEARLY).count() as f64 / m.len() as f64);
    if median(shares).is_some_and(|share| share > STILL_SHARE) || moves(&smooth)? {
        return Ok(Err(TrackFailure::CameraMoves));
    }
    let candidates = match window {
        Some(window) => vec![window],
        None => colours(&hsv, &moved)?,
    };
    let mut best = likeliest(frames, &moved, &candidates)?;
    if best.is_none() && window.is_none() {
        // Without a hue the ball is identified by its brightness only, so it has to be seen in most pictures.
        best = likeliest(frames, &moved, &[WHITE, BLACK])?.filter(|(.., share)| *share > PALE_SHARE);
    }
    let Some((_, wide, area, seen_share)) = best else { return Ok(Err(TrackFailure::NoBall)) };
    let saturated = window.is_none() && wide != WHITE && wide != BLACK;
    let window = if saturated { narrowed(&hsv, &moved, wide)? } else { wide };
    let clutter = clutter(&background, &window, area)?;
    let area_share = area / f64::from(background.cols() * background.rows());
    Ok(Ok(Scene { window, background, clutter, area_share, seen_share }))
}

/// The window whose patches look most like one ball on its way: merit, window, median area, and the share of the pictures in
/// which it is seen.
fn likeliest(
    frames: &[Mat],
    moved: &Vec<Vec<u8>>,
    candidates: &[Window],
) -> opencv::Result<Option<(f64, Window, f64, f64)>> {
    let mut best: Option<(f64, Window, f64, f64)> = None;
    for &window in candidates {
        // A ball that lies long in one place is background there, and only its colour identifies it; where the background
        // holds the colour, only motion does.
        for moved in [None, Some(moved)] {
            let seen = sightings(frames, moved, &window)?;
            let Some((merit, area)) = merit(&seen, frames.len()) else { continue };
            if best.as_ref().is_none_or(|b| merit > b.0) {
                let share = seen.iter().flatten().count() as f64 / frames.len() as f64;
                best = Some((merit, window, area, share));
            }
        }
    }
    Ok(best)
}

fn smoothed(frame: &Mat) -> opencv::Result<Mat> {
    let mut smooth = Mat::default();
    blur_def(frame, &mut smooth, Size::new(3, 3))?;
    Ok(smooth)
}

/// The median of each pixel over at most [`BACKGROUND_FRAMES`] frames.
fn median_picture(frames: &[Mat]) -> opencv::Result<Mat> {
    let count = frames.len().min(BACKGROUND_FRAMES);
    let chosen: Vec<&[u8]> =
        (0..count).map(|i| frames[i * frames.len() / count].data_bytes()).collect::<opencv::Result<_>>()?;
    let mut background = frames[0].clone();
    for (i, out) in background.data_bytes_mut()?.chunks_mut(SIDE_BY_SIDE).enumerate() {
        let place = i * SIDE_BY_SIDE..i * SIDE_BY_SIDE + out.len();
        medians(&chosen.iter().map(|frame| &frame[place.clone()]).collect::<Vec<_>>(), out);
    }
    Ok(background)
}

/// The upper median of each byte over the layers of `stack`, at most 255 of them and each as long as `out`.
///
/// Bit by bit from the highest, for many bytes side by side: no layer is sorted.
fn medians(stack: &[&[u8]], out: &mut [u8]) {
    let above = u8::try_from(stack.len() - stack.len() / 2).unwrap_or(u8::MAX);
    out.fill(0);
    for bit in (0..8).rev() {
        let mut counts = [0u8; SIDE_BY_SIDE];
        for layer in stack {
            for ((count, value), known) in counts.iter_mut().zip(*layer).zip(out.iter()) {
                *count += u8::from(*value >= known | 1 << bit);
            }
        }
        for (known, count) in out.iter_mut().zip(&counts) {
            *known |= u8::from(*count >= above) << bit;
        }
    }
}

fn to_hsv(frame: &Mat) -> opencv::Result<Mat> {
    let mut hsv = Mat::default();
    cvt_color_def(frame, &mut hsv, COLOR_BGR2HSV)?;
    Ok(hsv)
}

/// The greatest difference of the three channels, per pixel.
pub(crate) fn difference(a: &[u8], b: &[u8]) -> Vec<u8> {
    a.chunks_exact(3)
        .zip(b.chunks_exact(3))
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0))
        .collect()
}

/// The colours of what moves, the strongest first.
fn colours(hsv: &[Mat], moved: &[Vec<u8>]) -> opencv::Result<Vec<Window>> {
    let mut histogram = [0.0; HUES as usize];
    for (hsv, moved) in hsv.iter().zip(moved) {
        for (pixel, moved) in hsv.data_bytes()?.chunks_exact(3).zip(moved) {
            if *moved > MOVED_CLEARLY && pixel[1] > SATURATED.0 && pixel[2] > SATURATED.1 {
                histogram[usize::from(pixel[0]) % histogram.len()] += f64::from(pixel[1]);
            }
        }
    }
    let hues = histogram.len();
    let around = |h: usize, reach: usize| (0..=2 * reach).map(move |d| (h + hues - reach + d) % hues);
    let mut smooth: Vec<f64> = (0..histogram.len()).map(|h| around(h, 5).map(|i| histogram[i]).sum()).collect();
    let mut found = Vec::new();
    let mut greatest = 0.0;
    for _ in 0..MOST_COLOURS {
        let Some(peak) = (0..smooth.len()).max_by(|a, b| smooth[*a].total_cmp(&smooth[*b])) else { break };
        greatest = f64::max(greatest, smooth[peak]);
        if smooth[peak] <= 0.02 * greatest {
            break;
        }
        found.push(Window {
            hue: i32::try_from(peak).unwrap_or(0),
            half_width: ONE_COLOUR,
            saturation: (i32::from(SATURATED.0) - 10, 255),
            value: (i32::from(SATURATED.1), 255),
        });
        for i in around(peak, 20) {
            smooth[i] = 0.0;
        }
    }
    Ok(found)
}

/// The largest blob of this colour in each frame, of what moved where that is given.
fn sightings(frames: &[Mat], moved: Option<&Vec<Vec<u8>>>, window: &Window) -> opencv::Result<Vec<Option<Blob>>> {
    let lookup = Lookup::new(window);
    let largest = |(i, frame): (usize, &Mat)| {
        let mut mask: Vec<bool> =
            frame.data_bytes()?.chunks_exact(3).map(|p| lookup.holds([p[0], p[1], p[2]])).collect();
        if let Some(moved) = moved {
            mask.iter_mut().zip(&moved[i]).for_each(|(own, moved)| *own &= *moved > MOVED);
        }
        Ok(blobs(&mask, usize::try_from(frame.cols()).unwrap_or(1)).into_iter().next())
    };
    frames.par_iter().enumerate().map(largest).collect()
}

/// How much these blobs look like one ball on its way, and their median area. A hand or a shadow is ragged or stays where
/// it is.
fn merit(seen: &[Option<Blob>], frames: usize) -> Option<(f64, f64)> {
    let found: Vec<&Blob> = seen.iter().flatten().collect();
    if found.len() < 3 {
        return None;
    }
    let area = median(found.iter().map(|b| b.area))?;
    let fill = median(found.iter().map(|b| b.fill()))?;
    let (across, down) = (range(found.iter().map(|b| b.u)), range(found.iter().map(|b| b.v)));
    let travel = across.hypot(down) / area.sqrt();
    // Sizes that stay alike from frame to frame.
    let alike = found.iter().filter(|b| (0.4..2.5).contains(&(b.area / area))).count() as f64 / found.len() as f64;
    if !ROUND.contains(&fill) || area < 4.0 || travel < 1.0 || alike < 0.5 {
        return None;
    }
    let share = found.len() as f64 / frames as f64;
    // What only crosses the picture is a person who walks by, not a ball.
    let falls = (2.0 * down / (across + down)).clamp(LEVEL, 1.0);
    Some((share.sqrt() * alike * area.sqrt() * travel.min(10.0) * falls * (1.0 - (fill - 1.0).abs()), area))
}

/// The window that holds nearly all of the ball's own pixels.
fn narrowed(hsv: &[Mat], moved: &[Vec<u8>], wide: Window) -> opencv::Result<Window> {
    let (mut away, mut saturations, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for (hsv, moved) in hsv.iter().zip(moved) {
        for (pixel, moved) in hsv.data_bytes()?.chunks_exact(3).zip(moved) {
            if *moved > MOVED && wide.holds([pixel[0], pixel[1], pixel[2]]) {
                away.push((i32::from(pixel[0]) - wide.hue + HUES / 2).rem_euclid(HUES) - HUES / 2);
                saturations.push(i32::from(pixel[1]));
                values.push(i32::from(pixel[2]));
            }
        }
    }
    if away.is_empty() {
        return Ok(wide);
    }
    let share = |all: &mut Vec<i32>, share: f64| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
        let at = ((all.len() - 1) as f64 * share) as usize;
        *all.select_nth_unstable(at).1
    };
    let (low, high) = (share(&mut away, 0.05), share(&mut away, 0.95));
    // Blurred edges mix with the background: they are paler and a little off in hue.
    Ok(Window {
        hue: (wide.hue + i32::midpoint(low, high)).rem_euclid(HUES),
        half_width: ((high - low) / 2 + 6).min(2 * ONE_COLOUR),
        saturation: ((share(&mut saturations, 0.1) * 2 / 3).max(50), 255),
        value: ((share(&mut values, 0.1) / 2).max(30), 255),
    })
}

/// Whether the background holds the colour somewhere other than in a ball that rests there.
fn clutter(background: &Mat, window: &Window, area: f64) -> opencv::Result<bool> {
    let lookup = Lookup::new(window);
    let mask: Vec<bool> = background.data_bytes()?.chunks_exact(3).map(|p| lookup.holds([p[0], p[1], p[2]])).collect();
    let resting = |b: &Blob| (0.4..2.5).contains(&(b.area / area)) && ROUND.contains(&b.fill());
    Ok(blobs(&mask, usize::try_from(background.cols()).unwrap_or(1))
        .iter()
        .any(|b| b.area > 0.02 * area && !resting(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn medians_are_those_of_sorted_values(stack in prop::collection::vec(prop::collection::vec(any::<u8>(), 7), 1..40)) {
            let mut found = [9; 7];
            medians(&stack.iter().map(Vec::as_slice).collect::<Vec<_>>(), &mut found);
            for (i, median) in found.into_iter().enumerate() {
                let mut column: Vec<u8> = stack.iter().map(|layer| layer[i]).collect();
                column.sort_unstable();
                prop_assert_eq!(median, column[stack.len() / 2]);
            }
        }
    }
}

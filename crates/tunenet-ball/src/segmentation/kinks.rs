//! Change-point detection by two-sided slope differences: kinks of a ball's path, tested against noise and gravity.
//!
//! In free flight `w = z + g t²/2` is a straight line, so an impact is a kink of `w` upwards.

use std::ops::Range;

use tunenet_core::observation::noise_sd;
use tunenet_core::statistics::median;

use super::contacts::crossing;
use super::lasting::lasting;
use super::parabolas::parabolas;
use super::polynomial::Polynomial;
use super::span;
use super::stopped_fall::stopped_fall;

/// A slope difference counts as a kink from this many of its standard deviations on. Noise alone reaches it once in
/// 10^9 samples; the weakest impact that can be tuned to has far more.
const KINK_SIGNIFICANCE: f64 = 6.0;
/// ... and from this many times the change of speed that gravity alone makes between the two windows, so that a ball that
/// is held or rests is no impact.
const KINK_OVER_GRAVITY: f64 = 2.5;
/// ... and from this many times the slope difference that the record shows everywhere, so that slow errors of a camera,
/// which third differences do not see, are no impacts either.
const KINK_OVER_TYPICAL: f64 = 4.0;
/// A blow changes the velocity by more than this share of the typical speed; air does not.
const BLOW_SHARE: f64 = 0.3;
/// The kink detector looks at least at this many samples on either side.
const LEAST_WINDOW: f64 = 4.0;
/// Above this Coulomb coefficient a change of horizontal speed is a blow, not friction.
const GREATEST_FRICTION: f64 = 1.2;
/// A rise after a fall is none of the noise from this many times its standard deviation, and this share of all heights, on:
/// the difference of two samples is √2 as noisy as each.
const LATE_RISE: f64 = 6.0 * std::f64::consts::SQRT_2;
const LATE_SHARE: f64 = 0.005;
/// A bounce is late where its lowest sample is one of so many at the end ...
const LATE_SAMPLES: usize = 3;
/// ... and as many are left before it.
const LEAST_BEFORE_LATE: usize = 3;

/// Where the motion kinks.
pub(crate) struct Kinks {
    samples: usize,
    /// Samples at either end in which none can be detected.
    blind: usize,
    /// Impacts on the surface: the flight before ends at this sample, the next begins after it.
    pub(crate) impacts: Vec<usize>,
    /// Anything else that changes the velocity at once: a hand, a racket, another surface.
    blows: Vec<usize>,
}

/// Places where something other than the surface changes the velocity, and what of the record is used because of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Blows {
    /// When, s.
    pub times_s: Vec<f64>,
    /// The samples that no blow disturbs.
    pub used: Range<usize>,
    /// How many samples there are.
    pub samples: usize,
}

impl Kinks {
    pub(crate) fn find(clock: &[f64], axes: &[Vec<f64>; 3], gravity: f64) -> Self {
        let samples = clock.len();
        let without_gravity: Vec<f64> = clock.iter().zip(&axes[2]).map(|(t, z)| z + gravity / 2.0 * t * t).collect();
        let sd = [0, 1, 2].map(|axis| noise_sd(&axes[axis]));
        let half = window(clock, &axes[2], sd[2], gravity);
        if samples < 2 * half + 1 {
            return Self { samples, blind: half, impacts: Vec::new(), blows: Vec::new() };
        }
        let slope = |values: &[f64], range: Range<usize>| {
            Polynomial::fit(&clock[range.clone()], &values[range.clone()], clock[range.start], Some(0.0))
        };
        // Each kink is a local maximum of its slope difference within one window on either side.
        let jump = |values: &[f64], k: usize| -> Option<(f64, f64, f64)> {
            let (before, after) = (slope(values, k + 1 - half..k + 1)?, slope(values, k + 1..k + 1 + half)?);
            let gain = before.slope_gain(clock[k]).hypot(after.slope_gain(clock[k]));
            Some((after.slope(clock[k]) - before.slope(clock[k]), gain, clock[k + half] - clock[k + 1 - half]))
        };
        let range = half - 1..samples - half;
        let profile = |values: &[f64]| -> Vec<(f64, f64, f64)> {
            range.clone().map(|k| jump(values, k).unwrap_or((0.0, 0.0, 0.0))).collect()
        };
        // A ball that is held or lies still falls no more: between two windows its path without gravity bends by gravity times the
        // time from the middle of one to that of the other. That is no error of the camera.
        let centres = half as f64 / (2 * half - 1) as f64;
        // A kink stands out of the noise, of gravity's own bend, and of what the whole record shows.
        let judged = |profile: &[(f64, f64, f64)], sd: f64, (least, supported): (f64, f64)| -> Vec<(f64, bool)> {
            let typical = typical(profile.iter().map(|p| p.0.abs().min((p.0 - supported * p.2).abs())));
            let typical = typical * KINK_OVER_TYPICAL;
            let limit = |&(_, gain, span): &(f64, f64, f64)| {
                (KINK_SIGNIFICANCE * gain * sd).max(KINK_OVER_GRAVITY * gravity * span / 2.0).max(typical).max(least)
            };
            profile.iter().map(|p| (p.0, p.0 > limit(p))).collect()
        };
        let up = judged(&profile(&without_gravity), sd[2], (0.0, gravity * centres));
        let speed = median(range.clone().map(|k| {
            let along = |axis: usize| {
                (axes[axis][k + half] - axes[axis][k + 1 - half]) / (clock[k + half] - clock[k + 1 - half])
            };
            along(0).hypot(along(1)).hypot(along(2))
        }))
        .unwrap_or(0.0);
        let across: Vec<(f64, f64, f64)> =
            profile(&axes[0]).iter().zip(profile(&axes[1])).map(|(x, y)| (x.0.hypot(y.0), x.1, x.2)).collect();
        let across = judged(&across, sd[0].hypot(sd[1]), (BLOW_SHARE * speed, 0.0));
        let peaks = |signal: &[(f64, bool)]| -> Vec<usize> {
            (0..signal.len())
                .filter(|&i| {
                    let near = i.saturating_sub(half)..(i + half + 1).min(signal.len());
                    signal[i].1
                        && near.clone().all(|j| signal[j].0 < signal[i].0 || j >= i && signal[j].0 <= signal[i].0)
                })
                .map(|i| i + range.start)
                .collect()
        };
        let (mut impacts, mut blows) = (Vec::new(), Vec::new());
        let mut surface: Option<f64> = None;
        let (sharp, aside) = (peaks(&up), peaks(&across));
        let lasting =
            lasting(clock, [&axes[0], &axes[1], &without_gravity], &[sharp.as_slice(), &aside].concat(), half);
        let stays = |mut kinks: Vec<usize>| {
            kinks.retain(|k| lasting.contains(k));
            kinks
        };
        let (sharp, aside) = (stays(sharp), stays(aside));
        // A weak rebound, seen by few frames, stands out from nothing; the fewest parabolas still end there.
        let mut places = if sharp.is_empty() { cuts(clock, &axes[2], &range) } else { sharp };
        if places.is_empty() {
            // Fewer still show a drop that ends in rest by gravity alone.
            places.extend(stopped_fall(clock, &axes[2], gravity).filter(|k| range.contains(k)));
        }
        for k in places {
            let lines = (slope(&without_gravity, k + 1 - half..k + 1), slope(&without_gravity, k + 1..k + 1 + half));
            let (Some(before), Some(after)) = lines else { continue };
            let time = crossing(&before, &after, clock[k], clock[k + 1]);
            let height = before.at(time) - gravity / 2.0 * time * time;
            let (fall, rise) = (before.slope(time) - gravity * time, after.slope(time) - gravity * time);
            // What the noise leaves unsure of a speed, and of a height.
            let doubt = 0.5 * KINK_SIGNIFICANCE * sd[2] * before.slope_gain(time).hypot(after.slope_gain(time));
            let slack = KINK_SIGNIFICANCE * sd[2]
                + 0.5 * (fall.abs() + doubt) * (clock[k + 1] - clock[k])
                + 0.02 * span(&axes[2]);
            let level = surface.is_none_or(|s: f64| (height - s).abs() < slack);
            let shift = across[k - range.start].0;
            let unsure =
                0.5 * KINK_SIGNIFICANCE * sd[0].hypot(sd[1]) * before.slope_gain(time).hypot(after.slope_gain(time));
            let rubbed = shift <= GREATEST_FRICTION * (rise - fall) + doubt + unsure;
            let energetic = rise > -0.3 * fall.abs() - doubt && rise < 1.3 * fall.abs() + doubt;
            if fall < doubt && level && rubbed && energetic {
                surface = Some(surface.map_or(height, |s: f64| s.min(height)));
                impacts.push(k);
            } else {
                blows.push(k);
            }
        }
        for k in aside {
            if impacts.iter().chain(&blows).all(|&i| i.abs_diff(k) > half) {
                blows.push(k);
            }
        }
        blows.sort_unstable();
        Self { samples, blind: half, impacts, blows }
    }

    pub(crate) fn all(&self) -> Vec<usize> {
        let mut all: Vec<usize> = self.impacts.iter().chain(&self.blows).copied().collect();
        all.sort_unstable();
        all
    }

    /// The sample at which a first bounce begins that is too near the end for a flight after it: the ball falls to it and
    /// rises after it, which no flight does. The record ends there then, and a seeming kink next to it is not one.
    pub(crate) fn take_late(&mut self, heights: &[f64]) -> Option<usize> {
        let last = heights.len().checked_sub(LATE_SAMPLES).filter(|from| *from >= LEAST_BEFORE_LATE)?;
        let low = (last..heights.len()).min_by(|&a, &b| heights[a].total_cmp(&heights[b]))?;
        let clear = LATE_RISE * noise_sd(heights) + LATE_SHARE * span(heights);
        let highest = heights[low..].iter().fold(f64::NEG_INFINITY, |high, z| high.max(*z));
        let falls = heights[low - 2] > heights[low - 1] && heights[low - 1] > heights[low] + clear;
        let near_end = |k: &usize| k + self.blind + 1 >= low;
        if !falls || highest < heights[low] + clear || !self.impacts.iter().all(near_end) {
            return None;
        }
        let blind = self.blind;
        self.impacts.clear();
        self.blows.retain(|k| k + blind + 1 < low);
        self.samples = low;
        Some(low)
    }

    /// The longest stretch with the most impacts and no blow inside, and the blows, where they exclude samples.
    pub(crate) fn usable(&self, clock: &[f64]) -> (Range<usize>, Option<Blows>) {
        let cuts: Vec<usize> = self.blows.iter().copied().chain([self.samples]).collect();
        let mut best = 0..0;
        let mut best_rank = (0, 0);
        let mut start = 0;
        for &cut in &cuts {
            // A window's width on either side of a blow still feels it.
            let end = if cut == self.samples { cut } else { cut.saturating_sub(1) };
            let impacts = self.impacts.iter().filter(|&&k| k > start && k < end).count();
            let rank = (impacts.min(1), end.saturating_sub(start));
            if end > start && rank > best_rank {
                (best, best_rank) = (start..end, rank);
            }
            start = cut + 2;
        }
        let excludes = best.len() < self.samples && !self.blows.is_empty();
        let blows = excludes.then(|| Blows {
            times_s: self.blows.iter().map(|&k| clock[k]).collect(),
            used: best.clone(),
            samples: self.samples,
        });
        (best, blows)
    }
}

/// The samples of `range` at which one of the fewest parabolas that explain the heights falls and the next does so less.
fn cuts(clock: &[f64], heights: &[f64], range: &Range<usize>) -> Vec<usize> {
    let fit =
        |part: &Range<usize>| Polynomial::fit(&clock[part.clone()], &heights[part.clone()], clock[part.start], None);
    let pieces: Vec<Range<usize>> = parabolas(clock, heights).into_iter().filter(|p| p.len() > 3).collect();
    let mut places = Vec::new();
    for pair in pieces.windows(2) {
        let (Some(before), Some(after)) = (fit(&pair[0]), fit(&pair[1])) else { continue };
        let k = pair[0].end - 1;
        let (falls, then) = (before.slope(clock[k]), after.slope(clock[k]));
        // A release is no kink: its speed does not change.
        let unsure = KINK_SIGNIFICANCE * noise_sd(heights);
        let clear = (then - falls) > 0.5 * falls.abs() + unsure * before.slope_gain(clock[k]);
        // A surface lets nothing fall on.
        let stopped = then > -unsure * after.slope_gain(clock[k]);
        if falls < 0.0 && clear && stopped && range.contains(&k) {
            places.push(k);
        }
    }
    places
}

/// Half the width of the kink detector, in samples: the fewest whose slopes are known to a fourteenth of the speed of a fall
/// through the range of heights seen.
fn window(clock: &[f64], heights: &[f64], sd: f64, gravity: f64) -> usize {
    let step = (clock[clock.len() - 1] - clock[0]) / (clock.len() - 1) as f64;
    let speed = (2.0 * gravity * span(heights)).sqrt();
    // The slope of m even samples has standard deviation sd·√12 / (step · m^1.5).
    let wanted = (12f64.sqrt() * sd * 14.0 / (step * speed).max(f64::MIN_POSITIVE)).powf(2.0 / 3.0).ceil();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let wanted = wanted.clamp(LEAST_WINDOW, 1e6) as usize;
    wanted.min((clock.len() / 6).max(3))
}

/// A standard deviation by the median of absolute values, or by their lower quartile where that is less: in a short record
/// with many kinks, or one that ends in a long rest, half of the windows hold something else than noise.
fn typical(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |place: usize| sorted.get(place).copied().unwrap_or(0.0);
    // Half of a normal distribution's absolute values lie below 0.6745 standard deviations, a quarter below 0.3186.
    (at(sorted.len() / 2) / 0.6745).min(at(sorted.len() / 4) / 0.3186)
}

//! The clock: even or not, frames lost, frames that stand twice, and whether it is quick enough for the motion.

use super::share;
use crate::findings;
use crate::segmentation::span;
use tunenet_core::finding::FindingKind;
use tunenet_core::observation::Check;
use tunenet_core::observation::Observation;
use tunenet_core::observation::{noise_sd, step};
use tunenet_core::statistics::median;

/// Intervals whose range from 5 % to 95 % exceeds this share of their median are uneven; a camera's stamps are within 0.3,
/// rounding to milliseconds included.
const UNEVEN: f64 = 0.5;
/// An interval is a gap from this many medians on.
const GAP: f64 = 1.5;
/// A gap is worth a word from this many lost frames on ...
const LONG_GAP: f64 = 4.0;
/// ... or where this share of all frames is lost.
const LOST_SHARE: f64 = 0.04;
/// Frames in a fall through all heights seen; fewer leave impacts between frames.
const FEWEST_IN_FALL: f64 = 5.0;
/// Two neighbours whose noise is normal fall into one step of the grid with probability step over this many deviations: 2√π.
const SAME_BY_NOISE: f64 = 3.545;
/// Repeats are more than noise explains from this many times the number expected on, and one.
const CHANCES: f64 = 3.0;
/// ... or where the motion across them is this many times the noise.
const CLEAR_OF_NOISE: f64 = 6.0;
/// Longer runs of equal samples are a tracker that stands still, not frames that were written again.
const LONGEST_REPEAT: usize = 4;

fn intervals(clock: &[f64]) -> Vec<f64> {
    clock.windows(2).map(|w| w[1] - w[0]).collect()
}

/// Frames per second by the median interval.
pub(crate) fn rate_hz(clock: &[f64]) -> f64 {
    1.0 / median(intervals(clock)).unwrap_or(0.0)
}

/// Whether the intervals are even, gaps apart.
pub(crate) fn irregular(clock: &[f64]) -> Check {
    const KIND: FindingKind = findings::CLOCK_IRREGULAR;
    let all = intervals(clock);
    let middle = median(all.iter().copied()).unwrap_or(0.0);
    let mut near: Vec<f64> = all.into_iter().filter(|i| *i < GAP * middle).collect();
    near.sort_unstable_by(f64::total_cmp);
    let at = |share: usize| near[near.len() * share / 100];
    let (low, high) = (at(5), at(95));
    if near.len() < 8 {
        return Check::not_run(KIND, "too few intervals");
    }
    if high - low > UNEVEN * middle {
        let text = format!("intervals vary from {:.3} to {:.3} ms about {:.3} ms", low * 1e3, high * 1e3, middle * 1e3);
        return Check::noticed(
            KIND,
            text,
            "stamp frames when they are taken, not when they arrive; correct irregular stamps do no harm",
        );
    }
    Check::passed(KIND, format!("even intervals of {:.3} ms", middle * 1e3))
}

/// Whether frames are missing.
pub(crate) fn gaps(clock: &[f64]) -> Check {
    const KIND: FindingKind = findings::CLOCK_GAPS;
    let all = intervals(clock);
    let middle = median(all.iter().copied()).unwrap_or(0.0);
    let lost = |interval: f64| if interval > GAP * middle { (interval / middle).round() - 1.0 } else { 0.0 };
    let total: f64 = all.iter().map(|i| lost(*i)).sum();
    let (at, longest) = all.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, middle));
    let share = total / (total + clock.len() as f64);
    if lost(longest) >= LONG_GAP || share > LOST_SHARE {
        let text = format!(
            "{total:.0} frames are missing ({:.0} % of the record); the longest gap lasts {longest:.3} s from {:.3} s on",
            100.0 * share,
            clock[at]
        );
        return Check::noticed(KIND, text, "an impact within a gap is lost; record again if there are many gaps");
    }
    Check::passed(
        KIND,
        if total > 0.0 { format!("{total:.0} single frames missing") } else { "no frame is missing".into() },
    )
}

/// Whether there are frames enough between impacts.
pub(crate) fn slow(seen: &Observation, gravity_m_s2: f64) -> Check {
    const KIND: FindingKind = findings::CLOCK_SLOW;
    let heights: Vec<f64> = seen.column(2).collect();
    let fall_s = (2.0 * span(&heights) / gravity_m_s2).sqrt();
    let rate = rate_hz(seen.clock());
    let frames = fall_s * rate;
    if frames < FEWEST_IN_FALL {
        let wanted = 2.0 * FEWEST_IN_FALL / fall_s;
        let text = format!("{rate:.1} Hz leaves {frames:.1} frames for the {fall_s:.3} s of the longest fall");
        return Check::noticed(KIND, text, format!("record at {wanted:.0} Hz or more, or drop from higher up"));
    }
    Check::passed(KIND, format!("{frames:.0} frames in the longest fall"))
}

/// Runs of samples that are equal in every channel that moves, in the midst of motion: first and last sample of each.
pub(crate) fn standing(seen: &Observation) -> Vec<(usize, usize)> {
    let columns: Vec<Vec<f64>> = (0..seen.channels().len()).map(|c| seen.column(c).collect()).collect();
    let moving: Vec<&Vec<f64>> = columns.iter().filter(|c| span(c) > 0.0).collect();
    // Values of few digits are equal by themselves where the motion is slower than the noise.
    let coarse: Vec<f64> = moving
        .iter()
        .map(|c| {
            let (grid, noise) = (step(c), noise_sd(c));
            if grid > 0.1 * noise { 2.0 * grid + 4.0 * noise } else { 1e-6 * span(c) }
        })
        .collect();
    let equal = |i: usize| moving.iter().all(|c| c[i] == c[i - 1]);
    let mut runs = Vec::new();
    let mut i = 1;
    while i < seen.len() {
        let first = i - 1;
        while i < seen.len() && equal(i) {
            i += 1;
        }
        let last = i - 1;
        // A run at either end is a ball that is held, rests, or is lost: others see to that.
        if last > first && first > 0 && last + 1 < seen.len() {
            let moves = moving.iter().zip(&coarse).any(|(c, least)| (c[last + 1] - c[first - 1]).abs() > *least);
            if moves {
                runs.push((first, last));
            }
        }
        i += 1;
    }
    // A few may be noise, which repeats a value where the motion is slower than it. Where the motion is not, it cannot.
    let same = |c: &&Vec<f64>| (step(c) / (SAME_BY_NOISE * noise_sd(c)).max(f64::MIN_POSITIVE)).min(1.0);
    let expected = seen.len() as f64 * moving.iter().map(same).product::<f64>();
    if runs.len() as f64 <= CHANCES * (1.0 + expected) {
        let clearly = |c: &&Vec<f64>, (first, last): (usize, usize)| {
            (c[last + 1] - c[first - 1]).abs() > CLEAR_OF_NOISE * noise_sd(c)
        };
        runs.retain(|run| moving.iter().any(|c| clearly(c, *run)));
    }
    runs
}

/// Frames written more than once: the samples to leave out.
pub(crate) fn repeats(seen: &Observation, standing: &[(usize, usize)]) -> (Check, Vec<usize>) {
    const KIND: FindingKind = findings::CLOCK_REPEATS;
    let out: Vec<usize> =
        standing.iter().filter(|(a, b)| b - a < LONGEST_REPEAT).flat_map(|(a, b)| a + 1..b + 1).collect();
    let Some(first) = out.first() else {
        return (Check::passed(KIND, "no frame stands twice"), out);
    };
    let every = if out.len() * 3 > seen.len() { "every second frame or so" } else { "frames" };
    let (share, at_s) = (share(out.len(), seen.len()), seen.clock()[*first]);
    let text = format!("{} repeated frames left out ({every}; {share}), the first at {at_s:.3} s", out.len());
    (Check::noticed(KIND, text, "save the video at the rate at which it was taken"), out)
}

/// Long runs of equal samples: the samples after each first one.
pub(crate) fn frozen(standing: &[(usize, usize)]) -> Vec<(usize, usize)> {
    standing.iter().copied().filter(|(a, b)| b - a >= LONGEST_REPEAT).collect()
}

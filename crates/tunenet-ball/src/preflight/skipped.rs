//! Frames that are missing although the stamps are even: in flight, the motion leaps by what it does in whole frames.

use std::ops::Range;
use tunenet_core::finding::FindingKind;

use nalgebra::{Matrix4, Vector4};

use crate::findings;
use crate::segmentation::parabolas::{MOST_SAMPLES, parabolas};
use crate::segmentation::polynomial::Polynomial;
use crate::segmentation::span;
use tunenet_core::observation::Check;
use tunenet_core::observation::{Observation, noise_sd};
use tunenet_core::statistics::median;

const KIND: FindingKind = findings::CLOCK_SKIPPED;
/// A ball that turns upwards by more than this share of the fastest fall has bounced.
const BOUNCES_SHARE: f64 = 0.1;
/// ... in addition to this many times the uncertainty from noise of the turn.
const UNSURE: f64 = 3.0;
/// What falls by less than this share of gravity is held.
const FALLS_SHARE: f64 = 0.5;
/// A flight covers at least this share of all heights: small hops in a row look like anything.
const LEAST_SHARE: f64 = 0.1;
/// Fewest samples of a flight that is looked at, and most, since the time grows with their square.
const SAMPLES: std::ops::Range<usize> = 12..600;
/// Fewest samples on either side of a leap.
const MARGIN: usize = 3;
/// Most frames that one leap skips, and most leaps of one flight.
const MOST_FRAMES: usize = 4;
const MOST_LEAPS: usize = 8;
/// A leap must raise the log-likelihood by half of this over a smooth flight: a Bayes factor beyond e^12.
const EVIDENCE: f64 = 25.0;
/// A flight that strays from a cubic by less than this many times the noise leaps nowhere.
const NOISE_ALONE: f64 = 1.2;
/// With all leaps taken out, what is left is noise: to this many times its standard deviation, and this share of all heights.
const MISFIT_NOISE: f64 = 2.0;
const MISFIT_SHARE: f64 = 1e-3;
/// An interval from this many usual ones on is a gap that the clock knows of.
const GAP: f64 = 1.5;
/// Nothing is known better than to this share of all heights.
const EXACT_SHARE: f64 = 1e-7;

/// Whether frames were left out and the others stamped as if none was.
pub(crate) fn check(seen: &Observation, gravity_m_s2: f64) -> Check {
    if seen.len() > MOST_SAMPLES {
        return Check::not_run(KIND, "too many samples to search for single missing frames");
    }
    let (clock, heights) = (seen.clock(), seen.column(2).collect::<Vec<f64>>());
    let frame_s = median(clock.windows(2).map(|w| w[1] - w[0])).unwrap_or(0.0);
    let (noise, range) = (noise_sd(&heights), span(&heights));
    let mut leaps: Vec<(usize, usize)> = Vec::new();
    for part in flights(clock, &heights, noise, gravity_m_s2) {
        let flight = Flight { clock: &clock[part.clone()], heights: &heights[part.clone()], frame_s, noise, range };
        leaps.extend(flight.leaps().into_iter().map(|(at, frames)| (part.start + at, frames)));
    }
    let Some(&(first, _)) = leaps.iter().min() else {
        return Check::passed(KIND, "no flight jumps by whole frames");
    };
    let frames: usize = leaps.iter().map(|l| l.1).sum();
    let text = format!(
        "{frames} frame{} missing, although the stamps are even: the flight jumps ahead at {:.3} s{}",
        if frames == 1 { " is" } else { "s are" },
        clock[first],
        if leaps.len() > 1 { format!(" and {} times more", leaps.len() - 1) } else { String::new() }
    );
    Check::noticed(
        KIND,
        text,
        "stamp frames when they are taken; a program that counts frames does not notice a lost one",
    )
}

/// The stretches without a bounce: parabolas whose velocity does not turn upwards from one to the next.
fn flights(clock: &[f64], heights: &[f64], noise: f64, gravity_m_s2: f64) -> Vec<Range<usize>> {
    let turns = BOUNCES_SHARE * (2.0 * gravity_m_s2 * span(heights)).sqrt();
    let mut found: Vec<Range<usize>> = Vec::new();
    let mut before: Option<Polynomial> = None;
    let mut held = false;
    for piece in parabolas(clock, heights) {
        let (time, part) = (&clock[piece.clone()], &heights[piece.clone()]);
        // Pieces that are too short to have a velocity belong to the one before.
        let here = Polynomial::fit(time, part, time[0], None).filter(|_| piece.len() > 3);
        let bounces = before.zip(here).is_some_and(|(a, b)| {
            let unsure = UNSURE * noise * a.slope_gain(time[0]).hypot(b.slope_gain(time[0]));
            b.slope(time[0]) - a.slope(time[0]) > turns + unsure
        });
        match found.last_mut().filter(|_| !bounces && !held) {
            Some(last) => last.end = piece.end,
            None => found.push(piece),
        }
        // A hand that opens bends the motion as a lost frame does.
        held = here.is_some_and(|p| {
            let falls = -(p.slope(time[time.len() - 1]) - p.slope(time[0])) / (time[time.len() - 1] - time[0]);
            falls + 2.0 * UNSURE * noise * p.curvature_gain() < FALLS_SHARE * gravity_m_s2
        });
        before = here.or(before);
    }
    // The samples next to a bounce may belong to the other side.
    let inner = |p: Range<usize>| {
        let (start, end) = (p.start + usize::from(p.start > 0), p.end - usize::from(p.end < clock.len()));
        start..end.max(start)
    };
    let tall = |p: &Range<usize>| span(&heights[p.clone()]) > LEAST_SHARE * span(heights);
    found.into_iter().map(inner).filter(|p| SAMPLES.contains(&p.len()) && tall(p)).collect()
}

/// One stretch without a bounce.
struct Flight<'a> {
    clock: &'a [f64],
    heights: &'a [f64],
    frame_s: f64,
    noise: f64,
    range: f64,
}

impl Flight<'_> {
    /// Where it leaps, and by how many frames; none where leaps do not explain it.
    fn leaps(&self) -> Vec<(usize, usize)> {
        let n = self.clock.len();
        let mut times = self.clock.to_vec();
        let mut left = self.misfit(&times);
        let mut leaps = Vec::new();
        // Nothing is left to explain in most records.
        let smooth = (left / n as f64).sqrt() < NOISE_ALONE * self.noise;
        while !smooth && leaps.len() < MOST_LEAPS {
            let stamped = |at: usize| self.clock[at] - self.clock[at - 1] > GAP * self.frame_s;
            let places = (MARGIN..n - MARGIN).filter(|&at| !stamped(at));
            let tried = places.flat_map(|at| (1..=MOST_FRAMES).map(move |frames| (at, frames)));
            let best = tried
                .map(|(at, frames)| (self.misfit(&self.shifted(&times, at, frames)), at, frames))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((misfit, at, frames)) = best.filter(|b| n as f64 * (left / b.0).ln() > EVIDENCE) else { break };
            times = self.shifted(&times, at, frames);
            left = misfit;
            leaps.push((at, frames));
        }
        let explained = (left / n as f64).sqrt() < MISFIT_NOISE * self.noise + MISFIT_SHARE * self.range;
        if explained { leaps } else { Vec::new() }
    }

    /// The times as they would be had so many frames been left out before sample `at`.
    fn shifted(&self, times: &[f64], at: usize, frames: usize) -> Vec<f64> {
        let later = frames as f64 * self.frame_s;
        times.iter().enumerate().map(|(i, t)| if i < at { *t } else { t + later }).collect()
    }

    /// The sum of squares that a cubic leaves: air bends a parabola, and must not pass for a leap.
    fn misfit(&self, times: &[f64]) -> f64 {
        let (first, last) = (times[0], times[times.len() - 1]);
        let row = |t: f64| {
            let u = 2.0 * (t - first) / (last - first) - 1.0;
            Vector4::new(1.0, u, u * u, u * u * u)
        };
        let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
        for (&t, &z) in times.iter().zip(self.heights) {
            let row = row(t);
            normal += row * row.transpose();
            right += row * (z - self.heights[0]);
        }
        let floor = times.len() as f64 * (EXACT_SHARE * self.range).powi(2);
        let Some(inverse) = normal.try_inverse() else { return f64::INFINITY };
        let solution = inverse * right;
        let left = |(&t, &z): (&f64, &f64)| (z - self.heights[0] - row(t).dot(&solution)).powi(2);
        times.iter().zip(self.heights).map(left).sum::<f64>().max(floor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use tunenet_core::observation::State;

    /// A drop of 1 m with a rebound, at 60 Hz with 1 mm of noise, of which `lost` frames are left out.
    fn record(lost: &[usize]) -> Observation {
        let mut draw = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let fall = (2.0f64 / 9.81).sqrt();
        let height = |t: f64| {
            let s = t - fall;
            if s < 0.0 { 1.0 - 4.905 * t * t } else { 0.8 * 9.81 * fall * s - 4.905 * s * s }
        };
        let rows: Vec<[f64; 3]> = (0..64)
            .filter(|i| !lost.contains(i))
            .map(|i| [0.0, 0.0, height(i as f64 / 60.0) + 1e-3 * draw.sample::<f64, _>(rand_distr::StandardNormal)])
            .collect();
        let clock = (0..rows.len()).map(|i| i as f64 / 60.0).collect();
        Observation::positions(clock, &rows).unwrap()
    }

    #[test]
    fn frames_that_the_stamps_do_not_miss_are_found() {
        for (lost, found) in [(&[15][..], "1 frame is"), (&[14, 15], "2 frames are"), (&[15, 40], "2 frames are")] {
            let check = check(&record(lost), 9.81);
            assert!(check.state == State::Noticed && check.text.starts_with(found), "{lost:?}: {check:?}");
        }
    }

    #[test]
    fn a_whole_record_leaps_nowhere() {
        assert_eq!(check(&record(&[]), 9.81).state, State::Passed);
        // What the clock knows of is no leap.
        let whole = record(&[]);
        let gap = whole.without(&[14, 15, 16]).unwrap();
        assert_eq!(check(&gap, 9.81).state, State::Passed);
        // Nor is a ball that is held before it falls.
        let rows: Vec<[f64; 3]> =
            (0..40).map(|i| whole.row(i % 2)[2]).chain(whole.column(2)).map(|z| [0.0, 0.0, z]).collect();
        let clock = (0..rows.len()).map(|i| i as f64 / 60.0).collect();
        assert_eq!(check(&Observation::positions(clock, &rows).unwrap(), 9.81).state, State::Passed);
    }
}

//! Bounce times from a track of unknown scale: change points of the slope, and the intersection of adjacent flights.
//!
//! A camera shows a ball that comes nearer larger and lower, so that heights read off its picture drift; but a bounce stays
//! a kink, and the instant at which two flights cross is the same in every picture.

use super::polynomial::Polynomial;
use super::span;
use tunenet_core::observation::noise_sd;

/// Most samples on either side of a bounce through which a parabola is laid: a scale that drifts bends longer flights.
const MOST_SAMPLES: usize = 12;
/// Fewest, for three numbers and one to spare.
const FEWEST_SAMPLES: usize = 4;
/// Fewest of a flight whose end is not seen: one more, so that bending shows.
const FEWEST_OPEN: usize = 5;
/// A ball that bounces rises on either side of its lowest sample by so many standard deviations of the noise, ...
const RISES: f64 = 8.0;
/// ... and by this share of all that is seen of its way. One that rolls towards a camera sinks in the picture by more than
/// its last hops are high, so that little is left of them.
const SHARE: f64 = 0.003;
/// The end of the last flight is not observed, and hops too low to be resolved follow. It reaches as far as a parabola leaves no more
/// than so many standard deviations of the noise, or this share of the way.
const OPEN: (f64, f64) = (3.0, 0.001);

/// The instants (s) at which a ball bounced: `clock` in s, `heights` upwards in any unit, sample by sample. A list ends
/// where flights become too short to be seen.
///
/// ```
/// use tunenet_ball::bounces;
/// // A ball that falls 1 m and loses half of its speed, at 100 samples a second; a fall takes √(2/9.81) s.
/// let fall = (2.0_f64 / 9.81).sqrt();
/// let height = |t: f64| {
///     let s = t - fall;
///     if s < 0.0 { 1.0 - 4.905 * t * t } else { s * (0.5 * 9.81 * fall - 4.905 * s) }
/// };
/// let clock: Vec<f64> = (0..85).map(|i| 0.01 * f64::from(i)).collect();
/// let heights: Vec<f64> = clock.iter().map(|t| height(*t)).collect();
/// let found = bounces(&clock, &heights);
/// assert!(found.len() == 1 && (found[0] - fall).abs() < 1e-9);
/// ```
#[must_use]
pub fn bounces(clock: &[f64], heights: &[f64]) -> Vec<f64> {
    let lowest = minima(heights);
    let mut found: Vec<f64> = Vec::new();
    for (number, &low) in lowest.iter().enumerate() {
        let begin = if number == 0 { 0 } else { lowest[number - 1] + 1 };
        let Some(time_s) = crossing(clock, heights, (begin, low, lowest.get(number + 1).copied())) else { break };
        if found.last().is_some_and(|last| *last >= time_s) {
            break;
        }
        found.push(time_s);
    }
    found
}

/// Samples that are lower than all between them and a clear rise on either side.
fn minima(heights: &[f64]) -> Vec<usize> {
    let rise = (RISES * noise_sd(heights)).max(SHARE * span(heights));
    let (mut found, mut candidate, mut crest) = (Vec::new(), None::<usize>, f64::NEG_INFINITY);
    for (i, &height) in heights.iter().enumerate() {
        match candidate {
            // After a rise the next fall begins.
            Some(c) if height > heights[c] + rise => {
                found.push(c);
                (candidate, crest) = (None, height);
            }
            Some(c) if height < heights[c] => candidate = Some(i),
            Some(_) => {}
            None if height < crest - rise => candidate = Some(i),
            None => crest = crest.max(height),
        }
    }
    found
}

/// Where the flights before and after the sample `low` cross, s. They begin after the sample `begin`, and end before `next`,
/// where that bounce is seen.
fn crossing(clock: &[f64], heights: &[f64], (begin, low, next): (usize, usize, Option<usize>)) -> Option<f64> {
    let laid = |range: std::ops::Range<usize>, fewest: usize| {
        (range.len() >= fewest)
            .then(|| Polynomial::fit(&clock[range.clone()], &heights[range], clock[low], None))
            .flatten()
    };
    let most = (OPEN.0 * noise_sd(heights)).max(OPEN.1 * span(heights));
    let open = |first: usize| {
        let longest = heights.len().min(first + MOST_SAMPLES);
        let fits = (first + FEWEST_OPEN..=longest).map(|end| laid(first..end, FEWEST_OPEN));
        fits.map_while(|fit| fit.filter(|fit| fit.residual_sd <= most)).last()
    };
    let (from, to) = (clock[low.checked_sub(1)?], *clock.get(low + 1)?);
    // Which flight the lowest sample is of shows where they cross without it.
    let mut split = (low, low + 1);
    let mut time_s = None;
    for _ in 0..2 {
        let before = laid(begin.max(split.0.saturating_sub(MOST_SAMPLES))..split.0, FEWEST_SAMPLES)?;
        let after = match next {
            Some(next) => laid(split.1..next.min(split.1 + MOST_SAMPLES), FEWEST_SAMPLES)?,
            None => open(split.1)?,
        };
        let found = root(|t| after.at(t) - before.at(t), from, to)?;
        time_s = Some(found);
        split = if clock[low] < found { (low + 1, low + 1) } else { (low, low) };
    }
    time_s
}

/// Where a function that rises through 0 does so.
fn root(of: impl Fn(f64) -> f64, from: f64, to: f64) -> Option<f64> {
    let (mut low, mut high) = (from, to);
    if of(low) > 0.0 || of(high) < 0.0 {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if of(middle) < 0.0 { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tunenet_core::camera::Pinhole;

    /// Heights after a fall of 0.6 m and rebounds by `e`, from the closed form, and when it bounced.
    fn drop(e: f64, clock: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let fall = (1.2_f64 / 9.81).sqrt();
        let bounce = |k: i32| fall + 2.0 * fall * (1..=k).map(|i| e.powi(i)).sum::<f64>();
        let height = |t: f64| {
            if t < fall {
                return 0.6 - 4.905 * t * t;
            }
            let k = (0..40).rev().find(|k| bounce(*k) <= t).unwrap_or(0);
            let s = t - bounce(k);
            (s * (9.81 * fall * e.powi(k + 1) - 4.905 * s)).max(0.0)
        };
        (clock.iter().map(|t| height(*t)).collect(), (0..40).map(bounce).collect())
    }

    /// A ball that drifts towards a camera, with a tenth of a pixel of noise.
    #[test]
    fn a_drifting_ball_bounces_when_it_does() {
        let clock: Vec<f64> = (0..150).map(|i| f64::from(i) / 60.0).collect();
        let camera = Pinhole::aimed([0.9, 0.0, 0.45], [0.0, 0.0, 0.25], 1.05, (320, 240)).unwrap();
        for (e, drift, fewest) in [(0.8, 0.0, 4), (0.8, 0.15, 4), (0.62, -0.15, 3), (0.7, 0.2, 3)] {
            let (heights, truth) = drop(e, &clock);
            let v = clock.iter().zip(&heights).enumerate().map(|(i, (t, z))| {
                let noise = 0.1 * ((i * 7919 % 101) as f64 / 50.0 - 1.0);
                noise - camera.project([drift * t, 0.05 * t, z + 0.03]).unwrap()[1]
            });
            let found = bounces(&clock, &v.collect::<Vec<_>>());
            assert!(found.len() >= fewest, "{e} {drift}: {found:?}");
            for (found, truth) in found.iter().zip(&truth).take(fewest) {
                assert!((found - truth).abs() < 1.5e-3, "{e} {drift}: {found} {truth}");
            }
        }
    }

    /// What follows the last bounce that is seen are hops too low to be resolved: they are no part of its flight. Heights in
    /// pixels of 5 mm with a twentieth of noise; every restitution ends in hops of another size.
    #[test]
    fn hops_that_are_too_low_to_be_seen_shift_no_bounce() {
        let clock: Vec<f64> = (0..150).map(|i| f64::from(i) / 60.0).collect();
        for percent in 55..80 {
            let e = f64::from(percent) / 100.0;
            let (heights, truth) = drop(e, &clock);
            let noisy =
                heights.iter().enumerate().map(|(i, z)| 200.0 * z + 0.05 * ((i * 7919 % 101) as f64 / 50.0 - 1.0));
            let found = bounces(&clock, &noisy.collect::<Vec<_>>());
            assert!(found.len() >= 3, "{e}: {found:?}");
            for (found, truth) in found.iter().zip(&truth) {
                assert!((found - truth).abs() < 1.5e-3, "{e}: {found} {truth}");
            }
        }
    }

    #[test]
    fn what_does_not_bounce_has_no_bounces() {
        let clock: Vec<f64> = (0..60).map(|i| f64::from(i) / 60.0).collect();
        assert!(bounces(&clock, &clock.iter().map(|t| 2.0 - 4.9 * t * t).collect::<Vec<_>>()).is_empty());
        assert!(bounces(&clock, &vec![1.0; 60]).is_empty());
        assert!(bounces(&[], &[]).is_empty());
    }
}

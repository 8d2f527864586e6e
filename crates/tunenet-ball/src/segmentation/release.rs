//! Release time of a ball: the first flight, extended backwards while one parabola explains it.

use super::polynomial::Polynomial;
use super::span;
use tunenet_core::observation::noise_sd;

/// A held start must raise the log-likelihood by half of this over plain flight (a Bayes factor beyond e^10).
const RELEASE_EVIDENCE: f64 = 20.0;
/// Gravity is known to this share of itself before a recording is seen; at most this much of the evidence comes from it, so that a
/// wrong scale or drag alone makes no release.
const GRAVITY_SD: f64 = 0.1;
const GRAVITY_EVIDENCE: f64 = 12.0;
/// Most instants of release tried before the neighbourhood of the best is looked at sample by sample.
const MOST_RELEASES: usize = 200;
/// A held ball stays within so many standard deviations of the noise, or this share of its fall.
const HELD_NOISE: f64 = 10.0;
const HELD_SHARE: f64 = 0.02;
/// Samples before and after fall alike where their accelerations have this ratio, known to this share ...
const ALIKE: std::ops::Range<f64> = 0.7..1.4;
const ALIKE_SD: f64 = 0.1;
/// ... from at least so many samples each.
const FEWEST_ALIKE: usize = 4;

/// The first sample of free flight: the flight before the first impact is followed backwards for as long as one parabola
/// (its acceleration free, so that drag is no release) explains it.
pub(crate) fn release(clock: &[f64], heights: &[f64], from: usize, impact: usize, gravity: f64) -> usize {
    let sd = noise_sd(&heights[from..impact.min(heights.len())]).max(1e-9);
    let seed = ((impact - from) / 3).max(6);
    if impact < from + seed + 2 {
        return from;
    }
    let held = held_until(&clock[from..impact], &heights[from..impact], gravity);
    // The top of a throw is level too, but not for long.
    let level = |held: &usize| {
        span(&heights[from..=from + held]) < (HELD_NOISE * sd).max(HELD_SHARE * span(&heights[from..impact]))
    };
    if let Some(held) = held.filter(level) {
        return (from + held + 1).min(impact - 2);
    }
    let mut begin = impact - seed;
    while begin > from {
        let Some(fit) = Polynomial::fit(&clock[begin..impact], &heights[begin..impact], clock[begin], None) else {
            return from;
        };
        let misfit = |i: usize| (fit.at(clock[i]) - heights[i]).abs();
        let limit = 6.0 * sd.max(fit.residual_sd) + 1e-3 * span(&heights[from..impact]);
        // Two misfits in a row end the flight; one is an outlier.
        if misfit(begin - 1) > limit && (begin < from + 2 || misfit(begin - 2) > limit) {
            if falls_alike(&clock[from..impact], &heights[from..impact], begin - from, sd) {
                return from;
            }
            return (begin + 1).min(impact - 2);
        }
        begin -= 1;
    }
    from
}

/// Whether the first `count` samples fall as the rest does, though one parabola does not hold both: a camera that looks up
/// or down sees gravity change along the way. A hand lets nothing fall like that. `false` where noise hides it.
fn falls_alike(clock: &[f64], heights: &[f64], count: usize, noise_sd: f64) -> bool {
    let first = count.max(FEWEST_ALIKE);
    if clock.len() < first + FEWEST_ALIKE {
        return false;
    }
    let acceleration = |range: std::ops::Range<usize>| {
        let (t, z) = (&clock[range.clone()], &heights[range]);
        let fit = Polynomial::fit(t, z, t[0], None)?;
        // The acceleration of a parabola through n even samples over T has standard deviation sd·√720 / (√n T²).
        let duration = t[t.len() - 1] - t[0];
        let sd = fit.residual_sd.max(noise_sd) * (720.0 / t.len() as f64).sqrt() / (duration * duration);
        Some((2.0 * fit.coefficients[2], sd))
    };
    let (Some((before, sd)), Some((after, _))) = (acceleration(0..first), acceleration(first..clock.len())) else {
        return false;
    };
    sd < ALIKE_SD * after.abs() && ALIKE.contains(&(before / after))
}

/// The last held sample of a flight that begins with the ball held still and let go: a level line, then a parabola from
/// its end, must explain the samples far better than one parabola does. `None` where they do not.
fn held_until(clock: &[f64], heights: &[f64], gravity: f64) -> Option<usize> {
    if clock.len() < 8 {
        return None;
    }
    let whole = Polynomial::fit(clock, heights, clock[0], None)?;
    let squares: f64 = clock.iter().zip(heights).map(|(&t, &z)| (z - whole.at(t)).powi(2)).sum();
    // z = level + fall · (t − release)²₊, by least squares in (level, fall) for a release at sample `i`.
    let misfit = |i: usize| -> Option<(f64, f64)> {
        let bend = |t: f64| (t - clock[i]).max(0.0).powi(2);
        let (n, mut b, mut bb, mut z, mut bz, mut zz) = (clock.len() as f64, 0.0, 0.0, 0.0, 0.0, 0.0);
        for (&t, &height) in clock.iter().zip(heights) {
            // Heights from the first one keep the sums of squares small.
            let (bend, height) = (bend(t), height - heights[0]);
            b += bend;
            bb += bend * bend;
            z += height;
            bz += bend * height;
            zz += height * height;
        }
        let fall = (n * bz - b * z) / (n * bb - b * b);
        let level = (z - fall * b) / n;
        // Only a fall is a release; 1 to 20 m/s² is gravity in any unit that a ball's record may honestly have.
        (-10.0..-0.5).contains(&fall).then_some(((zz - level * z - fall * bz).max(0.0), -2.0 * fall))
    };
    let last = clock.len() - 4;
    let step = (last / MOST_RELEASES).max(1);
    let least = |range: &mut dyn Iterator<Item = usize>| {
        range.filter_map(|i| Some((i, misfit(i)?))).min_by(|a, b| a.1.0.total_cmp(&b.1.0))
    };
    let (coarse, _) = least(&mut (2..last).step_by(step))?;
    let (found, (remaining, acceleration)) =
        least(&mut (coarse.saturating_sub(step).max(2)..(coarse + step).min(last)))?;
    // One parabola over a held start falls, more slowly than gravity lets a ball fall; one that rises is no such parabola.
    let slow = -2.0 * whole.coefficients[2];
    let stray = |acceleration: f64| ((acceleration / gravity - 1.0) / GRAVITY_SD).powi(2);
    let known = if slow > 0.0 { (stray(slow) - stray(acceleration)).clamp(0.0, GRAVITY_EVIDENCE) } else { 0.0 };
    let gain = known + clock.len() as f64 * (squares / remaining.max(f64::MIN_POSITIVE)).ln();
    (gain > RELEASE_EVIDENCE).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    /// Heights at 120 Hz of a fall that starts after `held` samples with a velocity (m/s), and 2 mm of noise.
    fn fall(held: usize, velocity: f64) -> (Vec<f64>, Vec<f64>) {
        let clock: Vec<f64> = (0..held + 50).map(|i| i as f64 / 120.0).collect();
        let random = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let draws: Vec<f64> = Normal::new(0.0, 2e-3).unwrap().sample_iter(random).take(clock.len()).collect();
        let height = |(i, noise): (usize, &f64)| {
            let t = i.saturating_sub(held) as f64 / 120.0;
            1.0 + velocity * t - 9.81 / 2.0 * t * t + noise
        };
        let heights = draws.iter().enumerate().map(height).collect();
        (clock, heights)
    }

    #[test]
    fn a_ball_held_under_noise_is_let_go_where_it_starts_to_fall() {
        for held in [12, 30, 90] {
            let (clock, heights) = fall(held, 0.0);
            let found = release(&clock, &heights, 0, clock.len(), 9.81);
            // 2 mm of noise hide the first 20 ms of the fall.
            assert!(found + 3 >= held && found <= held + 8, "{held}: {found}");
        }
    }

    #[test]
    fn a_throw_seen_by_a_camera_that_looks_down_keeps_all_its_samples() {
        // Lengths shrink by a third per metre of height, which no parabola follows.
        let clock: Vec<f64> = (0..24).map(|i| f64::from(i) / 30.0).collect();
        let heights: Vec<f64> =
            clock.iter().map(|t| 0.3 + 3.5 * t - 4.905 * t * t).map(|z| z / (1.0 + 0.2 * z)).collect();
        assert_eq!(release(&clock, &heights, 0, clock.len(), 9.81), 0);
        // The same throw from a hand that brings the ball there at an even speed.
        let mut thrown: Vec<f64> = (0..10).map(|i| heights[0] - 0.01 * f64::from(10 - i)).collect();
        thrown.extend(&heights);
        let clock: Vec<f64> = (0..34).map(|i| f64::from(i) / 30.0).collect();
        let found = release(&clock, &thrown, 0, clock.len(), 9.81);
        assert!((9..=12).contains(&found), "{found}");
    }

    #[test]
    fn a_ball_that_is_in_flight_from_the_start_keeps_all_its_samples() {
        for velocity in [0.0, 1.0, -1.0] {
            let (clock, heights) = fall(0, velocity);
            assert_eq!(release(&clock, &heights, 0, clock.len(), 9.81), 0, "{velocity} m/s");
        }
    }

    /// Gravity says nothing of a record with z upside down: it is a matter of the checks, not of a release.
    #[test]
    fn a_fall_that_is_upside_down_is_no_release() {
        for seed in 0..20 {
            let draws = Normal::new(0.0, 6e-3).unwrap().sample_iter(rand_chacha::ChaCha8Rng::seed_from_u64(seed));
            let clock: Vec<f64> = (0..17).map(|i| f64::from(i) / 38.0).collect();
            let heights: Vec<f64> = clock.iter().zip(draws).map(|(t, noise)| 4.905 * t * t - 0.9 + noise).collect();
            assert_eq!(release(&clock, &heights, 0, clock.len(), 9.81), 0, "{seed}");
        }
    }

    /// 16 samples at 38 Hz with 6 mm of noise, 7 of them held: the squares alone do not distinguish that from one slow fall.
    #[test]
    fn a_short_hold_at_a_low_rate_shows_by_gravity() {
        let mut found = 0;
        for seed in 0..20 {
            let draws = Normal::new(0.0, 6e-3).unwrap().sample_iter(rand_chacha::ChaCha8Rng::seed_from_u64(seed));
            let clock: Vec<f64> = (0..17).map(|i| f64::from(i) / 38.0).collect();
            let height = |(t, noise): (&f64, f64)| 0.1 - 4.905 * (t - 0.17).max(0.0).powi(2) + noise;
            let heights: Vec<f64> = clock.iter().zip(draws).map(height).collect();
            found += usize::from((4..=9).contains(&release(&clock, &heights, 0, clock.len(), 9.81)));
        }
        assert!(found >= 16, "{found} of 20");
    }
}

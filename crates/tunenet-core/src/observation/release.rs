//! When a ball was let go.

use super::arcs::span;
use super::line::Polynomial;
use super::noise_sd;

/// Fewest samples of either part, held or falling.
const FEWEST: usize = 3;

/// The first sample of free flight: the flight before the first impact is followed backwards for as long as one parabola
/// (its acceleration free, so that drag is no release) explains it.
pub(super) fn release(clock: &[f64], heights: &[f64], from: usize, impact: usize) -> usize {
    let sd = noise_sd(&heights[from..impact.min(heights.len())]).max(1e-9);
    let seed = ((impact - from) / 3).max(6);
    if impact < from + seed + 2 {
        return from;
    }
    if let Some(begin) = held(clock, heights, from, impact, sd) {
        return begin;
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
            return (begin + 1).min(impact - 2);
        }
        begin -= 1;
    }
    from
}

/// Where a ball that was held still until its release starts to fall: the change from a constant to a parabola that leaves
/// least. `None` where the parabola explains the first samples as well. Under noise the steps back from the impact do not
/// see this: a free parabola bends along with each held sample that it takes in.
fn held(clock: &[f64], heights: &[f64], from: usize, impact: usize, sd: f64) -> Option<usize> {
    // A long record is searched in strides: a few samples lost after the release cost nothing.
    let stride = ((impact - from) / 400).max(1);
    let mut best: Option<(f64, usize, Polynomial)> = None;
    for begin in (from + FEWEST..impact.saturating_sub(2 * FEWEST)).step_by(stride) {
        let still = &heights[from..begin];
        let mean = still.iter().sum::<f64>() / still.len() as f64;
        let fall = Polynomial::fit(&clock[begin..impact], &heights[begin..impact], clock[begin], None)?;
        let left = still.iter().map(|z| (z - mean).powi(2)).sum::<f64>()
            + fall.residual_sd.powi(2) * (impact - begin - FEWEST) as f64;
        if best.as_ref().is_none_or(|b| left < b.0) {
            best = Some((left, begin, fall));
        }
    }
    let (_, begin, fall) = best?;
    // The parabola has to miss the first samples, as one that was thrown or let go before them does not.
    let limit = 6.0 * sd.max(fall.residual_sd) + 1e-3 * span(&heights[from..impact]);
    let missed = (from..from + 2).all(|i| (fall.at(clock[i]) - heights[i]).abs() > limit);
    missed.then(|| (begin + stride).min(impact - 2))
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
            let found = release(&clock, &heights, 0, clock.len());
            // 2 mm of noise hide the first 20 ms of the fall.
            assert!(found + 3 >= held && found <= held + 8, "{held}: {found}");
        }
    }

    #[test]
    fn a_ball_that_is_in_flight_from_the_start_keeps_all_its_samples() {
        for velocity in [0.0, 1.0, -1.0] {
            let (clock, heights) = fall(0, velocity);
            assert_eq!(release(&clock, &heights, 0, clock.len()), 0, "{velocity} m/s");
        }
    }
}

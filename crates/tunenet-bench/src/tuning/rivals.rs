//! What only a ball's rivals know: the apex of a rebound, two parabolas, rollouts that serve every height.

use anyhow::Result;

use super::super::search::Course;
use super::targets::{DropTarget, Simulation};
use crate::scene::GRAVITY_M_S2;

/// Rollouts stored for [`Stored`], evenly over the restitutions.
const STORED: u32 = 201;
/// The fall that they were rolled out from, and their rate: dimensionless, they serve every height. Finer than the target, so
/// that reading between two samples costs nothing in comparison.
const STORED_FALL_M: f64 = 4.0;
const STORED_RATE_HZ: f64 = 1920.0;
const STORED_FRAMES: u32 = 13_800;

/// The rule `e = √(first rebound / fall)` inside the paper's own loop, `c ← c + rule(target) − rule(rollout(c))`, started
/// at the rule itself.
pub fn apex_loop(simulation: &Simulation, target: &DropTarget, most: usize) -> Result<Course> {
    let rule = |heights: &[f64]| apex(target.fall_m, &simulation.clock, heights);
    let wanted = rule(&target.heights_m);
    let mut course = vec![wanted.clamp(0.0, 1.0)];
    for k in 0..most {
        let seen = rule(&simulation.roll(target, course[k])?);
        course.push((course[k] + wanted - seen).clamp(0.0, 1.0));
    }
    Ok(course)
}

/// `√(apex of the first rebound / fall)`. The apex is that of a parabola, its curvature that of gravity, through the inner
/// four fifths of the arc, so that every sample there counts; exact without noise. Where the arc holds fewer than three
/// samples, the highest of them.
pub fn apex(fall_m: f64, clock: &[f64], heights_m: &[f64]) -> f64 {
    let first = (2.0 * fall_m / GRAVITY_M_S2).sqrt();
    // No later rebound is higher, and the first ends by 3 × the fall's time.
    let within = |from: f64, to: f64| {
        clock.iter().zip(heights_m).filter(move |(t, _)| (from..=to).contains(*t)).map(|(t, z)| (*t, *z))
    };
    let highest = within(first, 3.0 * first).map(|(_, z)| z).fold(0.0, f64::max);
    let mut guess = (highest / fall_m).sqrt().min(1.0);
    for _ in 0..3 {
        let (middle, half) = (first * (1.0 + guess), 0.8 * first * guess);
        // z + g s²/2 is a straight line a + b s, whose parabola has its apex at a + b²/2g.
        let line = |s: f64, z: f64| (s, z + 0.5 * GRAVITY_M_S2 * s * s);
        let points: Vec<_> = within(middle - half, middle + half).map(|(t, z)| line(t - middle, z)).collect();
        if points.len() < 3 {
            break;
        }
        let n = points.len() as f64;
        let (mean_s, mean_y) =
            (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
        let square: f64 = points.iter().map(|p| (p.0 - mean_s).powi(2)).sum();
        let slope = points.iter().map(|p| (p.0 - mean_s) * (p.1 - mean_y)).sum::<f64>() / square;
        let apex = mean_y - slope * mean_s + slope * slope / (2.0 * GRAVITY_M_S2);
        guess = (apex.max(0.0) / fall_m).sqrt().min(1.0);
    }
    guess
}

/// Rollouts made beforehand, as heights in units of the fall at its own times.
pub struct Stored {
    restitutions: Vec<f64>,
    rollouts: Vec<Vec<f64>>,
}

impl Stored {
    pub fn new(simulation: &Simulation) -> Result<Self> {
        let clock: Vec<f64> = (0..STORED_FRAMES).map(|i| f64::from(i) / STORED_RATE_HZ).collect();
        let restitutions: Vec<f64> = (0..STORED).map(|i| f64::from(i) / f64::from(STORED - 1)).collect();
        let roll = |e: &f64| {
            let heights = simulation.roll_on(&clock, STORED_FALL_M, *e)?;
            Ok(heights.iter().map(|z| z / STORED_FALL_M).collect())
        };
        let rollouts = restitutions.iter().map(roll).collect::<Result<_>>()?;
        Ok(Self { restitutions, rollouts })
    }

    /// All of them as they would have been seen from another height.
    pub fn from(&self, fall_m: f64, clock: &[f64]) -> Vec<(f64, Vec<f64>)> {
        self.restitutions.iter().enumerate().map(|(i, e)| (*e, self.seen(i, fall_m, clock))).collect()
    }

    /// The rollout number `i` as it would have been seen from another height: lengths scale with it, times with its root.
    fn seen(&self, i: usize, fall_m: f64, clock: &[f64]) -> Vec<f64> {
        let stretch = (STORED_FALL_M / fall_m).sqrt() * STORED_RATE_HZ;
        let at = |t: &f64| {
            let place = t * stretch;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place in the record")]
            let before = (place as usize).min(self.rollouts[i].len() - 2);
            let share = place - before as f64;
            fall_m * (self.rollouts[i][before] * (1.0 - share) + self.rollouts[i][before + 1] * share)
        };
        clock.iter().map(at).collect()
    }
}

/// Rebound over approach speed where two parabolas cross, their curvature that of gravity: one through the first fall, one
/// through the first rebound. Takes instants with heights above anything; knows neither height of fall, release nor floor.
pub fn two_parabolas(seen: &[(f64, f64)]) -> f64 {
    let highest = |range: &[(f64, f64)]| range.iter().map(|p| p.1).fold(f64::MIN, f64::max);
    let fall = highest(seen) - seen.iter().map(|p| p.1).fold(f64::MAX, f64::min);
    // The first low: the lowest sample before the ball has risen from it by 3 % of the fall, or the record ends.
    let mut low = 0;
    for (i, (_, z)) in seen.iter().enumerate() {
        if *z < seen[low].1 {
            low = i;
        } else if z - seen[low].1 > 0.03 * fall && highest(seen) - seen[low].1 > 0.5 * fall {
            break;
        }
    }
    // The rebound lasts until the ball is as low again, or nearly.
    let apex = (low..seen.len()).take_while(|&i| i == low || seen[i].1 > seen[low].1);
    let rebound: Vec<usize> = apex.skip(1).collect();
    let end = rebound.last().map_or(low, |i| *i);
    // z + g t²/2 is a straight line a + b t in either flight; the samples next to the impact are left out.
    let line = |range: &[(f64, f64)]| {
        let n = range.len() as f64;
        let y = |(t, z): &(f64, f64)| z + 0.5 * GRAVITY_M_S2 * t * t;
        let (t0, y0) = (range.iter().map(|p| p.0).sum::<f64>() / n, range.iter().map(y).sum::<f64>() / n);
        let square: f64 = range.iter().map(|p| (p.0 - t0).powi(2)).sum();
        let slope = range.iter().map(|p| (p.0 - t0) * (y(p) - y0)).sum::<f64>() / square;
        (range.len() >= 2 && square > 0.0).then_some((y0 - slope * t0, slope))
    };
    let (before, after) = (&seen[..low], seen.get(low + 1..end).unwrap_or_default());
    let (Some(down), Some(up)) = (line(before), line(after)) else { return 0.0 };
    let time = (down.0 - up.0) / (up.1 - down.1);
    let (approach, rebound) = (GRAVITY_M_S2 * time - down.1, up.1 - GRAVITY_M_S2 * time);
    let rule = rebound / approach;
    if rule.is_finite() { rule.clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::closed_form::ClosedFormDrop;
    use super::*;

    #[test]
    fn two_parabolas_are_exact_without_noise() {
        for restitution in [0.2, 0.5, 0.9] {
            let clock: Vec<f64> = (3..200).map(|i| f64::from(i) / 100.0).collect();
            let heights = ClosedFormDrop { fall_m: 1.3, restitution }.heights(&clock);
            let seen: Vec<(f64, f64)> = clock.into_iter().zip(heights.into_iter().map(|z| z - 7.0)).collect();
            assert!((two_parabolas(&seen) - restitution).abs() < 1e-9, "{}", two_parabolas(&seen));
        }
    }

    #[test]
    fn the_apex_rule_is_exact_without_noise() {
        let clock: Vec<f64> = (0..400).map(|i| f64::from(i) / 60.0).collect();
        for restitution in [0.1, 0.3, 0.512_3, 0.7, 0.95, 1.0] {
            let seen = ClosedFormDrop { fall_m: 4.2, restitution }.heights(&clock);
            assert!((apex(4.2, &clock, &seen) - restitution).abs() < 1e-12, "{}", apex(4.2, &clock, &seen));
        }
    }
}

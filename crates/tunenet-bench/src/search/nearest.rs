//! No network at all: the nearest of rollouts that were made beforehand, then Gauss–Newton with slopes between rollouts.

use anyhow::Result;

use super::{Course, Search};

/// A secant step reaches no farther, lest a slope that is hardly there throws the estimate away; a share of the range that can
/// be simulated.
const FARTHEST_STEP: f64 = 0.03;
/// Rollouts that lie nearer have no slope between them.
const SAME: f64 = 1e-9;

/// Starts at the stored rollout that lies nearest, then Gauss–Newton with the slope to the nearest rollout known, stored
/// or made.
pub fn search(target: &Search, stored: Vec<(f64, Vec<f64>)>, most: usize) -> Result<Course> {
    let (low, high) = target.bounds;
    let farthest = FARTHEST_STEP * (high - low);
    let nearest = stored.iter().map(|(x, rolled)| (*x, target.squares(rolled))).min_by(|a, b| a.1.total_cmp(&b.1));
    let mut known = stored;
    let mut course = vec![nearest.map_or(target.proposed, |(x, _)| x)];
    for k in 0..most {
        let (here, rolled) = (course[k], (target.roll)(course[k])?);
        let others = known.iter().filter(|(x, _)| (x - here).abs() > SAME);
        let other = others.min_by(|a, b| (a.0 - here).abs().total_cmp(&(b.0 - here).abs()));
        let step = other.and_then(|(x, other)| target.step((here, &rolled), (*x, other))).unwrap_or(0.0);
        known.push((here, rolled));
        course.push((here + step.clamp(-farthest, farthest)).clamp(low, high));
    }
    Ok(course)
}

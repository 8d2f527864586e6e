//! Gauss and Newton's method with slopes from finite differences.
//!
//! Written here because that of the crate `argmin` 0.11 is the weaker rival: it knows no bounds, and where a rollout does not
//! depend on the number it stops with a step that is no number (drops with restitution 0 to 1 and noise of 2 cm), while this
//! one stays and keeps its best. On targets where that does not happen both give the same estimates to rounding.

use anyhow::Result;

use super::{Course, Search};

/// How far apart the two rollouts of a slope lie: errors of the forward difference (1e-4 of the curvature) and of rounding
/// (1e-16/1e-4) are far below the step itself.
const STEP: f64 = 1e-4;

/// The best estimate so far after every rollout, from the proposed start; two rollouts to a step.
pub fn search(target: &Search, most: usize) -> Result<Course> {
    let (low, high) = target.bounds;
    let mut course = vec![target.proposed];
    let (mut here, mut best) = (target.proposed, (f64::INFINITY, target.proposed));
    while course.len() <= most {
        let rolled = (target.roll)(here)?;
        if target.squares(&rolled) < best.0 {
            best = (target.squares(&rolled), here);
        }
        course.push(best.1);
        if course.len() > most {
            break;
        }
        let side = if here + STEP > high { here - STEP } else { here + STEP };
        let aside = (target.roll)(side)?;
        if target.squares(&aside) < best.0 {
            best = (target.squares(&aside), side);
        }
        course.push(best.1);
        if let Some(step) = target.step((here, &rolled), (side, &aside)) {
            here = (here + step).clamp(low, high);
        }
    }
    Ok(course)
}

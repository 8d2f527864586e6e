//! What anybody would write down first: Gauss and Newton's step with a slope from finite differences.

use anyhow::Result;

use super::{Course, Search};

/// How far apart the two rollouts of a slope lie.
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

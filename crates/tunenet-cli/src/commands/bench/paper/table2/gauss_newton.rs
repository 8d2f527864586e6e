//! What anybody would write down first: Gauss and Newton's step with a slope from finite differences.

use anyhow::Result;

use super::super::super::tuning::rivals::Course;
use super::super::super::tuning::targets::{Simulation, Target};

/// How far apart the two rollouts of a slope lie.
const STEP: f64 = 1e-4;

/// The best estimate so far after every rollout, from the proposed start; two rollouts to a step.
pub fn search(simulation: &Simulation, target: &Target, most: usize) -> Result<Course> {
    let off = |heights: &[f64]| heights.iter().zip(&target.heights_m).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    let mut course = vec![target.proposed];
    let (mut here, mut best) = (target.proposed, (f64::INFINITY, target.proposed));
    while course.len() <= most {
        let heights = simulation.roll(target, here)?;
        if off(&heights) < best.0 {
            best = (off(&heights), here);
        }
        course.push(best.1);
        if course.len() > most {
            break;
        }
        let side = if here > 0.5 { -STEP } else { STEP };
        let aside = simulation.roll(target, here + side)?;
        if off(&aside) < best.0 {
            best = (off(&aside), here + side);
        }
        course.push(best.1);
        let (mut square, mut product) = (0.0, 0.0);
        for ((a, h), seen) in aside.iter().zip(&heights).zip(&target.heights_m) {
            let slope = (a - h) / side;
            square += slope * slope;
            product += slope * (seen - h);
        }
        if square > 0.0 {
            here = (here + product / square).clamp(0.0, 1.0);
        }
    }
    Ok(course)
}

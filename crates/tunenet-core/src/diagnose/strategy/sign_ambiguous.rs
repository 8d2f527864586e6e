//! Sign-ambiguous nuisance parameters: they turn a motion out of the measured plane, to either side alike.
//!
//! Of a body seen along x and z alone, spin about an axis within the picture pushes it across, and then pushes what has become
//! of that back along x: a braking of second order, which drag would have to share with a spin that nobody saw. To first
//! order nothing is known of such an unknown, and it stays at its guess.

use crate::Result;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::recording::Set;
use crate::diagnose::hypothesis::context::Context;
use crate::diagnose::hypothesis::joint::Point;

/// How far from its guess an unknown is tried, as a share of its range.
const TRIED: f64 = 0.05;
/// Two sides are alike where they differ by less than this share of what either does.
const ALIKE: f64 = 1e-6;

/// The evidence with such unknowns held at their guesses, before anything is fitted.
pub(in crate::diagnose) fn fix_sign_ambiguous(context: &Context) -> Result<Evidence> {
    let mut evidence = Evidence::clone(&context.evidence);
    for sets in [&mut evidence.training, &mut evidence.validation] {
        let ambiguous = ambiguous(context, sets)?;
        hold(sets, &ambiguous);
    }
    Ok(evidence)
}

/// For each recording: which of its nuisance parameters are such.
fn ambiguous(context: &Context<'_>, sets: &[Set]) -> Result<Vec<Vec<bool>>> {
    let none = |set: &Set| vec![false; set.prepared.nuisances.len()];
    let mut found: Vec<Vec<bool>> = sets.iter().map(none).collect();
    if sets.iter().all(|set| set.unmeasured().is_empty()) {
        return Ok(found);
    }
    let structure = context.structure(&[])?;
    let joint = crate::diagnose::hypothesis::joint::Joint { structure: &structure, sets, rollouts: &context.rollouts };
    let guess = Point {
        parameters: structure.globals.iter().map(|g| g.parameter.value).collect(),
        nuisances: sets.iter().map(|s| s.prepared.nuisance_values()).collect(),
    };
    // What cannot be simulated from the guesses is left to the fit.
    let Ok(still) = joint.residuals(&guess, 1.0) else { return Ok(found) };
    for i in 0..found.iter().map(Vec::len).max().unwrap_or(0) {
        let moved = |direction: f64| {
            let mut point = guess.clone();
            for (nuisances, set) in point.nuisances.iter_mut().zip(sets) {
                let Some(unknown) = set.prepared.nuisances.get(i) else { continue };
                let room = (unknown.max - nuisances[i]).min(nuisances[i] - unknown.min);
                nuisances[i] += direction * room.min(TRIED * unknown.span());
            }
            joint.residuals(&point, 1.0)
        };
        let (Ok(more), Ok(less)) = (moved(1.0), moved(-1.0)) else { continue };
        for (d, set) in sets.iter().enumerate().filter(|(_, set)| i < set.prepared.nuisances.len()) {
            let differ = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            let (one, sides) = (differ(&more[d], &still[d]), differ(&more[d], &less[d]));
            found[d][i] = !set.unmeasured().is_empty() && one > 0.0 && sides < ALIKE * one;
        }
    }
    Ok(found)
}

fn hold(sets: &mut [Set], ambiguous: &[Vec<bool>]) {
    for (set, ambiguous) in sets.iter_mut().zip(ambiguous) {
        for i in (0..ambiguous.len()).filter(|&i| ambiguous[i]) {
            set.hold(i);
        }
    }
}

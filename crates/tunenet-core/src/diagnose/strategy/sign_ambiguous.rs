//! Sign-ambiguous nuisance parameters: they turn a motion out of the measured plane, to either side alike.
//!
//! Of a body seen along x and z alone, a hidden rotation about an axis within that plane pushes it across the plane, and then
//! pushes the motion across it back along x. This braking is of second order, and drag would have to share it with a rotation that
//! was not measured. To first order nothing is known of such a parameter, and it stays at its guess.

use crate::Result;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::diagnose::hypothesis::context::Context;
use crate::diagnose::hypothesis::joint::{Joint, Point};

/// How far from its guess an unknown is tried, as a share of its range.
const TRIED: f64 = 0.05;
/// Two sides are alike where they differ by less than this share of what either does.
const ALIKE: f64 = 1e-6;

/// The evidence with such unknowns held at their guesses, before anything is fitted.
pub(in crate::diagnose) fn fix_sign_ambiguous(context: &Context) -> Result<Evidence> {
    let mut evidence = Evidence::clone(&context.evidence);
    for recordings in [&mut evidence.training, &mut evidence.validation] {
        let ambiguous = ambiguous(context, recordings)?;
        hold(recordings, &ambiguous);
    }
    Ok(evidence)
}

/// For each recording: which of its nuisance parameters are such.
fn ambiguous(context: &Context<'_>, recordings: &[PreparedRecording]) -> Result<Vec<Vec<bool>>> {
    let none = |recording: &PreparedRecording| vec![false; recording.prepared.nuisances.len()];
    let mut found: Vec<Vec<bool>> = recordings.iter().map(none).collect();
    if recordings.iter().all(|recording| recording.unmeasured().is_empty()) {
        return Ok(found);
    }
    let structure = context.structure(&[])?;
    let joint = Joint { structure: &structure, recordings, separable: false, rollouts: &context.rollouts };
    let guess = Point {
        parameters: structure.shared.iter().map(|shared| shared.parameter.value).collect(),
        nuisances: recordings.iter().map(|r| r.prepared.nuisance_values()).collect(),
    };
    // What cannot be simulated from the guesses is left to the fit.
    let Ok(still) = joint.residuals(&guess, 1.0) else { return Ok(found) };
    for i in 0..found.iter().map(Vec::len).max().unwrap_or(0) {
        let moved = |direction: f64| {
            let mut point = guess.clone();
            for (nuisances, recording) in point.nuisances.iter_mut().zip(recordings) {
                let Some(unknown) = recording.prepared.nuisances.get(i) else { continue };
                let room = (unknown.max - nuisances[i]).min(nuisances[i] - unknown.min);
                nuisances[i] += direction * room.min(TRIED * unknown.span());
            }
            joint.residuals(&point, 1.0)
        };
        let (Ok(more), Ok(less)) = (moved(1.0), moved(-1.0)) else { continue };
        for (index, recording) in recordings.iter().enumerate().filter(|(_, r)| i < r.prepared.nuisances.len()) {
            let differ = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            let (one, sides) = (differ(&more[index], &still[index]), differ(&more[index], &less[index]));
            found[index][i] = !recording.unmeasured().is_empty() && one > 0.0 && sides < ALIKE * one;
        }
    }
    Ok(found)
}

fn hold(recordings: &mut [PreparedRecording], ambiguous: &[Vec<bool>]) {
    for (recording, ambiguous) in recordings.iter_mut().zip(ambiguous) {
        for i in (0..ambiguous.len()).filter(|&i| ambiguous[i]) {
            recording.hold(i);
        }
    }
}

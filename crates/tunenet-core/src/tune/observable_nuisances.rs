//! Local observability of nuisance parameters by finite differences: which of them change what was measured. The height of a
//! surface that is never touched does not, nor a position along an axis that was not measured.

use crate::Result;
use crate::estimate::RolloutLog;
use crate::simulator::{Parameter, Prepared, Simulator};

/// Step of the finite difference, as a share of the bounds.
const NUDGE: f64 = 1e-6;
/// A change counts from this share of the noise on: rounding stays below.
const LEAST: f64 = 1e-5;

/// The nuisance parameters of a recording, with their values `nuisances`, on which a measured channel depends.
///
/// # Errors
/// Where the simulator refuses the values themselves.
pub(super) fn observable_nuisances(
    simulator: &dyn Simulator,
    (d, recording): (usize, &Prepared),
    noise: &[f64],
    (parameters, nuisances): (&[f64], &[f64]),
    log: &RolloutLog,
) -> Result<Vec<Parameter>> {
    if nuisances.is_empty() {
        return Ok(Vec::new());
    }
    let predict =
        |nuisances: &[f64]| log.predict(simulator, (d, recording), parameters, nuisances, recording.seen.len());
    let width = noise.len();
    // A channel that never varies, not even by noise, was not measured.
    let measured: Vec<bool> =
        (0..width).map(|c| recording.seen.column(c).any(|v| v != recording.seen.row(0)[c])).collect();
    let here = predict(nuisances)?;
    let moves = |i: usize, step: f64| {
        let mut moved = nuisances.to_vec();
        moved[i] += step;
        // A step that cannot be simulated makes a difference.
        predict(&moved).map_or(true, |there| {
            let differs =
                |(k, (a, b)): (usize, (&f64, &f64))| measured[k % width] && (a - b).abs() > LEAST * noise[k % width];
            there.iter().zip(&here).enumerate().any(differs)
        })
    };
    // To both sides: a surface just below the lowest sample is felt from below alone.
    let seen = |(i, p): &(usize, &Parameter)| {
        let step = NUDGE * (p.max - p.min);
        moves(*i, step) && moves(*i, -step)
    };
    let kept = recording.nuisances.iter().enumerate().filter(seen);
    Ok(kept.map(|(i, p)| Parameter { value: nuisances[i], ..p.clone() }).collect())
}

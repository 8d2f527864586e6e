//! Rolling out: once, or many times at once.

use rayon::prelude::*;

use super::{Prepared, RolloutError, RolloutResult, Simulator};
use crate::observation::{usable, usable_number};
use crate::{Error, Result};

/// One rollout, values row-major `[sample, channel]`.
///
/// # Errors
/// [`Error::Simulator`] where the simulator refuses; [`Error::SimulatorBroken`] where it failed; [`Error::Prediction`] where it returns a number that is not finite or
/// beyond [`GREATEST`](crate::observation::GREATEST).
pub fn rollout(simulator: &dyn Simulator, parameters: &[f64], nuisances: &[f64], clock: &[f64]) -> Result<Vec<f64>> {
    checked(simulator, parameters, clock, |values| simulator.rollout(parameters, nuisances, clock, values))
}

/// One rollout in the circumstances of `recording`, values row-major `[sample, channel]`.
///
/// # Errors
/// As [`rollout`]; a refusal says of which recording, where that has a name, and from which start.
pub fn predict(
    simulator: &dyn Simulator,
    recording: &Prepared,
    parameters: &[f64],
    nuisances: &[f64],
    clock: &[f64],
) -> Result<Vec<f64>> {
    let Some(known) = &recording.circumstances else { return rollout(simulator, parameters, nuisances, clock) };
    checked(simulator, parameters, clock, |values| {
        let run = simulator.rollout_driven(parameters, nuisances, known, clock, values);
        run.map_err(|error| match error {
            RolloutError::Refused(message) if !known.name.is_empty() => {
                let start = recording.nuisances.iter().zip(nuisances).map(|(p, v)| format!("{}={v}", p.name));
                let start = start.collect::<Vec<_>>().join(" ");
                let from = if start.is_empty() { start } else { format!(" from {start}") };
                RolloutError::Refused(format!("{message} (simulating {}{from})", known.name))
            }
            other => other,
        })
    })
}

/// What `run` writes, if it succeeds and all numbers are usable.
fn checked(
    simulator: &dyn Simulator,
    parameters: &[f64],
    clock: &[f64],
    run: impl FnOnce(&mut [f64]) -> RolloutResult,
) -> Result<Vec<f64>> {
    let mut values = vec![0.0; clock.len() * simulator.channels().len()];
    let at = || {
        let named = simulator.parameters().iter().zip(parameters).map(|(p, v)| format!("{}={v}", p.name));
        named.collect::<Vec<_>>().join(" ")
    };
    run(&mut values).map_err(|error| match error {
        RolloutError::Refused(message) => Error::Simulator { at: at(), message },
        RolloutError::Broken(message) => Error::SimulatorBroken { message },
    })?;
    if let Some(i) = values.iter().position(|&v| !usable(v)) {
        let (sample, channel) =
            (i / simulator.channels().len() + 1, &simulator.channels()[i % simulator.channels().len()]);
        let place = format!("`{}` at sample {sample}", channel.header());
        let found = format!("{:?}", values[i]);
        return Err(Error::Prediction { at: at(), place, expected: usable_number(), found });
    }
    Ok(values)
}

/// Several rollouts on the same clock, spread over the processor's cores; the order of the results is that of `points`,
/// each a pair of parameters and nuisance parameters.
///
/// # Errors
/// The first failure in order, as [`rollout`].
pub fn rollouts(simulator: &dyn Simulator, points: &[(Vec<f64>, Vec<f64>)], clock: &[f64]) -> Result<Vec<Vec<f64>>> {
    every(points.par_iter().map(|(parameters, nuisances)| rollout(simulator, parameters, nuisances, clock)))
}

/// All results in order, or the first failure in order. One that fails stops no other: which rollouts are asked for must not
/// depend on the number of threads.
///
/// # Errors
/// That failure.
pub(crate) fn every<T: Send>(results: impl ParallelIterator<Item = Result<T>>) -> Result<Vec<T>> {
    results.collect::<Vec<_>>().into_iter().collect()
}

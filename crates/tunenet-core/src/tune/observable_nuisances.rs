//! Local observability of nuisance parameters by finite differences: which of them change what was measured. The height of a
//! surface that is never touched does not, nor a position along an axis that was not measured.

use crate::estimate::{RolloutLog, STATE_STEP};
use crate::simulator::{Parameter, Prepared, STATE, Simulator};

/// Step of the finite difference, as a share of the bounds.
const NUDGE: f64 = 1e-6;
/// A change counts from this share of the noise on: rounding stays below.
const LEAST: f64 = 1e-5;

/// The nuisance parameters of a recording, with their values `nuisances`, on which a measured channel depends; each of them where
/// a limit on rollouts leaves none to find out.
pub(super) fn observable_nuisances(
    simulator: &dyn Simulator,
    (d, recording): (usize, &Prepared),
    noise: &[f64],
    (parameters, nuisances): (&[f64], &[f64]),
    log: &RolloutLog,
) -> Vec<Parameter> {
    if nuisances.is_empty() {
        return Vec::new();
    }
    let valued = |(i, p): (usize, &Parameter)| Parameter { value: nuisances[i], ..p.clone() };
    let log = log.strict();
    let predict =
        |nuisances: &[f64]| log.predict(simulator, (d, recording), parameters, nuisances, recording.seen.len());
    let width = noise.len();
    // A channel that never varies, not even by noise, was not measured.
    let measured: Vec<bool> =
        (0..width).map(|c| recording.seen.column(c).any(|v| v != recording.seen.row(0)[c])).collect();
    let Ok(here) = predict(nuisances) else { return recording.nuisances.iter().enumerate().map(valued).collect() };
    let moves = |i: usize, step: f64| {
        let mut moved = nuisances.to_vec();
        moved[i] += step;
        // A step that cannot be simulated, or must not be, counts as a difference.
        predict(&moved).map_or(true, |there| {
            let differs =
                |(k, (a, b)): (usize, (&f64, &f64))| measured[k % width] && (a - b).abs() > LEAST * noise[k % width];
            there.iter().zip(&here).enumerate().any(differs)
        })
    };
    // To both sides: a surface just below the lowest sample is felt from below alone.
    let seen = |(i, p): &(usize, &Parameter)| {
        let share = if p.name.starts_with(STATE) { STATE_STEP } else { NUDGE };
        let step = share * (p.max - p.min);
        moves(*i, step) && moves(*i, -step)
    };
    let kept = recording.nuisances.iter().enumerate().filter(seen);
    kept.map(valued).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::findings;
    use crate::observation::Note;
    use crate::observation::{Channel, Kind, Observation};
    use crate::simulator::{FnSimulator, StartState, StartValue};
    use crate::tune::{Settings, tune};

    /// x(t) = start + slope t; a second state is read by nothing.
    #[test]
    fn a_state_that_nothing_reads_is_reported() {
        let slope = Parameter::new("slope", "m/s", 1.0, 0.0, 5.0).unwrap();
        let line = FnSimulator::new(vec![slope], vec![Channel::new("x", "m")], |p, run, clock, out| {
            clock.iter().zip(out).for_each(|(t, x)| *x = run.start[0] + p[0] * t);
            Ok(())
        });
        let line = line.start(StartState::new("x", "m", StartValue::First(0)).with_prior(0.1));
        let line = line.start(StartState::new("unread", "m", StartValue::Number(0.0)).with_prior(0.1));
        let clock: Vec<f64> = (0..50).map(|i| 0.02 * f64::from(i)).collect();
        let values = clock.iter().map(|t| 0.3 + 2.0 * t + 1e-3 * (97.0 * t).sin()).collect();
        let seen = Observation::new(Kind::Other, vec![Channel::new("x", "m")], clock, values).unwrap();
        let outcome = tune(&line, &[seen], None, &Settings::default()).unwrap();
        let said: Vec<&Note> = outcome.notes.iter().filter(|note| note.kind == findings::START_NO_EFFECT).collect();
        assert!(said.len() == 1 && said[0].text.starts_with("`start.unread` changes nothing"), "{said:?}");
        assert!(outcome.nuisances[0].iter().any(|p| p.name == "start.x"));
    }
}

//! Local observability of initial states by finite differences: those on which no recording depends, since what simulates does not read
//! them.

use std::sync::Arc;

use super::RolloutLog;
use crate::Result;
use crate::findings;
use crate::observation::Note;
use crate::simulator::{Parameter, Prepared, STATE, Simulator, predict};

/// How far an estimated state is moved, as a share of its bounds, and a known one, as a share of its value or of 1, whichever is larger: so far
/// that a program which rounds its answers shows it.
pub(crate) const STATE_STEP: f64 = 1e-3;

/// What is said of each initial state on which no recording depends at these parameters. Every recording has its number in the log and its
/// nuisance parameters. A state counts as read where that cannot be simulated, or where no rollout is left to find out.
pub(crate) fn unread_states(
    simulator: &dyn Simulator,
    recordings: &[(usize, &Prepared, &[f64])],
    parameters: &[f64],
    log: &RolloutLog,
) -> Vec<Note> {
    let states = |(_, one, _): &(usize, &Prepared, &[f64])| {
        let estimated = one.nuisances.iter().filter_map(|p| p.name.strip_prefix(STATE)).map(str::to_owned);
        estimated.chain(one.known_states.iter().map(|(_, name)| name.clone())).collect::<Vec<_>>()
    };
    let log = &log.strict();
    let mut names: Vec<String> = recordings.iter().flat_map(states).collect();
    names.sort_unstable();
    names.dedup();
    names.retain(|name| {
        let reads = |recording| depends(simulator, recording, name, parameters, log).unwrap_or(true);
        !recordings.iter().copied().any(reads)
    });
    let remedy = "check its name: what simulates may not read it";
    let note = |name: &String| {
        Note::new(findings::START_NO_EFFECT, format!("`{STATE}{name}` changes nothing in any recording"), remedy)
    };
    names.iter().map(note).collect()
}

/// Whether what is simulated of a recording depends on an initial state.
fn depends(
    simulator: &dyn Simulator,
    (d, recording, nuisances): (usize, &Prepared, &[f64]),
    name: &str,
    parameters: &[f64],
    log: &RolloutLog,
) -> Result<bool> {
    let clock = recording.seen.clock();
    let known = || log.predict(simulator, (d, recording), parameters, nuisances, clock.len());
    let estimated = |p: &Parameter| p.name.strip_prefix(STATE) == Some(name);
    if let Some(i) = recording.nuisances.iter().position(estimated) {
        let here = known()?;
        let mut moved = nuisances.to_vec();
        moved[i] += STATE_STEP * recording.nuisances[i].span();
        return Ok(log.predict(simulator, (d, recording), parameters, &moved, clock.len())? != here);
    }
    let place = recording.known_states.iter().find(|(_, state)| state == name).map(|(place, _)| *place);
    let (Some(place), Some(circumstances)) = (place, &recording.circumstances) else { return Ok(false) };
    let here = known()?;
    let mut other = circumstances.as_ref().clone();
    other.start[place] += STATE_STEP * other.start[place].abs().max(1.0);
    let other = Prepared { circumstances: Some(Arc::new(other)), ..recording.clone() };
    log.spend()?;
    Ok(predict(simulator, &other, parameters, nuisances, clock)? != here)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::{Channel, Kind, Observation};
    use crate::simulator::{FnSimulator, Preparation, StartState, StartValue};

    /// x(t) = x₀ + v₀ t, where v₀ is what its name says.
    fn notes(read: &'static str, most: Option<usize>) -> (Vec<String>, usize) {
        let line = FnSimulator::new(Vec::new(), vec![Channel::new("x", "m")], move |_, run, clock, out| {
            let speed = if read == "speed" { run.start[1] } else { 2.0 };
            clock.iter().zip(out).for_each(|(t, x)| *x = run.start[0] + speed * t);
            Ok(())
        });
        let line = line.start(StartState::new("x", "m", StartValue::First(0)).with_prior(0.1));
        let line = line.start(StartState::new("speed", "m/s", StartValue::Number(2.0)));
        let seen =
            Observation::new(Kind::Other, vec![Channel::new("x", "m")], vec![0.0, 0.1, 0.2], vec![1.0; 3]).unwrap();
        let Preparation::Usable(ready) = line.prepare(&seen).unwrap() else { panic!("usable") };
        let log = RolloutLog::new(most, None, None);
        let recordings: [(usize, &Prepared, &[f64]); 2] = [(0, &ready, &[1.0]), (1, &ready, &[1.1])];
        let notes = unread_states(&line, &recordings, &[], &log);
        (notes.into_iter().map(|note| note.text).collect(), log.count())
    }

    #[test]
    fn a_state_that_no_recording_depends_on_is_said() {
        let (said, rollouts) = notes("position", None);
        assert_eq!((said, rollouts), (vec!["`start.speed` changes nothing in any recording".to_owned()], 5));
        let (said, rollouts) = notes("speed", None);
        assert!(said.is_empty() && rollouts == 3, "the first recording shows both: {rollouts}");
    }

    #[test]
    fn where_no_rollout_is_left_nothing_is_said() {
        assert!(notes("position", Some(1)).0.is_empty());
    }
}

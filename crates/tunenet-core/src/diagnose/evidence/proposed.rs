//! Recordings that could be made next: other starts that the simulator proposes, other inputs and initial states.

use std::sync::Arc;

use crate::Result;
use crate::diagnose::evidence::ar1_prewhitening::Filter;
use crate::diagnose::evidence::recording::PreparedRecording;
use crate::estimate::RolloutLog;
use crate::observation::{Circumstances, Input, Observation};
use crate::simulator::{Parameter, Prepared, ProposedStart, STATE, Simulator, predict};

/// Factors of an input's values, and of the speed at which all inputs are played.
const SCALES: [f64; 3] = [-1.0, 0.3, 2.0];
const SPEEDS: [f64; 2] = [0.3, 2.0];
/// Distances of an initial state from its value, as shares of how far it may start from it.
const SHIFTS: [f64; 2] = [-0.8, 0.8];
/// What differs from the recording that is repeated.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::diagnose) enum Change {
    /// The start, as the simulator proposes it.
    Proposed { text: String, settings: Vec<(String, f64)>, tangential_m_s: f64 },
    /// All values of one input, by a factor.
    Scaled { input: String, factor: f64 },
    /// One input, which keeps this value.
    Constant { input: String, value: f64, unit: String },
    /// The speed at which all inputs are played, by a factor.
    Speed(f64),
    /// The initial value of a state.
    Start { state: String, value: f64, unit: String },
}

impl Change {
    /// What to do, in words.
    pub fn words(&self) -> String {
        match self {
            Self::Proposed { text, .. } => text.clone(),
            Self::Scaled { input, factor } if *factor == -1.0 => format!("repeat a recording with {input} reversed"),
            Self::Scaled { input, factor } => format!("repeat a recording with {factor} times the values of {input}"),
            Self::Constant { input, value, unit } => {
                format!("repeat a recording with {input} constant at {value:.3} {unit}")
            }
            Self::Speed(factor) => format!("repeat a recording with its inputs played at {factor} times the speed"),
            Self::Start { state, value, unit } => format!("repeat a recording from {state} = {value:.3} {unit}"),
        }
    }

    /// Its numbers by name, for scripts.
    pub fn settings(&self) -> Vec<(String, f64)> {
        match self {
            Self::Proposed { settings, .. } => settings.clone(),
            Self::Scaled { input, factor } => vec![(format!("inputs.{input}.scale"), *factor)],
            Self::Constant { input, value, .. } => vec![(format!("inputs.{input}.value"), *value)],
            Self::Speed(factor) => vec![("inputs.speed".into(), *factor)],
            Self::Start { state, value, .. } => vec![(format!("{STATE}{state}"), *value)],
        }
    }
}

/// A recording that could be made, as a model predicts it.
pub(in crate::diagnose) struct Proposed {
    pub recording: PreparedRecording,
    pub change: Change,
}

/// Recordings that could be made after `recording`, as `simulator` predicts them with these values; clock and noise are those of
/// `recording`. None where there is neither a start nor an input nor an initial state to choose.
pub(in crate::diagnose) fn proposed(
    recording: &PreparedRecording,
    simulator: &dyn Simulator,
    (parameters, nuisances): (&[f64], &[f64]),
    rollouts: &RolloutLog,
) -> Result<Vec<Proposed>> {
    let mut all = Vec::new();
    for (change, circumstances, start) in
        starts(recording, simulator, nuisances).into_iter().chain(circumstances(recording, nuisances)?)
    {
        let prepared = Prepared { circumstances, ..recording.prepared.clone() };
        rollouts.spend()?;
        // What cannot be simulated is no proposal.
        let Ok(values) = predict(simulator, &prepared, parameters, &start, recording.clock()) else { continue };
        let mut whole = Prepared::whole(recording.prepared.seen.with_values(values)?, parameters.len());
        whole.circumstances = prepared.circumstances;
        let free = |(p, value): (&Parameter, &f64)| {
            let reach = p.span().max(2.0 * (value - p.value).abs());
            Parameter { value: *value, min: value - reach, max: value + reach, ..p.clone() }
        };
        whole.nuisances = recording.prepared.nuisances.iter().zip(&start).map(free).collect();
        all.push(Proposed { recording: alike(recording, whole), change });
    }
    Ok(all)
}

/// A proposed recording with clock, noise and unmeasured axes of `recording`.
fn alike(recording: &PreparedRecording, prepared: Prepared) -> PreparedRecording {
    let unmeasured = recording.unmeasured();
    let values = prepared.seen.values().len();
    let keep: Vec<bool> = (0..values).map(|i| !unmeasured.contains(&(i % recording.width()))).collect();
    let filter = Filter::new(prepared.seen.clock(), &recording.noise, &keep, 0.0);
    PreparedRecording {
        index: 0,
        object: recording.object,
        motion: 0,
        held_out: false,
        prior_sd: recording.prior_sd.clone(),
        prepared,
        noise: recording.noise.clone(),
        measured_noise: recording.measured_noise.clone(),
        keep,
        resting: 0,
        filter,
        events: Vec::new(),
        held_still: false,
        loss_scale: 1.0,
        random_draws: 0,
        random_parameter: None,
    }
}

type Start = (Change, Option<Arc<Circumstances>>, Vec<f64>);

/// Other starts, where the simulator proposes any.
fn starts(recording: &PreparedRecording, simulator: &dyn Simulator, nuisances: &[f64]) -> Vec<Start> {
    let Some(segmented) = simulator.segmented() else { return Vec::new() };
    let proposed = segmented.proposed_starts(&recording.prepared, nuisances, &recording.unmeasured()).into_iter();
    let start = |ProposedStart { text, settings, nuisances, tangential_m_s }| {
        (Change::Proposed { text, settings, tangential_m_s }, recording.prepared.circumstances.clone(), nuisances)
    };
    proposed.map(start).collect()
}

/// Other inputs, and other values of initial states that are estimated.
fn circumstances(recording: &PreparedRecording, nuisances: &[f64]) -> Result<Vec<Start>> {
    let Some(known) = &recording.prepared.circumstances else { return Ok(Vec::new()) };
    let mut all = Vec::new();
    let same = || nuisances.to_vec();
    for (number, input) in known.inputs.iter().enumerate() {
        let [channel] = input.series().channels() else { continue };
        let with = |values: Vec<f64>| -> Result<Option<Arc<Circumstances>>> {
            let mut made = Circumstances::clone(known);
            made.inputs[number] = Input::new(input.series().with_values(values)?, input.hold());
            Ok(Some(Arc::new(made)))
        };
        let values = input.series().values();
        for factor in SCALES {
            let change = Change::Scaled { input: channel.header(), factor };
            all.push((change, with(values.iter().map(|v| factor * v).collect())?, same()));
        }
        let greatest = values.iter().fold(0.0_f64, |most, v| if v.abs() > most.abs() { *v } else { most });
        for value in [0.0, 0.5 * greatest] {
            let change = Change::Constant { input: channel.header(), value, unit: channel.unit.clone() };
            all.push((change, with(vec![value; values.len()])?, same()));
        }
    }
    for factor in if known.inputs.is_empty() { &[][..] } else { &SPEEDS } {
        let played = known.inputs.iter().map(|input| {
            let series = input.series();
            let clock = series.clock().iter().map(|t| known.start_s + (t - known.start_s) / factor).collect();
            let (channels, values) = (series.channels().to_vec(), series.values().to_vec());
            Ok(Input::new(Observation::new(series.kind(), channels, clock, values)?, input.hold()))
        });
        let made = Circumstances { inputs: played.collect::<Result<_>>()?, ..Circumstances::clone(known) };
        all.push((Change::Speed(*factor), Some(Arc::new(made)), same()));
    }
    for (i, state) in recording.prepared.nuisances.iter().enumerate() {
        let Some(name) = state.name.strip_prefix(STATE) else { continue };
        for shift in SHIFTS {
            let mut start = same();
            start[i] = state.value + shift * reach(recording, name, state);
            let change = Change::Start { state: name.to_owned(), value: start[i], unit: state.unit.clone() };
            all.push((change, Some(Arc::clone(known)), start));
        }
    }
    Ok(all)
}

/// How far a state may start from its value: half the range of the channel that shows it, or half of its bounds.
fn reach(recording: &PreparedRecording, name: &str, state: &Parameter) -> f64 {
    let seen = &recording.prepared.seen;
    let shown = seen.channels().iter().position(|channel| channel.name == name);
    shown.map_or(0.5 * state.span(), |channel| {
        let (low, high) =
            seen.column(channel).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        0.5 * (high - low)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::{Channel, Hold, Kind};
    use crate::simulator::{FnSimulator, Preparation, StartState, StartValue};

    /// x(t) = start + u(t): what is proposed shows the changed input or the changed start.
    #[test]
    fn inputs_and_initial_states_are_varied() {
        let follower = FnSimulator::new(Vec::new(), vec![Channel::new("x", "m")], |_, run, clock, out| {
            clock.iter().zip(out).for_each(|(&t, x)| *x = run.start[0] + run.input(0, t));
            Ok(())
        })
        .start(StartState::new("x", "m", StartValue::Number(1.0)).within(-4.0, 4.0));
        let times = vec![0.0, 1.0, 2.0, 3.0];
        let input = Input::sampled(Channel::new("u", "V"), Hold::Linear, times.clone(), vec![0.0, 2.0, -4.0, 1.0]);
        let seen = Observation::new(Kind::Other, vec![Channel::new("x", "m")], times, vec![1.0, 3.0, -3.0, 2.0]);
        let seen = seen.unwrap().under(Arc::new(Circumstances::driven_by(vec![input.unwrap()])));
        let Preparation::Usable(prepared) = follower.prepare(&seen).unwrap() else { panic!("usable") };
        let recording = PreparedRecording::new(0, 0, false, *prepared);
        let all = proposed(&recording, &follower, (&[], &[1.0]), &RolloutLog::default()).unwrap();
        let of = |text: &str| {
            let found = all.iter().find(|one| one.change.words().ends_with(text));
            found.unwrap_or_else(|| panic!("{text}")).recording.prepared.seen.values().to_vec()
        };
        assert_eq!(of("2 times the values of u_v"), [1.0, 5.0, -7.0, 3.0]);
        assert_eq!(of("u_v reversed"), [1.0, -1.0, 5.0, 0.0]);
        assert_eq!(of("u_v constant at -2.000 V"), [-1.0; 4]);
        assert_eq!(of("played at 2 times the speed"), [1.0, -3.0, 2.0, 2.0]);
        // Half the range of x is 3 m.
        let moved = of("from x = 3.400 m");
        assert!(moved.iter().zip([3.4, 5.4, -0.6, 4.4]).all(|(a, b)| (a - b).abs() < 1e-12), "{moved:?}");
        assert!(all.iter().any(|one| one.change.settings() == [("inputs.u_v.scale".to_owned(), 2.0)]));
    }
}

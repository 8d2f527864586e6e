//! A simulator whose initial states and candidate effects are declared as data: what it simulates is a [`Model`].

use std::sync::Arc;

use super::{
    Effect, Parameter, Preparation, Prepared, RolloutError, RolloutResult, Simulator, StartState, StartValue,
    measurement_effects,
};
use crate::observation::{Channel, Circumstances, Kind, Observation};
use crate::{Error, Origin, Result};

/// One rollout that is asked of a [`Model`].
#[derive(Debug, Clone, Copy)]
pub struct Run<'a> {
    /// The parameters and the coefficients, one after the other.
    pub numbers: &'a [f64],
    /// The values of the parameters, in their order.
    pub parameters: &'a [f64],
    /// The coefficients of all candidates, in their order; those of an absent candidate have the values that mean "absent".
    pub coefficients: &'a [f64],
    /// What drove the thing, which setup it had, and its first instant.
    pub recording: &'a Circumstances,
    /// The initial state at the recording's first instant, in the order of the states.
    pub start: &'a [f64],
    /// Instants to predict, rising, s. They need not include the first instant of the recording.
    pub times_s: &'a [f64],
}

impl Run<'_> {
    /// The value of input `number` at an instant, by its hold; inputs have one channel each.
    ///
    /// # Panics
    /// Where the recording has no such input.
    #[must_use]
    pub fn input(&self, number: usize, time_s: f64) -> f64 {
        self.recording.inputs[number].at(0, time_s)
    }
}

/// What simulates, without any bookkeeping of effects and states.
pub trait Model: Send + Sync {
    /// Writes the prediction for every instant of [`Run::times_s`] into `values`, row-major `[sample, channel]`. Deterministic:
    /// the same run gives the same bits.
    ///
    /// # Errors
    /// Where these values cannot be simulated, or the simulator failed.
    fn simulate(&self, run: &Run, values: &mut [f64]) -> RolloutResult;

    /// Whether its candidates hold all that can go wrong with the measurement.
    fn has_own_measurement(&self) -> bool {
        false
    }

    /// Whether the initial state may hold at an earlier instant than the recording's first, where stamps are late.
    fn starts_earlier(&self) -> bool {
        true
    }

    /// Whether it refuses initial states that it does not know.
    fn checks_states(&self) -> bool {
        false
    }

    /// Examines a recording that was made ready as it was declared: cuts it, notes what is odd, or rejects it. By default it is
    /// usable as it is.
    ///
    /// # Errors
    /// Where another recording cannot be made of it.
    fn examine(&self, prepared: Box<Prepared>) -> Result<Preparation> {
        Ok(Preparation::Usable(prepared))
    }
}

impl<F: Fn(&Run, &mut [f64]) -> RolloutResult + Send + Sync> Model for F {
    fn simulate(&self, run: &Run, values: &mut [f64]) -> RolloutResult {
        self(run, values)
    }
}

/// A [`Model`] as a simulator that [`tune`](crate::tune::tune) and [`diagnose`](crate::diagnose::diagnose) work on.
#[derive(Debug)]
pub struct Declared<M> {
    model: Arc<M>,
    channels: Vec<Channel>,
    /// Its own, then the coefficients of the carried candidates.
    parameters: Vec<Parameter>,
    /// How many are its own.
    own: usize,
    /// The initial states of each setup.
    setups: Vec<Vec<StartState>>,
    candidates: Vec<Candidate>,
    /// Positions of the candidates whose coefficients are parameters, in that order.
    carried: Vec<usize>,
}

/// An effect, and its coefficients where it is there at fixed values.
#[derive(Debug, Clone)]
struct Candidate {
    effect: Effect,
    present: Option<Vec<f64>>,
}

impl<M> Clone for Declared<M> {
    fn clone(&self) -> Self {
        Self {
            model: Arc::clone(&self.model),
            channels: self.channels.clone(),
            parameters: self.parameters.clone(),
            own: self.own,
            setups: self.setups.clone(),
            candidates: self.candidates.clone(),
            carried: self.carried.clone(),
        }
    }
}

impl<M: Model> Declared<M> {
    /// A simulator without initial states and candidates.
    pub fn new(model: M, parameters: Vec<Parameter>, channels: Vec<Channel>) -> Self {
        Self {
            model: Arc::new(model),
            channels,
            own: parameters.len(),
            parameters,
            setups: vec![Vec::new()],
            candidates: Vec::new(),
            carried: Vec::new(),
        }
    }

    /// The same with one more initial state, in the first setup.
    #[must_use]
    pub fn start(mut self, state: StartState) -> Self {
        self.setups[0].push(state);
        self
    }

    /// The same with these initial states, a list for each setup of its recordings (see [`Circumstances::setup`]), each of the same
    /// states in the same order.
    #[must_use]
    pub fn setups(self, mut setups: Vec<Vec<StartState>>) -> Self {
        if setups.is_empty() {
            setups.push(Vec::new());
        }
        Self { setups, ..self }
    }

    /// The same with one more effect that may be missing.
    #[must_use]
    pub fn candidate(mut self, effect: Effect) -> Self {
        self.candidates.push(Candidate { effect, present: None });
        self
    }

    /// The same with one more effect that is there, at these values of its coefficients.
    ///
    /// # Errors
    /// [`Error::Parameter`] where a value lies outside its bounds.
    pub fn present(mut self, effect: Effect, values: &[f64]) -> Result<Self> {
        effect.parameters(Some(values))?;
        self.candidates.push(Candidate { effect, present: Some(values.to_vec()) });
        Ok(self)
    }

    /// What simulates.
    #[must_use]
    pub fn model(&self) -> &M {
        &self.model
    }

    /// The initial states of a setup.
    fn states(&self, setup: usize) -> Result<&[StartState]> {
        let known = self.setups.len();
        self.setups.get(setup).map(Vec::as_slice).ok_or_else(|| Error::Observation {
            what: "the setup of the recording".into(),
            expected: format!("a number below {known}"),
            found: setup.to_string(),
        })
    }

    /// Its own parameters and the coefficients of all candidates.
    fn numbers(&self, parameters: &[f64]) -> Vec<f64> {
        let (own, mut free) = parameters.split_at(self.own);
        let mut all = own.to_vec();
        let mut coefficients: Vec<Vec<f64>> = self.candidates.iter().map(Candidate::values).collect();
        for &i in &self.carried {
            let count = coefficients[i].len().min(free.len());
            let (values, rest) = free.split_at(count);
            coefficients[i] = values.to_vec();
            free = rest;
        }
        all.extend(coefficients.into_iter().flatten());
        all
    }

    fn run(
        &self,
        parameters: &[f64],
        nuisances: &[f64],
        recording: &Circumstances,
        times_s: &[f64],
        values: &mut [f64],
    ) -> RolloutResult {
        let numbers = self.numbers(parameters);
        let states = self.states(recording.setup).map_err(|error| RolloutError::Refused(error.to_string()))?;
        let mut start = recording.start.clone();
        let free = (0..states.len()).filter(|&i| states[i].is_free());
        for (i, value) in free.zip(nuisances) {
            start[i] = *value;
        }
        let (parameters, coefficients) = numbers.split_at(self.own);
        // A state that is estimated is that of the first sample, however late its stamp: the thing did not rest until that instant.
        let earlier = times_s.first().copied().filter(|first| {
            *first < recording.start_s && states.iter().any(StartState::is_free) && self.model.starts_earlier()
        });
        let earlier = earlier.map(|start_s| Circumstances { start_s, ..recording.clone() });
        let recording = earlier.as_ref().unwrap_or(recording);
        let run = Run { numbers: &numbers, parameters, coefficients, recording, start: &start, times_s };
        self.model.simulate(&run, values)
    }
}

impl Candidate {
    fn values(&self) -> Vec<f64> {
        let absent = || self.effect.coefficients.iter().map(|c| c.absent).collect();
        self.present.clone().unwrap_or_else(absent)
    }
}

impl<M: Model + 'static> Simulator for Declared<M> {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// The initial state holds at the first sample. What of it is estimated becomes a nuisance parameter `start.NAME`.
    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        if seen.kind() != Kind::Other || seen.channels() != self.channels {
            let names = |channels: &[Channel]| channels.iter().map(Channel::header).collect::<Vec<_>>().join(", ");
            return Err(Error::Observation {
                what: "the channels".into(),
                expected: names(&self.channels),
                found: names(seen.channels()),
            });
        }
        let mut known = seen.circumstances().map(|known| Circumstances::clone(known)).unwrap_or_default();
        known.start_s = seen.clock()[0];
        let mut prepared = Prepared::whole(seen.clone(), self.parameters.len());
        let states = self.states(known.setup)?;
        known.start = states.iter().map(|state| state.value(seen)).collect();
        for (position, (state, value)) in states.iter().zip(&known.start).enumerate() {
            if let Some((nuisance, sd)) = state.nuisance(*value)? {
                prepared.begin.push(state.begin(seen, &nuisance));
                prepared.nuisances.push(nuisance);
                prepared.prior_sd.push(sd);
            } else if !self.model.checks_states() {
                prepared.known_states.push((position, state.name.clone()));
            }
        }
        prepared.circumstances = Some(Arc::new(known));
        self.model.examine(Box::new(prepared))
    }

    fn effects(&self) -> Vec<Effect> {
        let absent = (0..self.candidates.len()).filter(|i| !self.carried.contains(i)).map(|i| &self.candidates[i]);
        absent.filter(|candidate| candidate.present.is_none()).map(|candidate| candidate.effect.clone()).collect()
    }

    fn measured_effects(&self) -> Vec<Effect> {
        if self.model.has_own_measurement() { Vec::new() } else { measurement_effects(self.kind()) }
    }

    fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
        let mut made = self.clone();
        for name in names {
            let new = |i: &usize| self.candidates[*i].effect.name == *name && !made.carried.contains(i);
            let Some(i) = (0..self.candidates.len()).find(new) else {
                let known = self.candidates.iter().map(|c| c.effect.name.to_string()).collect::<Vec<_>>().join(", ");
                let expected = format!("an effect that this simulator declares ({known}), once");
                let found = format!("`{name}`");
                return Err(Error::Setting { origin: Origin::Caller, name: "effects", expected, found });
            };
            let Candidate { effect, present } = &self.candidates[i];
            made.parameters.extend(effect.parameters(present.as_deref())?);
            made.carried.push(i);
        }
        Ok(Box::new(made))
    }

    /// In the first setup, without inputs, from the first of these instants on.
    fn rollout(&self, parameters: &[f64], nuisances: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
        let known = |state: &StartState| match state.value {
            StartValue::Number(value) => Ok(value),
            StartValue::First(_) => {
                Err(format!("`start.{}` is a recording's first sample, and there is no recording", state.name))
            }
        };
        let start = self.setups[0].iter().map(known).collect::<std::result::Result<_, _>>()?;
        let start_s = clock.first().copied().unwrap_or(0.0);
        let recording = Circumstances { start_s, start, ..Circumstances::default() };
        self.run(parameters, nuisances, &recording, clock, values)
    }

    fn rollout_driven(
        &self,
        parameters: &[f64],
        nuisances: &[f64],
        circumstances: &Circumstances,
        clock: &[f64],
        values: &mut [f64],
    ) -> RolloutResult {
        self.run(parameters, nuisances, circumstances, clock, values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::{Hold, Input};
    use crate::simulator::{Coefficient, Phase, predict};

    fn effect(name: &'static str) -> Effect {
        Effect::new(name, Phase::Joint, "", vec![Coefficient::new("k", "1", 1.0, (0.0, 5.0), 0.1)])
    }

    /// x(t) = start + (mass + spring) u(t) + drag, to see which number arrives where.
    fn simulator() -> Declared<impl Model> {
        let model = |run: &Run, values: &mut [f64]| {
            let [spring, drag] = run.coefficients else { return Err("two coefficients".into()) };
            for (value, &t) in values.iter_mut().zip(run.times_s) {
                *value = run.start[0] + (run.parameters[0] + spring) * run.input(0, t) + 100.0 * drag;
            }
            Ok(())
        };
        let mass = Parameter::new("mass", "kg", 2.0, 0.0, 10.0).unwrap();
        let start = StartState::new("x", "m", StartValue::First(0)).with_prior(0.5);
        Declared::new(model, vec![mass], vec![Channel::new("x", "m")])
            .start(start)
            .candidate(effect("spring"))
            .present(effect("drag"), &[3.0])
            .unwrap()
    }

    fn recording() -> Observation {
        let clock = vec![10.0, 11.0, 12.0];
        let force = Input::sampled(Channel::new("u", "N"), Hold::Previous, clock.clone(), vec![1.0, 2.0, 3.0]).unwrap();
        let seen = Observation::new(Kind::Other, vec![Channel::new("x", "m")], clock, vec![7.0, 8.0, 9.0]).unwrap();
        seen.under(Circumstances::driven_by(vec![force]))
    }

    fn prepared(simulator: &dyn Simulator) -> Prepared {
        let Preparation::Usable(prepared) = simulator.prepare(&recording()).unwrap() else { panic!("usable") };
        *prepared
    }

    #[test]
    fn the_start_is_a_nuisance_parameter_with_its_prior() {
        let ready = prepared(&simulator());
        let known = ready.circumstances.as_ref().unwrap();
        assert_eq!((known.start_s, known.start.as_slice()), (10.0, &[7.0][..]));
        assert_eq!(
            (ready.nuisances[0].name.as_str(), ready.nuisances[0].value, ready.prior_sd(0)),
            ("start.x", 7.0, 0.5)
        );
    }

    /// x(t) = start + (t − first instant): stamps that are late by 0.5 s change nothing where the start is estimated; a known start holds
    /// at the first stamp.
    #[test]
    fn an_estimated_start_is_that_of_the_first_sample_however_late_its_stamp() {
        let model = |run: &Run, values: &mut [f64]| {
            for (value, &t) in values.iter_mut().zip(run.times_s) {
                *value = run.start[0] + (t - run.recording.start_s).max(0.0);
            }
            Ok(())
        };
        let of = |start: StartState| Declared::new(model, Vec::new(), vec![Channel::new("x", "m")]).start(start);
        let late = |simulator: &dyn Simulator, nuisances: &[f64]| {
            let ready = prepared(simulator);
            predict(simulator, &ready, &[], nuisances, &[9.5, 10.5, 11.5]).unwrap()
        };
        let start = StartState::new("x", "m", StartValue::First(0));
        assert_eq!(late(&of(start.clone().with_prior(0.5)), &[7.0]), [7.0, 8.0, 9.0]);
        assert_eq!(late(&of(start), &[]), [7.0, 7.5, 8.5]);
    }

    #[test]
    fn coefficients_are_absent_present_or_free() {
        let plain = simulator();
        let ready = prepared(&plain);
        let at = |simulator: &dyn Simulator, p: &[f64]| predict(simulator, &ready, p, &[1.0], &[11.5]).unwrap();
        assert_eq!(at(&plain, &[2.0]), [1.0 + (2.0 + 1.0) * 2.0 + 300.0]);
        assert_eq!(plain.effects().iter().map(|e| e.name.to_string()).collect::<Vec<_>>(), ["spring"]);
        let both = plain.with_effects(&["drag", "spring"]).unwrap();
        let values: Vec<f64> = both.parameters().iter().map(|p| p.value).collect();
        assert_eq!(values, [2.0, 3.0, 1.0], "one that is there begins there");
        assert_eq!(at(both.as_ref(), &[2.0, 0.5, 4.0]), [1.0 + (2.0 + 4.0) * 2.0 + 50.0]);
        assert!(plain.with_effects(&["lift"]).is_err() && plain.with_effects(&["drag", "drag"]).is_err());
    }

    #[test]
    fn a_start_that_only_a_recording_knows_is_refused_without_one() {
        let mut values = [0.0];
        let refused = simulator().rollout(&[2.0], &[], &[0.0], &mut values).unwrap_err();
        assert!(refused.message().contains("`start.x`"), "{refused}");
    }

    #[test]
    fn another_setup_than_those_declared_is_refused() {
        let other = Circumstances { setup: 1, ..Circumstances::default() };
        let refused = simulator().prepare(&recording().under(other)).unwrap_err();
        assert!(refused.to_string().contains("a number below 1"), "{refused}");
    }
}

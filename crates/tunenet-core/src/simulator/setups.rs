//! Recordings of one thing in several setups (constants that differ from recording to recording): a simulator for each setup.

use std::sync::Arc;

use super::{
    Assumed, Effect, Parameter, Preparation, Prepared, ProposedStart, RolloutError, RolloutResult, Segmented,
    Simulator, Text,
};
use crate::observation::{Channel, Circumstances, Kind, Observation};
use crate::{Error, Origin, Result};

/// Simulators of one thing, one for each setup of its recordings: [`Circumstances::setup`] of a recording says which of them
/// prepares and predicts it.
///
/// All have the same parameters, channels and effects. Only a parameter that none of them tunes may have a value of its own in
/// each setup, which is then used instead of the one that a rollout is asked with.
///
/// A recording has to say its setup, and its parts keep it. The simulators within must not read the number themselves: they know
/// one setup, their own.
///
/// ```
/// use std::sync::Arc;
/// use tunenet_core::observation::{Channel, Circumstances, Kind, Observation};
/// use tunenet_core::simulator::{Parameter, RolloutResult, Setups, Simulator};
/// use tunenet_core::tune::{Settings, tune};
///
/// /// Falls from rest by k g t²/2.
/// struct Fall { g: f64, k: Vec<Parameter>, channels: Vec<Channel> }
/// impl Simulator for Fall {
///     fn parameters(&self) -> &[Parameter] { &self.k }
///     fn channels(&self) -> &[Channel] { &self.channels }
///     fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
///         clock.iter().zip(values).for_each(|(t, v)| *v = 0.5 * p[0] * self.g * t * t);
///         Ok(())
///     }
/// }
/// let channels = vec![Channel::new("fallen", "m")];
/// let fall = |g| -> tunenet_core::Result<Box<dyn Simulator>> {
///     Ok(Box::new(Fall { g, k: vec![Parameter::new("k", "1", 1.0, 0.0, 2.0)?], channels: channels.clone() }))
/// };
/// let both = Setups::of(vec![fall(9.81)?, fall(1.62)?])?;
/// // One on the earth and one on the moon, of the same k = 0.8.
/// let recorded = |setup: usize, g: f64| {
///     let clock: Vec<f64> = (0..30).map(|i| f64::from(i) * 0.02).collect();
///     let fallen = clock.iter().map(|t| 0.4 * g * t * t).collect();
///     let seen = Observation::new(Kind::Other, channels.clone(), clock, fallen)?;
///     Ok::<_, tunenet_core::Error>(seen.under(Circumstances { setup, ..Circumstances::default() }))
/// };
/// let found = tune(&both, &[recorded(0, 9.81)?, recorded(1, 1.62)?], None, &Settings::default())?;
/// assert!((found.parameters[0].value - 0.8).abs() < 1e-6);
/// # Ok::<(), tunenet_core::Error>(())
/// ```
pub struct Setups {
    /// One for each setup; never empty.
    each: Vec<Arc<dyn Simulator>>,
    /// For each parameter that has a value of its own in each setup: its position and those values.
    own: Vec<(usize, Vec<f64>)>,
}

impl Setups {
    /// The simulator of recordings in these setups; with a single one, that one itself.
    ///
    /// # Errors
    /// [`Error::Setting`] where there is none, or they differ in parameters, channels, kind or effects.
    pub fn of(mut each: Vec<Box<dyn Simulator>>) -> Result<Box<dyn Simulator>> {
        match each.len() {
            0 => Err(differ("at least one setup".into(), "none".into())),
            1 => Ok(each.remove(0)),
            _ => Ok(Box::new(Self::checked(each.into_iter().map(Arc::from).collect())?)),
        }
    }

    fn checked(each: Vec<Arc<dyn Simulator>>) -> Result<Self> {
        let first = &each[0];
        for (number, other) in each.iter().enumerate().skip(1) {
            let names = |all: &[Parameter]| all.iter().map(|p| p.name.clone()).collect::<Vec<_>>().join(", ");
            let headers = |all: &[Channel]| all.iter().map(Channel::header).collect::<Vec<_>>().join(", ");
            let effects = |all: &[Effect]| all.iter().map(|e| e.name.to_string()).collect::<Vec<_>>().join(", ");
            let (mine, theirs) = (first.effects(), other.effects());
            let alike = |(a, b): (&Effect, &Effect)| a.name == b.name && a.coefficients == b.coefficients;
            let (what, expected, found) = if names(first.parameters()) != names(other.parameters()) {
                ("parameters", names(first.parameters()), names(other.parameters()))
            } else if first.kind() != other.kind() || first.channels() != other.channels() {
                ("channels", headers(first.channels()), headers(other.channels()))
            } else if mine.len() != theirs.len() || !mine.iter().zip(&theirs).all(alike) {
                ("effects", effects(&mine), effects(&theirs))
            } else {
                continue;
            };
            let expected = format!("the same {what} in every setup ({expected})");
            return Err(differ(expected, format!("`{found}` in setup {}", number + 1)));
        }
        let own = own_values(&each)?;
        Ok(Self { each, own })
    }

    /// The same setups of other simulators, in their order.
    fn each_with(&self, made: impl Fn(&dyn Simulator) -> Result<Box<dyn Simulator>>) -> Result<Self> {
        Self::checked(self.each.iter().map(|one| Ok(Arc::from(made(one.as_ref())?))).collect::<Result<_>>()?)
    }

    /// The same variant of every setup, where all have it.
    fn variant(&self, made: impl Fn(&dyn Segmented) -> Option<Box<dyn Simulator>>) -> Option<Box<dyn Simulator>> {
        let each = self.each.iter().map(|one| Some(Arc::from(made(one.segmented()?)?)));
        Some(Box::new(Self::checked(each.collect::<Option<_>>()?).ok()?))
    }

    /// The same with a constant at the upper end of its range, wherever a setup takes it for granted.
    fn at_upper(&self, setting: &str) -> Self {
        let one = |one: &Arc<dyn Simulator>| {
            let mut assumed = one.assumed().into_iter();
            assumed
                .find(|known| known.setting == setting)
                .map_or_else(|| Arc::clone(one), |known| Arc::from(known.at_upper))
        };
        Self { each: self.each.iter().map(one).collect(), own: self.own.clone() }
    }

    /// The simulator of a setup.
    fn setup(&self, number: usize) -> Result<&dyn Simulator> {
        self.each.get(number).map(AsRef::as_ref).ok_or_else(|| self.unknown(number.to_string()))
    }

    fn unknown(&self, found: String) -> Error {
        let expected = format!("a number below {}", self.each.len());
        Error::Observation { what: "the setup of the recording".into(), expected, found }
    }

    /// The parameters with the values that a setup has for itself.
    fn parameters_in(&self, setup: usize, parameters: &[f64]) -> Vec<f64> {
        let mut all = parameters.to_vec();
        for (parameter, values) in &self.own {
            all[*parameter] = values[setup];
        }
        all
    }
}

fn differ(expected: String, found: String) -> Error {
    Error::Setting { origin: Origin::Caller, name: "setups", expected, found }
}

/// The parameters that no setup tunes and whose values differ, with those values.
fn own_values(each: &[Arc<dyn Simulator>]) -> Result<Vec<(usize, Vec<f64>)>> {
    let mut own = Vec::new();
    for (i, first) in each[0].parameters().iter().enumerate() {
        let all: Vec<&Parameter> = each.iter().map(|one| &one.parameters()[i]).collect();
        if all.iter().all(|p| *p == first) {
            continue;
        }
        if let Some(other) = all.iter().find(|p| p.tune || p.known95.is_some()) {
            let kept = |p: &Parameter| if p.tune { "tuned" } else { "fixed" };
            let described = |p: &Parameter| format!("{} ({} to {}, {})", p.value, p.min, p.max, kept(p));
            let unlike = all.iter().find(|p| **p != first).unwrap_or(other);
            let expected = format!("the same `{}` in every setup, {}", first.name, described(first));
            return Err(differ(expected, described(unlike)));
        }
        own.push((i, all.iter().map(|p| p.value).collect()));
    }
    Ok(own)
}

/// An effect of which every setup knows an entry: what is plausible in any of them is plausible, and what is implausible in all of
/// them is implausible.
fn joined(mut entry: Effect, others: impl Iterator<Item = Effect>) -> Effect {
    for other in others {
        for (range, (low, high)) in entry.plausible.iter_mut().zip(other.plausible) {
            *range = (range.0.min(low), range.1.max(high));
        }
        let new = |setting: &Text| !entry.plausible_rests_on.contains(setting);
        let rests_on: Vec<Text> = other.plausible_rests_on.into_iter().filter(new).collect();
        entry.plausible_rests_on.extend(rests_on);
        entry.implausible = entry.implausible.filter(|_| other.implausible.is_some());
        entry.feigned_by = entry.feigned_by.or(other.feigned_by);
    }
    entry
}

impl Simulator for Setups {
    fn parameters(&self) -> &[Parameter] {
        self.each[0].parameters()
    }

    fn channels(&self) -> &[Channel] {
        self.each[0].channels()
    }

    fn kind(&self) -> Kind {
        self.each[0].kind()
    }

    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        let known = seen.circumstances().ok_or_else(|| self.unknown("none".into()))?;
        let preparation = self.setup(known.setup)?.prepare(seen)?;
        let Preparation::Usable(prepared) = preparation else { return Ok(preparation) };
        // Every rollout and every part of it has to reach this setup again.
        let mut circumstances = prepared.circumstances.as_deref().unwrap_or(known).clone();
        circumstances.setup = known.setup;
        let part = prepared.seen.circumstances().unwrap_or(known);
        let seen = prepared.seen.clone().under(Arc::clone(part));
        let circumstances = Some(Arc::new(circumstances));
        Ok(Preparation::Usable(Box::new(Prepared { seen, circumstances, ..*prepared })))
    }

    fn effects(&self) -> Vec<Effect> {
        let known: Vec<Vec<Effect>> = self.each.iter().map(|one| one.effects()).collect();
        let one = |(i, entry): (usize, &Effect)| {
            joined(entry.clone(), known[1..].iter().filter_map(|other| other.get(i).cloned()))
        };
        known[0].iter().enumerate().map(one).collect()
    }

    fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
        Ok(Box::new(self.each_with(|one| one.with_effects(names))?))
    }

    /// Those of any setup; at the upper end in all setups that take them for granted.
    fn assumed(&self) -> Vec<Assumed> {
        let mut found: Vec<Assumed> = Vec::new();
        for assumed in self.each.iter().flat_map(|one| one.assumed()) {
            if found.iter().all(|known| known.setting != assumed.setting) {
                let at_upper = Box::new(self.at_upper(assumed.setting));
                found.push(Assumed { at_upper, ..assumed });
            }
        }
        found
    }

    fn segmented(&self) -> Option<&dyn Segmented> {
        self.each.iter().all(|one| one.segmented().is_some()).then_some(self as &dyn Segmented)
    }

    fn rollout(&self, _: &[f64], _: &[f64], _: &[f64], _: &mut [f64]) -> RolloutResult {
        Err(RolloutError::Broken(self.unknown("none".into()).to_string()))
    }

    fn rollout_driven(
        &self,
        parameters: &[f64],
        nuisances: &[f64],
        circumstances: &Circumstances,
        clock: &[f64],
        values: &mut [f64],
    ) -> RolloutResult {
        let number = circumstances.setup;
        let one = self.setup(number).map_err(|error| RolloutError::Broken(error.to_string()))?;
        if self.own.is_empty() {
            return one.rollout_driven(parameters, nuisances, circumstances, clock, values);
        }
        one.rollout_driven(&self.parameters_in(number, parameters), nuisances, circumstances, clock, values)
    }
}

/// Setups whose free segments and hidden states are those of each.
impl Segmented for Setups {
    fn free_segment(&self) -> Option<Box<dyn Simulator>> {
        self.variant(|one| one.free_segment())
    }

    fn with_hidden_state(&self) -> Option<Box<dyn Simulator>> {
        self.variant(|one| one.with_hidden_state())
    }

    fn with_hidden_state_at_events(&self) -> Option<Box<dyn Simulator>> {
        self.variant(|one| one.with_hidden_state_at_events())
    }

    /// Those of the setup of the recording.
    fn proposed_starts(&self, prepared: &Prepared, nuisances: &[f64], unmeasured: &[usize]) -> Vec<ProposedStart> {
        let number = prepared.circumstances.as_ref().map_or(0, |known| known.setup);
        let one = self.each.get(number).and_then(|one| one.segmented());
        one.map_or_else(Vec::new, |one| one.proposed_starts(prepared, nuisances, unmeasured))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::{Coefficient, Phase, predict};
    use crate::testing::{Exact, Shuttle};
    use crate::tune::{Settings, tune};

    /// y = k g t²/2 + p t, where `p` is an effect and `offset` a parameter that is not tuned.
    #[derive(Clone)]
    struct Fall {
        gravity: f64,
        parameters: Vec<Parameter>,
        channels: Vec<Channel>,
    }

    const PUSH: Coefficient = Coefficient::new("p", "m/s", 0.0, (-5.0, 5.0), 0.1);

    impl Simulator for Fall {
        fn parameters(&self) -> &[Parameter] {
            &self.parameters
        }

        fn channels(&self) -> &[Channel] {
            &self.channels
        }

        fn effects(&self) -> Vec<Effect> {
            let plausible = vec![(0.0, 0.1 * self.gravity)];
            vec![Effect { plausible, ..Effect::new("push", Phase::Segment, "", vec![PUSH]) }]
        }

        fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
            let mut made = self.clone();
            for _ in names {
                made.parameters.push(Parameter::new("push.p", "m/s", 0.0, -5.0, 5.0)?);
            }
            Ok(Box::new(made))
        }

        fn assumed(&self) -> Vec<Assumed> {
            let usual = (self.gravity - 9.81).abs() < 1e-9;
            let at_upper = Box::new(Self { gravity: 9.83, ..self.clone() });
            let one = Assumed { setting: "gravity", value: self.gravity, range: (9.79, 9.83), unit: "m/s²", at_upper };
            if usual { vec![one] } else { Vec::new() }
        }

        fn rollout(&self, p: &[f64], _: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
            let push = p.get(2).copied().unwrap_or(0.0);
            clock.iter().zip(values).for_each(|(t, y)| *y = 0.5 * p[0] * self.gravity * t * t + p[1] + push * t);
            Ok(())
        }
    }

    fn fall(gravity: f64, offset: f64) -> Fall {
        let fixed = Parameter { tune: false, ..Parameter::new("offset", "m", offset, -9.0, 9.0).unwrap() };
        let parameters = vec![Parameter::new("k", "1", 1.0, 0.0, 2.0).unwrap(), fixed];
        Fall { gravity, parameters, channels: vec![Channel::new("y", "m")] }
    }

    fn setups(each: &[Fall]) -> Result<Box<dyn Simulator>> {
        Setups::of(each.iter().map(|one| Box::new(one.clone()) as Box<dyn Simulator>).collect())
    }

    /// Half a second of `0.8 g t²/2 + offset + push t` in a setup.
    fn recorded(setup: usize, gravity: f64, offset: f64, push: f64) -> Observation {
        let clock: Vec<f64> = (0..40).map(|i| f64::from(i) / 80.0).collect();
        let values = clock.iter().map(|t| 0.4 * gravity * t * t + offset + push * t).collect();
        let seen = Observation::new(Kind::Other, vec![Channel::new("y", "m")], clock, values).unwrap();
        seen.under(Circumstances { setup, ..Circumstances::default() })
    }

    fn usable(simulator: &dyn Simulator, seen: &Observation) -> Prepared {
        let Preparation::Usable(prepared) = simulator.prepare(seen).unwrap() else { panic!("usable") };
        *prepared
    }

    #[test]
    fn each_recording_is_tuned_to_in_its_own_setup() {
        let both = setups(&[fall(9.81, 0.0), fall(1.62, 0.0)]).unwrap();
        let found = |all: &[Observation]| tune(&both, all, None, &Settings::default()).unwrap().parameters[0].value;
        let right = [recorded(0, 9.81, 0.0, 0.0), recorded(1, 1.62, 0.0, 0.0)];
        assert!((found(&right) - 0.8).abs() < 1e-9);
        // Both in the setup of the earth: a k between 0.8 and 0.8 · 1.62 / 9.81.
        let wrong = right.map(|seen| seen.under(Circumstances::default()));
        assert!(found(&wrong) < 0.7);
    }

    #[test]
    fn parts_of_a_recording_keep_its_setup() {
        let both = setups(&[fall(9.81, 0.0), fall(1.62, 0.0)]).unwrap();
        let whole = recorded(1, 1.62, 0.0, 0.0);
        for part in [whole.slice(5..20).unwrap(), whole.thinned(10).unwrap().unwrap(), whole.from_zero()] {
            let prepared = usable(&both, &part);
            assert_eq!(prepared.circumstances.as_ref().unwrap().setup, 1);
            let again = usable(&both, &prepared.seen.slice(0..4).unwrap());
            let at = predict(&both, &again, &[1.0, 0.0], &[], &[1.0]).unwrap();
            assert!((at[0] - 0.81).abs() < 1e-12, "{at:?}");
        }
    }

    #[test]
    fn a_single_setup_is_the_simulator_itself() {
        let one = setups(&[fall(9.81, 0.0)]).unwrap();
        let mut values = [0.0];
        one.rollout(&[1.0, 0.0], &[], &[1.0], &mut values).unwrap();
        assert_eq!(values, [0.5 * 9.81]);
        assert!(Setups::of(Vec::new()).is_err());
    }

    #[test]
    fn a_recording_without_its_setup_is_refused() {
        let both = setups(&[fall(9.81, 0.0), fall(1.62, 0.0)]).unwrap();
        let nowhere = Observation::new(Kind::Other, vec![Channel::new("y", "m")], vec![0.0, 1.0, 2.0], vec![0.0; 3]);
        let message = both.prepare(&nowhere.unwrap()).unwrap_err().to_string();
        assert_eq!(message, "the setup of the recording: expected a number below 2, found none");
        assert!(both.prepare(&recorded(2, 9.81, 0.0, 0.0)).unwrap_err().to_string().ends_with("found 2"));
        let refused = both.rollout(&[1.0, 0.0], &[], &[1.0], &mut [0.0]).unwrap_err();
        assert!(matches!(refused, RolloutError::Broken(_)), "{refused}");
    }

    #[test]
    fn what_all_setups_share_must_agree() {
        let refused = |second: Fall| setups(&[fall(9.81, 0.0), second]).map(|_| ()).unwrap_err().to_string();
        let mut other = fall(9.81, 0.0);
        other.parameters[0].value = 0.5;
        let message = refused(other);
        assert!(message.contains("the same `k` in every setup, 1 (0 to 2, tuned), found 0.5"), "{message}");
        let mut other = fall(9.81, 0.0);
        other.channels = vec![Channel::new("z", "m")];
        assert!(refused(other).contains("the same channels in every setup (y_m), found `z_m` in setup 2"));
        let mut other = fall(9.81, 0.0);
        other.parameters.truncate(1);
        assert!(refused(other).contains("the same parameters in every setup (k, offset), found `k` in setup 2"));
    }

    #[test]
    fn a_fixed_parameter_may_have_a_value_of_its_own_in_each_setup() {
        let both = setups(&[fall(9.81, 0.5), fall(9.81, -0.5)]).unwrap();
        let seen = [recorded(0, 9.81, 0.5, 0.0), recorded(1, 9.81, -0.5, 0.0)];
        let found = tune(&both, &seen, None, &Settings::default()).unwrap();
        assert!((found.parameters[0].value - 0.8).abs() < 1e-9, "{:?}", found.parameters);
    }

    #[test]
    fn effects_are_those_of_all_setups() {
        let both = setups(&[fall(9.81, 0.0), fall(1.62, 0.0)]).unwrap();
        let plausible = &both.effects()[0].plausible;
        assert!((plausible[0].1 - 0.981).abs() < 1e-12, "what one of them takes for plausible is: {plausible:?}");
        let pushed = both.with_effects(&["push"]).unwrap();
        let seen = [recorded(0, 9.81, 0.0, 0.3), recorded(1, 1.62, 0.0, 0.3)];
        let found = tune(&pushed, &seen, None, &Settings::default()).unwrap();
        let values: Vec<f64> = found.parameters.iter().map(|p| p.value).collect();
        assert!((values[0] - 0.8).abs() < 1e-6 && (values[1] - 0.3).abs() < 1e-6, "{values:?}");
    }

    #[test]
    fn a_constant_is_assumed_where_a_setup_assumes_it() {
        let both = setups(&[fall(1.62, 0.0), fall(9.81, 0.0)]).unwrap();
        let assumed = both.assumed();
        assert_eq!((assumed.len(), assumed[0].value), (1, 9.81));
        let at = |setup: usize, simulator: &dyn Simulator| {
            let prepared = usable(simulator, &recorded(setup, 1.0, 0.0, 0.0));
            predict(simulator, &prepared, &[2.0, 0.0], &[], &[1.0]).unwrap()[0]
        };
        let there = assumed[0].at_upper.as_ref();
        assert_eq!((at(0, there), at(1, there)), (1.62, 9.83));
        assert_eq!((at(0, &both), at(1, &both)), (1.62, 9.81));
    }

    #[test]
    fn segments_are_those_of_every_setup() {
        let shuttle = || Box::new(Exact::new(Shuttle::default())) as Box<dyn Simulator>;
        let both = Setups::of(vec![shuttle(), shuttle()]).unwrap();
        let free = both.segmented().and_then(Segmented::free_segment).unwrap();
        let (second, mut values) = (Circumstances { setup: 1, ..Circumstances::default() }, [0.0]);
        free.rollout_driven(&[0.9], &[0.0, 1.5], &second, &[1.0], &mut values).unwrap();
        assert!((values[0] - 1.5).abs() < 1e-12, "nothing reflects it: {values:?}");
        assert!(both.segmented().unwrap().with_hidden_state().is_none());
        assert!(setups(&[fall(9.81, 0.0), fall(1.62, 0.0)]).unwrap().segmented().is_none());
    }
}

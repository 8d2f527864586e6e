//! A zoo of closed-form systems: simulators whose solution is known exactly, for tests, examples and documentation.
//!
//! Each system has a parameter to tune, nuisance parameters (where it starts), and candidate effects that it may lack; a
//! recording of it is drawn with or without them, with white noise by seed. So every claim of an answer can be judged by the
//! truth.
//!
//! | system | equation | candidate effects |
//! |---|---|---|
//! | [`Line`] | y' = b | `curvature`, `cubic` |
//! | [`Decay`] | y' = −k y | `offset`, `self_quenching` |
//! | [`Pendulum`] | θ'' = −(g/L) θ | `viscous_friction`, `rest_angle` |
//! | [`DrivenOscillator`] | x'' = −ω² x + a cos Ωt | `damping`, `drive_detuning` |
//! | [`Shuttle`] | y' = v, and v → −r v at known instants | `friction`, `push` between events, `kick`, `slip` at events |
//!
//! [`Levers`] are driven: two joints whose motion is an input and whose torques are seen, with `viscous_friction` and `torque_bias`
//! of each joint.
//!
//! [`PushedCart`] is driven by a recorded force; a declared simulator of it may lack its `delay_s` or `stiffness_n_m`.
//!
//! [`reflected_point`] is a point that falls and is reflected, with the data set of pairs that a network learns from.
//!
//! ```
//! use tunenet_core::diagnose::{Recording, Settings, Subject, Verdict, diagnose};
//! use tunenet_core::testing::{Exact, Pendulum};
//!
//! let simulator = Exact::new(Pendulum);
//! // Three recordings of a pendulum of 0.8 m with friction, which the simulator lacks; noise of 1 mrad.
//! let truth = [("length", 0.8), ("viscous_friction.rate_1_s", 0.2)];
//! let starts = [[0.2, 0.0], [-0.1, 0.5], [0.05, -0.4]];
//! let seen: Vec<_> = (0..3).map(|i| simulator.observe(&truth, &starts[i as usize], 0.001, i)).collect::<Result<_, _>>()?;
//! let recordings: Vec<Recording> = seen
//!     .iter()
//!     .map(|seen| Recording { name: "swing".into(), object: 0, held_out: false, seen })
//!     .collect();
//! let subjects = [Subject { name: "pendulum".into(), simulator: &simulator }];
//! let found = diagnose(&subjects, &recordings, &Settings::default(), &|_| {})?;
//! assert_eq!((found.verdict(), found.names()), (Verdict::Named, vec!["viscous_friction"]));
//! # Ok::<(), tunenet_core::Error>(())
//! ```

mod decay;
mod driven_oscillator;
mod levers;
mod line;
mod oscillation;
mod pendulum;
mod pushed_cart;
pub mod reflected_point;
mod shuttle;

pub use decay::Decay;
pub use driven_oscillator::DrivenOscillator;
pub use levers::Levers;
pub use line::Line;
pub use pendulum::Pendulum;
pub use pushed_cart::PushedCart;
pub use reflected_point::ReflectedPoint;
pub use shuttle::Shuttle;

use std::sync::Arc;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::observation::{Channel, Observation};
use crate::simulator::{
    Coefficient, Effect, Parameter, Phase, Preparation, Prepared, RolloutResult, Segmentation, Segmented, Simulator,
    Text,
};
use crate::{Error, Origin, Result};

/// Samples of a recording that [`Exact::observe`] draws, and their rate in Hz.
pub const SAMPLES: u32 = 200;
/// See [`SAMPLES`].
pub const RATE_HZ: f64 = 100.0;

/// The values of a system's parameters and coefficients by name; what is absent has its absent value.
pub type Values<'a> = dyn Fn(&str) -> f64 + 'a;

/// A system with one channel whose solution is known in closed form.
pub trait ClosedForm: Send + Sync + 'static {
    /// What is observed.
    fn channel(&self) -> Channel;

    /// What may be tuned.
    fn parameters(&self) -> Vec<Parameter>;

    /// What may be missing.
    fn effects(&self) -> Vec<Effect>;

    /// Where a recording starts, guessed from its first samples.
    ///
    /// # Errors
    /// Where a guess lies outside its bounds.
    fn nuisances(&self, seen: &Observation) -> Result<Vec<Parameter>>;

    /// The solution at `t` seconds from a start.
    fn solution(&self, values: &Values, start: &[f64], t: f64) -> f64;

    /// Where its recordings are cut into segments between events; `None` without events.
    fn segmentation(&self) -> Option<Arc<dyn Segmentation>> {
        None
    }

    /// The same system without events; `None` where it has none to leave out.
    fn free(&self) -> Option<Self>
    where
        Self: Sized,
    {
        None
    }
}

/// A closed-form system as a simulator that carries some of its effects.
pub struct Exact<S> {
    system: S,
    parameters: Vec<Parameter>,
    channels: [Channel; 1],
    carried: Vec<Text>,
}

impl<S: ClosedForm + Clone> Exact<S> {
    /// The system without any effect.
    pub fn new(system: S) -> Self {
        Self { parameters: system.parameters(), channels: [system.channel()], carried: Vec::new(), system }
    }

    /// A recording of [`SAMPLES`] samples from `start`, with these true values of parameters and coefficients
    /// (`viscous_friction.rate_1_s`) and white noise of standard deviation `noise` drawn from `seed`. What `truth` does not
    /// name has its own value, or is absent.
    ///
    /// # Errors
    /// Where `truth` names nothing of this system.
    pub fn observe(&self, truth: &[(&str, f64)], start: &[f64], noise: f64, seed: u64) -> Result<Observation> {
        let known: Vec<Parameter> = self.system.parameters().into_iter().chain(coefficients(&self.system)?).collect();
        if let Some((lost, _)) = truth.iter().find(|(name, _)| known.iter().all(|p| p.name != *name)) {
            return Err(Error::Setting {
                origin: Origin::Caller,
                name: "truth",
                expected: "a name of this system".into(),
                found: (*lost).into(),
            });
        }
        let value = |name: &str| {
            let given = truth.iter().find(|(n, _)| *n == name).map(|(_, value)| *value);
            given.or_else(|| known.iter().find(|p| p.name == name).map(|p| p.value)).unwrap_or(0.0)
        };
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        let clock: Vec<f64> = (0..SAMPLES).map(|k| f64::from(k) / RATE_HZ).collect();
        let one = |t: &f64| self.system.solution(&value, start, *t) + noise * draw.sample::<f64, _>(StandardNormal);
        let values = clock.iter().map(one).collect();
        Observation::new(self.kind(), self.channels.to_vec(), clock, values)
    }
}

/// The coefficients of all effects of a system as parameters.
fn coefficients(system: &dyn ClosedForm) -> Result<Vec<Parameter>> {
    let each: Vec<Vec<Parameter>> = system.effects().iter().map(|e| e.parameters(None)).collect::<Result<_>>()?;
    Ok(each.concat())
}

impl<S: ClosedForm + Clone> Simulator for Exact<S> {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        let mut prepared = Prepared::whole(seen.clone(), self.parameters.len());
        prepared.nuisances = self.system.nuisances(seen)?;
        prepared.segmentation = self.system.segmentation();
        Ok(Preparation::Usable(Box::new(prepared)))
    }

    fn segmented(&self) -> Option<&dyn Segmented> {
        self.system.free().map(|_| self as &dyn Segmented)
    }

    fn effects(&self) -> Vec<Effect> {
        self.system.effects().into_iter().filter(|e| !self.carried.contains(&e.name)).collect()
    }

    fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
        let mut made = Self::new(self.system.clone());
        for name in names {
            let Some(effect) = self.effects().into_iter().find(|e| e.name == *name) else {
                let expected = "an effect of this system".into();
                return Err(Error::Setting {
                    origin: Origin::Caller,
                    name: "effects",
                    expected,
                    found: (*name).into(),
                });
            };
            made.parameters.extend(effect.parameters(None)?);
            made.carried.push(effect.name);
        }
        Ok(Box::new(made))
    }

    fn rollout(&self, parameters: &[f64], nuisances: &[f64], clock: &[f64], values: &mut [f64]) -> RolloutResult {
        let all = self.parameters.iter().zip(parameters);
        let value = |name: &str| all.clone().find(|(p, _)| p.name == name).map_or(0.0, |(_, value)| *value);
        for (t, y) in clock.iter().zip(values) {
            *y = self.system.solution(&value, nuisances, *t);
        }
        Ok(())
    }
}

impl<S: ClosedForm + Clone> Segmented for Exact<S> {
    fn free_segment(&self) -> Option<Box<dyn Simulator>> {
        let carried: Vec<&str> = self.carried.iter().map(AsRef::as_ref).collect();
        Exact::new(self.system.free()?).with_effects(&carried).ok()
    }
}

/// An effect of one coefficient that is absent at 0 and plausible within `bounds`.
fn effect(name: &'static str, key: &'static str, unit: &'static str, bounds: (f64, f64), typical: f64) -> Effect {
    Effect::new(name, Phase::Joint, "", vec![Coefficient::new(key, unit, 0.0, bounds, typical)])
}

/// Value and slope at the start of a recording, guessed from its first samples, with bounds this far from the guess.
fn start(seen: &Observation, names: [(&str, &str); 2], reach: [f64; 2]) -> Result<Vec<Parameter>> {
    const NEAR: usize = 5;
    let (first, near) = (seen.row(0)[0], seen.row(NEAR.min(seen.len() - 1))[0]);
    let slope = (near - first) / (seen.clock()[NEAR.min(seen.len() - 1)] - seen.clock()[0]);
    let one = |((name, unit), guess, reach): ((&str, &str), f64, f64)| {
        Parameter::new(name, unit, guess, guess - reach, guess + reach)
    };
    [(names[0], first, reach[0]), (names[1], slope, reach[1])].into_iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::rollout;

    /// Central differences of the solution, checked against the right side of its differential equation.
    pub(super) fn second_derivative(
        system: &dyn ClosedForm,
        values: &Values,
        start: &[f64],
        t: f64,
    ) -> (f64, f64, f64) {
        let h = 1e-3;
        let at = |t: f64| system.solution(values, start, t);
        (at(t), (at(t + h) - at(t - h)) / (2.0 * h), (at(t + h) - 2.0 * at(t) + at(t - h)) / (h * h))
    }

    #[test]
    fn a_recording_without_noise_is_the_rollout_of_its_truth() {
        let line = Exact::new(Line);
        let seen = line.observe(&[("slope", 0.7), ("curvature.c_1_s2", 0.3)], &[0.2], 0.0, 1).unwrap();
        let with = line.with_effects(&["curvature"]).unwrap();
        let values = rollout(&with, &[0.7, 0.3], &[0.2], seen.clock()).unwrap();
        assert_eq!(seen.values(), values);
    }

    #[test]
    fn noise_follows_from_the_seed() {
        let decay = Exact::new(Decay);
        let seen = |seed| decay.observe(&[], &[1.0], 0.01, seed).unwrap();
        assert_eq!(seen(3).values(), seen(3).values());
        assert_ne!(seen(3).values(), seen(4).values());
        assert!(decay.observe(&[("rat", 1.0)], &[1.0], 0.0, 0).is_err());
    }
}

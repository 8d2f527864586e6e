//! A driven mechanism as data: what a user declares of it, what may be hidden in it, and the signal path that all of them share.

use anyhow::Result;
use rand::Rng;
use std::f64::consts::TAU;
use tunenet_core::observation::{Channel, Hold, Input};
use tunenet_core::simulator::{Coefficient, Effect, FnSimulator, Parameter, Phase, Simulator, StartState, StartValue};

/// How many candidates each mechanism declares.
pub const CANDIDATES: usize = 9;
/// Rate of an input, Hz; it begins this long before its recording, so that a late command is known.
const INPUT_HZ: f64 = 200.0;
const BEFORE_S: f64 = 0.3;
const SINUSOIDS: usize = 5;

/// An unknown parameter: what the file says of it, and where true values are drawn from.
pub struct Unknown {
    pub name: &'static str,
    pub unit: &'static str,
    pub guess: f64,
    pub bounds: (f64, f64),
    pub truth: (f64, f64),
}

impl Unknown {
    pub const fn new(
        name: &'static str,
        unit: &'static str,
        guess: f64,
        bounds: (f64, f64),
        truth: (f64, f64),
    ) -> Self {
        Self { name, unit, guess, bounds, truth }
    }
}

/// An effect that the file declares as a candidate.
pub struct Candidate {
    pub name: &'static str,
    pub acts: Phase,
    pub sentence: &'static str,
    pub unit: &'static str,
    pub absent: f64,
    pub bounds: (f64, f64),
    pub typical: f64,
}

impl Candidate {
    /// A candidate that is absent at 0 and never below it.
    pub const fn new(name: &'static str, acts: Phase, unit: &'static str, most: f64, typical: f64) -> Self {
        Self { name, acts, sentence: name, unit, absent: 0.0, bounds: (0.0, most), typical }
    }

    /// The same where it may have either sign.
    pub const fn signed(mut self) -> Self {
        self.bounds.0 = -self.bounds.1;
        self
    }

    /// The same as a factor, which is absent at 1.
    pub const fn factor(mut self, least: f64) -> Self {
        self.absent = 1.0;
        self.bounds.0 = least;
        self
    }

    fn effect(&self) -> Effect {
        let coefficient = Coefficient::new("c", self.unit, self.absent, self.bounds, self.typical);
        Effect::new(self.name, self.acts.clone(), self.sentence, vec![coefficient])
    }
}

/// A signal that drives a mechanism: a sum of sinusoids.
pub struct Signal {
    pub name: &'static str,
    pub unit: &'static str,
    /// Amplitudes of its sinusoids, in its unit, and their frequencies, Hz.
    pub amplitudes: (f64, f64),
    pub frequencies_hz: (f64, f64),
}

/// What no candidate describes. Its size is a share of the command, a torque or a force, or an angle, as the mechanism says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Undeclared {
    /// The actuator saturates softly.
    Saturation,
    /// The gain of the actuator drifts with time.
    Drift,
    /// A force or a torque that repeats with the position.
    Ripple,
    /// A force or a torque in proportion to the position.
    Spring,
    /// A force or a torque of a frequency that nothing recorded has.
    Vibration,
    /// An encoder that is mounted off its centre.
    Eccentricity,
}

impl Undeclared {
    pub const ALL: [Self; 6] =
        [Self::Saturation, Self::Drift, Self::Ripple, Self::Spring, Self::Vibration, Self::Eccentricity];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Saturation => "saturation",
            Self::Drift => "drift",
            Self::Ripple => "ripple",
            Self::Spring => "spring",
            Self::Vibration => "vibration",
            Self::Eccentricity => "eccentricity",
        }
    }
}

/// The nine coefficients, in the order in which every mechanism declares its candidates.
#[derive(Debug, Clone, Copy)]
pub struct Coefficients {
    pub delay_s: f64,
    pub gain: f64,
    pub bias: f64,
    pub dead_zone: f64,
    pub dry_friction: f64,
    pub air_drag: f64,
    pub tilt: f64,
    pub offset: f64,
    pub play: f64,
}

impl From<[f64; CANDIDATES]> for Coefficients {
    fn from([delay_s, gain, bias, dead_zone, dry_friction, air_drag, tilt, offset, play]: [f64; CANDIDATES]) -> Self {
        Self { delay_s, gain, bias, dead_zone, dry_friction, air_drag, tilt, offset, play }
    }
}

/// A mechanism with everything that decides its motion.
pub struct World<'a> {
    pub unknowns: &'a [f64],
    pub effects: Coefficients,
    pub undeclared: Option<(Undeclared, f64)>,
}

impl World<'_> {
    /// The size of what no candidate describes, 0 where it is another.
    pub fn size(&self, of: Undeclared) -> f64 {
        self.undeclared.filter(|(kind, _)| *kind == of).map_or(0.0, |(_, size)| size)
    }

    /// What an actuator makes of a command at an instant.
    pub fn acted(&self, command: f64, time_s: f64) -> f64 {
        let Coefficients { gain, bias, dead_zone, .. } = self.effects;
        let driven = command * gain + bias;
        let driven = driven.signum() * (driven.abs() - dead_zone).max(0.0);
        let limited = driven / (1.0 + (self.size(Undeclared::Saturation) * driven).powi(2)).sqrt();
        limited * (1.0 + self.size(Undeclared::Drift) * time_s)
    }

    /// What shakes the mechanism at an instant, in the unit of its actuator.
    pub fn shaken(&self, time_s: f64) -> f64 {
        self.size(Undeclared::Vibration) * (TAU * 3.7 * time_s + 1.0).sin()
    }
}

/// What an encoder shows: eccentricity, play and offset, in that order.
pub struct Encoder {
    seen: Option<f64>,
}

impl Encoder {
    pub const fn new() -> Self {
        Self { seen: None }
    }

    pub fn read(&mut self, angle: f64, world: &World) -> f64 {
        let shown = angle + world.size(Undeclared::Eccentricity) * (2.0 * angle).sin();
        let half = 0.5 * world.effects.play;
        let seen = self.seen.unwrap_or(shown).max(shown - half).min(shown + half);
        self.seen = Some(seen);
        seen + world.effects.offset
    }
}

/// The inputs of one recording, by number and instant.
pub type Drive<'a> = &'a dyn Fn(usize, f64) -> f64;

/// Writes every channel at each instant: the world, its inputs, the initial state, the instants, the longest step in s, the numbers.
type Simulate = fn(&World, Drive, &[f64], &[f64], f64, &mut [f64]);

/// A driven mechanism.
pub struct Plant {
    pub name: &'static str,
    pub unknowns: &'static [Unknown],
    /// Name, unit and standard deviation of the noise of each channel.
    pub channels: &'static [(&'static str, &'static str, f64)],
    pub inputs: &'static [Signal],
    /// The initial state where it is estimated, each with the channel whose first sample its prior has, and where it is drawn from.
    pub start: &'static [(&'static str, usize, (f64, f64))],
    pub candidates: [Candidate; CANDIDATES],
    /// Length and rate of a recording, and the longest step of the simulator that is under test.
    pub seconds: f64,
    pub rate_hz: f64,
    pub step_s: f64,
    pub simulate: Simulate,
}

impl Plant {
    pub fn channels(&self) -> Vec<Channel> {
        self.channels.iter().map(|(name, unit, _)| Channel::new(*name, *unit)).collect()
    }

    pub fn noise(&self) -> impl Iterator<Item = f64> + '_ {
        self.channels.iter().map(|(.., sd)| *sd)
    }

    pub fn clock(&self) -> Vec<f64> {
        even(0.0, self.rate_hz, self.seconds)
    }

    /// The mechanism with nothing hidden in it.
    pub fn absent(&self) -> [f64; CANDIDATES] {
        self.candidates.each_ref().map(|candidate| candidate.absent)
    }

    /// Draws the inputs of one recording.
    pub fn draw_inputs(&self, random: &mut impl Rng) -> Result<Vec<Input>> {
        let mut one = |signal: &Signal| -> Result<Input> {
            let waves: [[f64; 3]; SINUSOIDS] = std::array::from_fn(|_| {
                let (a, f) = (signal.amplitudes, signal.frequencies_hz);
                [random.random_range(a.0..a.1), random.random_range(f.0..f.1), random.random_range(0.0..TAU)]
            });
            let clock = even(-BEFORE_S, INPUT_HZ, self.seconds);
            let at = |t: &f64| waves.iter().map(|[a, f, p]| a * (TAU * f * t + p).sin()).sum();
            let values = clock.iter().map(at).collect();
            Ok(Input::sampled(Channel::new(signal.name, signal.unit), Hold::Linear, clock, values)?)
        };
        self.inputs.iter().map(&mut one).collect()
    }

    /// What a user would hand to the tool: parameters, channels, initial states and candidates.
    pub fn simulator(&'static self) -> Result<Box<dyn Simulator>> {
        let known = |u: &Unknown| Parameter::new(u.name, u.unit, u.guess, u.bounds.0, u.bounds.1);
        let parameters = self.unknowns.iter().map(known).collect::<Result<Vec<_>, _>>()?;
        let count = parameters.len();
        let mut simulator = FnSimulator::new(parameters, self.channels(), move |numbers, run, clock, out| {
            let (unknowns, coefficients) = numbers.split_at(count);
            let coefficients = <[f64; CANDIDATES]>::try_from(coefficients).map_err(|e| e.to_string())?;
            let world = World { unknowns, effects: coefficients.into(), undeclared: None };
            (self.simulate)(&world, &|input, t| run.input(input, t), run.start, clock, self.step_s, out);
            if out.iter().all(|value| value.is_finite()) { Ok(()) } else { Err("the motion leaves all bounds".into()) }
        });
        for (name, channel, _) in self.start {
            let (_, unit, sd) = self.channels[*channel];
            simulator = simulator.start(StartState::new(*name, unit, StartValue::First(*channel)).with_prior(sd));
        }
        for candidate in &self.candidates {
            simulator = simulator.candidate(candidate.effect());
        }
        Ok(Box::new(simulator))
    }
}

fn even(from_s: f64, rate_hz: f64, to_s: f64) -> Vec<f64> {
    (0..u32::MAX).map(|i| from_s + f64::from(i) / rate_hz).take_while(|t| *t <= to_s).collect()
}

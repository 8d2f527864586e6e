//! Two driven levers: τ = I q'' + W cos q, by a measured motion.

use std::f64::consts::TAU;
use std::sync::Arc;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::{Values, effect};
use crate::observation::{Channel, Circumstances, Hold, Input, Kind, Observation};
use crate::simulator::{
    Coefficient, Effect, Follows, Parameter, Preparation, Prepared, RolloutResult, Simulator, Text,
};
use crate::{Error, Origin, Result};

/// Samples of a recording, and their rate in Hz.
const SAMPLES: u32 = 600;
const RATE_HZ: f64 = 20.0;
/// Where the second lever is held, rad.
const HELD_RAD: f64 = 0.4;

/// Two levers with motors whose torques are measured. The first swings, the second is held; both motions are inputs, so that a
/// prediction has no start state and is linear in every parameter. What the simulator may lack, in each lever: `viscous_friction`
/// (+ b q') and `torque_bias` (+ c).
pub struct Levers {
    parameters: Vec<Parameter>,
    channels: [Channel; 2],
    carried: Vec<Text>,
}

impl Levers {
    /// The levers without any effect.
    ///
    /// # Errors
    /// Never: the bounds are sound.
    pub fn new() -> Result<Self> {
        let parameters = vec![
            Parameter::new("inertia", "kg·m²", 1.0, 0.1, 10.0)?,
            Parameter { tune: false, ..Parameter::new("weight", "N·m", 3.0, 0.0, 20.0)? },
        ];
        let channels = [Channel::new("tau1", "N·m"), Channel::new("tau2", "N·m")];
        Ok(Self { parameters, channels, carried: Vec::new() })
    }

    /// The same where the weight is known only to this 95 % interval, N·m.
    #[must_use]
    pub fn with_weight_known_to(mut self, interval95: (f64, f64)) -> Self {
        self.parameters[1].known95 = Some(interval95);
        self
    }

    /// A recording of 30 s with these true values (`viscous_friction.nms_rad.1`) and white noise of standard deviation `noise_nm`
    /// drawn from `seed`: channels `q1`, `dq1`, `ddq1`, `q2`, `dq2`, `ddq2`, `tau1`, `tau2`.
    ///
    /// # Errors
    /// Where `truth` names nothing of this system.
    pub fn observe(&self, truth: &[(&str, f64)], noise_nm: f64, seed: u64) -> Result<Observation> {
        let mut known = self.parameters.clone();
        for effect in effects() {
            known.extend(effect.parameters(None)?);
        }
        if let Some((lost, _)) = truth.iter().find(|(name, _)| known.iter().all(|p| p.name != *name)) {
            let (expected, found) = ("a name of this system".into(), (*lost).into());
            return Err(Error::Setting { origin: Origin::Caller, name: "truth", expected, found });
        }
        let value = |name: &str| {
            let given = truth.iter().find(|(n, _)| *n == name).map(|(_, value)| *value);
            given.or_else(|| known.iter().find(|p| p.name == name).map(|p| p.value)).unwrap_or(0.0)
        };
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        let clock: Vec<f64> = (0..SAMPLES).map(|k| f64::from(k) / RATE_HZ).collect();
        let mut values = Vec::with_capacity(8 * clock.len());
        for t in &clock {
            let motion = [swing(*t), [HELD_RAD, 0.0, 0.0]];
            values.extend(motion.iter().flatten());
            let torques = motion.iter().enumerate().map(|(j, m)| torque(&value, j, *m));
            values.extend(torques.map(|torque| torque + noise_nm * draw.sample::<f64, _>(StandardNormal)));
        }
        let names = ["q1", "dq1", "ddq1", "q2", "dq2", "ddq2", "tau1", "tau2"];
        let units = ["rad", "rad/s", "rad/s²", "rad", "rad/s", "rad/s²", "N·m", "N·m"];
        let channels = names.into_iter().zip(units).map(|(name, unit)| Channel::new(name, unit)).collect();
        Observation::new(Kind::Joints, channels, clock, values)
    }
}

/// Position, speed and acceleration of the first lever: two sines.
fn swing(t: f64) -> [f64; 3] {
    let mut motion = [0.0; 3];
    for (amplitude, frequency, phase) in [(0.8, 0.3, 0.0), (0.3, 0.8, 1.0)] {
        let omega = TAU * frequency;
        let (sin, cos) = (omega * t + phase).sin_cos();
        motion[0] += amplitude * sin;
        motion[1] += amplitude * omega * cos;
        motion[2] -= amplitude * omega * omega * sin;
    }
    motion
}

/// The torque of lever `j`, counted from 0, in N·m.
fn torque(value: &Values, j: usize, [q, speed, acceleration]: [f64; 3]) -> f64 {
    let number = j + 1;
    let of = |name: &str| value(&format!("{name}.{number}"));
    value("inertia") * acceleration
        + value("weight") * q.cos()
        + of("viscous_friction.nms_rad") * speed
        + of("torque_bias.nm")
}

fn effects() -> Vec<Effect> {
    let each = |name, key, unit, bounds, typical| {
        let one = effect(name, key, unit, bounds, typical);
        let coefficients: Vec<Coefficient> = [1, 2].map(|number| one.coefficients[0].clone().numbered(number)).into();
        Effect { coefficients, plausible: vec![bounds; 2], ..one }
    };
    vec![
        each("viscous_friction", "nms_rad", "N·m·s/rad", (0.0, 20.0), 0.01)
            .excited_by(Follows::Speed, "grows in proportion to speed"),
        each("torque_bias", "nm", "N·m", (-20.0, 20.0), 0.01).excited_by(Follows::Pose, "is the same in every pose"),
    ]
}

impl Simulator for Levers {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn kind(&self) -> Kind {
        Kind::Joints
    }

    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        let part = |names: &[&str]| -> Result<Observation> {
            let at: Vec<usize> =
                names.iter().filter_map(|n| seen.channels().iter().position(|c| c.name == *n)).collect();
            let values = (0..seen.len()).flat_map(|k| at.iter().map(move |&c| seen.row(k)[c])).collect();
            let channels = at.iter().map(|&c| seen.channels()[c].clone()).collect();
            Observation::new(seen.kind(), channels, seen.clock().to_vec(), values)
        };
        let mut prepared = Prepared::whole(part(&["tau1", "tau2"])?, self.parameters.len());
        let motion = part(&["q1", "dq1", "ddq1", "q2", "dq2", "ddq2"])?;
        prepared.circumstances = Some(Arc::new(Circumstances::driven_by(vec![Input::new(motion, Hold::Previous)])));
        prepared.memoryless = true;
        Ok(Preparation::Usable(Box::new(prepared)))
    }

    fn effects(&self) -> Vec<Effect> {
        effects().into_iter().filter(|e| !self.carried.contains(&e.name)).collect()
    }

    fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
        let mut made = Self {
            parameters: self.parameters.clone(),
            channels: self.channels.clone(),
            carried: self.carried.clone(),
        };
        for name in names {
            let Some(effect) = self.effects().into_iter().find(|e| e.name == *name) else {
                let (expected, found) = ("an effect of this system".into(), (*name).into());
                return Err(Error::Setting { origin: Origin::Caller, name: "effects", expected, found });
            };
            made.parameters.extend(effect.parameters(None)?);
            made.carried.push(effect.name);
        }
        Ok(Box::new(made))
    }

    fn rollout(&self, _: &[f64], _: &[f64], _: &[f64], _: &mut [f64]) -> RolloutResult {
        Err("levers need a measured motion".into())
    }

    fn rollout_driven(
        &self,
        parameters: &[f64],
        _: &[f64],
        circumstances: &Circumstances,
        clock: &[f64],
        values: &mut [f64],
    ) -> RolloutResult {
        let value = |name: &str| {
            self.parameters.iter().zip(parameters).find(|(p, _)| p.name == name).map_or(0.0, |(_, value)| *value)
        };
        let motion = circumstances.inputs[0].series();
        for (t, row) in clock.iter().zip(values.chunks_exact_mut(2)) {
            // The clock is a part of the motion's.
            let k = motion.clock().partition_point(|s| s < t).min(motion.len() - 1);
            for (j, tau) in row.iter_mut().enumerate() {
                let joint = &motion.row(k)[3 * j..3 * j + 3];
                *tau = torque(&value, j, [joint[0], joint[1], joint[2]]);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::predict;

    #[test]
    fn speeds_and_accelerations_are_derivatives_of_the_motion() {
        let h = 1e-4;
        for k in 0..20 {
            let t = 0.37 * f64::from(k);
            let [low, here, high] = [swing(t - h), swing(t), swing(t + h)];
            assert!(((high[0] - low[0]) / (2.0 * h) - here[1]).abs() < 1e-6);
            assert!(((high[1] - low[1]) / (2.0 * h) - here[2]).abs() < 1e-5);
        }
    }

    #[test]
    fn a_recording_without_noise_is_the_prediction_of_its_truth() {
        let levers = Levers::new().unwrap();
        let seen = levers.observe(&[("inertia", 1.4), ("viscous_friction.nms_rad.2", 0.5)], 0.0, 0).unwrap();
        let Preparation::Usable(prepared) = levers.prepare(&seen).unwrap() else { panic!("usable") };
        assert!(prepared.driven() && prepared.seen.channels().len() == 2);
        let carried = levers.with_effects(&["viscous_friction"]).unwrap();
        let values = predict(carried.as_ref(), &prepared, &[1.4, 3.0, 0.0, 0.5], &[], prepared.seen.clock()).unwrap();
        assert!(values.iter().zip(prepared.seen.values()).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(levers.observe(&[("length", 1.0)], 0.0, 0).is_err());
    }
}

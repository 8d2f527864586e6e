//! A glider: a simulator for tests, and its truth in closed form.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::observation::{Channel, Kind, Observation};
use crate::simulator::{Coefficient, Effect, Parameter, Phase, Preparation, Prepared, RolloutResult, Simulator, Text};
use crate::{Error, Origin, Result};

pub const GRAVITY: f64 = 9.81;
pub const NOISE_M: f64 = 0.002;

/// Starts in a plane, pushed along x by a parameter; Runge–Kutta from sample to sample.
pub struct Glider {
    parameters: Vec<Parameter>,
    channels: Vec<Channel>,
    effects: Vec<Text>,
}

impl Glider {
    pub fn new() -> Self {
        let push = Parameter::new("push", "m/s²", 0.0, -5.0, 5.0).unwrap();
        Self { parameters: vec![push], channels: vec![Channel::new("x", "m"), Channel::new("z", "m")], effects: vec![] }
    }
}

fn effect(name: &'static str, key: &'static str, range: (f64, f64), typical: f64, plausible: (f64, f64)) -> Effect {
    Effect {
        plausible: vec![plausible],
        ..Effect::new(name, Phase::Segment, "", vec![Coefficient::new(key, "1", 0.0, range, typical)])
    }
}

impl Simulator for Glider {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn prepare(&self, seen: &Observation) -> Result<Preparation> {
        let mut prepared = Prepared::whole(seen.clone(), self.parameters.len());
        let span = seen.clock()[seen.len() - 1] - seen.clock()[0];
        for (i, name) in ["x", "z"].into_iter().enumerate() {
            let (first, last) = (seen.row(0)[i], seen.row(seen.len() - 1)[i]);
            let fall = if i == 1 { 0.5 * GRAVITY * span } else { 0.0 };
            let speed = (last - first) / span + fall;
            prepared.nuisances.push(Parameter::new(format!("initial.{name}"), "m", first, first - 5.0, first + 5.0)?);
            let velocity = format!("initial.velocity_{name}");
            prepared.nuisances.push(Parameter::new(velocity, "m/s", speed, speed - 20.0, speed + 20.0)?);
        }
        Ok(Preparation::Usable(Box::new(prepared)))
    }

    fn effects(&self) -> Vec<Effect> {
        let all = [
            effect("linear_drag", "b_1_s", (0.0, 5.0), 0.02, (0.0, 3.0)),
            effect("effective_gravity", "dg_m_s2", (-9.0, 9.0), 0.05, (-3.0, 3.0)),
            effect("spring", "k_1_s2", (-5.0, 5.0), 0.05, (-5.0, 5.0)),
        ];
        all.into_iter().filter(|e| !self.effects.contains(&e.name)).collect()
    }

    fn with_effects(&self, names: &[&str]) -> Result<Box<dyn Simulator>> {
        let mut glider = Self::new();
        for name in names {
            let Some(effect) = self.effects().into_iter().find(|e| e.name == *name) else {
                return Err(Error::Setting {
                    origin: Origin::Caller,
                    name: "effects",
                    expected: "a glider's".into(),
                    found: (*name).into(),
                });
            };
            glider.parameters.extend(effect.parameters(None)?);
            glider.effects.push(effect.name);
        }
        Ok(Box::new(glider))
    }

    fn rollout(&self, p: &[f64], nuisances: &[f64], clock: &[f64], out: &mut [f64]) -> RolloutResult {
        let of = |name: &str| self.effects.iter().position(|e| *e == name).map_or(0.0, |i| p[1 + i]);
        let (drag, down, spring) = (of("linear_drag"), GRAVITY + of("effective_gravity"), of("spring"));
        let slope = |s: [f64; 4]| [s[1], p[0] - drag * s[1], s[3], -down - drag * s[3] - spring * s[2]];
        let along = |s: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| s[i] + h * k[i]);
        let (mut s, mut now) = ([nuisances[0], nuisances[1], nuisances[2], nuisances[3]], clock[0]);
        for (t, row) in clock.iter().zip(out.chunks_exact_mut(2)) {
            let h = t - now;
            let a = slope(s);
            let b = slope(along(s, a, h / 2.0));
            let c = slope(along(s, b, h / 2.0));
            let d = slope(along(s, c, h));
            s = std::array::from_fn(|i| s[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
            now = *t;
            row.copy_from_slice(&[s[0], s[2]]);
        }
        Ok(())
    }
}

/// What is true of a set of glides.
#[derive(Clone, Copy, Default)]
pub struct Truth {
    pub push: f64,
    pub drag: f64,
    pub more_gravity: f64,
    /// Amplitude of a sway of 2.5 Hz, m.
    pub sway_m: f64,
}

/// Glides in closed form, with white noise: x(t) = x + c t + (v − c)(1 − e^(−bt))/b with c = a/b.
pub fn glides(truth: Truth, count: usize, samples: usize, seed: u64) -> Vec<Observation> {
    let mut draw = ChaCha8Rng::seed_from_u64(seed);
    (0..count)
        .map(|_| {
            let start = [0.0, draw.random_range(-4.0..4.0), draw.random_range(0.0..2.0), draw.random_range(-1.0..6.0)];
            let clock: Vec<f64> = (0..samples).map(|i| i as f64 / 120.0).collect();
            let path = |x: f64, v: f64, a: f64, t: f64| {
                let b = truth.drag;
                if b == 0.0 { x + v * t + 0.5 * a * t * t } else { x + a / b * t - (v - a / b) * (-b * t).exp_m1() / b }
            };
            let mut values = Vec::new();
            for t in &clock {
                let sway = truth.sway_m * (std::f64::consts::TAU * 2.5 * t).sin();
                values.push(path(start[0], start[1], truth.push, *t));
                values.push(path(start[2], start[3], -GRAVITY - truth.more_gravity, *t) + sway);
            }
            for v in &mut values {
                *v += NOISE_M * draw.sample::<f64, _>(rand_distr::StandardNormal);
            }
            Observation::new(Kind::Other, Glider::new().channels, clock, values).unwrap()
        })
        .collect()
}

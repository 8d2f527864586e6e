//! One log of a seven-joint arm with something hidden in it.

use rand::Rng;
use rand_distr::StandardNormal;
use tunenet_core::observation::{Channel, Kind, Observation};
use tunenet_sim::arm::{Frame, Model};

use super::world::ArmWorld;

/// Rate and length of a log, and the noise of torques (N·m) and encoders (rad).
pub(super) const RATE_HZ: f64 = 100.0;
const SAMPLES: u32 = 2000;
const SECONDS: f64 = SAMPLES as f64 / RATE_HZ;
pub(super) const TORQUE_NOISE_NM: f64 = 0.5;
const ENCODER_NOISE_RAD: f64 = 1e-5;
/// What the arm holds.
const PAYLOAD_KG: f64 = 1.3;
pub(super) const PAYLOAD_COM_M: [f64; 3] = [0.02, -0.01, 0.05];
/// Waves of each joint's motion.
const WAVES: usize = 4;
const JOINTS: usize = 7;
/// Speed at which the teeth have crossed their gap; a tooth that jumps would be nothing but shocks.
const CROSSING_RAD_S: f64 = 0.2;

/// What is hidden: an effect of the catalogue, or something that is in none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ArmEffect {
    Nothing,
    Effect(&'static str),
    /// A torque that follows the teeth of the gears.
    Ripple,
    /// Encoders before a gear with play.
    Play,
    /// Torques whose scale drifts as the sensors warm up.
    Drift,
}

impl ArmEffect {
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Effect(name) => name,
            Self::Ripple => "torque ripple (outside)",
            Self::Play => "play in the gears (outside)",
            Self::Drift => "drifting scale (outside)",
        }
    }
}

/// Smooth motion of all joints, each a sum of waves about the middle of its range.
struct Path {
    middle: Vec<f64>,
    waves: Vec<[(f64, f64, f64); WAVES]>,
}

impl Path {
    fn draw(random: &mut impl Rng) -> Self {
        // Joints 2, 4 and 6 of this arm reach from 0.8 to 5.5 rad, so that all swing about π.
        let middle = (0..JOINTS).map(|_| std::f64::consts::PI + random.random_range(-0.4..0.4)).collect();
        let mut wave = |k: usize| {
            let hz = 0.08 + 0.13 * k as f64 + random.random_range(0.0..0.1);
            (random.random_range(0.15..0.45), std::f64::consts::TAU * hz, random.random_range(0.0..6.3))
        };
        Self { middle, waves: (0..JOINTS).map(|_| std::array::from_fn(&mut wave)).collect() }
    }

    fn at(&self, t: f64, order: u32) -> Vec<f64> {
        let one = |j: usize| {
            let sum: f64 = self.waves[j]
                .iter()
                .map(|(a, w, phase)| match order {
                    0 => a * (w * t + phase).sin(),
                    1 => a * w * (w * t + phase).cos(),
                    _ => -a * w * w * (w * t + phase).sin(),
                })
                .sum();
            sum + if order == 0 { self.middle[j] } else { 0.0 }
        };
        (0..JOINTS).map(one).collect()
    }
}

/// What an effect draws for each joint: a share of its size, and whether it may be below 0.
fn shape(signed: bool, random: &mut impl Rng) -> Vec<f64> {
    let mut one = |_| {
        let size: f64 = random.random_range(0.3..1.0);
        if signed && random.random_bool(0.5) { -size } else { size }
    };
    (0..JOINTS).map(&mut one).collect()
}

/// The log that an arm with this hidden in it writes, the effect having `ratio` times the torque noise.
pub(super) fn draw(model: &Model, frame: &Frame, hidden: ArmEffect, ratio: f64, random: &mut impl Rng) -> Observation {
    let path = Path::draw(random);
    let signed = matches!(
        hidden,
        ArmEffect::Effect(
            "torque_bias" | "torque_gain" | "joint_offset" | "joint_spring" | "payload_com_offset" | "base_tilt"
        )
    );
    let shape = shape(signed, random);
    let clock: Vec<f64> = (0..SAMPLES).map(|i| f64::from(i) / RATE_HZ).collect();
    let plain = run(model, frame, &path, &clock, ArmEffect::Nothing, &shape, 0.0);
    let mut size = 0.01;
    if hidden != ArmEffect::Nothing && ratio > 0.0 {
        // The size that makes the deviation as large as asked: all but proportional, so a few rounds do.
        for _ in 0..4 {
            let there = run(model, frame, &path, &clock, hidden, &shape, size);
            let square: f64 = deviation(&plain, &there);
            size *= ratio * TORQUE_NOISE_NM / square.sqrt().max(1e-12);
        }
    }
    let (q, torques) =
        if hidden == ArmEffect::Nothing { plain } else { run(model, frame, &path, &clock, hidden, &shape, size) };
    let mut values = Vec::with_capacity(clock.len() * 2 * JOINTS);
    for (q, torque) in q.iter().zip(&torques) {
        values.extend(q.iter().map(|q| q + ENCODER_NOISE_RAD * random.sample::<f64, _>(StandardNormal)));
        values.extend(torque.iter().map(|t| t + TORQUE_NOISE_NM * random.sample::<f64, _>(StandardNormal)));
    }
    let channels = (1..=JOINTS).map(|j| Channel::new(format!("q{j}"), "rad"));
    let channels = channels.chain((1..=JOINTS).map(|j| Channel::new(format!("tau{j}"), "N·m"))).collect();
    Observation::new(Kind::Joints, channels, clock, values).expect("finite numbers on a rising clock")
}

type Rows = Vec<Vec<f64>>;

/// Mean square by which an effect changes what a log of the *same encoders* says: torques, and the torque that a wrong position
/// stands for.
fn deviation(plain: &(Rows, Rows), there: &(Rows, Rows)) -> f64 {
    let each = plain.1.iter().zip(&there.1).flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)));
    each.sum::<f64>() / (plain.1.len() * JOINTS) as f64
}

/// What encoders and torque sensors show without noise.
///
/// The arm is commanded by its encoders: they follow the path, and where they are wrong the links are in other positions.
fn run(
    model: &Model,
    frame: &Frame,
    path: &Path,
    clock: &[f64],
    hidden: ArmEffect,
    shape: &[f64],
    size: f64,
) -> (Rows, Rows) {
    let is = |name: &'static str| hidden == ArmEffect::Effect(name);
    let mut com = PAYLOAD_COM_M;
    let mut tilt = [0.0; 2];
    if is("payload_com_offset") {
        com.iter_mut().zip(shape).for_each(|(c, s)| *c += size * s);
    }
    if is("base_tilt") {
        tilt = [size * shape[0], size * shape[1]];
    }
    let world = ArmWorld::new(model, frame, PAYLOAD_KG, com, tilt);
    let untilted = ArmWorld::new(model, frame, PAYLOAD_KG, com, [0.0; 2]);
    let links = |t: f64| -> Vec<f64> {
        let mut q = path.at(t, 0);
        for j in 0..JOINTS {
            let moved = match hidden {
                ArmEffect::Effect("joint_offset") => size * shape[j],
                // The link lies on the side of the play that it comes from.
                ArmEffect::Play => -size * shape[j] * (path.at(t, 1)[j] / CROSSING_RAD_S).tanh(),
                _ => 0.0,
            };
            q[j] += moved;
        }
        if is("joint_elasticity") {
            let encoders = |t: f64| path.at(t, 0);
            let torque = untilted.torques(&encoders, t);
            // The load is that of the twisted arm: one more round of the fixed point changes a thousandth.
            q.iter_mut().zip(&torque).zip(shape).for_each(|((q, torque), s)| *q -= size * s * torque);
        }
        q
    };
    let delay = if is("time_delay") { size * shape[0] } else { 0.0 };
    let mut rows = Vec::with_capacity(clock.len());
    for &t in clock {
        let at = t - delay;
        let mut torques = world.torques(&links, at);
        let (q, dq, ddq) = (path.at(at, 0), path.at(at, 1), path.at(at, 2));
        for j in 0..JOINTS {
            let c = size * shape[j];
            let t = &mut torques[j];
            match hidden {
                ArmEffect::Effect("viscous_friction") => *t += c * dq[j],
                ArmEffect::Effect("coulomb_friction") => *t += c * dq[j].signum(),
                ArmEffect::Effect("stribeck_friction") => *t += c * dq[j].signum() * (-(dq[j] / 0.15).powi(2)).exp(),
                ArmEffect::Effect("armature") => *t += c * ddq[j],
                ArmEffect::Effect("torque_bias") => *t += c,
                ArmEffect::Effect("torque_gain") => *t *= 1.0 + c,
                ArmEffect::Effect("joint_spring") => *t += c * q[j],
                ArmEffect::Ripple => *t += c * (23.0 * q[j] + f64::from(u8::try_from(j).unwrap_or(0))).sin(),
                ArmEffect::Drift => *t *= 1.0 + c * (at / SECONDS - 0.5),
                _ => {}
            }
        }
        rows.push(torques);
    }
    (clock.iter().map(|t| path.at(*t, 0)).collect(), rows)
}

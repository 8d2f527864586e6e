//! How the motion was seen: everything that happens between the ball and the file, noise included.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::ball::{BlindBall, BlindThrow};
use super::hidden::{EffectKind, HiddenEffect};
use super::vector::{Vector, plus, times};
use super::world::BallWorld;

/// Instants that a blurred picture is averaged over.
const WITHIN_EXPOSURE: usize = 24;
/// A camera's shake, Hz.
const SHAKE_HZ: f64 = 4.0;

/// What a camera reports of `throw` at `clock`, without noise.
pub fn seen(world: &BallWorld, throw: &BlindThrow, clock: &[f64]) -> Vec<Vector> {
    let of = |kind: EffectKind| world.hidden.iter().filter(move |h| h.kind == kind);
    let mut times_s: Vec<f64> = clock.to_vec();
    for hidden in of(EffectKind::TimeScale) {
        // The clock in the file runs faster than the true one.
        for t in &mut times_s {
            *t /= 1.0 + hidden.signed();
        }
    }
    for hidden in of(EffectKind::ClockDrift) {
        for t in &mut times_s {
            *t *= 1.0 + hidden.signed() * *t;
        }
    }
    let mut positions = at(world, throw, &times_s);
    for hidden in of(EffectKind::RollingShutter) {
        // The row on which the ball is found is read later by its height.
        for _ in 0..3 {
            let late: Vec<f64> = times_s.iter().zip(&positions).map(|(t, x)| t + hidden.size * x[2].max(0.0)).collect();
            positions = at(world, throw, &late);
        }
    }
    for hidden in of(EffectKind::ObservationBlur) {
        positions = blurred(world, throw, &times_s, hidden.size);
    }
    for (position, t) in positions.iter_mut().zip(clock) {
        *position = world.hidden.iter().fold(*position, |x, hidden| pictured(hidden, x, *t));
    }
    positions
}

fn at(world: &BallWorld, throw: &BlindThrow, clock: &[f64]) -> Vec<Vector> {
    let mut ball = BlindBall::new(world, throw);
    clock.iter().map(|t| ball.at(*t)).collect()
}

/// Means over an exposure in whose middle the stamp lies: an exposure that began at its stamp would be late as well, which
/// is no blur, and which the free start hides.
fn blurred(world: &BallWorld, throw: &BlindThrow, clock: &[f64], exposure_s: f64) -> Vec<Vector> {
    let share = |i: usize| exposure_s * ((i as f64 + 0.5) / WITHIN_EXPOSURE as f64 - 0.5);
    let mut sums = vec![[0.0; 3]; clock.len()];
    for i in 0..WITHIN_EXPOSURE {
        let within: Vec<f64> = clock.iter().map(|t| t + share(i)).collect();
        for (sum, x) in sums.iter_mut().zip(at(world, throw, &within)) {
            *sum = plus(*sum, x, 1.0 / WITHIN_EXPOSURE as f64);
        }
    }
    sums
}

/// Where the picture shows `x`, in the frame that it is measured in: a camera looks along y, with the origin in its middle.
fn pictured(hidden: &HiddenEffect, [x, y, z]: Vector, t: f64) -> Vector {
    let by = hidden.signed();
    match hidden.kind {
        EffectKind::LengthScale => times([x, y, z], 1.0 + by),
        EffectKind::AspectRatio => [x, y, z * (1.0 + by)],
        EffectKind::CameraTilt => {
            // A turn about a level axis, by Rodrigues' formula.
            let ([ax, ay], (sin, cos)) = ([hidden.turn.cos(), hidden.turn.sin()], hidden.size.sin_cos());
            let along = (ax * x + ay * y) * (1.0 - cos);
            [
                x * cos + ay * z * sin + ax * along,
                y * cos - ax * z * sin + ay * along,
                z * cos + (ax * y - ay * x) * sin,
            ]
        }
        // It looks up or down at the scene, so what is higher is farther away.
        EffectKind::Perspective => times([x, y, z], 1.0 / (1.0 + by * z)),
        EffectKind::LensDistortion => {
            let stretch = 1.0 + by * (x * x + z * z);
            [x * stretch, y, z * stretch]
        }
        EffectKind::CameraShake => {
            let sway = hidden.size * (std::f64::consts::TAU * SHAKE_HZ * t + hidden.lift).sin();
            [x + sway * hidden.turn.cos(), y, z + sway * hidden.turn.sin()]
        }
        EffectKind::Zoom => times([x, y, z], 1.0 + by * t),
        EffectKind::PictureRoll => {
            let (sin, cos) = (by * t).sin_cos();
            [x * cos - z * sin, y, x * sin + z * cos]
        }
        _ => [x, y, z],
    }
}

/// What corrupts the numbers.
#[derive(Debug, Clone, Copy)]
pub struct Noise {
    /// Standard deviation on every axis, m.
    pub sd_m: f64,
    /// How much of it the next sample keeps.
    pub colour: f64,
    /// Share of samples that lie far off.
    pub outliers: f64,
    /// Share of samples that are missing.
    pub dropped: f64,
}

impl Noise {
    pub const WHITE: Self = Self { sd_m: 0.002, colour: 0.0, outliers: 0.0, dropped: 0.0 };

    /// Adds noise to `positions`; says which samples arrive.
    pub fn corrupt(&self, positions: &mut [Vector], random: &mut ChaCha8Rng) -> Vec<bool> {
        let fresh = (1.0 - self.colour * self.colour).sqrt();
        let normal = |random: &mut ChaCha8Rng| -> Vector { std::array::from_fn(|_| random.sample(StandardNormal)) };
        let mut last = normal(random);
        let mut arrives = Vec::with_capacity(positions.len());
        for position in positions {
            *position = plus(*position, last, self.sd_m);
            last = plus(times(last, self.colour), normal(random), fresh);
            // Drawn whether needed or not, so that sets differ in what is asked for alone.
            let (off, gone, size) = (random.random::<f64>(), random.random::<f64>(), random.random_range(5.0..30.0));
            let way: Vector = normal(random);
            if off < self.outliers {
                *position = plus(*position, way, self.sd_m * size / super::vector::length(way));
            }
            arrives.push(gone >= self.dropped);
        }
        arrives
    }
}

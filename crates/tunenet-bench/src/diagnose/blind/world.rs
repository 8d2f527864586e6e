//! The true world of a set: what acts on a ball in the air, and what a bounce does to it.

use std::f64::consts::{PI, TAU};

use super::hidden::{EffectKind, HiddenEffect};
use super::vector::{Vector, cross, dot, length, plus, times};
use crate::scene::GRAVITY_M_S2;

pub const RADIUS_M: f64 = 0.02;
/// The approach speed at which a speed-dependent restitution has its nominal value, m/s.
const NOMINAL_M_S: f64 = 3.0;
/// When late drag begins, s.
const LATE_S: f64 = 0.7;

/// Between these instants a jet blows, s.
const JET_S: (f64, f64) = (0.4, 0.8);
/// How often a gust and a shaken floor come, Hz.
const GUST_HZ: f64 = 1.5;
const SHAKEN_HZ: f64 = 5.0;
/// How short a pulse is, s.
const PULSE_S: f64 = 0.03;

/// A ball, a floor, and what is hidden. The floor passes through the origin.
#[derive(Debug, Clone)]
pub struct BallWorld {
    pub restitution: f64,
    pub hidden: Vec<HiddenEffect>,
}

/// Centre (m), velocity (m/s) and spin (rad/s).
#[derive(Debug, Clone, Copy)]
pub struct BlindState {
    pub x: Vector,
    pub v: Vector,
    pub w: Vector,
}

impl BallWorld {
    /// The unit normal of the floor.
    pub fn normal(&self) -> Vector {
        let mut normal = [0.0, 0.0, 1.0];
        for tilt in self.hidden.iter().filter(|h| h.kind == EffectKind::SurfaceTilt) {
            let (tilt_rad, [x, y]) = (tilt.size, [tilt.turn.cos(), tilt.turn.sin()]);
            normal = [x * tilt_rad.sin(), y * tilt_rad.sin(), tilt_rad.cos()];
        }
        normal
    }

    /// Acceleration in the air, m/s². `own` are two normal draws of this throw.
    pub fn acceleration(&self, t: f64, x: Vector, v: Vector, own: [f64; 2]) -> Vector {
        let mut a = [0.0, 0.0, -GRAVITY_M_S2];
        for hidden in &self.hidden {
            let size = hidden.size;
            let push = match hidden.kind {
                EffectKind::QuadraticDrag => times(v, -size * length(v)),
                EffectKind::LateDrag if t > LATE_S => times(v, -size * length(v)),
                EffectKind::LinearDrag => times(v, -size),
                EffectKind::Wind => [hidden.level()[0], hidden.level()[1], 0.0],
                EffectKind::Magnus => cross(times(hidden.axis(), size), v),
                EffectKind::SignedSpin => cross(times(hidden.axis(), size * own[0].signum()), v),
                EffectKind::Jet if (JET_S.0..JET_S.1).contains(&t) => [hidden.level()[0], hidden.level()[1], 0.0],
                EffectKind::Tether => {
                    let post = [0.4 * hidden.turn.cos(), 0.4 * hidden.turn.sin(), 1.0];
                    times(plus(post, x, -1.0), size)
                }
                EffectKind::ConstantBrake => times(v, -size / length(v).max(0.01)),
                EffectKind::LevelBrake => times([v[0], v[1], 0.0], -size / v[0].hypot(v[1]).max(0.01)),
                EffectKind::Gust => {
                    let blow = (TAU * GUST_HZ * t + PI * own[0]).sin();
                    [blow * hidden.level()[0], blow * hidden.level()[1], 0.0]
                }
                EffectKind::Vortex => cross([0.0, 0.0, hidden.signed()], x),
                EffectKind::Shear => [x[2] * hidden.level()[0], x[2] * hidden.level()[1], 0.0],
                EffectKind::Pulse => {
                    let late = (t - 0.5 - 0.15 * own[0]) / PULSE_S;
                    let push = (-late * late).exp();
                    [push * hidden.level()[0], push * hidden.level()[1], 0.0]
                }
                EffectKind::EffectiveGravity => [0.0, 0.0, -hidden.signed()],
                EffectKind::Fan => {
                    let share = (-((x[2] - 0.5) / 0.2).powi(2)).exp();
                    [share * hidden.level()[0], share * hidden.level()[1], 0.0]
                }
                EffectKind::Magnet => [0.0, 0.0, -size / (1.0 + (x[2] / 0.1).powi(2)).powi(2)],
                EffectKind::Updraught => [0.0, 0.0, size * t],
                _ => continue,
            };
            a = plus(a, push, 1.0);
        }
        a
    }

    /// How long a bounce lasts, s.
    pub fn contact_s(&self) -> f64 {
        self.hidden.iter().filter(|h| h.kind == EffectKind::ContactTime).map(|h| h.size).sum()
    }

    /// The restitution of bounce number `bounce` from 0 at `x`, approached at `speed` m/s.
    fn restitution(&self, bounce: usize, x: Vector, speed: f64) -> f64 {
        let mut e = self.restitution;
        for hidden in &self.hidden {
            e *= match hidden.kind {
                EffectKind::SpeedDependentRestitution => (speed / NOMINAL_M_S).powf(-hidden.size),
                EffectKind::Wear => (1.0 - hidden.size).powi(i32::try_from(bounce).unwrap_or(i32::MAX)),
                EffectKind::SoftSpot => {
                    let centre = [0.6 * hidden.turn.cos(), 0.6 * hidden.turn.sin()];
                    let far = (x[0] - centre[0]).hypot(x[1] - centre[1]) / 0.5;
                    1.0 - hidden.size * (-far * far).exp()
                }
                _ => continue,
            };
        }
        e.clamp(0.0, 1.0)
    }

    /// Velocity and spin after bounce number `bounce` at `t` on a floor with this normal: a solid sphere under Coulomb's law,
    /// impulses per mass.
    pub fn bounce(
        &self,
        before: BlindState,
        normal: Vector,
        (bounce, t): (usize, f64),
        scatter: [f64; 2],
    ) -> BlindState {
        let uneven: f64 = self.hidden.iter().filter(|h| h.kind == EffectKind::BounceScatter).map(|h| h.size).sum();
        let (a, b) = (uneven * scatter[0], uneven * scatter[1]);
        let rough = plus(normal, [a, b, 0.0], 1.0);
        let n = times(rough, 1.0 / length(rough));
        let speed = -dot(before.v, n);
        if speed <= 0.0 {
            return before;
        }
        let impulse = (1.0 + self.restitution(bounce, before.x, speed)) * speed;
        let mut after = BlindState { v: plus(before.v, n, impulse), ..before };
        for hidden in &self.hidden {
            match hidden.kind {
                EffectKind::ShakenFloor => {
                    let rise = hidden.size * (TAU * SHAKEN_HZ * t + hidden.lift).cos();
                    after.v = plus(after.v, n, rise.max(0.01 - dot(after.v, n)));
                }
                EffectKind::Conveyor => after.v = plus(after.v, [hidden.level()[0], hidden.level()[1], 0.0], 1.0),
                _ => {}
            }
            let arm = times(n, -RADIUS_M);
            let sliding = plus(after.v, cross(after.w, arm), 1.0);
            let slide = plus(sliding, n, -dot(sliding, n));
            let fast = length(slide);
            if fast == 0.0 {
                continue;
            }
            // Stopping the slide of a sphere's skin takes 2/7 of it from the centre.
            let taken = match hidden.kind {
                EffectKind::BounceFriction => (hidden.size * impulse).min(2.0 / 7.0 * fast),
                EffectKind::TangentialRestitution => 2.0 / 7.0 * fast * hidden.size,
                _ => continue,
            };
            let impulse = times(slide, -taken / fast);
            after.v = plus(after.v, impulse, 1.0);
            after.w = plus(after.w, cross(arm, impulse), 2.5 / (RADIUS_M * RADIUS_M));
        }
        after
    }
}

//! Where laws are hidden: a ball in flight, a free body in the plane, one around a known centre, and a driven pendulum. The
//! base model of each is known to the tool, but for its parameters.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::scene::GRAVITY_M_S2;

/// What differs from recording to recording: the start (position and velocity), two draws of the recording for what is hidden,
/// and the input at each stamp, on straight lines between them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    pub start: [f64; 6],
    pub own: [f64; 2],
    pub input: Vec<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Arena {
    Flight,
    Plane,
    Centre,
    Pendulum,
}

/// The radius of the ball, m.
pub const RADIUS_M: f64 = 0.1;

/// How soft the known centre is, m: a motion that is guessed to start at rest falls through it and can be simulated.
pub const SOFT_M: f64 = 0.05;

/// An arena with its true parameters. Of a ball the first is its restitution, of a free body its damping, 1/s, of a centre its
/// strength, m²/s², of a pendulum its stiffness, 1/s², and its damping, 1/s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Base {
    pub arena: Arena,
    pub numbers: [f64; 2],
}

impl Base {
    pub fn draw(arena: Arena, random: &mut ChaCha8Rng) -> Self {
        let numbers = match arena {
            Arena::Flight => [random.random_range(0.7..0.9), 0.0],
            Arena::Plane => [random.random_range(0.02..0.08), 0.0],
            Arena::Centre => [random.random_range(0.9..1.5), 0.0],
            Arena::Pendulum => [random.random_range(18.0..30.0), random.random_range(0.1..0.4)],
        };
        Self { arena, numbers }
    }

    /// The acceleration without the law that is hidden; `driven` is the input.
    pub fn acceleration(&self, x: [f64; 3], v: [f64; 3], driven: f64) -> [f64; 3] {
        let [first, second] = self.numbers;
        match self.arena {
            Arena::Flight => [0.0, 0.0, -GRAVITY_M_S2],
            Arena::Plane => v.map(|v| -first * v),
            Arena::Centre => {
                let square = x[0] * x[0] + x[1] * x[1] + SOFT_M * SOFT_M;
                [-first * x[0] / square, -first * x[1] / square, 0.0]
            }
            Arena::Pendulum => [driven - first * x[0].sin() - second * v[0], 0.0, 0.0],
        }
    }
}

impl Arena {
    /// How many numbers of the position are recorded.
    pub fn channels(self) -> usize {
        match self {
            Self::Flight => 3,
            Self::Plane | Self::Centre => 2,
            Self::Pendulum => 1,
        }
    }

    pub fn clock(self) -> Vec<f64> {
        let (samples, rate_hz) = match self {
            Self::Flight => (150, 100.0),
            Self::Plane | Self::Centre => (120, 20.0),
            Self::Pendulum => (200, 50.0),
        };
        (0..samples).map(|i| f64::from(i) / rate_hz).collect()
    }

    /// Standard deviation of the noise, m or rad.
    pub fn noise(self) -> f64 {
        match self {
            Self::Flight | Self::Pendulum => 2e-3,
            Self::Plane | Self::Centre => 1e-2,
        }
    }

    /// The start of a recording, and its input; `faster` scales velocities and inputs, of a pendulum the start angle too.
    pub fn draw(self, faster: f64, random: &mut ChaCha8Rng) -> Run {
        let turn: f64 = random.random_range(0.0..std::f64::consts::TAU);
        let mut start = [0.0; 6];
        let mut input = Vec::new();
        match self {
            Self::Flight => {
                let speed = faster * random.random_range(0.4..3.0);
                start[0] = random.random_range(-0.3..0.3);
                start[1] = random.random_range(-0.3..0.3);
                start[2] = RADIUS_M + random.random_range(0.7..1.8);
                start[3..].copy_from_slice(&[
                    speed * turn.cos(),
                    speed * turn.sin(),
                    faster * random.random_range(-0.5..1.5),
                ]);
            }
            Self::Plane => {
                // Towards the origin and past it: near and far are both in the record.
                let (from, speed) = (random.random_range(1.5..3.0), faster * random.random_range(0.4..0.9));
                let miss: f64 = random.random_range(0.3..1.0);
                let aim = (miss / from).asin() * if random.random() { 1.0 } else { -1.0 };
                start[..2].copy_from_slice(&[from * turn.cos(), from * turn.sin()]);
                start[3..5].copy_from_slice(&[-speed * (turn + aim).cos(), -speed * (turn + aim).sin()]);
            }
            Self::Centre => {
                let (from, speed) = (random.random_range(0.9..2.4), faster * random.random_range(0.7..1.25));
                let way = turn + if random.random() { 1.0 } else { -1.0 } * random.random_range(1.0..2.1);
                start[..2].copy_from_slice(&[from * turn.cos(), from * turn.sin()]);
                start[3..5].copy_from_slice(&[speed * way.cos(), speed * way.sin()]);
            }
            Self::Pendulum => {
                start[0] = faster * random.random_range(-0.8..0.8);
                start[3] = faster * random.random_range(-2.0..2.0);
                let waves: [[f64; 3]; 3] = std::array::from_fn(|_| {
                    [
                        random.random_range(0.5..2.5),
                        random.random_range(0.2..2.0),
                        random.random_range(0.0..std::f64::consts::TAU),
                    ]
                });
                let at = |t: f64| {
                    let each = waves.iter().map(|[a, f, phase]| a * (std::f64::consts::TAU * f * t + phase).sin());
                    faster * each.sum::<f64>()
                };
                input = self.clock().into_iter().map(at).collect();
            }
        }
        Run { start, own: [random.random(), random.random()], input }
    }

    /// The start of an orbit of `DiscoverPhysics`: from 1 to 4 m, so fast that it is near a circle under the acceleration
    /// `inward`, m/s², at its radius.
    pub fn orbit(inward: impl Fn(f64) -> f64, random: &mut ChaCha8Rng) -> Run {
        let turn: f64 = random.random_range(0.0..std::f64::consts::TAU);
        let from: f64 = random.random_range(1.0..4.0);
        let speed = (from * inward(from).abs() * random.random_range(0.6..1.4)).sqrt();
        let way = turn + if random.random() { 1.0 } else { -1.0 } * random.random_range(1.05..2.09);
        let start = [from * turn.cos(), from * turn.sin(), 0.0, speed * way.cos(), speed * way.sin(), 0.0];
        Run { start, own: [0.0; 2], input: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::set::stream;

    #[test]
    fn bodies_of_the_plane_pass_the_origin_on_one_side() {
        let mut random = stream("test", 1, "plane", 0);
        for _ in 0..50 {
            let [x, y, _, vx, vy, _] = Arena::Plane.draw(1.0, &mut random).start;
            let miss = (x * vy - y * vx).abs() / vx.hypot(vy);
            assert!((0.3..1.0).contains(&miss), "{miss}");
            assert!(x * vx + y * vy < 0.0);
        }
    }

    #[test]
    fn an_orbit_starts_near_a_circle() {
        let mut random = stream("test", 1, "orbit", 0);
        for _ in 0..50 {
            let start = Arena::orbit(|r| 1.6 / r, &mut random).start;
            let square = start[3] * start[3] + start[4] * start[4];
            assert!((0.6..1.4).contains(&(square / 1.6)), "{square}");
        }
    }
}

//! Lying, rolling and sliding: motion of a ball that an obstacle holds up.

use rapier3d::math::Vector;
use rapier3d::parry::shape::Ball;

use super::contact::{Law, Server};
use super::flight::{Field, Motion, Path, ROLLING_SHARE, along};
use super::impact::{Gap, Obstacle};

/// A rebound slower than this (m/s) ends the bouncing. What it cuts off is a hop of v²/2g = 5e-10 m.
pub(crate) const SLOWEST_REBOUND_M_S: f64 = 1e-4;
/// An obstacle nearer than this holds the ball, m.
const TOUCH_M: f64 = 1e-9;
/// The step of sliding, s: constant accelerations within it, so only the step in which slip ends is inexact, by 1e-5 m.
const SLIDING_STEP_S: f64 = 1.0 / 240.0;
/// A skin slower than this against the surface, relative to the ball's speed plus 1 m/s, rolls.
const SLIP: f64 = 1e-8;
/// Slower than this (m/s) a ball that rolling resistance can hold stands still.
const STANDSTILL_M_S: f64 = 1e-7;
/// Rounds over several supports, one after the other, within a step.
const MOST_ROUNDS: usize = 32;
/// More supports than this never matter: three planes hold a sphere.
const MOST_SUPPORTS: usize = 4;

/// What presses on a ball and what answers.
pub(crate) struct Ground<'a> {
    pub obstacles: &'a [Obstacle],
    pub ball: Ball,
    pub field: &'a Field,
    pub law: &'a Law,
    /// The present instant, s.
    pub now_s: f64,
}

/// The obstacles that hold a ball up.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Supports {
    index: [usize; MOST_SUPPORTS],
    normal: [Vector; MOST_SUPPORTS],
    count: usize,
}

impl Supports {
    pub fn contains(&self, obstacle: usize) -> bool {
        self.index[..self.count].contains(&obstacle)
    }

    fn normals(&self) -> &[Vector] {
        &self.normal[..self.count]
    }
}

impl Ground<'_> {
    /// The next piece of supported motion and what supports it; none where nothing does.
    pub fn follow(&self, motion: Motion, server: &mut Server, calls: &mut u64) -> Option<(Path, Supports)> {
        let a = self.field.acceleration(self.now_s, motion.x, motion.v);
        let (mut motion, supports) = self.settle(motion, a);
        let radius = self.ball.radius;
        let (_, friction) = self.law.at(0.0);
        if let [normal] = supports.normals()
            && self.obstacles[supports.index[0]].is_plane()
        {
            let (pressing, drive) = (-normal.dot(a), along(a, *normal));
            let slip = motion.v - motion.w.cross(*normal * radius);
            let sticks = slip.length() <= SLIP * (1.0 + motion.v.length());
            // Rolling needs friction for 2/7 of the driving acceleration.
            if sticks && drive.length() * 2.0 / 7.0 <= friction * pressing {
                let resistance = self.law.rolling_resistance * pressing;
                if motion.v.length() < STANDSTILL_M_S && drive.length() * ROLLING_SHARE <= resistance {
                    (motion.v, motion.w) = (Vector::ZERO, *normal * normal.dot(motion.w));
                    return Some((Path::even(motion, Vector::ZERO, Vector::ZERO, self.rest_s()), supports));
                }
                motion.w = normal.cross(motion.v) / radius + *normal * normal.dot(motion.w);
                return Some((Path::rolling(motion, self.now_s, self.field, *normal, radius, resistance), supports));
            }
            if friction == 0.0 && !self.field.varies {
                return Some((Path::even(motion, drive, Vector::ZERO, f64::INFINITY), supports));
            }
        }
        if supports.count == 0 {
            return None;
        }

        let step = SLIDING_STEP_S;
        let mut after = self.press(&motion, a * step, friction, &supports, server, calls);
        if self.field.varies {
            let middle = self.field.acceleration(self.now_s + 0.5 * step, motion.x, (motion.v + after.0) * 0.5);
            after = self.press(&motion, middle * step, friction, &supports, server, calls);
        }
        let at_rest = |(v, w): (Vector, Vector)| v.length() < 1e-12 && w.length() * radius < 1e-12;
        if at_rest((motion.v, motion.w)) && at_rest(after) {
            motion.v = Vector::ZERO;
            return Some((Path::even(motion, Vector::ZERO, Vector::ZERO, self.rest_s()), supports));
        }
        let path = Path::even(motion, (after.0 - motion.v) / step, (after.1 - motion.w) / step, step);
        Some((path, supports))
    }

    /// How long a ball at rest certainly stays there, s.
    fn rest_s(&self) -> f64 {
        if self.field.depends_on_time() { SLIDING_STEP_S } else { f64::INFINITY }
    }

    /// Finds what holds the ball and lays the ball onto it, without its last speed into it.
    fn settle(&self, mut motion: Motion, a: Vector) -> (Motion, Supports) {
        let mut supports = Supports::default();
        for (i, obstacle) in self.obstacles.iter().enumerate() {
            let Gap { distance, normal } = obstacle.gap(motion.x, self.ball);
            let near = distance <= TOUCH_M + 8.0 * f64::EPSILON * motion.x.abs().max_element();
            let speed = normal.dot(motion.v);
            if near && normal.dot(a) < 0.0 && speed.abs() < SLOWEST_REBOUND_M_S && supports.count < MOST_SUPPORTS {
                motion.x -= normal * distance;
                motion.v -= normal * speed;
                supports.index[supports.count] = i;
                supports.normal[supports.count] = normal;
                supports.count += 1;
            }
        }
        (motion, supports)
    }

    /// Velocity and spin after a push against the supports, each an impact without rebound.
    fn press(
        &self,
        motion: &Motion,
        push: Vector,
        friction: f64,
        supports: &Supports,
        server: &mut Server,
        calls: &mut u64,
    ) -> (Vector, Vector) {
        let (mut v, mut w) = (motion.v + push, motion.w);
        for _ in 0..MOST_ROUNDS {
            let mut quiet = true;
            for normal in supports.normals() {
                if normal.dot(v) < -1e-13 {
                    (v, w) = server.resolve(*normal, self.ball.radius, (v, w), (0.0, friction));
                    *calls += 1;
                    quiet = false;
                }
            }
            // A single support is satisfied after one impact.
            if quiet || supports.count == 1 {
                break;
            }
        }
        (v, w)
    }
}

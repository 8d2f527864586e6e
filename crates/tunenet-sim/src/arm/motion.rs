//! The circle of the tool as smooth joint positions: solved once, then shared by every rollout.

use nalgebra::{Rotation3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use tunenet_core::{Error, Origin, Result};

use super::chebyshev::{Chebyshev, nodes};
use super::reach::{Goal, Reach, Settings};
use super::{Frame, Kinematics, Model};

/// Postures from which the circle is tried; the best is kept.
const STARTS: u64 = 32;
/// Degree of the polynomials, for each turn of the circle that is begun.
const DEGREE: usize = 24;
/// Instants for each degree at which the joints are solved for.
const OVERSAMPLING: usize = 6;
/// The polynomials may leave the circle by so much, m and rad.
const FIT: f64 = 1e-4;
/// Most turns.
const MOST_TURNS: f64 = 20.0;

/// A vertical circle of the tool: at `t` it is at `centre + radius · (0, cos(rate·t), sin(rate·t))`.
///
/// With the default orientation the tool's z axis points down. Source: arXiv 1907.11200, section 4.1, whose circle it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Its centre in the world, m.
    pub centre_m: Vector3<f64>,
    /// Its radius, m.
    pub radius_m: f64,
    /// How fast it is drawn, rad/s.
    pub rate_rad_s: f64,
    /// For how long, s.
    pub duration_s: f64,
    /// The tool's orientation in the world.
    pub tool: Rotation3<f64>,
}

impl Default for Circle {
    fn default() -> Self {
        Self {
            centre_m: Vector3::new(-0.4, 0.0, 0.0),
            radius_m: 0.2,
            rate_rad_s: 1.2,
            duration_s: 5.0,
            tool: Rotation3::from_euler_angles(0.0, -std::f64::consts::PI, 0.0),
        }
    }
}

impl Circle {
    /// Where the tool is to be at `time_s`.
    #[must_use]
    pub fn goal(&self, time_s: f64) -> Goal {
        let (sine, cosine) = (self.rate_rad_s * time_s).sin_cos();
        let position_m = self.centre_m + Vector3::new(0.0, cosine, sine) * self.radius_m;
        Goal { position_m, rotation: Some(self.tool) }
    }

    fn turns(&self) -> f64 {
        (self.rate_rad_s * self.duration_s).abs() / std::f64::consts::TAU
    }
}

/// Joint positions as smooth functions of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    joints: Chebyshev,
    duration_s: f64,
}

impl Motion {
    /// The joint positions that draw `circle` with `frame`, from the posture that keeps joints farthest from their limits of
    /// position and speed. The same arguments give the same bits.
    ///
    /// # Errors
    /// [`Error::Setting`] where the circle is out of reach, leads out of the limits, or asks for too much speed.
    pub fn circle(model: &Model, frame: &Frame, circle: &Circle) -> Result<Self> {
        if circle.turns() > MOST_TURNS {
            let found = format!("{:.0} turns", circle.turns());
            return Err(refusal(format!("at most {MOST_TURNS} turns of the circle"), found));
        }
        let (mut best, mut nearest): (Option<(f64, Vec<f64>)>, _) = (None, f64::INFINITY);
        for start in 0..STARTS {
            match trace(model, frame, circle, start, true) {
                Ok(path) => {
                    let strain = strain(model, &Self::fitted(&path, model, circle));
                    if best.as_ref().is_none_or(|(least, _)| strain < *least) {
                        best = Some((strain, path));
                    }
                }
                Err(distance) => nearest = nearest.min(distance),
            }
        }
        let Some((_, path)) = best else {
            let free = (0..STARTS).any(|start| trace(model, frame, circle, start, false).is_ok());
            let (expected, found) = if free {
                ("a circle within the joints' limits", "one that needs joints outside theirs".to_string())
            } else {
                ("a circle within reach", format!("one that the tool misses by {nearest:.1e} m or rad"))
            };
            return Err(refusal(expected.into(), found));
        };
        let motion = Self::fitted(&path, model, circle);
        motion.check(model, frame, circle)?;
        Ok(motion)
    }

    fn fitted(path: &[f64], model: &Model, circle: &Circle) -> Self {
        let joints = Chebyshev::through(path, model.degrees(), circle.duration_s, degree(circle));
        Self { joints, duration_s: circle.duration_s }
    }

    /// For how long it goes, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Positions, velocities and accelerations of the joints at `time_s`, within the duration.
    ///
    /// # Panics
    /// Where a slice is shorter than [`Model::degrees`].
    pub fn at(&self, time_s: f64, q: &mut [f64], dq: &mut [f64], ddq: &mut [f64]) {
        self.joints.at(time_s, q, dq, ddq);
    }

    /// Refuses a motion that leaves limits or circle anywhere between the nodes.
    fn check(&self, model: &Model, frame: &Frame, circle: &Circle) -> Result<()> {
        let mut at = Kinematics::new(model);
        for (time_s, q, dq) in self.sampled(model, 400) {
            for ((joint, q), dq) in model.joints().iter().zip(&q).zip(&dq) {
                let limits = &joint.limits;
                if *q < limits.lower - 1e-9 || *q > limits.upper + 1e-9 {
                    let expected = format!("joint `{}` within {} to {}", joint.name, limits.lower, limits.upper);
                    return Err(refusal(expected, format!("{q:.4} at {time_s:.2} s")));
                }
                // Some slack: what makers round, drives allow.
                if dq.abs() > limits.velocity * 1.05 {
                    let expected = format!("joint `{}` no faster than {}", joint.name, limits.velocity);
                    return Err(refusal(expected, format!("{:.3} at {time_s:.2} s: lower the rate", dq.abs())));
                }
            }
            at.update(&q);
            let (now, goal) = (at.frame(frame), circle.goal(time_s));
            let turned = goal.rotation.map_or(0.0, |wanted| wanted.rotation_to(&now.rotation).angle());
            let off = (now.translation.vector - goal.position_m).norm().max(turned);
            if off > FIT {
                let found =
                    format!("{off:.1e} m or rad off at {time_s:.2} s: the arm has to fold or stretch too suddenly");
                return Err(refusal("a circle that smooth joint positions can follow".into(), found));
            }
        }
        Ok(())
    }

    /// Time, positions and velocities at `count` + 1 even instants.
    fn sampled(&self, model: &Model, count: usize) -> impl Iterator<Item = (f64, Vec<f64>, Vec<f64>)> {
        let degrees = model.degrees();
        (0..=count).map(move |i| {
            let time_s = self.duration_s * i as f64 / count as f64;
            let (mut q, mut dq, mut ddq) = (vec![0.0; degrees], vec![0.0; degrees], vec![0.0; degrees]);
            self.at(time_s, &mut q, &mut dq, &mut ddq);
            (time_s, q, dq)
        })
    }
}

fn degree(circle: &Circle) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to be at most 20 turns")]
    let turns = circle.turns().ceil().max(1.0) as usize;
    DEGREE * turns
}

/// Joint positions at the nodes, row-major `[node, joint]`, from the posture that `start` draws; or how far off it got stuck.
fn trace(
    model: &Model,
    frame: &Frame,
    circle: &Circle,
    start: u64,
    limited: bool,
) -> std::result::Result<Vec<f64>, f64> {
    let mut reach = Reach::new(model, frame);
    let mut q = vec![0.0; model.degrees()];
    reach.draw(&mut ChaCha8Rng::seed_from_u64(start), &mut q);
    let begin = Settings { limited, tolerance: 1e-9, ..Settings::default() };
    // Along the way the joints move as little as the circle allows.
    let follow = Settings { iterations: 20, centring: 0.0, tolerance: 1e-12, limited };
    let reached = |distance: f64| if distance <= 1e-8 { Ok(()) } else { Err(distance) };
    reached(reach.solve(&circle.goal(0.0), &mut q, &begin))?;
    let count = (degree(circle) + 1) * OVERSAMPLING;
    let mut path = Vec::with_capacity(count * q.len());
    for time_s in nodes(count, circle.duration_s) {
        reached(reach.solve(&circle.goal(time_s), &mut q, &follow))?;
        path.extend_from_slice(&q);
    }
    Ok(path)
}

/// How near a motion comes to the joints' limits: the greatest share of the speed limit, and of the way from the middle of
/// the range to its end. Below 1 each, it keeps within both.
fn strain(model: &Model, motion: &Motion) -> f64 {
    let joints = model.joints();
    let (mut speed, mut position) = (0.0_f64, 0.0_f64);
    for (_, q, dq) in motion.sampled(model, 100) {
        for ((joint, q), dq) in joints.iter().zip(&q).zip(&dq) {
            let limits = &joint.limits;
            speed = speed.max(dq.abs() / limits.velocity);
            if limits.lower.is_finite() && limits.upper.is_finite() {
                let middle = 0.5 * (limits.lower + limits.upper);
                position = position.max((q - middle).abs() / (limits.upper - middle));
            }
        }
    }
    // Within the limits a little speed is worth a little room; beyond them nothing is.
    speed + position + 100.0 * ((speed - 1.0).max(0.0) + (position - 1.0).max(0.0))
}

fn refusal(expected: String, found: String) -> Error {
    Error::Setting { origin: Origin::Caller, name: "motion", expected, found }
}

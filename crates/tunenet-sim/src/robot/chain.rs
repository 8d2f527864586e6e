//! Several driven joints: the scheme of one joint with the mass matrix of the chain, and the frictions of all joints together by
//! projected Gauss–Seidel (Moreau 1988; Jean 1999).

use nalgebra::{DMatrix, DVector, Vector3};
use tunenet_core::statistics::dot;

use super::acting::asked;
use super::numbers::{Command, JointNumbers, Motor};
use super::trajectory::Trajectory;
use super::wiring::Wire;
use crate::arm::{CompositeBodies, Model, Recursion};
use crate::formula_effect::joint::{AppliedTorque, JointInstant};

/// The weight and the products of speeds are taken at the middle of a step, whose end is not known at first: so often they are renewed.
const PASSES: usize = 2;
/// Most sweeps over the frictions; a chain of seven joints takes about ten.
const SWEEPS: usize = 200;
/// A change of speed below this share of the greatest speed ends them.
const SETTLED: f64 = 1e-13;

/// The chain and its working memory, which is allocated once: a step takes less time than its allocations would.
struct Chain<'a> {
    joints: &'a [JointNumbers],
    formulas: &'a [AppliedTorque],
    weighing: Recursion<'a>,
    composites: CompositeBodies<'a>,
    mass: DMatrix<f64>,
    /// The mass matrix with the braking of half a step, and its inverse.
    braked: DMatrix<f64>,
    inverse: DMatrix<f64>,
    /// Torque that rigid bodies ask for at rest in acceleration.
    bias: Vec<f64>,
    zeros: Vec<f64>,
    /// What encoders read at the middle of the step, true positions there, and speeds.
    measured: Vec<f64>,
    place: Vec<f64>,
    middle: Vec<f64>,
    speeds: DVector<f64>,
    impulse: DVector<f64>,
    /// Speeds at the end of the step.
    after: DVector<f64>,
    /// The most impulse that friction takes forwards and backwards, and what it takes.
    most: Vec<(f64, f64)>,
    taken: Vec<f64>,
    motors: Vec<Motor>,
}

/// Rolls out from the positions `q` and speeds `w` over the grid of `out`.
///
/// # Errors
/// Where a joint has no inertia.
pub(super) fn roll(
    (joints, model, gravity, formulas): (&[JointNumbers], &Model, Vector3<f64>, &[AppliedTorque]),
    wires: &mut [Wire],
    (q, w): (&[f64], &[f64]),
    out: &mut Trajectory,
) -> Result<(), &'static str> {
    let n = joints.len();
    let mut chain = Chain { formulas, ..Chain::new(joints, model, gravity) };
    let (mut q, mut w) = (q.to_vec(), w.to_vec());
    let mut commands = vec![Command { goal: 0.0, on: 1.0 }; n];
    for k in 0..out.steps() {
        for (command, wire) in commands.iter_mut().zip(&mut *wires) {
            *command = wire.command();
        }
        chain.step((&q, &w), &commands, (out.time(k), out.step_s()))?;
        for j in 0..n {
            let after = chain.after[j];
            q[j] += 0.5 * out.step_s() * (w[j] + after);
            if out.holds_torques() {
                let motor = chain.motors[j];
                out.torque(k, j, motor.torque - (motor.braking - motor.passive) * 0.5 * (w[j] + after));
            }
            w[j] = after;
            out.state(k + 1, j, q[j], w[j]);
        }
    }
    Ok(())
}

impl<'a> Chain<'a> {
    fn new(joints: &'a [JointNumbers], model: &'a Model, gravity: Vector3<f64>) -> Self {
        let n = joints.len();
        let (square, vector, list) = (DMatrix::zeros(n, n), DVector::zeros(n), vec![0.0; n]);
        Self {
            joints,
            formulas: &[],
            weighing: Recursion::new(model, gravity),
            composites: CompositeBodies::new(model),
            mass: square.clone(),
            braked: square.clone(),
            inverse: square,
            bias: list.clone(),
            zeros: list.clone(),
            measured: list.clone(),
            place: list.clone(),
            middle: list.clone(),
            speeds: vector.clone(),
            impulse: vector.clone(),
            after: vector,
            most: vec![(0.0, 0.0); n],
            taken: list,
            motors: vec![Motor { torque: 0.0, braking: 0.0, passive: 0.0 }; n],
        }
    }

    /// The speeds after a step of `dt` from `q` and `w` at the instant `t`, and the motors that led there.
    fn step(
        &mut self,
        (q, w): (&[f64], &[f64]),
        commands: &[Command],
        (t, dt): (f64, f64),
    ) -> Result<(), &'static str> {
        for (j, joint) in self.joints.iter().enumerate() {
            self.measured[j] = q[j] + 0.5 * dt * w[j];
            self.place[j] = self.measured[j] + joint.zero;
        }
        self.weighing.place(&self.place);
        self.weigh();
        self.after.copy_from_slice(w);
        self.speeds.copy_from_slice(w);
        for pass in 0..PASSES {
            for (j, middle) in self.middle.iter_mut().enumerate() {
                *middle = 0.5 * (w[j] + self.after[j]);
            }
            self.weighing.torques(&self.middle, &self.zeros, &mut self.bias);
            self.impulse.gemv(1.0, &self.mass, &self.speeds, 0.0);
            let mut renewed = pass == 0;
            for (j, joint) in self.joints.iter().enumerate() {
                let (place, measured, middle) = (self.place[j], self.measured[j], self.middle[j]);
                let at = JointInstant { t: t + 0.5 * dt, q: measured, dq: middle, command: commands[j].goal };
                let (needed, rubbing) = asked(self.formulas, j, at)?;
                let outside = -self.bias[j] + joint.preload - joint.spring * place - needed;
                let before = self.motors[j].braking;
                self.motors[j] = motor(joint, commands[j], measured, middle);
                let Motor { torque, braking, passive } = self.motors[j];
                renewed |= braking != before;
                self.impulse[j] += dt * (torque + outside) - 0.5 * dt * braking * w[j];
                let carried = outside - (torque - (braking - passive) * middle);
                let (forward, backward) = joint.friction(middle, carried, rubbing);
                self.most[j] = (dt * forward, dt * backward);
            }
            if renewed {
                self.brake(dt)?;
            }
            self.rub();
        }
        Ok(())
    }

    /// The mass matrix where the chain is, armatures included.
    fn weigh(&mut self) {
        self.composites.mass_matrix(&self.weighing, &mut self.mass);
        for (j, joint) in self.joints.iter().enumerate() {
            self.mass[(j, j)] += joint.armature;
        }
    }

    /// The inverse of the mass matrix with the braking of the motors.
    fn brake(&mut self, dt: f64) -> Result<(), &'static str> {
        self.braked.copy_from(&self.mass);
        for (j, motor) in self.motors.iter().enumerate() {
            self.braked[(j, j)] += 0.5 * dt * motor.braking;
        }
        self.inverse.copy_from(&self.braked);
        let inverted = self.inverse.try_inverse_mut();
        let heavy = (0..self.motors.len()).all(|j| self.inverse[(j, j)] > 0.0 && self.inverse[(j, j)].is_finite());
        if inverted && heavy {
            return Ok(());
        }
        // A number that is none spreads from the torques or the speeds.
        let finite = self.braked.iter().all(|value| value.is_finite());
        Err(if finite {
            "a joint has no inertia: its armature or its links need some"
        } else {
            "the simulated motion is not finite"
        })
    }

    /// Speeds for the impulse, less what friction may take of it.
    fn rub(&mut self) {
        let (inverse, speeds, taken) = (&self.inverse, &mut self.after, &mut self.taken);
        // What friction takes changes little from step to step.
        for (taken, (forward, backward)) in taken.iter_mut().zip(&self.most) {
            *taken = taken.clamp(-forward, *backward);
        }
        for (impulse, taken) in self.impulse.iter_mut().zip(&*taken) {
            *impulse += taken;
        }
        speeds.gemv(1.0, inverse, &self.impulse, 0.0);
        for _ in 0..SWEEPS {
            let mut change: f64 = 0.0;
            for (j, (forward, backward)) in self.most.iter().enumerate() {
                let before: f64 = taken[j];
                taken[j] = (before - speeds[j] / inverse[(j, j)]).clamp(-forward, *backward);
                let by = taken[j] - before;
                if by != 0.0 {
                    speeds.axpy(by, &inverse.column(j), 1.0);
                    change = change.max((by * inverse[(j, j)]).abs());
                }
            }
            if change <= SETTLED * dot(speeds.as_slice(), speeds.as_slice()).sqrt() {
                break;
            }
        }
        // What friction holds does not move, not even by rounding.
        for (j, (forward, backward)) in self.most.iter().enumerate() {
            if taken[j] > -forward && taken[j] < *backward {
                speeds[j] = 0.0;
            }
        }
    }
}

/// The motor of a joint whose speed at the middle of the step is about `middle`.
fn motor(joint: &JointNumbers, command: Command, position: f64, middle: f64) -> Motor {
    let demand = joint.demand(command.goal, position);
    let duty = demand - joint.duty_by_speed() * middle;
    if joint.drive.has_duty() && duty.abs() > joint.duty_max {
        joint.limited(command, duty.signum(), middle)
    } else {
        joint.unlimited(command, demand, middle)
    }
}

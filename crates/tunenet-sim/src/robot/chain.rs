//! Several driven joints: the scheme of one joint with the mass matrix of the chain, by the recursion of Newton and Euler (Walker and
//! Orin 1982), and the frictions of all joints together by projected Gauss–Seidel (Moreau 1988; Jean 1999).

use nalgebra::{DMatrix, DVector, Vector3};
use tunenet_core::statistics::dot;

use super::numbers::{Command, JointNumbers, Motor};
use super::trajectory::Trajectory;
use super::wiring::Wire;
use crate::arm::{Model, Recursion};

/// The weight and the products of speeds are taken at the middle of a step, whose end is not known at first: so often they are renewed.
const PASSES: usize = 2;
/// Most sweeps over the frictions; a chain of seven joints takes about ten.
const SWEEPS: usize = 200;
/// A change of speed below this share of the greatest speed ends them.
const SETTLED: f64 = 1e-13;

/// The chain and its working memory.
struct Chain<'a> {
    joints: &'a [JointNumbers],
    weighing: Recursion<'a>,
    weightless: Recursion<'a>,
    mass: DMatrix<f64>,
    inverse: DMatrix<f64>,
    /// Torque that rigid bodies ask for at rest in acceleration.
    bias: Vec<f64>,
    zeros: Vec<f64>,
    unit: Vec<f64>,
    column: Vec<f64>,
}

/// Rolls out from the positions `q` and speeds `w` over the grid of `out`.
///
/// # Errors
/// Where a joint has no inertia.
pub(super) fn roll(
    (joints, model, gravity): (&[JointNumbers], &Model, Vector3<f64>),
    wires: &mut [Wire],
    (q, w): (&[f64], &[f64]),
    out: &mut Trajectory,
) -> Result<(), &'static str> {
    let n = joints.len();
    let mut chain = Chain {
        joints,
        weighing: Recursion::new(model, gravity),
        weightless: Recursion::new(model, Vector3::zeros()),
        mass: DMatrix::zeros(n, n),
        inverse: DMatrix::zeros(n, n),
        bias: vec![0.0; n],
        zeros: vec![0.0; n],
        unit: vec![0.0; n],
        column: vec![0.0; n],
    };
    let (mut q, mut w) = (q.to_vec(), w.to_vec());
    let mut commands = vec![Command { goal: 0.0, on: 1.0 }; n];
    let mut motors = vec![Motor { torque: 0.0, braking: 0.0, passive: 0.0 }; n];
    for k in 0..out.steps() {
        for (command, wire) in commands.iter_mut().zip(&mut *wires) {
            *command = wire.step(out.time(k), out.time(k + 1));
        }
        let after = chain.step((&q, &w), &commands, &mut motors, out.step_s)?;
        for j in 0..n {
            q[j] += 0.5 * out.step_s * (w[j] + after[j]);
            if out.holds_torques() {
                let motor = motors[j];
                out.torque(k, j, motor.torque - (motor.braking - motor.passive) * 0.5 * (w[j] + after[j]));
            }
            w[j] = after[j];
            out.state(k + 1, j, q[j], w[j]);
        }
    }
    Ok(())
}

impl Chain<'_> {
    /// The speeds after a step from `q` and `w`, and the motors that led there.
    fn step(
        &mut self,
        (q, w): (&[f64], &[f64]),
        commands: &[Command],
        motors: &mut [Motor],
        dt: f64,
    ) -> Result<DVector<f64>, &'static str> {
        let n = self.joints.len();
        let measured: Vec<f64> = q.iter().zip(w).map(|(q, w)| q + 0.5 * dt * w).collect();
        let place: Vec<f64> = measured.iter().zip(self.joints).map(|(q, joint)| q + joint.zero).collect();
        self.weighing.place(&place);
        self.weigh(&place);
        let mut after = DVector::from_column_slice(w);
        for _ in 0..PASSES {
            let middle: Vec<f64> = w.iter().zip(after.iter()).map(|(a, b)| 0.5 * (a + b)).collect();
            self.weighing.torques(&middle, &self.zeros, &mut self.bias);
            let mut matrix = self.mass.clone();
            let mut impulse = &self.mass * DVector::from_column_slice(w);
            let mut most = Vec::with_capacity(n);
            for (j, joint) in self.joints.iter().enumerate() {
                let outside = -self.bias[j] - joint.spring * place[j];
                motors[j] = motor(joint, commands[j], measured[j], middle[j]);
                let Motor { torque, braking, passive } = motors[j];
                matrix[(j, j)] += 0.5 * dt * braking;
                impulse[j] += dt * (torque + outside) - 0.5 * dt * braking * w[j];
                let carried = outside - (torque - (braking - passive) * middle[j]);
                let (forward, backward) = joint.friction(middle[j], carried);
                most.push((dt * forward, dt * backward));
            }
            let factor = matrix.cholesky().ok_or("a joint has no inertia: its armature or its links need some")?;
            self.inverse = factor.inverse();
            after = self.with_friction(impulse, &most);
        }
        Ok(after)
    }

    /// The mass matrix at a position, armatures included.
    fn weigh(&mut self, place: &[f64]) {
        self.weightless.place(place);
        for j in 0..self.joints.len() {
            self.unit.fill(0.0);
            self.unit[j] = 1.0;
            self.weightless.torques(&self.zeros, &self.unit, &mut self.column);
            self.mass.column_mut(j).copy_from_slice(&self.column);
            self.mass[(j, j)] += self.joints[j].armature;
        }
    }

    /// Speeds for this impulse, less what friction may take of it.
    fn with_friction(&self, impulse: DVector<f64>, most: &[(f64, f64)]) -> DVector<f64> {
        let mut speeds = &self.inverse * impulse;
        let mut taken = vec![0.0; most.len()];
        for _ in 0..SWEEPS {
            let mut change: f64 = 0.0;
            for (j, (forward, backward)) in most.iter().enumerate() {
                let before: f64 = taken[j];
                taken[j] = (before - speeds[j] / self.inverse[(j, j)]).clamp(-forward, *backward);
                let by = taken[j] - before;
                if by != 0.0 {
                    speeds.axpy(by, &self.inverse.column(j), 1.0);
                    change = change.max((by * self.inverse[(j, j)]).abs());
                }
            }
            if change <= SETTLED * dot(speeds.as_slice(), speeds.as_slice()).sqrt() {
                break;
            }
        }
        // What friction holds does not move, not even by rounding.
        for (j, (forward, backward)) in most.iter().enumerate() {
            if taken[j] > -forward && taken[j] < *backward {
                speeds[j] = 0.0;
            }
        }
        speeds
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

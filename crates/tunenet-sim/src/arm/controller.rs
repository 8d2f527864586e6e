//! The controller that follows a motion: computed torque with its own model of the arm.

use nalgebra::Vector3;

use super::{Model, Recursion};

/// Computed torque: what the modelled arm needs for the desired acceleration, corrected by the tracking error.
///
/// `τ = M(q)·(q̈* + kp·(q* − q) + kd·(q̇* − q̇)) + h(q, q̇)`, computed by inverse dynamics. It has no model of a payload that
/// its model leaves out; what that asks for comes in through the error.
#[derive(Debug, Clone)]
pub struct ComputedTorque<'a> {
    assumed: Recursion<'a>,
    stiffness: f64,
    damping: f64,
    acceleration: Vec<f64>,
}

impl<'a> ComputedTorque<'a> {
    /// A controller with this `model` of the arm, stiffness kp (1/s²) and critical damping.
    #[must_use]
    pub fn new(model: &'a Model, gravity: Vector3<f64>, stiffness_1_s2: f64) -> Self {
        Self {
            assumed: Recursion::new(model, gravity),
            stiffness: stiffness_1_s2,
            damping: 2.0 * stiffness_1_s2.sqrt(),
            acceleration: vec![0.0; model.degrees()],
        }
    }

    /// The torques for an arm that is at `q`, `dq` and wanted at `wanted` (positions, velocities, accelerations).
    ///
    /// # Panics
    /// Where a slice is shorter than the model's [`degrees`](Model::degrees).
    pub fn torque(&mut self, (q, dq): (&[f64], &[f64]), wanted: (&[f64], &[f64], &[f64]), torque: &mut [f64]) {
        for (i, acceleration) in self.acceleration.iter_mut().enumerate() {
            let (off, slow) = (wanted.0[i] - q[i], wanted.1[i] - dq[i]);
            *acceleration = wanted.2[i] + self.stiffness * off + self.damping * slow;
        }
        self.assumed.inverse_dynamics(q, dq, &self.acceleration, torque);
    }
}

//! One rollout: the controller follows the motion, Rapier answers, and what was commanded is what is seen.

use nalgebra::Vector3;

use super::ObservedArm;
use crate::arm::{ComputedTorque, Inertia, Multibody, gravity};

/// Steps of the simulation and of the controller, 1/s.
pub const STEP_HZ: f64 = 240.0;
/// The controller's stiffness, 1/s²; its damping is critical.
pub const STIFFNESS_1_S2: f64 = 2500.0;

impl ObservedArm {
    /// Commanded torques at the instants of `clock`, s from the start of the motion; between two steps on the straight line.
    pub(super) fn roll(&self, parameters: &[f64], clock: &[f64], values: &mut [f64]) -> Result<(), String> {
        let last = clock.last().copied().unwrap_or(0.0);
        let duration = self.motion.duration_s();
        if clock[0] < 0.0 || last > duration + 1e-9 {
            let from = clock[0];
            return Err(format!(
                "the motion goes from 0 s to {duration} s, and torques are asked for {from} s to {last} s"
            ));
        }
        let [mass, x, y, z] = parameters else {
            return Err(format!("an arm's payload has 4 numbers, found {}", parameters.len()));
        };
        if *mass < 0.0 {
            return Err(format!("the payload weighs {mass} kg, but has to weigh 0 or more"));
        }
        let payload = Inertia::cube(*mass, Vector3::new(*x, *y, *z), self.payload_size_m);
        let real = self.model.loaded(&self.model.frames[self.link], &payload);
        let gravity = gravity(self.gravity_m_s2);
        let degrees = self.channels.len();
        let zero = || vec![0.0; degrees];
        let (mut q, mut dq) = (zero(), zero());
        let (mut wanted_q, mut wanted_dq, mut wanted_ddq) = (zero(), zero(), zero());
        self.motion.at(0.0, &mut q, &mut dq, &mut wanted_ddq);
        let mut arm = Multibody::new(&real, gravity, 1.0 / STEP_HZ, &q, &dq)?;
        let mut controller = ComputedTorque::new(&self.model, gravity, STIFFNESS_1_S2);
        let (mut before, mut now) = (zero(), zero());
        let (mut next, mut step) = (0, 0_u32);
        while next < clock.len() {
            let time_s = f64::from(step) / STEP_HZ;
            let until = time_s.min(duration);
            self.motion.at(until, &mut wanted_q, &mut wanted_dq, &mut wanted_ddq);
            controller.torque((&q, &dq), (&wanted_q, &wanted_dq, &wanted_ddq), &mut now);
            while next < clock.len() && clock[next] <= time_s + 1e-9 {
                let share = (1.0 - (time_s - clock[next]) * STEP_HZ).clamp(0.0, 1.0);
                let row = &mut values[next * degrees..(next + 1) * degrees];
                for ((value, now), before) in row.iter_mut().zip(&now).zip(&before) {
                    *value = before + share * (now - before);
                }
                next += 1;
            }
            arm.step(&now);
            arm.state(&mut q, &mut dq);
            std::mem::swap(&mut before, &mut now);
            step += 1;
        }
        Ok(())
    }
}

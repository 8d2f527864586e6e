//! Equations of motion of a two-link arm in the plane (Spong, Hutchinson and Vidyasagar 2006, section 7.4) under position control.

use crate::scene::GRAVITY_M_S2;

/// Lengths, m, and masses, kg, of the links; they are uniform rods, and the payload is a point at the tip.
const LENGTH_M: [f64; 2] = [0.4, 0.35];
const MASS_KG: [f64; 2] = [2.1, 1.2];
/// Gains of the controllers: N·m/rad, and N·m·s/rad.
const STIFFNESS: [f64; 2] = [150.0, 80.0];
const DAMPING: [f64; 2] = [8.0, 4.0];
/// Below this speed dry friction fades, rad/s.
const FADES_RAD_S: f64 = 0.05;

/// What moves, and what brakes each joint.
#[derive(Debug, Clone, Copy, Default)]
pub struct TwoLinks {
    pub payload_kg: f64,
    /// N·m·s.
    pub viscous: [f64; 2],
    /// Coulomb friction, N·m.
    pub coulomb: [f64; 2],
    /// kg·m².
    pub armature: [f64; 2],
    /// Drag of the second link in proportion to the square of its joint's speed, N·m·s².
    pub drag: f64,
    /// By how much the base leans, rad.
    pub tilt: f64,
}

/// Torques that the controllers command, N·m.
pub fn commanded(reference: [f64; 2], q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
    std::array::from_fn(|i| STIFFNESS[i] * (reference[i] - q[i]) - DAMPING[i] * v[i])
}

impl TwoLinks {
    /// Accelerations of both joints, rad/s². Angles are 0 where the arm hangs straight down and its base stands upright.
    pub fn acceleration(&self, torque: [f64; 2], q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        let ([l1, l2], [m1, m2], payload) = (LENGTH_M, MASS_KG, self.payload_kg);
        // Mass times length of what the second link carries, and its inertia about its joint.
        let (first, inertia) = (m2 * l2 / 2.0 + payload * l2, m2 * l2 * l2 / 3.0 + payload * l2 * l2);
        let (sin, cos) = q[1].sin_cos();
        let both = inertia + l1 * first * cos;
        let m11 = m1 * l1 * l1 / 3.0 + (m2 + payload) * l1 * l1 + 2.0 * l1 * first * cos + inertia + self.armature[0];
        let m22 = inertia + self.armature[1];
        let whirl = l1 * first * sin;
        let weight_2 = GRAVITY_M_S2 * first * (q[0] + q[1] + self.tilt).sin();
        let weight_1 = GRAVITY_M_S2 * (m1 / 2.0 + m2 + payload) * l1 * (q[0] + self.tilt).sin() + weight_2;
        let friction = |i: usize| self.viscous[i] * v[i] + self.coulomb[i] * (v[i] / FADES_RAD_S).tanh();
        let r1 = torque[0] + whirl * (2.0 * v[0] * v[1] + v[1] * v[1]) - weight_1 - friction(0);
        let r2 = torque[1] - whirl * v[0] * v[0] - weight_2 - friction(1) - self.drag * v[1].abs() * v[1];
        let determinant = m11 * m22 - both * both;
        [(m22 * r1 - both * r2) / determinant, (m11 * r2 - both * r1) / determinant]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runge_kutta::follow;

    /// Kinetic and potential energy from the speeds of the points of both rods; the base leans by `tilt`.
    fn energy(payload: f64, tilt: f64, [q1, q2, v1, v2]: [f64; 4]) -> f64 {
        let ([l1, l2], [m1, m2]) = (LENGTH_M, MASS_KG);
        let point = |mass: f64, a: f64, b: f64| {
            let (first, q, v) = (q1 + tilt, q1 + q2 + tilt, v1 + v2);
            let (x, z) = (a * v1 * first.cos() + b * v * q.cos(), a * v1 * first.sin() + b * v * q.sin());
            mass * (0.5 * (x * x + z * z) - GRAVITY_M_S2 * (a * first.cos() + b * q.cos()))
        };
        let rod = |mass: f64, a: [f64; 2], b: [f64; 2]| {
            // Simpson's rule is exact for squares.
            let at = |s: f64| point(1.0, a[0] + s * a[1], b[0] + s * b[1]);
            mass * (at(0.0) + 4.0 * at(0.5) + at(1.0)) / 6.0
        };
        rod(m1, [0.0, l1], [0.0, 0.0]) + rod(m2, [l1, 0.0], [0.0, l2]) + point(payload, l1, l2)
    }

    #[test]
    fn an_arm_without_friction_keeps_its_energy() {
        for tilt in [0.0, 0.2] {
            let arm = TwoLinks { payload_kg: 1.3, tilt, ..TwoLinks::default() };
            let slope = |_: f64, [q1, q2, v1, v2]: [f64; 4]| {
                let [a1, a2] = arm.acceleration([0.0; 2], [q1, q2], [v1, v2]);
                [v1, v2, a1, a2]
            };
            let start = [1.2, -0.7, 0.4, 2.0];
            let before = energy(1.3, tilt, start);
            let mut worst: f64 = 0.0;
            follow(start, &[0.5, 1.0, 2.0], 5e-4, slope, |_, _, state| {
                worst = worst.max((energy(1.3, tilt, state) - before).abs());
            });
            assert!(worst < 1e-6, "{worst} J of {before} J");
        }
    }
}

//! Which joints show by their dynamics where their zero is.
//!
//! Commands and readings of a joint have one zero. Another one changes a motion only where weights or inertias depend on the joint's
//! position: not of a vertical axis at the base, and not of a slide that carries nothing that turns with it.

use nalgebra::Vector3;

use crate::arm::{Model, Recursion};

/// How far the joint is moved, rad or m.
const MOVED: f64 = 0.9;
/// Torques that differ by less than this share do not depend on the position.
const SAME: f64 = 1e-9;

/// For each joint of the model, in the order of its coordinates, whether any torque depends on its position under this gravity, m/s².
#[must_use]
pub fn observable_zeros(model: &Model, gravity: Vector3<f64>) -> Vec<bool> {
    let joints = model.joints().len();
    let number = |i: usize| i as f64;
    let q: Vec<f64> = (0..joints).map(|i| 0.37 + 0.21 * number(i)).collect();
    let dq: Vec<f64> = (0..joints).map(|i| 0.6 + 0.13 * number(i)).collect();
    let ddq: Vec<f64> = (0..joints).map(|i| 1.1 - 0.17 * number(i)).collect();
    let mut recursion = Recursion::new(model, gravity);
    let mut torques = |q: &[f64]| {
        let mut torque = vec![0.0; joints];
        recursion.inverse_dynamics(q, &dq, &ddq, &mut torque);
        torque
    };
    let here = torques(&q);
    let size = here.iter().map(|torque| torque.abs()).fold(0.0, f64::max);
    (0..joints)
        .map(|joint| {
            let mut moved = q.clone();
            moved[joint] += MOVED;
            torques(&moved).iter().zip(&here).any(|(there, here)| (there - here).abs() > SAME * size)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::arm::{gravity, model_file::parse_mjcf};

    #[test]
    fn a_vertical_axis_and_a_slide_hide_their_zero() {
        let text = "<mujoco><worldbody>\
            <body><joint name='yaw' axis='0 0 1'/><geom size='0.1'/>\
            <body pos='0.3 0 0'><joint name='elbow' axis='0 0 1'/><inertial pos='0.2 0 0' mass='1' diaginertia='0.01 0.01 0.01'/>\
            <body pos='0.3 0 0'><joint name='lift' type='slide' axis='0 0 1'/><inertial pos='0 0 0' mass='1' diaginertia='0.01 0.01 0.01'/>\
            </body></body></body></worldbody></mujoco>";
        let model = parse_mjcf(Path::new("scara.xml"), text).unwrap();
        assert_eq!(observable_zeros(&model, gravity(9.81)), [false, true, false]);
        // Weights depend on both axes where gravity does not run along them.
        assert_eq!(observable_zeros(&model, Vector3::new(0.0, -9.81, 0.0)), [true, true, false]);
    }
}

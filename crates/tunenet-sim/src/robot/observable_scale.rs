//! Which joints show by their dynamics how large their torques are.
//!
//! Where no weight and no other joint acts on a joint, and its inertia is constant, `(I + J) · ddq = gain · error − damping · dq − friction`: a
//! common factor of the gain, the friction, the damping and the whole inertia changes no motion.

use nalgebra::Vector3;

use crate::arm::{Model, Recursion};

/// How far joints are moved, rad or m.
const MOVED: f64 = 0.9;
/// Torques below this share of what the joint's own acceleration takes count as none.
const NONE: f64 = 1e-9;

/// For each joint of the model, in the order of its coordinates, whether a weight, another joint or a changing inertia shows the size of its
/// torques under this gravity, m/s².
#[must_use]
pub fn observable_scales(model: &Model, gravity: Vector3<f64>) -> Vec<bool> {
    let joints = model.joints().len();
    let number = |i: usize| i as f64;
    let mut recursion = Recursion::new(model, gravity);
    let mut torque = |at: f64, joint: usize, accelerates: bool| {
        let q: Vec<f64> = (0..joints).map(|i| at + 0.37 + 0.21 * number(i)).collect();
        let moving = |size: f64| if accelerates { 0.0 } else { size };
        let dq: Vec<f64> = (0..joints).map(|i| moving(0.6 + 0.13 * number(i))).collect();
        let others: Vec<f64> = (0..joints).map(|i| moving(1.1 - 0.17 * number(i))).collect();
        let mut ddq = others;
        ddq[joint] = if accelerates { 1.0 } else { 0.0 };
        let mut torques = vec![0.0; joints];
        recursion.inverse_dynamics(&q, &dq, &ddq, &mut torques);
        torques[joint]
    };
    (0..joints)
        .map(|joint| {
            let own = [0.0, MOVED].map(|at| torque(at, joint, true));
            let rest = [0.0, MOVED].map(|at| torque(at, joint, false));
            let none = NONE * own[0].abs();
            (own[1] - own[0]).abs() > none || rest.iter().any(|torque| torque.abs() > none)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::arm::{gravity, model_file::parse_mjcf};

    fn scales(text: &str) -> Vec<bool> {
        let model = parse_mjcf(Path::new("m.xml"), text).unwrap();
        observable_scales(&model, gravity(9.81))
    }

    #[test]
    fn a_turntable_hides_the_size_of_its_torques() {
        let table = "<mujoco><worldbody><body><joint name='yaw' axis='0 0 1'/>\
            <inertial pos='0.1 0 0' mass='1' diaginertia='0.01 0.01 0.01'/></body></worldbody></mujoco>";
        assert_eq!(scales(table), [false]);
    }

    #[test]
    fn weights_couplings_and_changing_inertias_show_it() {
        let pan_tilt = "<mujoco><worldbody><body><joint name='yaw' axis='0 0 1'/>\
            <inertial pos='0 0 0' mass='1' diaginertia='0.01 0.01 0.01'/>\
            <body><joint name='tilt' axis='0 1 0'/><inertial pos='0.2 0 0' mass='1' diaginertia='0.01 0.02 0.02'/></body>\
            </body></worldbody></mujoco>";
        assert_eq!(scales(pan_tilt), [true, true]);
        let lift = "<mujoco><worldbody><body><joint name='lift' type='slide' axis='0 0 1'/>\
            <inertial pos='0 0 0' mass='1' diaginertia='0.01 0.01 0.01'/></body></worldbody></mujoco>";
        assert_eq!(scales(lift), [true]);
    }
}

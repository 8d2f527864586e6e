//! Several joints.

use super::super::chain;
use super::super::one_joint;
use super::super::trajectory::{Grid, Readout, Trajectory};
use super::super::wiring::Wire;
use super::*;
use crate::arm::{Kinematics, gravity};

const GRID: Grid = Grid { start_s: 0.0, step_s: 0.001 };

#[test]
fn a_chain_of_one_joint_is_that_joint() {
    let model = arm(PENDULUM);
    let link = model.frame("rod").unwrap().clone();
    let mass = Mass { link, mass_kg: 0.5, position_m: Vector3::new(0.0, 0.0, -0.12) };
    let joint = JointNumbers { kd: 0.05, load_friction: 0.1, inverse_speed: 0.2, command_delay_s: 0.02, ..servo() };
    let rig = Rig::new(model, vec![mass], (9.81, [0.0; 2]), vec![joint], 0.001);
    let none = super::super::imperfect::Imperfect::none(1);
    let (world, down) = rig.world(&none);
    let (goal, on) = (command(|t| (2.0 * t).sin()), on_until(4.0));
    let wire = || Wire::new(&joint, Some(&goal), Some(&on), GRID);
    let mut alone = Trajectory::new(GRID, 6000, 1, false);
    alone.state(0, 0, 0.1, 0.0);
    let mut among = alone.clone();
    one_joint::roll((&joint, &rig.load(&none).unwrap(), &[]), &mut wire(), (0.1, 0.0), &mut alone).unwrap();
    chain::roll((&[joint], &world, down, &[]), &mut [wire()], (&[0.1], &[0.0]), &mut among).unwrap();
    for t in clock(6.0) {
        let read = |of: &Trajectory| of.read(t, 0, Quantity::Position, Readout::default());
        // The chain takes speeds at the middle of a step where one joint takes those at its beginning.
        assert!((read(&alone) - read(&among)).abs() < 2e-3, "{t}: {} {}", read(&alone), read(&among));
    }
}

/// What is no number is not taken for a joint without inertia.
#[test]
fn a_motion_that_is_not_finite_is_called_so() {
    let joint = JointNumbers { viscous: f64::NAN, ..servo() };
    let rig = Rig::new(arm(PENDULUM), Vec::new(), (9.81, [0.0; 2]), vec![joint], 0.001);
    let (world, down) = rig.world(&super::super::imperfect::Imperfect::none(1));
    let (goal, on) = (command(|_| 0.0), on_until(4.0));
    let mut wires = [Wire::new(&joint, Some(&goal), Some(&on), GRID)];
    let mut out = Trajectory::new(GRID, 100, 1, false);
    let failed = chain::roll((&[joint], &world, down, &[]), &mut wires, (&[0.1], &[0.0]), &mut out);
    assert_eq!(failed, Err("the simulated motion is not finite"));
}

#[test]
fn a_double_pendulum_keeps_its_energy() {
    let model = arm(DOUBLE);
    let free = JointNumbers::free(Drive::Torque);
    let robot = robot(model.clone(), Vec::new(), vec![free; 2], &[], 0.0005);
    let times: Vec<f64> = (0..=200).map(|i| f64::from(i) / 100.0).collect();
    let still = || vec![command(|_| 0.0), command(|_| 0.0), on_until(9.0)];
    let found = rolled(&robot, still(), &[1.0, 0.5, 0.0, 0.0], &[], &times);
    // Speeds from positions 0.5 ms apart.
    let near: Vec<f64> = times.iter().map(|t| t + 0.0005).collect();
    let later = rolled(&robot, still(), &[1.0, 0.5, 0.0, 0.0], &[], &near);
    let mut at = Kinematics::new(&model);
    let mut energy = |k: usize| {
        let (q, next) = (&found[2 * k..2 * k + 2], &later[2 * k..2 * k + 2]);
        let middle: Vec<f64> = q.iter().zip(next).map(|(a, b)| 0.5 * (a + b)).collect();
        let speed: Vec<f64> = q.iter().zip(next).map(|(a, b)| (b - a) / 0.0005).collect();
        at.update(&middle);
        let height = |body: usize| (at.body(body) * nalgebra::Point3::new(0.0, 0.0, -0.2)).z;
        let potential = 0.5 * 9.81 * (height(0) + height(1));
        let (a, b) = (0.2 * speed[0], 0.2 * (speed[0] + speed[1]));
        potential + 0.25 * (a * a + a * a + b * b + 2.0 * a * b * middle[1].cos())
    };
    let first = energy(0);
    for k in [50, 100, 150, 200] {
        assert!((energy(k) - first).abs() < 4e-3, "{k}: {} {first}", energy(k));
    }
}

#[test]
fn friction_that_holds_one_joint_leaves_the_other_as_a_pendulum_of_its_own() {
    let free = JointNumbers::free(Drive::Torque);
    let held = JointNumbers { coulomb: 50.0, ..free };
    let robot = robot(arm(DOUBLE), Vec::new(), vec![held, free], &[], 0.001);
    let still = || vec![command(|_| 0.0), command(|_| 0.0), on_until(9.0)];
    let times = clock(4.0);
    let found = rolled(&robot, still(), &[0.3, -0.299, 0.0, 0.0], &[], &times);
    // About the vertical it swings as a pendulum of 0.2 m with a little inertia of its own: 0.001 rad from it.
    let rate = (0.5 * 9.81 * 0.2 / (0.5 * 0.04 + 1e-6_f64)).sqrt();
    for (t, row) in times.iter().zip(found.chunks(2)) {
        assert_eq!(row[0], 0.3);
        assert!((row[0] + row[1] - 0.001 * (rate * t).cos()).abs() < 2e-5, "{t}: {row:?}");
    }
}

#[test]
fn a_seven_joint_arm_holds_its_pose_by_its_servos() {
    let text = include_str!("../../../../../assets/jaco_robotiq.urdf");
    let model = arm(text).chain_to("grip").unwrap();
    let n = model.degrees();
    let joint = JointNumbers { stall: 60.0, kp: 40.0, gain: 0.5, armature: 0.1, ..servo() };
    let robot = robot(model, Vec::new(), vec![joint; n], &[], 0.001);
    let pose = [0.0, 2.6, 0.0, 1.8, 0.0, 2.6, 0.0];
    let start = [&pose[..], &[0.0; 7]].concat();
    let commands = |pose: &[f64]| {
        pose.iter()
            .map(|q| {
                let q = *q;
                command(move |_| q)
            })
            .collect::<Vec<_>>()
    };
    let inputs = [commands(&pose), vec![on_until(99.0)]].concat();
    let found = rolled(&robot, inputs, &start, &[], &[0.5, 1.0]);
    let farthest = found[n..].iter().zip(pose).map(|(q, goal)| (q - goal).abs()).fold(0.0, f64::max);
    assert!(farthest < 0.05, "{found:?}");
    assert_eq!(gravity(9.81).z, -9.81);
}

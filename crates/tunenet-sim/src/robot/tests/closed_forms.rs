//! Motions with a formula.

use super::*;

#[test]
fn a_released_pendulum_swings_and_decays_as_its_formula_says() {
    // I q'' + D q' + m g l q = 0 at small angles.
    let (mass, length, viscous) = (0.6, 0.2, 0.01);
    let joint = JointNumbers { viscous, ..JointNumbers::free(Drive::Position) };
    let robot = pendulum(mass, length, joint, &[], 0.001);
    let times = clock(5.0);
    let found = rolled(&robot, vec![command(|_| 0.0), on_until(1e-9)], &[0.001, 0.0], &[], &times);
    let inertia = mass * length * length + 1e-9;
    let (decay, stiffness) = (0.5 * viscous / inertia, mass * 9.81 * length / inertia);
    let rate = (stiffness - decay * decay).sqrt();
    let exact = |t: &f64| 0.001 * (-decay * t).exp() * ((rate * t).cos() + decay / rate * (rate * t).sin());
    let exact: Vec<f64> = times.iter().map(exact).collect();
    assert!(root_mean_square(&found, &exact) < 2e-6, "{}", root_mean_square(&found, &exact));
}

#[test]
fn a_constant_torque_less_coulomb_friction_gives_a_parabola() {
    let joint = JointNumbers { coulomb: 0.3, armature: 0.05, ..JointNumbers::free(Drive::Torque) };
    let robot = pendulum(0.0, 0.1, joint, &[], 0.001);
    let times = clock(1.0);
    let found = rolled(&robot, vec![command(|_| 0.8), on_until(9.0)], &[0.0, 0.0], &[], &times);
    for (t, q) in times.iter().zip(found) {
        let exact = 0.5 * (0.8 - 0.3) / (0.05 + 1e-9) * t * t;
        assert!((q - exact).abs() < 2e-5 * (1.0 + exact), "{t}: {q} {exact}");
    }
}

#[test]
fn what_friction_holds_does_not_move_at_all() {
    let joint = JointNumbers { coulomb: 0.3, armature: 0.05, ..JointNumbers::free(Drive::Torque) };
    // The weight at 0.4 rad asks for 0.19 N·m, the motor for 0.1 N·m more.
    let robot = pendulum(0.5, 0.1, joint, &[], 0.001);
    let found = rolled(&robot, vec![command(|_| -0.1), on_until(9.0)], &[0.4, 0.0], &[], &clock(3.0));
    assert!(found.iter().all(|q| *q == 0.4), "{found:?}");
}

#[test]
fn a_servo_stands_where_its_duty_carries_the_weight_and_the_friction() {
    // Rising slowly, it stops below the goal by (m g l sin q + F) / (A c kp), to within what it still creeps.
    let robot = pendulum(0.5, 0.1, servo(), &[], 0.001);
    let rising = command(|t| (0.5 * t).min(1.0));
    let found = rolled(&robot, vec![rising, on_until(99.0)], &[0.0, 0.0], &[], &[5.9, 6.0]);
    let q = found[1];
    let carried = 6.0 * 0.166 * 16.0 * (1.0 - q);
    let weight = 0.5 * 9.81 * 0.1 * q.sin();
    assert!((carried - weight - 0.12).abs() < 0.01, "{carried} {weight}");
    assert_eq!(found[0], found[1], "it rests");
}

/// A mass at the place of the load swings and hangs as a heavier load.
#[test]
fn an_extra_load_is_one_more_mass_at_the_centre_of_mass() {
    let swing = |robot: &RobotModel, kg: &[f64]| {
        rolled(robot, vec![command(|t| (0.5 * t).min(1.0)), on_until(99.0)], &[0.1, 0.0], kg, &clock(6.0))
    };
    let found = swing(&pendulum(0.5, 0.1, servo(), &["extra_load"], 0.001), &[0.3]);
    let heavier = swing(&pendulum(0.8, 0.1, servo(), &[], 0.001), &[]);
    assert!(root_mean_square(&found, &heavier) < 1e-6, "{}", root_mean_square(&found, &heavier));
    assert!(root_mean_square(&found, &swing(&pendulum(0.5, 0.1, servo(), &[], 0.001), &[])) > 1e-3);
}

#[test]
fn a_limited_goal_is_reached_at_its_greatest_speed() {
    let joint = JointNumbers { kp: 400.0, coulomb: 0.0, ..servo() };
    let robot = pendulum(0.1, 0.1, joint, &["speed_limit"], 0.001);
    let step = Input::sampled(Channel::new("goal", "rad"), Hold::Previous, vec![0.0, 0.5, 6.0], vec![0.0, 1.5, 1.5]);
    let found = rolled(&robot, vec![step.unwrap(), on_until(9.0)], &[0.0; 2], &[0.5], &[0.4, 1.0, 1.1, 2.0]);
    assert!((found[2] - found[1] - 0.2).abs() < 2e-3, "2 rad/s: {found:?}");
    assert!(found[0] == 0.0 && (found[3] - 1.5).abs() < 3e-3, "{found:?}");
}

#[test]
fn a_delay_moves_the_answer_by_as_much() {
    let robot = pendulum(0.5, 0.1, servo(), &["command_delay"], 0.001);
    let swing = || command(|t| if t < 0.5 { 0.0 } else { (3.0 * (t - 0.5)).sin() });
    let now = rolled(&robot, vec![swing(), on_until(99.0)], &[0.0; 2], &[0.0], &[1.0, 2.0, 3.0]);
    let late = rolled(&robot, vec![swing(), on_until(99.0)], &[0.0; 2], &[0.0373], &[1.0373, 2.0373, 3.0373]);
    assert!(root_mean_square(&now, &late) < 2e-5, "{now:?} {late:?}");
}

/// A delay of less than a step changes the answer in proportion: without a share of the step its slope would be 0.
#[test]
fn switching_inside_a_step_has_a_slope() {
    let robot = pendulum(0.5, 0.1, servo(), &["release_delay"], 0.001);
    let at = |delay: f64| rolled(&robot, vec![command(|_| -1.0), on_until(2.0)], &[0.0; 2], &[delay], &[2.2])[0];
    let (none, some, more) = (at(0.0), at(1e-5), at(2e-5));
    assert!((some - none).abs() > 1e-6 && ((more - some) / (some - none) - 1.0).abs() < 0.01, "{none} {some} {more}");
}

#[test]
fn backlash_leaves_half_its_gap_to_either_side_at_rest() {
    let joint = JointNumbers { kp: 200.0, coulomb: 0.05, ..servo() };
    let robot = pendulum(0.5, 0.1, joint, &["backlash"], 0.001);
    let still = || vec![command(|_| 0.8), on_until(99.0)];
    let found = rolled(&robot, still(), &[0.8, 0.0], &[0.04], &[0.0, 5.0, 6.0]);
    // The encoder is on the link: the controller brings it to the goal.
    assert!((found[2] - 0.8).abs() < 0.01 && (found[2] - found[1]).abs() < 1e-6, "{found:?}");
    // A motor that is held lets the link fall through the gap only.
    let locked = JointNumbers { kp: 0.0, coulomb: 50.0, ..servo() };
    let robot = pendulum(0.5, 0.1, locked, &["backlash"], 0.001);
    let found = rolled(&robot, still(), &[-0.3, 0.0], &[0.04], &[0.0, 3.0]);
    assert!((found[1] + 0.3).abs() < 1e-3, "{found:?}");
}

/// A command or a switch inside a step counts by its share, so that a delay of less than a step moves the motion in proportion. The goal
/// is one that the duty is not limited at: the duty is limited for a step as a whole.
#[test]
fn derivatives_by_delays_do_not_vanish_inside_a_step() {
    for (name, command_late) in [("release_delay", false), ("command_delay", true)] {
        let robot = pendulum(0.6, 0.15, servo(), &[name], 0.001);
        let goal =
            || Input::sampled(Channel::new("goal", "rad"), Hold::Previous, vec![0.0, 0.5, 6.0], vec![0.0, 0.3, 0.3]);
        let at = |delay: f64| {
            // While the joint moves one way: where it turns, friction changes its sign between two steps.
            let (off, read) = if command_late { (9.0, 0.56) } else { (0.56, 0.62) };
            rolled(&robot, vec![goal().unwrap(), on_until(off)], &[0.0; 2], &[delay], &[read])[0]
        };
        let slopes: Vec<f64> =
            [0.0201, 0.0203, 0.0207].iter().map(|at_s| (at(at_s + 1e-4) - at(*at_s)) / 1e-4).collect();
        let whole = (at(0.021) - at(0.020)) / 1e-3;
        assert!(whole.abs() > 0.1, "{name}: {whole}");
        assert!(slopes.iter().all(|slope| (slope / whole - 1.0).abs() < 0.1), "{name}: {slopes:?} {whole}");
    }
}

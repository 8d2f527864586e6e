//! The example of a robot in rapier3d names the motor that is weaker than stated.

#[path = "../../examples/rapier_robot.rs"]
mod rapier_robot;

use tunenet_core::diagnose::Verdict;

#[test]
fn the_robot_shows_its_weak_motors_or_nothing() {
    let found = rapier_robot::diagnosed(0.9).unwrap();
    assert_eq!((found.verdict(), found.names()), (Verdict::Named, vec!["motor_gain"]), "{:?}", found.conclusion);
    let gain = found.effects()[0].coefficients[0].values[0].value;
    assert!((gain - 0.9).abs() < 0.01, "{gain}");
    assert!((found.parameters[0].value - 0.5).abs() < 0.02, "{:?}", found.parameters[0]);
    assert_eq!(rapier_robot::diagnosed(1.0).unwrap().verdict(), Verdict::None);
    rapier_robot::main().unwrap();
}

//! The circle as a motion of the joints, and what it refuses.

use nalgebra::Vector3;
use tunenet_sim::arm::{Circle, Kinematics, Model, Motion, urdf};

fn arm() -> Model {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/jaco_robotiq.urdf");
    urdf::read(&path).unwrap().chain_to("grip").unwrap()
}

#[test]
fn the_tool_draws_the_circle_and_points_down() {
    let (arm, circle) = (arm(), Circle::default());
    let grip = arm.frame("grip").unwrap();
    let motion = Motion::circle(&arm, grip, &circle).unwrap();
    let (mut q, mut dq, mut ddq) = ([0.0; 7], [0.0; 7], [0.0; 7]);
    let mut at = Kinematics::new(&arm);
    let (mut off, mut tilt, mut before) = (0.0_f64, 0.0_f64, None::<([f64; 7], [f64; 7])>);
    for i in 0..=1000 {
        let time_s = f64::from(i) * 0.005;
        motion.at(time_s, &mut q, &mut dq, &mut ddq);
        at.update(&q);
        let (now, goal) = (at.frame(grip), circle.goal(time_s));
        off = off.max((now.translation.vector - goal.position_m).norm());
        tilt = tilt.max((now.rotation * Vector3::z() + Vector3::z()).norm());
        // Derivatives are those of the positions: the trapezium's rule is off by a twelfth of h² times the third.
        if let Some((last, speed)) = before {
            for j in 0..7 {
                let mean = 0.5 * (dq[j] + speed[j]);
                assert!(((q[j] - last[j]) / 0.005 - mean).abs() < 5e-4, "{time_s} s, joint {}", j + 1);
            }
        }
        before = Some((q, dq));
        for (joint, q) in arm.joints().iter().zip(q) {
            assert!((joint.limits.lower..=joint.limits.upper).contains(&q), "{}", joint.name);
        }
    }
    println!("off the circle by at most {off:.1e} m, and tilted by {tilt:.1e} rad");
    // A polynomial of degree 24 for each joint; a tenth of what is refused.
    assert!(off < 1e-5 && tilt < 1e-5, "{off:e} m, {tilt:e} rad");
    assert_eq!(motion, Motion::circle(&arm, grip, &circle).unwrap());
}

#[test]
fn a_circle_that_cannot_be_drawn_is_refused() {
    let arm = arm();
    let grip = arm.frame("grip").unwrap();
    let refused = |circle: Circle| Motion::circle(&arm, grip, &circle).unwrap_err().to_string();
    let far = refused(Circle { centre_m: Vector3::new(-2.0, 0.0, 0.0), ..Circle::default() });
    assert!(far.contains("a circle within reach, found one that the tool misses by"), "{far}");
    let fast = refused(Circle { rate_rad_s: 6.0, duration_s: 1.0, ..Circle::default() });
    assert!(fast.contains("no faster than") && fast.contains("lower the rate"), "{fast}");
    let limits = refused(Circle { centre_m: Vector3::new(-0.4, 0.0, 0.4), ..Circle::default() });
    assert!(limits.contains("limits") || limits.contains("within reach"), "{limits}");
}

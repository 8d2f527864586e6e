//! Inverse dynamics by Newton and Euler, written for tests alone: accelerations outward, forces inward.
//! Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 5; in ordinary vectors of the world.

use nalgebra::{Point3, Rotation3, Vector3};
use tunenet_models::{Motion, Pose, Robot};

/// A link on its way: its pose, its angular speed and acceleration, and speed-free acceleration of its origin.
#[derive(Clone, Copy)]
struct Moving {
    pose: Pose,
    spin: Vector3<f64>,
    spin_rate: Vector3<f64>,
    /// Acceleration of the link's origin minus gravity.
    acceleration: Vector3<f64>,
}

/// One joint in the world: its axis, a point of it, its link.
struct Axis {
    direction: Vector3<f64>,
    point: Vector3<f64>,
    link: usize,
}

/// Torques or forces at the joints of a robot without ball and free joints: bodies, armature, damping and springs.
pub fn inverse(robot: &Robot, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
    let gravity = Vector3::from(robot.gravity_m_s2.unwrap_or([0.0, 0.0, -9.81]));
    let world =
        Moving { pose: Pose::identity(), spin: Vector3::zeros(), spin_rate: Vector3::zeros(), acceleration: -gravity };
    let mut all: Vec<Moving> = Vec::new();
    let mut axes: Vec<Option<Axis>> = robot.joints.iter().map(|_| None).collect();
    for (index, link) in robot.links.iter().enumerate() {
        let parent = link.parent.map_or(world, |parent| all[parent]);
        // The link as it would be carried along by its parent, then moved by one joint after another.
        let mut now = carried(&parent, parent.pose * link.placement);
        for &j in &link.joints {
            let joint = &robot.joints[j];
            let (position, speed, rate) = (q[j] - joint.reference, v[j], a[j]);
            let direction = now.pose.rotation * joint.axis.into_inner();
            let point = (now.pose * Point3::from(joint.anchor_m)).coords;
            if joint.motion == Motion::Prismatic {
                let moved =
                    Pose::from_parts((now.pose.translation.vector + direction * position).into(), now.pose.rotation);
                let mut next = carried(&now, moved);
                next.acceleration += direction * rate + 2.0 * now.spin.cross(&(direction * speed));
                now = next;
            } else {
                let turn = Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(direction), position);
                let origin = point + turn * (now.pose.translation.vector - point);
                let at_point = carried(&now, Pose::from_parts(point.into(), now.pose.rotation));
                let spun = Moving {
                    spin: now.spin + direction * speed,
                    spin_rate: now.spin_rate + direction * rate + now.spin.cross(&(direction * speed)),
                    ..at_point
                };
                now = carried(&spun, Pose::from_parts(origin.into(), turn * now.pose.rotation));
            }
            axes[j] = Some(Axis { direction, point, link: index });
        }
        all.push(now);
    }
    // What each link needs: a force through its centre of mass and a torque.
    let needs: Vec<(Vector3<f64>, Vector3<f64>, Vector3<f64>)> = robot
        .links
        .iter()
        .zip(&all)
        .map(|(link, moving)| {
            let inertia = link.inertia.seen_from(&moving.pose);
            let arm = inertia.com_m - moving.pose.translation.vector;
            let acceleration =
                moving.acceleration + moving.spin_rate.cross(&arm) + moving.spin.cross(&moving.spin.cross(&arm));
            let tensor = inertia.about_com_kg_m2;
            let torque = tensor * moving.spin_rate + moving.spin.cross(&(tensor * moving.spin));
            (acceleration * inertia.mass_kg, torque, inertia.com_m)
        })
        .collect();
    let on = |at: usize, base: usize| {
        let mut at = Some(at);
        while let Some(link) = at {
            if link == base {
                return true;
            }
            at = robot.links[link].parent;
        }
        false
    };
    axes.iter()
        .enumerate()
        .map(|(j, axis)| {
            let axis = axis.as_ref().expect("every joint has a link");
            let joint = &robot.joints[j];
            let carried = (0..robot.links.len()).filter(|&link| on(link, axis.link));
            let bodies: f64 = carried
                .map(|link| {
                    let (force, torque, com) = &needs[link];
                    match joint.motion {
                        Motion::Prismatic => axis.direction.dot(force),
                        _ => axis.direction.dot(&(torque + (com - axis.point).cross(force))),
                    }
                })
                .sum();
            let spring = joint.stiffness * (q[j] - joint.spring_reference);
            bodies + joint.armature * a[j] + joint.damping * v[j] + spring
        })
        .collect()
}

/// What is fixed to `base` and lies at `pose`.
fn carried(base: &Moving, pose: Pose) -> Moving {
    let arm = pose.translation.vector - base.pose.translation.vector;
    let acceleration = base.acceleration + base.spin_rate.cross(&arm) + base.spin.cross(&base.spin.cross(&arm));
    Moving { pose, acceleration, ..*base }
}

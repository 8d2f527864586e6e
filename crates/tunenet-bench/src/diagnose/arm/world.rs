//! An arm of the bench's own: torques by d'Alembert's principle from where every body is at neighbouring instants.
//!
//! Nothing is shared with the simulator but the figures of the URDF: no recursion, no analytic derivative. With positions of
//! the centres of mass and orientations at t − h, t, t + h, accelerations are second differences, and the torque of a joint
//! is the work of all inertial and weight forces along its motion.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};
use tunenet_sim::arm::{Frame, JointKind, Model};

use crate::scene::GRAVITY_M_S2;

/// Distance of the neighbouring instants, s: errors of second differences (h² from the Taylor series, 1e-16/h² from rounding)
/// are both near 1e-7.
const H_S: f64 = 3e-4;

/// A body: where it hangs, what it weighs.
struct Link {
    parent: Option<usize>,
    placement: Isometry3<f64>,
    axis: Vector3<f64>,
    coordinate: usize,
    mass_kg: f64,
    com_m: Vector3<f64>,
    inertia_kg_m2: Matrix3<f64>,
}

/// The arm, its payload a point among its bodies.
pub(super) struct ArmWorld {
    links: Vec<Link>,
    gravity_m_s2: Vector3<f64>,
    /// The body and the place on it that hold the payload, and its mass.
    payload: (usize, Point3<f64>, f64),
}

/// Where every link is at one instant.
struct Pose {
    turns: Vec<Rotation3<f64>>,
    /// Axes of the joints and points on them.
    axes: Vec<(Vector3<f64>, Point3<f64>)>,
    /// Masses in their places.
    points: Vec<Point3<f64>>,
}

impl ArmWorld {
    /// The arm with a point payload at `com_m` of `frame`, its base turned by `tilt_rad` about x, then y.
    pub fn new(model: &Model, frame: &Frame, mass_kg: f64, com_m: [f64; 3], tilt_rad: [f64; 2]) -> Self {
        let placed = |pose: &tunenet_sim::arm::Pose| {
            Isometry3::from_parts(pose.translation, UnitQuaternion::from_rotation_matrix(&pose.rotation))
        };
        let links = model.bodies.iter().map(|body| {
            assert!(
                body.joint.kind != JointKind::Prismatic && body.coordinate.own,
                "the bench's arm has turning joints"
            );
            Link {
                parent: body.parent,
                placement: placed(&body.placement),
                axis: body.joint.axis.into_inner(),
                coordinate: body.coordinate.index,
                mass_kg: body.inertia.mass_kg,
                com_m: body.inertia.com_m,
                inertia_kg_m2: body.inertia.about_com_kg_m2,
            }
        });
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), tilt_rad[1])
            * Rotation3::from_axis_angle(&Vector3::x_axis(), tilt_rad[0]);
        let at = placed(&frame.placement) * Point3::from(Vector3::from(com_m));
        Self {
            links: links.collect(),
            // Seen from the tilted base, the plumb line leans the other way.
            gravity_m_s2: turn.transpose() * Vector3::new(0.0, 0.0, -GRAVITY_M_S2),
            payload: (frame.body.unwrap_or(0), at, mass_kg),
        }
    }

    fn pose(&self, q: &[f64]) -> Pose {
        let mut frames: Vec<Isometry3<f64>> = Vec::with_capacity(self.links.len());
        let mut pose = Pose { turns: Vec::new(), axes: Vec::new(), points: Vec::new() };
        for link in &self.links {
            let base = link.parent.map_or(Isometry3::identity(), |p| frames[p]) * link.placement;
            let frame = base * Isometry3::rotation(link.axis * q[link.coordinate]);
            pose.axes.push((base * link.axis, Point3::from(base.translation.vector)));
            pose.turns.push(frame.rotation.to_rotation_matrix());
            pose.points.push(frame * Point3::from(link.com_m));
            frames.push(frame);
        }
        pose.points.push(frames[self.payload.0] * self.payload.1);
        pose
    }

    /// Torques that keep the arm on `q(t)` at `t`.
    pub fn torques(&self, q: &dyn Fn(f64) -> Vec<f64>, t: f64) -> Vec<f64> {
        let [before, now, after] = [t - H_S, t, t + H_S].map(|t| self.pose(&q(t)));
        let n = self.links.len();
        // Inertial less weight force of every mass, and the change of every body's angular momentum.
        let force = |k: usize, mass: f64| {
            let a = (after.points[k].coords - now.points[k].coords * 2.0 + before.points[k].coords) / (H_S * H_S);
            (a - self.gravity_m_s2) * mass
        };
        let momentum = |k: usize| {
            let link = &self.links[k];
            let half = |first: &Rotation3<f64>, second: &Rotation3<f64>| {
                // The turn between two instants, about a fixed axis: angular velocity half way. It is so small that its sine
                // stands for it, which, other than a logarithm, has no singular place.
                let turn = (second * first.transpose()).into_inner();
                let skew = turn - turn.transpose();
                let omega = Vector3::new(skew[(2, 1)], skew[(0, 2)], skew[(1, 0)]) / (2.0 * H_S);
                let middle = Rotation3::new(omega * (0.5 * H_S)) * first;
                middle * (link.inertia_kg_m2 * (middle.transpose() * omega))
            };
            (half(&now.turns[k], &after.turns[k]) - half(&before.turns[k], &now.turns[k])) / H_S
        };
        let mut torques = vec![0.0; n];
        for k in 0..=n {
            let (carrier, mass, turning) = if k < n {
                (k, self.links[k].mass_kg, momentum(k))
            } else {
                (self.payload.0, self.payload.2, Vector3::zeros())
            };
            let push = force(k, mass);
            let mut joint = Some(carrier);
            while let Some(j) = joint {
                let (axis, point) = now.axes[j];
                torques[self.links[j].coordinate] += axis.dot(&((now.points[k] - point).cross(&push) + turning));
                joint = self.links[j].parent;
            }
        }
        torques
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tunenet_sim::arm::{Recursion, gravity, urdf};

    /// Two ways to the same torques, which share nothing but the URDF's figures.
    #[test]
    fn the_bench_and_the_simulator_agree_on_rigid_bodies() {
        let model = urdf::parse("jaco_robotiq.urdf".as_ref(), crate::scene::URDF).unwrap().chain_to("grip").unwrap();
        let frame = model.frame("grip").unwrap().clone();
        let q = |t: f64| -> Vec<f64> {
            (0..7).map(|j| 1.0 + 0.3 * f64::from(j) + 0.5 * (t * (1.0 + 0.2 * f64::from(j))).sin()).collect()
        };
        let (mut dq, mut ddq) = (vec![0.0; 7], vec![0.0; 7]);
        for (j, (dq, ddq)) in dq.iter_mut().zip(&mut ddq).enumerate() {
            let w = 1.0 + 0.2 * j as f64;
            (*dq, *ddq) = (0.5 * w * (0.7 * w).cos(), -0.5 * w * w * (0.7 * w).sin());
        }
        let mut expected = vec![0.0; 7];
        Recursion::new(&model, gravity(9.81)).inverse_dynamics(&q(0.7), &dq, &ddq, &mut expected);
        let found = ArmWorld::new(&model, &frame, 0.0, [0.0; 3], [0.0; 2]).torques(&q, 0.7);
        for (a, b) in found.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-4, "{found:?} instead of {expected:?}");
        }
    }
}

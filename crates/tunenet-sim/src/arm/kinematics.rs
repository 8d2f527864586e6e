//! Forward kinematics and the geometric Jacobian.

use nalgebra::{Matrix6xX, Point3, Vector3};

use super::{Frame, JointKind, Model, Pose};

/// Where the bodies of one model are; working memory that is allocated once.
///
/// ```
/// # use tunenet_sim::arm::{Kinematics, urdf};
/// # let text = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/jaco_robotiq.urdf"));
/// let arm = urdf::parse("jaco_robotiq.urdf".as_ref(), text)?.chain_to("grip")?;
/// let mut at = Kinematics::new(&arm);
/// let pi = std::f64::consts::PI;
/// at.update(&[0.0, pi, 0.0, pi, 0.0, pi, 0.0]);
/// // Straight up: the lengths of the links add up.
/// let tool = at.frame(arm.frame("grip")?);
/// assert!((tool.translation.z - 1.2953).abs() < 1e-9 && tool.translation.x.abs() < 1e-9);
/// # Ok::<(), tunenet_core::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Kinematics<'a> {
    model: &'a Model,
    poses: Vec<Pose>,
}

impl<'a> Kinematics<'a> {
    /// Working memory for `model`, all joints at 0.
    #[must_use]
    pub fn new(model: &'a Model) -> Self {
        let mut new = Self { model, poses: vec![Pose::identity(); model.bodies.len()] };
        new.update(&vec![0.0; model.degrees()]);
        new
    }

    /// Moves the joints to `q`.
    ///
    /// # Panics
    /// Where `q` is shorter than [`Model::degrees`].
    pub fn update(&mut self, q: &[f64]) {
        for (i, body) in self.model.bodies.iter().enumerate() {
            let own = body.moved(body.coordinate.position(q));
            self.poses[i] = body.parent.map_or(own, |parent| self.poses[parent] * own);
        }
    }

    /// Where body `i` is in the world.
    #[must_use]
    pub fn body(&self, i: usize) -> &Pose {
        &self.poses[i]
    }

    /// Where `frame` is in the world.
    #[must_use]
    pub fn frame(&self, frame: &Frame) -> Pose {
        frame.body.map_or(frame.placement, |body| self.poses[body] * frame.placement)
    }

    /// How `frame` moves with the joints, in world axes: rows are velocity (m/s) of its origin and angular velocity (rad/s),
    /// columns the coordinates.
    ///
    /// # Panics
    /// Where `jacobian` has fewer columns than [`Model::degrees`].
    pub fn jacobian(&self, frame: &Frame, jacobian: &mut Matrix6xX<f64>) {
        jacobian.fill(0.0);
        let origin = Point3::from(self.frame(frame).translation.vector);
        let mut at = frame.body;
        while let Some(i) = at {
            let (body, pose) = (&self.model.bodies[i], &self.poses[i]);
            let axis = pose.rotation * body.joint.axis.into_inner();
            let (linear, angular) = match body.joint.kind {
                JointKind::Prismatic => (axis, Vector3::zeros()),
                _ => (axis.cross(&(origin - Point3::from(pose.translation.vector))), axis),
            };
            let mut column = jacobian.column_mut(body.coordinate.index);
            for k in 0..3 {
                column[k] += body.coordinate.multiplier * linear[k];
                column[k + 3] += body.coordinate.multiplier * angular[k];
            }
            at = body.parent;
        }
    }
}

//! The arm as Rapier simulates it: a multibody on a fixed base, driven by torques alone.
//!
//! Rapier has no input for generalised forces, so a joint's torque goes onto its body and back onto the parent. Its terms of
//! Coriolis converge with the step: for slow motion 1/240 s is near enough (see `tests/sim/arm_multibody.rs`).

use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};
use rapier3d::math::{Matrix, Pose as RapierPose, Vector};
use rapier3d::prelude::{
    GenericJointBuilder, JointAxesMask, MassProperties, MultibodyJointHandle, PhysicsWorld, RigidBodyBuilder,
    RigidBodyHandle,
};

use super::{JointKind, Model, Pose};

/// An arm on its way.
pub struct Multibody<'a> {
    model: &'a Model,
    world: PhysicsWorld,
    base: RigidBodyHandle,
    /// Body and joint of every body of the model.
    bodies: Vec<(RigidBodyHandle, MultibodyJointHandle)>,
}

impl<'a> Multibody<'a> {
    /// An arm that moves with `dq` at `q` under `gravity` (m/s², in world axes), simulated in steps of `step_s`.
    ///
    /// # Errors
    /// A sentence where a joint mimics another: Rapier would couple them by springs.
    ///
    /// # Panics
    /// Where `q` or `dq` is shorter than [`Model::degrees`].
    pub fn new(model: &'a Model, gravity: Vector3<f64>, step_s: f64, q: &[f64], dq: &[f64]) -> Result<Self, String> {
        if let Some(body) = model.bodies.iter().find(|b| !b.coordinate.own) {
            return Err(format!("joint `{}` mimics another; such arms cannot be simulated yet", body.joint.name));
        }
        let mut world = PhysicsWorld { gravity: vector(&gravity), ..PhysicsWorld::default() };
        world.integration_parameters.dt = step_s;
        world.integration_parameters.num_solver_iterations = 1;
        let base = world.bodies.insert(RigidBodyBuilder::fixed());
        let mut new = Self { model, world, base, bodies: Vec::with_capacity(model.bodies.len()) };
        for body in &model.bodies {
            let i = &body.inertia;
            let rows = i.about_com_kg_m2;
            let column = |k: usize| Vector::new(rows[(0, k)], rows[(1, k)], rows[(2, k)]);
            let inertia = Matrix::from_cols(column(0), column(1), column(2));
            let mass = MassProperties::with_inertia_matrix(vector(&i.com_m), i.mass_kg, inertia);
            let builder = RigidBodyBuilder::dynamic().can_sleep(false).additional_mass_properties(mass);
            let handle = new.world.bodies.insert(builder);
            let along = along(&body.joint.axis);
            let turned = Pose::from_parts(nalgebra::Translation3::identity(), along);
            let free = match body.joint.kind {
                JointKind::Prismatic => JointAxesMask::LOCKED_PRISMATIC_AXES,
                _ => JointAxesMask::LOCKED_REVOLUTE_AXES,
            };
            let joint = GenericJointBuilder::new(free)
                .local_frame1(pose(&(body.placement * turned)))
                .local_frame2(pose(&turned))
                .contacts_enabled(false)
                .build();
            let parent = body.parent.map_or(base, |p| new.bodies[p].0);
            let joint = new.world.multibody_joints.insert(parent, handle, joint, true);
            // Every body is new and hangs on one that is there.
            let joint = joint.ok_or("Rapier refuses the arm's joints")?;
            new.bodies.push((handle, joint));
        }
        new.place(q, dq);
        Ok(new)
    }

    /// Puts the arm at `q`, moving with `dq`.
    fn place(&mut self, q: &[f64], dq: &[f64]) {
        for (handle, _) in &self.bodies {
            if let Some(body) = self.world.bodies.get_mut(*handle) {
                body.recompute_mass_properties_from_colliders(&self.world.colliders);
            }
        }
        let degrees = self.model.bodies.len();
        let by_body =
            |values: &[f64]| -> Vec<f64> { self.model.bodies.iter().map(|b| values[b.coordinate.index]).collect() };
        let (displacement, speed) = (by_body(q), by_body(dq));
        let Some((_, first)) = self.bodies.first() else { return };
        let Some((multibody, _)) = self.world.multibody_joints.get_mut(*first) else { return };
        // Only after this the fixed base counts no degrees of its own.
        multibody.forward_kinematics(&self.world.bodies, true);
        multibody.damping_mut().fill(0.0);
        multibody.apply_displacements(&displacement);
        multibody.forward_kinematics(&self.world.bodies, false);
        for (i, speed) in speed.iter().enumerate().take(degrees) {
            multibody.generalized_velocity_mut()[i] = *speed;
        }
        multibody.update_rigid_bodies(&mut self.world.bodies, true);
    }

    /// Positions and velocities of the joints now.
    ///
    /// # Panics
    /// Where a slice is shorter than [`Model::degrees`].
    pub fn state(&self, q: &mut [f64], dq: &mut [f64]) {
        for (at, (body, (_, joint))) in self.model.bodies.iter().zip(&self.bodies).enumerate() {
            let Some((multibody, link)) = self.world.multibody_joints.get(*joint) else { continue };
            let Some(link) = multibody.link(link) else { continue };
            let first = usize::from(body.joint.kind != JointKind::Prismatic) * 3;
            q[body.coordinate.index] = link.joint().coords()[first];
            dq[body.coordinate.index] = multibody.generalized_velocity()[at];
        }
    }

    /// Goes one step with these torques (N·m; N of a prismatic joint) in the joints.
    ///
    /// # Panics
    /// Where `torque` is shorter than [`Model::degrees`].
    pub fn step(&mut self, torque: &[f64]) {
        for (handle, _) in &self.bodies {
            let body = &mut self.world.bodies[*handle];
            body.reset_forces(false);
            body.reset_torques(false);
        }
        for (at, body) in self.model.bodies.iter().enumerate() {
            let (handle, size) = (self.bodies[at].0, torque[body.coordinate.index]);
            let now = *self.world.bodies[handle].position();
            let axis = now.rotation * vector(&body.joint.axis) * size;
            let parent = body.parent.map_or(self.base, |p| self.bodies[p].0);
            if body.joint.kind == JointKind::Prismatic {
                self.world.bodies[handle].add_force_at_point(axis, now.translation, true);
                self.world.bodies[parent].add_force_at_point(-axis, now.translation, true);
            } else {
                self.world.bodies[handle].add_torque(axis, true);
                self.world.bodies[parent].add_torque(-axis, true);
            }
        }
        self.world.step();
    }
}

/// The rotation that takes x to `axis`: Rapier's free axis is x.
fn along(axis: &Vector3<f64>) -> Rotation3<f64> {
    Rotation3::rotation_between(&Vector3::x(), axis)
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI))
}

fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn pose(pose: &Pose) -> RapierPose {
    Isometry3::from_parts(pose.translation, UnitQuaternion::from_rotation_matrix(&pose.rotation)).into()
}

//! Inverse dynamics: the recursion of Newton and Euler, outwards for the motion, inwards for the forces.
//!
//! Source: Luh, Walker and Paul (1980). All vectors are in world axes; gravity enters as an upward acceleration of the base.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::{Frame, JointKind, Model};

/// How one body moves, and what acts on it.
#[derive(Debug, Clone, Copy)]
struct Link {
    rotation: Rotation3<f64>,
    position: Vector3<f64>,
    axis: Vector3<f64>,
    /// From the origin of the carrier to that of the link.
    arm: Vector3<f64>,
    /// Angular velocity and acceleration.
    omega: Vector3<f64>,
    alpha: Vector3<f64>,
    /// Acceleration of the origin, less gravity.
    acceleration: Vector3<f64>,
    /// What its joint has to carry: force, and moment about its origin.
    force: Vector3<f64>,
    moment: Vector3<f64>,
}

/// A frame's motion in its own axes: what a load there feels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FrameMotion {
    pub rotation: Rotation3<f64>,
    pub position: Vector3<f64>,
    pub omega: Vector3<f64>,
    pub alpha: Vector3<f64>,
    pub acceleration: Vector3<f64>,
}

/// The recursion over one model; working memory that is allocated once.
///
/// What it gives is the torque that moves the rigid bodies; friction of the joints is not in it.
#[derive(Debug, Clone)]
pub struct Recursion<'a> {
    model: &'a Model,
    gravity: Vector3<f64>,
    links: Vec<Link>,
}

impl<'a> Recursion<'a> {
    /// Working memory for `model`, with `gravity` as an acceleration in world axes, m/s²
    /// ([`gravity`](super::gravity)).
    #[must_use]
    pub fn new(model: &'a Model, gravity: Vector3<f64>) -> Self {
        let zero = Vector3::zeros();
        let rest = Link {
            rotation: Rotation3::identity(),
            position: zero,
            axis: zero,
            arm: zero,
            omega: zero,
            alpha: zero,
            acceleration: zero,
            force: zero,
            moment: zero,
        };
        Self { model, gravity, links: vec![rest; model.bodies.len()] }
    }

    /// The torques (N·m; N of a prismatic joint) that accelerate the arm at `q`, `dq` by `ddq`, into `torque`; one for each
    /// coordinate, all slices [`Model::degrees`] long.
    ///
    /// # Panics
    /// Where a slice is shorter.
    pub fn inverse_dynamics(&mut self, q: &[f64], dq: &[f64], ddq: &[f64], torque: &mut [f64]) {
        self.place(q);
        self.torques(dq, ddq, torque);
    }

    /// The same at the position of the last [`place`](Self::place).
    pub(crate) fn torques(&mut self, dq: &[f64], ddq: &[f64], torque: &mut [f64]) {
        self.outwards(dq, ddq);
        torque.fill(0.0);
        for i in (0..self.links.len()).rev() {
            let (body, link) = (&self.model.bodies[i], self.links[i]);
            let along = if body.joint.kind == JointKind::Prismatic { link.force } else { link.moment };
            torque[body.coordinate.index] += body.coordinate.multiplier * link.axis.dot(&along);
            if let Some(parent) = body.parent {
                let carrier = &mut self.links[parent];
                carrier.force += link.force;
                carrier.moment += link.moment + (link.position - carrier.position).cross(&link.force);
            }
        }
    }

    /// Places all bodies at the position `q`.
    ///
    /// # Panics
    /// Where it is shorter than [`Model::degrees`].
    pub(crate) fn place(&mut self, q: &[f64]) {
        let zero = Vector3::zeros();
        for (i, body) in self.model.bodies.iter().enumerate() {
            let (rotation, position) = match body.parent.map(|p| &self.links[p]) {
                Some(p) => (p.rotation, p.position),
                None => (Rotation3::identity(), zero),
            };
            let at = body.coordinate.position(q);
            let mut arm = rotation * body.placement.translation.vector;
            let joint = rotation * body.placement.rotation;
            let axis = joint * body.joint.axis.into_inner();
            let link = &mut self.links[i];
            link.rotation = if body.joint.kind == JointKind::Prismatic {
                arm += axis * at;
                joint
            } else {
                joint * Rotation3::from_axis_angle(&body.joint.axis, at)
            };
            link.axis = axis;
            link.arm = arm;
            link.position = position + arm;
        }
    }

    /// Where the frame of a body is, by its place in the list of the model: its orientation and its origin.
    pub(super) fn place_of(&self, body: usize) -> (&Rotation3<f64>, Vector3<f64>) {
        (&self.links[body].rotation, self.links[body].position)
    }

    /// The axis of the joint that moves a body.
    pub(super) fn axis_of(&self, body: usize) -> Vector3<f64> {
        self.links[body].axis
    }

    /// The motion of all bodies where they are placed, and the force and moment that each alone needs.
    fn outwards(&mut self, dq: &[f64], ddq: &[f64]) {
        let zero = Vector3::zeros();
        for (i, body) in self.model.bodies.iter().enumerate() {
            let (omega, alpha, acceleration) = match body.parent.map(|p| &self.links[p]) {
                Some(p) => (p.omega, p.alpha, p.acceleration),
                None => (zero, zero, -self.gravity),
            };
            let c = &body.coordinate;
            let (speed, faster) = (c.multiplier * dq[c.index], c.multiplier * ddq[c.index]);
            let link = &mut self.links[i];
            let (axis, arm) = (link.axis, link.arm);
            let (mut sliding, mut turning) = (zero, (zero, zero));
            if body.joint.kind == JointKind::Prismatic {
                sliding = omega.cross(&axis) * (2.0 * speed) + axis * faster;
            } else {
                turning = (axis * speed, axis * faster + omega.cross(&axis) * speed);
            }
            link.acceleration = acceleration + alpha.cross(&arm) + omega.cross(&omega.cross(&arm)) + sliding;
            link.omega = omega + turning.0;
            link.alpha = alpha + turning.1;
            let com = link.rotation * body.inertia.com_m;
            let of_com = link.acceleration + link.alpha.cross(&com) + link.omega.cross(&link.omega.cross(&com));
            let turned: &Matrix3<f64> = link.rotation.matrix();
            let inertia = |v: &Vector3<f64>| turned * (body.inertia.about_com_kg_m2 * (turned.transpose() * v));
            link.force = of_com * body.inertia.mass_kg;
            link.moment = inertia(&link.alpha) + link.omega.cross(&inertia(&link.omega)) + com.cross(&link.force);
        }
    }

    /// The motion of `frame` at the last call, in its own axes.
    pub(super) fn motion_of(&self, frame: &Frame) -> FrameMotion {
        let base = frame.placement;
        let Some(link) = frame.body.map(|i| &self.links[i]) else {
            let (rotation, position) = (base.rotation, base.translation.vector);
            let (zero, acceleration) = (Vector3::zeros(), rotation.inverse() * -self.gravity);
            return FrameMotion { rotation, position, omega: zero, alpha: zero, acceleration };
        };
        let rotation = link.rotation * base.rotation;
        let arm = link.rotation * base.translation.vector;
        let acceleration = link.acceleration + link.alpha.cross(&arm) + link.omega.cross(&link.omega.cross(&arm));
        let own = rotation.inverse();
        FrameMotion {
            rotation,
            position: link.position + arm,
            omega: own * link.omega,
            alpha: own * link.alpha,
            acceleration: own * acceleration,
        }
    }

    /// What a force and a moment at `at` (world) ask of the joints that carry `body`, added by `add(coordinate, torque)`.
    pub(super) fn carried(
        &self,
        body: Option<usize>,
        at: &Vector3<f64>,
        force: &Vector3<f64>,
        moment: &Vector3<f64>,
        mut add: impl FnMut(usize, f64),
    ) {
        let mut carrier = body;
        while let Some(i) = carrier {
            let (body, link) = (&self.model.bodies[i], &self.links[i]);
            let along = match body.joint.kind {
                JointKind::Prismatic => *force,
                _ => moment + (at - link.position).cross(force),
            };
            add(body.coordinate.index, body.coordinate.multiplier * link.axis.dot(&along));
            carrier = body.parent;
        }
    }
}

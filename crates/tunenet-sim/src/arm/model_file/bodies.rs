//! From links, joints and couplings of a file to moving bodies: one for each joint, fixed links merged into what carries them.

use std::path::Path;

use nalgebra::{Rotation3, Translation3, Vector3};
use tunenet_core::observation::Note;
use tunenet_formats::{Error, Result};
use tunenet_models::{Motion, Robot, Weight};

use super::left_out;
use crate::arm::{Body, Coordinate, Frame, Inertia, Joint, JointKind, Limits, Model, Pose};
use crate::findings;

/// What becomes of a joint.
#[derive(Debug, Clone, Copy)]
enum Role {
    /// It moves.
    Moves(Coordinate),
    /// It stays at this position.
    Held(f64),
}

/// The model of a robot that the file at `path` describes.
pub(super) fn model(path: &Path, robot: &Robot) -> Result<Model> {
    let mut notes = left_out::notes(robot);
    let roles = roles(path, robot, &mut notes)?;
    let mut model = Model { name: robot.name.clone(), bodies: Vec::new(), frames: Vec::new(), notes };
    // Where each link went: the body that carries it, and its place there.
    let mut homes: Vec<(Option<usize>, Pose)> = Vec::new();
    for (index, link) in robot.links.iter().enumerate() {
        let (mut carrier, mut place) = link.parent.map_or((None, Pose::identity()), |parent| homes[parent]);
        place *= link.placement;
        for &j in &link.joints {
            let joint = &robot.joints[j];
            let anchor = Pose::from_parts(Translation3::from(joint.anchor_m), Rotation3::identity());
            let away = anchor.inverse();
            match roles[j] {
                Role::Held(position) => place = place * anchor * moved(joint, position) * away,
                Role::Moves(coordinate) => {
                    // The joint's own frame turns by the joint's position, which is its reference where the links lie.
                    let placement = place * anchor * moved(joint, 0.0);
                    let joint = described(robot, j);
                    model.notes.extend(joint.without_limits());
                    let inertia = Inertia::default();
                    let body = Body { name: link.name.clone(), parent: carrier, placement, joint, coordinate, inertia };
                    model.bodies.push(body);
                    (carrier, place) = (Some(model.bodies.len() - 1), away);
                }
            }
        }
        if let Some(body) = carrier {
            if let Weight::Mesh(what) = &link.weight {
                return Err(without_mass(path, &link.name, what));
            }
            let own = Inertia {
                mass_kg: link.inertia.mass_kg,
                com_m: link.inertia.com_m,
                about_com_kg_m2: link.inertia.about_com_kg_m2,
            };
            let carrier = &mut model.bodies[body];
            carrier.inertia = carrier.inertia.with(&own.seen_from(&place));
        }
        homes.push((carrier, place));
        model.frames.push(Frame { name: robot.links[index].name.clone(), body: carrier, placement: place });
    }
    if model.bodies.is_empty() {
        let message = "expected a hinge or a slide, found none";
        return Err(Error::file(path, message, "is this the model of an arm?"));
    }
    Ok(model)
}

/// How far the joint's frame is moved at a position.
fn moved(joint: &tunenet_models::Joint, position: f64) -> Pose {
    let by = position - joint.reference;
    match joint.motion {
        Motion::Prismatic => Pose::from_parts((joint.axis.into_inner() * by).into(), Rotation3::identity()),
        Motion::Revolute => Pose::from_parts(Vector3::zeros().into(), Rotation3::from_axis_angle(&joint.axis, by)),
        Motion::Ball | Motion::Free => Pose::identity(),
    }
}

/// The joint with its limits; where it states no effort, that of its only actuator.
fn described(robot: &Robot, index: usize) -> Joint {
    let joint = &robot.joints[index];
    let kind = match (joint.motion, joint.range) {
        (Motion::Prismatic, _) => JointKind::Prismatic,
        (_, Some(_)) => JointKind::Revolute,
        _ => JointKind::Continuous,
    };
    let mut own = robot.actuators.iter().filter(|a| a.target == tunenet_models::Target::Joint(index));
    let actuator = match (own.next(), own.next()) {
        (Some(only), None) => only.force_range.map(|[_, force]| force * only.gear.abs()),
        _ => None,
    };
    let [lower, upper] = joint.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let effort = joint.effort_range.map(|[_, effort]| effort).or(actuator).filter(|effort| *effort > 0.0);
    let limits = Limits {
        lower,
        upper,
        velocity: joint.velocity_limit.unwrap_or(f64::INFINITY),
        effort: effort.unwrap_or(f64::INFINITY),
    };
    Joint { name: joint.name.clone(), kind, axis: joint.axis, limits, damping: joint.damping, friction: joint.friction }
}

fn without_mass(path: &Path, link: &str, what: &str) -> Error {
    let message =
        format!("body `{link}`, which moves: expected an <inertial>, found none: its mass would come from {what}");
    let hint = "add <inertial> with mass and inertia; MuJoCo writes it where <compiler saveinertial=\"true\"/> stands and it saves \
                the model";
    Error::file(path, message, hint)
}

/// What becomes of each joint.
fn roles(path: &Path, robot: &Robot, notes: &mut Vec<Note>) -> Result<Vec<Role>> {
    let mut roles = Vec::new();
    let mut next = 0;
    for (index, joint) in robot.joints.iter().enumerate() {
        let tie = tie(robot, index);
        roles.push(match (joint.motion, tie) {
            (Motion::Ball | Motion::Free, _) => {
                let kind = if joint.motion == Motion::Ball { "ball" } else { "free" };
                let text = format!("{kind} joint `{}` is held where the file places it", joint.name);
                notes.push(Note::new(findings::URDF_HELD, text, ""));
                Role::Held(0.0)
            }
            (_, Some((None, [constant, _]))) => Role::Held(joint.reference + constant),
            (_, Some((Some(_), _))) => Role::Moves(Coordinate { own: false, ..Coordinate::own(0) }),
            (_, None) => {
                next += 1;
                Role::Moves(Coordinate::own(next - 1))
            }
        });
    }
    for index in 0..robot.joints.len() {
        if matches!(roles[index], Role::Moves(Coordinate { own: false, .. })) {
            roles[index] = followed(path, robot, index, &roles)?;
        }
    }
    Ok(roles)
}

/// The joint that this one follows in proportion, and the coefficients; `None` where it moves by itself.
fn tie(robot: &Robot, joint: usize) -> Option<(Option<usize>, [f64; 2])> {
    let coupling = robot.couplings.iter().find(|coupling| coupling.joint == joint)?;
    let [constant, factor, rest @ ..] = coupling.coefficients;
    rest.iter().all(|c| *c == 0.0).then_some((coupling.other, [constant, factor]))
}

/// What moves a joint that follows others, through all of them.
fn followed(path: &Path, robot: &Robot, start: usize, roles: &[Role]) -> Result<Role> {
    let (mut at, mut multiplier, mut offset) = (start, 1.0, 0.0);
    for _ in 0..=robot.joints.len() {
        match (roles[at], tie(robot, at)) {
            (Role::Held(position), _) => return Ok(Role::Held(multiplier * position + offset)),
            (_, Some((Some(other), [constant, factor]))) => {
                let (own, others) = (robot.joints[at].reference, robot.joints[other].reference);
                offset += multiplier * (own + constant - factor * others);
                multiplier *= factor;
                at = other;
            }
            (Role::Moves(coordinate), _) => {
                return Ok(Role::Moves(Coordinate { index: coordinate.index, multiplier, offset, own: false }));
            }
        }
    }
    let message =
        format!("joint `{}`: expected to follow a joint that moves by itself, found none", robot.joints[start].name);
    Err(Error::file(path, message, "let one joint of the circle be free"))
}

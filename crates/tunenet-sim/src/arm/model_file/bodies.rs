//! From links, joints and couplings of a file to moving bodies: one for each joint, fixed links merged into what carries them.

use std::path::Path;

use nalgebra::{Rotation3, Translation3, Vector3};
use tunenet_core::observation::Note;
use tunenet_core::text::visible;
use tunenet_formats::{Error, Result};
use tunenet_models::mjcf::MAKERS;
use tunenet_models::{Motion, Robot, Weight};

use super::left_out::{self, Driven};
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
pub(super) fn model(path: &Path, robot: &Robot, driven: Driven) -> Result<Model> {
    let mut notes = left_out::notes(robot, driven);
    let roles = roles(path, robot, &mut notes)?;
    let mut model = Model { name: robot.name.clone(), bodies: Vec::new(), frames: Vec::new(), notes };
    // Where each link went: the body that carries it, and its place there.
    let mut homes: Vec<(Option<usize>, Pose)> = Vec::new();
    for link in &robot.links {
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
                    let mut joint = described(robot, j);
                    if driven == Driven::Commands && coordinate.own {
                        let whole = robot.with_followers(j);
                        (joint.damping, joint.friction, joint.armature) =
                            (whole.damping, whole.friction, whole.armature);
                    }
                    let inertia = Inertia::zero();
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
            let carrier = &mut model.bodies[body];
            carrier.inertia = carrier.inertia.with(&link.inertia.seen_from(&place));
        }
        homes.push((carrier, place));
        model.frames.push(Frame { name: link.name.clone(), body: carrier, placement: place });
    }
    if model.bodies.is_empty() {
        let expected = "expected a hinge or a slide, found none";
        let made = robot.unused.iter().find(|left| MAKERS.contains(&left.element.as_str()));
        return Err(match made {
            Some(left) => {
                let message = format!("{expected} without <{}>, which is not read", left.element);
                Error::file(path, message, "write the bodies themselves: MuJoCo saves a model with them")
            }
            None => Error::file(path, expected, "is this the model of an arm?"),
        });
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
        lacking: false,
    };
    let (damping, friction, armature) = (joint.damping, joint.friction, joint.armature);
    let (stiffness, spring_rest) = (joint.stiffness, joint.spring_reference);
    let name = joint.name.clone();
    Joint { name, kind, axis: joint.axis, limits, damping, friction, armature, stiffness, spring_rest }
}

fn without_mass(path: &Path, link: &str, what: &str) -> Error {
    let message = format!(
        "body `{}`, which moves: expected an <inertial>, found none: its mass would come from {what}",
        visible(link)
    );
    let hint = "add <inertial> with mass and inertia; MuJoCo writes it where <compiler saveinertial=\"true\"/> stands and it saves \
                the model";
    Error::file(path, message, hint)
}

/// How a joint follows another one in proportion.
#[derive(Debug, Clone, Copy)]
struct Tie {
    /// The joint that it follows; `None` where it is held.
    other: Option<usize>,
    constant: f64,
    factor: f64,
}

/// The tie of each joint. Curves are no ties; of several, the first counts, and the others are noted.
fn ties(robot: &Robot, notes: &mut Vec<Note>) -> Vec<Option<Tie>> {
    let mut ties: Vec<Option<Tie>> = vec![None; robot.joints.len()];
    for coupling in &robot.couplings {
        let [constant, factor, curve @ ..] = coupling.coefficients;
        if curve.iter().any(|c| *c != 0.0) {
            continue;
        }
        let tie = &mut ties[coupling.joint];
        if tie.is_some() {
            let name = visible(&robot.joints[coupling.joint].name);
            let text = format!(
                "joint `{name}` follows several others; the first equality counts, and the others are left out"
            );
            notes.push(Note::new(findings::MODEL_LEFT_OUT, text, "write one equality for each joint"));
        } else {
            *tie = Some(Tie { other: coupling.other, constant, factor });
        }
    }
    ties
}

/// What becomes of each joint.
fn roles(path: &Path, robot: &Robot, notes: &mut Vec<Note>) -> Result<Vec<Role>> {
    let ties = ties(robot, notes);
    let mut roles = Vec::new();
    let mut next = 0;
    for (joint, tie) in robot.joints.iter().zip(&ties) {
        roles.push(match (joint.motion, tie) {
            (Motion::Ball | Motion::Free, _) => {
                let kind = if joint.motion == Motion::Ball { "ball" } else { "free" };
                let text = format!("{kind} joint `{}` is held where the file places it", visible(&joint.name));
                notes.push(Note::new(findings::URDF_HELD, text, ""));
                Role::Held(0.0)
            }
            (_, Some(Tie { other: None, constant, .. })) => Role::Held(joint.reference + constant),
            (_, Some(_)) => Role::Moves(Coordinate { own: false, ..Coordinate::own(0) }),
            (_, None) => {
                next += 1;
                Role::Moves(Coordinate::own(next - 1))
            }
        });
    }
    for index in 0..robot.joints.len() {
        if matches!(roles[index], Role::Moves(Coordinate { own: false, .. })) {
            roles[index] = followed(path, robot, index, (&ties, &roles))?;
        }
    }
    Ok(roles)
}

/// What moves a joint that follows others, through all of them.
fn followed(path: &Path, robot: &Robot, start: usize, (ties, roles): (&[Option<Tie>], &[Role])) -> Result<Role> {
    let (mut at, mut multiplier, mut offset) = (start, 1.0, 0.0);
    let name = || visible(&robot.joints[start].name);
    let finite = |role: Role, numbers: [f64; 2]| {
        if numbers.iter().all(|number| number.is_finite()) {
            return Ok(role);
        }
        let message = format!("joint `{}`: expected to follow by finite numbers, found others", name());
        Err(Error::file(path, message, "correct `polycoef` of the equalities between joints"))
    };
    for _ in 0..=robot.joints.len() {
        match (roles[at], ties[at]) {
            (Role::Held(position), _) => {
                let position = multiplier * position + offset;
                return finite(Role::Held(position), [position, 0.0]);
            }
            (Role::Moves(coordinate), None) => {
                let moves = Coordinate { index: coordinate.index, multiplier, offset, own: false };
                return finite(Role::Moves(moves), [multiplier, offset]);
            }
            (Role::Moves(_), Some(Tie { other: Some(other), constant, factor })) => {
                let (own, others) = (robot.joints[at].reference, robot.joints[other].reference);
                offset += multiplier * (own + constant - factor * others);
                multiplier *= factor;
                at = other;
            }
            (Role::Moves(_), Some(Tie { other: None, .. })) => break,
        }
    }
    let message = format!("joint `{}`: expected to follow a joint that moves by itself, found none", name());
    Err(Error::file(path, message, "let one joint of the circle be free"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An MJCF asks for no range; a URDF does, of all joints that are not continuous.
    #[test]
    fn a_slide_without_range_lacks_nothing_in_an_mjcf() {
        let text =
            "<mujoco><worldbody><body><joint name='rail' type='slide'/><geom size='0.1'/></body></worldbody></mujoco>";
        let cart = super::super::parse_mjcf(Path::new("cart.xml"), text).unwrap();
        assert!(cart.notes.iter().all(|note| note.kind != findings::URDF_LIMITS), "{:?}", cart.notes);
        assert_eq!(cart.joints()[0].without_limits(), None);
        let urdf = "<robot name='c'><link name='base'/><link name='cart'/><joint name='rail' type='prismatic'>\
            <parent link='base'/><child link='cart'/><limit lower='0' upper='0' effort='1' velocity='1'/></joint></robot>";
        let cart = crate::arm::urdf::parse(Path::new("cart.urdf"), urdf).unwrap();
        assert!(cart.joints()[0].without_limits().is_some());
    }
}

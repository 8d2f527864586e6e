//! From a URDF to a [`Model`].
//!
//! Read are links with their inertia (its rotation included), joints with axis, limits, `<dynamics>` and `<mimic>`; links
//! that are fixed to one another become one body. Shapes are not needed and never opened, so meshes may be missing. What
//! is left out stands in [`Model::notes`].

mod place;
mod text;
mod tree;

use std::path::Path;

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use tunenet_core::observation::Note;
use tunenet_formats::read_text;
use tunenet_formats::{Error, Result};
use tunenet_models::urdf::Commands;

use super::inertia::impossible;
use super::{Coordinate, Inertia, Joint, JointKind, Limits, Model, Pose};
use crate::findings;

/// Most links of a file: a humanoid with hands has about a hundred.
const MOST_LINKS: usize = 1000;

/// Reads the arm that the URDF at `path` describes.
///
/// # Errors
/// [`Error::Io`] where it cannot be read; [`Error::File`] where it is no URDF, or no arm can be what it describes: its
/// links make no tree with one root, a name stands twice or nowhere, a link has an inertia that no body can have, a
/// joint's axis, limits or kind cannot be used. Links without inertia are noted; see [`Model::weighed`].
pub fn read(path: &Path) -> Result<Model> {
    parse(path, &read_text(path)?)
}

/// The arm that `text`, the content of `path`, describes.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, text: &str) -> Result<Model> {
    parse_driven(path, text, None)
}

/// The same, `commands` being what the file says of the commands to its joints, where they and not torques drive the joints.
pub(super) fn parse_driven(path: &Path, text: &str, commands: Option<&Commands>) -> Result<Model> {
    text::check(path, text)?;
    let robot = urdf_rs::read_from_string(text).map_err(|e| {
        place::broken(path, text).unwrap_or_else(|| {
            Error::file(path, format!("expected a URDF, found what cannot be read as one: {e}"), "mend the XML")
        })
    })?;
    if robot.links.len() > MOST_LINKS {
        let message = format!("expected at most {MOST_LINKS} links, found {}", robot.links.len());
        return Err(Error::file(path, message, "cut the file down to the arm"));
    }
    let file = File { path, text, robot };
    let mut notes = file.ignored(text, commands);
    let coordinates = file.coordinates()?;
    let (bodies, frames) = tree::build(&file, &coordinates, &mut notes)?;
    let weightless: Vec<_> =
        bodies.iter().filter(|b| b.inertia.mass_kg == 0.0).map(|b| format!("`{}`", b.name)).collect();
    if !weightless.is_empty() {
        let text = format!("no <inertial> of {}, which move: without weight here", weightless.join(", "));
        notes.push(Note::new(findings::URDF_WEIGHTLESS, text, "add mass, centre of mass and inertia"));
    }
    if bodies.is_empty() {
        return Err(file.error("expected a joint that moves, found none", "is this the URDF of an arm?"));
    }
    Ok(Model { name: file.robot.name.clone(), bodies, frames, notes })
}

/// A parsed file and where it came from.
struct File<'a> {
    path: &'a Path,
    text: &'a str,
    robot: urdf_rs::Robot,
}

impl File<'_> {
    fn error(&self, message: impl Into<String>, hint: &str) -> Error {
        Error::file(self.path, message, hint)
    }

    /// An error at the line where the link or joint of this name begins.
    fn error_at(&self, element: &str, name: &str, message: impl Into<String>, hint: &str) -> Error {
        place::at_element(self.path, self.text, element, name, message.into(), hint)
    }

    /// The inertia of a link, in its own frame; nothing where it has none.
    fn inertia(&self, link: &urdf_rs::Link) -> Result<Inertia> {
        let given = &link.inertial;
        let i = &given.inertia;
        let own = Inertia {
            mass_kg: given.mass.value,
            com_m: Vector3::zeros(),
            about_com_kg_m2: Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz),
        };
        if let Some((expected, found)) = impossible(&own) {
            let message = format!("link `{}`: expected {expected}, found {found}", link.name);
            return Err(self.error_at("link", &link.name, message, "no body has such an inertia: correct <inertial>"));
        }
        Ok(own.seen_from(&self.pose(&format!("the <inertial> of link `{}`", link.name), &given.origin)?))
    }

    fn pose(&self, of: &str, origin: &urdf_rs::Pose) -> Result<Pose> {
        if let Some(number) = origin.xyz.iter().chain(origin.rpy.iter()).find(|n| !n.is_finite()) {
            return Err(self.error(format!("{of}: expected finite numbers in <origin>, found {number}"), ""));
        }
        let ([x, y, z], [roll, pitch, yaw]) = (*origin.xyz, *origin.rpy);
        Ok(Pose::from_parts(Vector3::new(x, y, z).into(), Rotation3::from_euler_angles(roll, pitch, yaw)))
    }

    /// The moving joint that `joint` describes.
    fn joint(&self, joint: &urdf_rs::Joint, kind: JointKind, notes: &mut Vec<Note>) -> Result<Joint> {
        let named = |text: String| format!("joint `{}`: {text}", joint.name);
        let axis = Vector3::from(*joint.axis.xyz);
        let Some(axis) = Unit::try_new(axis, 1e-9).filter(|a| a.iter().all(|n| n.is_finite())) else {
            let found = format!("expected an axis with a direction, found `{} {} {}`", axis.x, axis.y, axis.z);
            return Err(self.error_at("joint", &joint.name, named(found), "write <axis xyz=\"0 0 1\"/>, say"));
        };
        let dynamics = joint.dynamics.clone().unwrap_or_default();
        for (name, value) in [("damping", dynamics.damping), ("friction", dynamics.friction)] {
            if !(value.is_finite() && value >= 0.0) {
                let message = named(format!("expected {name} of 0 or more, found {value}"));
                return Err(self.error_at("joint", &joint.name, message, "correct <dynamics>"));
            }
        }
        let limits = self.limits(joint, kind)?;
        let (damping, friction) = (dynamics.damping, dynamics.friction);
        let (armature, stiffness, spring_rest) = (0.0, 0.0, 0.0);
        let name = joint.name.clone();
        let joint = Joint { name, kind, axis, limits, damping, friction, armature, stiffness, spring_rest };
        notes.extend(joint.without_limits());
        Ok(joint)
    }

    fn limits(&self, joint: &urdf_rs::Joint, kind: JointKind) -> Result<Limits> {
        let limit = &joint.limit;
        let given = [limit.lower, limit.upper, limit.velocity, limit.effort];
        if given.iter().any(|n| n.is_nan()) || limit.lower > limit.upper || limit.velocity < 0.0 || limit.effort < 0.0 {
            let found = format!("lower {} upper {} velocity {} effort {}", given[0], given[1], given[2], given[3]);
            let message = format!("joint `{}`: expected limits with lower below upper, found {found}", joint.name);
            return Err(self.error_at("joint", &joint.name, message, "correct <limit>"));
        }
        // 0 stands for "not said" in the files that exporters write: such a joint could never move.
        let or_none = |value: f64| if value > 0.0 { value } else { f64::INFINITY };
        let mut limits = Limits { velocity: or_none(limit.velocity), effort: or_none(limit.effort), ..Limits::NONE };
        if kind == JointKind::Continuous {
            return Ok(limits);
        }
        if limit.lower < limit.upper {
            (limits.lower, limits.upper) = (limit.lower, limit.upper);
        } else {
            limits.lacking = true;
        }
        Ok(limits)
    }

    /// What moves each joint of the file; `None` for fixed ones.
    fn coordinates(&self) -> Result<Vec<Option<(JointKind, Coordinate)>>> {
        let mut next = 0;
        let mut found = Vec::new();
        for joint in &self.robot.joints {
            use urdf_rs::JointType as Type;
            let kind = match joint.joint_type {
                Type::Fixed => None,
                Type::Revolute => Some(JointKind::Revolute),
                Type::Continuous => Some(JointKind::Continuous),
                Type::Prismatic => Some(JointKind::Prismatic),
                Type::Floating | Type::Planar | Type::Spherical => {
                    let message = format!(
                        "joint `{}`: expected fixed, revolute, continuous or prismatic, found {:?}",
                        joint.name, joint.joint_type
                    );
                    let hint = "describe it by joints with one axis each";
                    return Err(self.error_at("joint", &joint.name, message.to_lowercase(), hint));
                }
            };
            found.push(kind.map(|kind| (kind, Coordinate::own(next))));
            next += usize::from(kind.is_some() && joint.mimic.is_none());
        }
        let own = found.clone();
        for (i, joint) in self.robot.joints.iter().enumerate() {
            if let (Some((_, coordinate)), Some(_)) = (&mut found[i], &joint.mimic) {
                *coordinate = self.mimicked(i, &own)?;
            }
        }
        Ok(found)
    }

    /// The coordinate behind joint `i`, through the joints it mimics.
    fn mimicked(&self, i: usize, own: &[Option<(JointKind, Coordinate)>]) -> Result<Coordinate> {
        let name = &self.robot.joints[i].name;
        let (mut at, mut multiplier, mut offset) = (i, 1.0, 0.0);
        for _ in 0..self.robot.joints.len() {
            let Some(mimic) = &self.robot.joints[at].mimic else {
                let Some((_, driver)) = own[at] else { break };
                return Ok(Coordinate { index: driver.index, multiplier, offset, own: false });
            };
            offset += multiplier * mimic.offset.unwrap_or(0.0);
            multiplier *= mimic.multiplier.unwrap_or(1.0);
            if !(multiplier.is_finite() && offset.is_finite()) {
                return Err(self.error(format!("joint `{name}`: expected finite numbers in <mimic>"), ""));
            }
            let Some(next) = self.robot.joints.iter().position(|j| j.name == mimic.joint) else {
                let message =
                    format!("joint `{name}`: expected a joint to mimic, found `{}`, which is none", mimic.joint);
                return Err(self.error(message, "correct <mimic joint=…>"));
            };
            at = next;
        }
        let message = format!("joint `{name}`: expected to mimic a joint that moves by itself, found none behind it");
        Err(self.error(message, "let <mimic> name the joint that is driven"))
    }

    /// What the file holds and the model leaves out.
    fn ignored(&self, text: &str, commands: Option<&Commands>) -> Vec<Note> {
        let robot = &self.robot;
        let shapes: usize = robot.links.iter().map(|l| l.visual.len() + l.collision.len()).sum();
        let safety = robot.joints.iter().filter(|j| j.safety_controller.is_some()).count();
        let calibration = robot.joints.iter().filter(|j| j.calibration.is_some()).count();
        let tags = |tag: &str| text.matches(tag).count();
        // Of a robot from commands, the kind of each command is read.
        let [transmissions, sections] = match commands {
            Some(commands) => [
                (commands.reductions, "reductions of transmissions (armature and friction count behind the gear)"),
                (
                    tags("<ros2_control"),
                    "ros2_control sections, apart from their command interfaces (gains stand in YAML files)",
                ),
            ],
            None => [
                (tags("<transmission"), "transmissions"),
                (tags("<ros2_control"), "ros2_control sections (their gains stand in YAML files)"),
            ],
        };
        let each = [
            (shapes, "shapes (their meshes are not opened)"),
            transmissions,
            sections,
            (tags("<mujoco"), "settings for MuJoCo"),
            (tags("<gazebo"), "settings of Gazebo"),
            (safety, "safety controllers"),
            (calibration, "calibrations"),
        ];
        let all: Vec<String> = each.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
        if all.is_empty() {
            return Vec::new();
        }
        vec![Note::new(findings::URDF_IGNORED, format!("the URDF's {} are left out", all.join(", ")), "")]
    }
}

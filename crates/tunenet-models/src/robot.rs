//! A robot, from whichever file it was read: links, joints, actuators, and what of the file is left out.

use nalgebra::{IsometryMatrix3, Unit, Vector3};

use crate::{Inertia, Unused};

/// A place and an orientation: from the coordinates of one frame to those of another.
pub type Pose = IsometryMatrix3<f64>;

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// It turns about its axis.
    Revolute,
    /// It slides along its axis.
    Prismatic,
    /// It turns about every axis.
    Ball,
    /// It moves freely in all six directions.
    Free,
}

/// A joint: what lets a link move in the frame of its parent. SI units; angles in rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Its name, unique among the joints; that of its place in the file where the file gives none.
    pub name: String,
    /// How it moves.
    pub motion: Motion,
    /// The point that its axis goes through, in the frame of its link, m.
    pub anchor_m: Vector3<f64>,
    /// Along or about what, in the frame of its link.
    pub axis: Unit<Vector3<f64>>,
    /// Its position where the links lie as their placements say, rad or m.
    pub reference: f64,
    /// Least and greatest position, rad or m; `None` where it has no limits.
    pub range: Option<[f64; 2]>,
    /// Greatest speed, rad/s or m/s; `None` where the file does not say.
    pub velocity_limit: Option<f64>,
    /// Least and greatest torque or force of all its actuators together, N·m or N; `None` where the file does not say.
    pub effort_range: Option<[f64; 2]>,
    /// Inertia of the rotor as the joint feels it, kg·m² or kg.
    pub armature: f64,
    /// Viscous friction, N·m·s/rad or N·s/m.
    pub damping: f64,
    /// Coulomb friction, N·m or N.
    pub friction: f64,
    /// Spring, N·m/rad or N/m.
    pub stiffness: f64,
    /// Where the spring is at rest, rad or m.
    pub spring_reference: f64,
}

/// Where the mass of a link comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Weight {
    /// The file states it.
    Stated,
    /// It was computed from the shapes of the link and their densities or masses.
    Shapes,
    /// It would follow from a shape that only another file describes; the inertia is 0 here. The sentence says which.
    Mesh(String),
    /// The file gives none; the inertia is 0.
    Missing,
}

/// A rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Its name, unique among the links.
    pub name: String,
    /// The link that carries it, always one before it in the list; `None` for the world.
    pub parent: Option<usize>,
    /// Where its frame lies in the frame of its parent while every joint is at its reference.
    pub placement: Pose,
    /// Its joints as places in [`Robot::joints`], in the order in which they act; none where it is fixed to its parent.
    pub joints: Vec<usize>,
    /// Its inertia, in its own frame.
    pub inertia: Inertia,
    /// Where that comes from.
    pub weight: Weight,
}

/// A joint that follows another one: `q = Σ c_i · (q_other − r_other)^i + r`, with the references `r`.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// The joint that follows, as a place in [`Robot::joints`].
    pub joint: usize,
    /// The joint that it follows; `None` where it is held.
    pub other: Option<usize>,
    /// The coefficients `c_0` to `c_4`.
    pub coefficients: [f64; 5],
}

/// A length that is a sum of joint positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Tendon {
    /// Its name.
    pub name: String,
    /// Joints, as places in [`Robot::joints`], and their factors.
    pub terms: Vec<(usize, f64)>,
}

/// Whether the shapes of a model touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contacts {
    /// None can, or the format does not say.
    None,
    /// Those of several links or of the world may, since nothing says that they do not.
    ByDefault,
    /// The file says which do.
    Stated,
}

/// What an actuator acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A joint, as a place in [`Robot::joints`].
    Joint(usize),
    /// A tendon, as a place in [`Robot::tendons`].
    Tendon(usize),
    /// Something that this description does not hold: a site, a body.
    Other,
}

/// What lies between a command and what the actuator does with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Filter {
    /// Nothing.
    None,
    /// A first-order low-pass with this time constant, s.
    LowPass {
        /// s, above 0.
        time_constant_s: f64,
    },
    /// The command is a speed; it is integrated.
    Integrator,
}

/// How an actuator computes its force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// `gain · command + bias_0 + bias_1 · length + bias_2 · speed`; length and speed are those of the target times the gear.
    Affine {
        /// N·m (or N) per unit of the command.
        gain: f64,
        /// N·m, N·m/rad and N·m·s/rad, or the same of a sliding joint.
        bias: [f64; 3],
    },
    /// Another one, which this description does not hold.
    Other,
}

/// What drives a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuator {
    /// Its name.
    pub name: String,
    /// What it acts on.
    pub target: Target,
    /// Transmission ratio: length per position of the target.
    pub gear: f64,
    /// Its force.
    pub law: Law,
    /// What the command goes through before.
    pub filter: Filter,
    /// Least and greatest command; `None` where it is not limited.
    pub command_range: Option<[f64; 2]>,
    /// Least and greatest force, N·m or N; `None` where it is not limited.
    pub force_range: Option<[f64; 2]>,
    /// How much later the command arrives, s.
    pub delay_s: f64,
}

impl Actuator {
    /// The gains `kp` and `kv` of a servo that goes to a position: `force = kp · (command − length) − kv · speed`.
    #[must_use]
    pub fn position_gains(&self) -> Option<[f64; 2]> {
        match self.law {
            Law::Affine { gain, bias: [constant, proportional, speed] } => {
                (gain > 0.0 && proportional == -gain && constant == 0.0).then_some([gain, -speed])
            }
            Law::Other => None,
        }
    }
}

/// What a file describes.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// Its name in the file; empty where it has none.
    pub name: String,
    /// The links, parents first.
    pub links: Vec<Link>,
    /// The joints, in the order of the file.
    pub joints: Vec<Joint>,
    /// The joints that follow others.
    pub couplings: Vec<Coupling>,
    /// The tendons that are sums of joints.
    pub tendons: Vec<Tendon>,
    /// The actuators, in the order of the file.
    pub actuators: Vec<Actuator>,
    /// Gravity in world axes, m/s²; `None` where the format has none.
    pub gravity_m_s2: Option<[f64; 3]>,
    /// The step of its simulation, s; `None` where the format has none.
    pub step_s: Option<f64>,
    /// Whether shapes touch in its simulation.
    pub contacts: Contacts,
    /// What the file holds and this description leaves out.
    pub unused: Vec<Unused>,
}

impl Robot {
    /// The place of the joint `name` in [`joints`](Self::joints).
    #[must_use]
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Whether a joint moves the link: one of its own, or one of a link that carries it.
    #[must_use]
    pub fn moves(&self, link: usize) -> bool {
        let mut at = Some(link);
        while let Some(i) = at {
            if !self.links[i].joints.is_empty() {
                return true;
            }
            at = self.links[i].parent;
        }
        false
    }

    /// The joints that follow a joint in proportion, themselves or through others, and how far each moves with it. Of several couplings of a
    /// joint the first counts.
    #[must_use]
    pub fn followers(&self, joint: usize) -> Vec<(usize, f64)> {
        let mut found: Vec<(usize, f64)> = vec![(joint, 1.0)];
        // Once for each coupling, in whichever order they stand.
        for _ in 0..self.couplings.len() {
            for (i, coupling) in self.couplings.iter().enumerate() {
                let first = self.couplings[..i].iter().all(|other| other.joint != coupling.joint);
                let straight = coupling.coefficients[2..].iter().all(|c| *c == 0.0);
                let carrier = found.iter().find(|(known, _)| coupling.other == Some(*known));
                let Some(&(_, by)) = carrier.filter(|_| first && straight) else { continue };
                if found.iter().all(|(known, _)| *known != coupling.joint) {
                    found.push((coupling.joint, by * coupling.coefficients[1]));
                }
            }
        }
        found.split_off(1)
    }

    /// The joint with the damping, the friction and the armature of those that follow it, as it feels them: of a joint that moves m times as
    /// far, m² of its damping and its armature and m of its friction.
    #[must_use]
    pub fn with_followers(&self, joint: usize) -> Joint {
        let mut whole = self.joints[joint].clone();
        for (follower, by) in self.followers(joint) {
            let other = &self.joints[follower];
            whole.damping += by * by * other.damping;
            whole.armature += by * by * other.armature;
            whole.friction += by.abs() * other.friction;
        }
        whole
    }

    /// The inertia of a link with those that are fixed to it, in its frame.
    #[must_use]
    pub fn fixed_together(&self, link: usize) -> Inertia {
        let mut places: Vec<Option<Pose>> = vec![None; self.links.len()];
        places[link] = Some(Pose::identity());
        let mut whole = self.links[link].inertia;
        // A link stands behind the one that carries it.
        for (i, one) in self.links.iter().enumerate().skip(link + 1) {
            let carrier = one.parent.and_then(|parent| places[parent]).filter(|_| one.joints.is_empty());
            if let Some(carrier) = carrier {
                let place = carrier * one.placement;
                whole = whole.with(&one.inertia.seen_from(&place));
                places[i] = Some(place);
            }
        }
        whole
    }

    /// Where every link lies in the world while every joint is at its reference.
    #[must_use]
    pub fn reference_poses(&self) -> Vec<Pose> {
        let mut poses: Vec<Pose> = Vec::with_capacity(self.links.len());
        for link in &self.links {
            let base = link.parent.map_or_else(Pose::identity, |parent| poses[parent]);
            poses.push(base * link.placement);
        }
        poses
    }
}

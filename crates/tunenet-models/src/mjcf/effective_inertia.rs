//! What a single actuator has to move: `1 / (J·M⁻¹·Jᵀ)` with the mass matrix `M` of the tree at its reference.
//!
//! Source: Khatib, A unified approach for motion and force control of robot manipulators, 1987; MuJoCo 4.0.0 computes the
//! damping of a position actuator with `dampratio` from it (before 4, from the diagonal of `M`).

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector, Point3, Vector3};

use crate::Pose;
use crate::robot::{Motion, Robot};

/// Most degrees of freedom of one tree: a humanoid with hands has about a hundred.
const MOST_DEGREES: usize = 200;

/// One direction in which a link moves, in world axes.
struct Degree {
    joint: usize,
    turn: Vector3<f64>,
    slide: Vector3<f64>,
    /// A point that does not move.
    point: Vector3<f64>,
    link: usize,
    armature: f64,
}

/// Effective inertias, tree by tree as they are asked for.
pub(super) struct EffectiveInertias<'a> {
    robot: &'a Robot,
    poses: Vec<Pose>,
    roots: Vec<usize>,
    /// The link of each joint.
    link_of: Vec<Option<usize>>,
    /// By the root of a tree: joints and their effective inertias.
    known: HashMap<usize, HashMap<usize, f64>>,
}

impl<'a> EffectiveInertias<'a> {
    pub fn new(robot: &'a Robot) -> Self {
        let mut link_of = vec![None; robot.joints.len()];
        for (i, link) in robot.links.iter().enumerate() {
            link.joints.iter().for_each(|joint| link_of[*joint] = Some(i));
        }
        let (poses, roots) = (robot.reference_poses(), roots(robot));
        Self { robot, poses, roots, link_of, known: HashMap::new() }
    }

    /// Effective inertia at a hinge or slide, kg·m² or kg; `None` for other joints, and where nothing has mass.
    pub fn of(&mut self, joint: usize) -> Option<f64> {
        if !matches!(self.robot.joints[joint].motion, Motion::Revolute | Motion::Prismatic) {
            return None;
        }
        let root = self.roots[self.link_of[joint]?];
        if !self.known.contains_key(&root) {
            let tree = self.tree(root).unwrap_or_default();
            self.known.insert(root, tree);
        }
        self.known[&root].get(&joint).copied()
    }

    fn tree(&self, root: usize) -> Option<HashMap<usize, f64>> {
        let links: Vec<usize> = (root..self.robot.links.len()).filter(|i| self.roots[*i] == root).collect();
        let mut degrees = Vec::new();
        for &link in &links {
            for &joint in &self.robot.links[link].joints {
                add(self.robot, (link, joint), &self.poses[link], &mut degrees);
            }
            if degrees.len() > MOST_DEGREES {
                return None;
            }
        }
        let inverse = mass_matrix(self.robot, &links, &degrees, &self.poses).cholesky()?.inverse();
        let inertias = degrees.iter().enumerate().map(|(i, degree)| (degree.joint, 1.0 / inverse[(i, i)]));
        Some(inertias.filter(|(_, inertia)| inertia.is_finite() && *inertia > 0.0).collect())
    }
}

/// The link that hangs on the world, for each link.
fn roots(robot: &Robot) -> Vec<usize> {
    let mut roots: Vec<usize> = Vec::with_capacity(robot.links.len());
    for (i, link) in robot.links.iter().enumerate() {
        roots.push(link.parent.map_or(i, |parent| roots[parent]));
    }
    roots
}

fn add(robot: &Robot, (link, joint): (usize, usize), pose: &Pose, degrees: &mut Vec<Degree>) {
    let index = joint;
    let joint = &robot.joints[joint];
    let point = (pose * Point3::from(joint.anchor_m)).coords;
    let zero = Vector3::zeros();
    let degree = |turn, slide| Degree { joint: index, turn, slide, point, link, armature: joint.armature };
    let axes = || [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| pose.rotation * axis);
    let axis = pose.rotation * joint.axis.into_inner();
    match joint.motion {
        Motion::Revolute => degrees.push(degree(axis, zero)),
        Motion::Prismatic => degrees.push(degree(zero, axis)),
        Motion::Ball => degrees.extend(axes().map(|axis| degree(axis, zero))),
        Motion::Free => {
            degrees.extend(axes().map(|axis| degree(zero, axis)));
            degrees.extend(axes().map(|axis| degree(axis, zero)));
        }
    }
}

fn mass_matrix(robot: &Robot, links: &[usize], degrees: &[Degree], poses: &[Pose]) -> DMatrix<f64> {
    let n = degrees.len();
    let mut matrix = DMatrix::from_diagonal(&DVector::from_iterator(n, degrees.iter().map(|degree| degree.armature)));
    for &i in links {
        let link = &robot.links[i];
        let carriers: Vec<usize> = (0..n).filter(|d| carries(robot, degrees[*d].link, i)).collect();
        let inertia = link.inertia.seen_from(&poses[i]);
        let speeds: Vec<_> = carriers
            .iter()
            .map(|&d| {
                let degree = &degrees[d];
                (degree.turn, degree.slide + degree.turn.cross(&(inertia.com_m - degree.point)))
            })
            .collect();
        for (a, (turn, speed)) in carriers.iter().zip(&speeds) {
            let (momentum, spin) = (speed * inertia.mass_kg, inertia.about_com_kg_m2 * turn);
            for (b, (other_turn, other_speed)) in carriers.iter().zip(&speeds) {
                matrix[(*a, *b)] += momentum.dot(other_speed) + spin.dot(other_turn);
            }
        }
    }
    matrix
}

/// Whether `link` hangs on `base`, or is it.
fn carries(robot: &Robot, base: usize, link: usize) -> bool {
    let mut at = Some(link);
    while let Some(i) = at.filter(|i| *i >= base) {
        if i == base {
            return true;
        }
        at = robot.links[i].parent;
    }
    false
}

//! An arm as a tree of rigid bodies on a fixed base, one joint each.

use nalgebra::{Rotation3, Translation3, Unit, Vector3};
use tunenet_core::observation::Note;
use tunenet_core::{Error, Origin, Result};

use super::{Inertia, Pose};
use crate::findings;

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// It turns within limits.
    Revolute,
    /// It turns without end.
    Continuous,
    /// It slides.
    Prismatic,
}

/// How far, how fast and how strongly a joint may move; infinite where the file does not say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Least position, rad or m.
    pub lower: f64,
    /// Greatest position, rad or m.
    pub upper: f64,
    /// Greatest speed, rad/s or m/s.
    pub velocity: f64,
    /// Greatest torque or force, N·m or N.
    pub effort: f64,
    /// Whether the format of the file asks for a range that it does not state. MJCF asks for none.
    pub lacking: bool,
}

impl Limits {
    /// None at all.
    pub const NONE: Self = Self {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        velocity: f64::INFINITY,
        effort: f64::INFINITY,
        lacking: false,
    };
}

/// What joint a body hangs on.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Its name in the model file.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Along or about what, in the joint's frame.
    pub axis: Unit<Vector3<f64>>,
    /// Its limits.
    pub limits: Limits,
    /// Viscous friction, N·m·s/rad or N·s/m.
    pub damping: f64,
    /// Coulomb friction, N·m or N.
    pub friction: f64,
    /// Inertia of the rotor as the joint feels it, kg·m² or kg; 0 of a URDF, which has none. Arms that torques drive take it from
    /// their simulation file instead.
    pub armature: f64,
    /// Spring of the joint, N·m/rad or N/m; 0 of a URDF, which has none. Arms that torques drive take it from their simulation file
    /// instead.
    pub stiffness: f64,
    /// Position at which the spring is at rest, rad or m.
    pub spring_rest: f64,
}

impl Joint {
    /// Least and greatest position where it has both, to 0.1 mrad or 0.1 mm, for people to read.
    #[must_use]
    pub fn shown_range(&self) -> Option<[f64; 2]> {
        let range = [self.limits.lower, self.limits.upper];
        range.iter().all(|end| end.is_finite()).then(|| range.map(|end| (end * 1e4).round() / 1e4))
    }

    /// That the URDF gives no range to a joint that should have one, where it does not.
    #[must_use]
    pub fn without_limits(&self) -> Option<Note> {
        self.limits.lacking.then(|| {
            let text = format!("joint `{}` has no room between its limits; taken as one without limits", self.name);
            Note::new(findings::URDF_LIMITS, text, "write lower and upper into <limit>")
        })
    }
}

/// Which coordinate moves a joint: its position is `multiplier · q[index] + offset`. Joints that mimic another share its
/// coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordinate {
    /// Place in `q`.
    pub index: usize,
    /// 1 for a joint that mimics nothing.
    pub multiplier: f64,
    /// 0 for a joint that mimics nothing.
    pub offset: f64,
    /// Whether the joint mimics nothing.
    pub own: bool,
}

/// A moving body: a link of the URDF with everything that is fixed to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Name of its link.
    pub name: String,
    /// The body that carries it, always one before it in the list; `None` for the base.
    pub parent: Option<usize>,
    /// Where its joint's frame lies in the frame of the parent.
    pub placement: Pose,
    /// Its joint.
    pub joint: Joint,
    /// What moves the joint.
    pub coordinate: Coordinate,
    /// Its inertia, in its own frame.
    pub inertia: Inertia,
}

impl Body {
    /// The place of its frame in its parent's, its joint at `position`.
    #[must_use]
    pub fn moved(&self, position: f64) -> Pose {
        let own = match self.joint.kind {
            JointKind::Prismatic => {
                Pose::from_parts((self.joint.axis.into_inner() * position).into(), Rotation3::identity())
            }
            _ => Pose::from_parts(Translation3::identity(), Rotation3::from_axis_angle(&self.joint.axis, position)),
        };
        self.placement * own
    }
}

/// A place that has a name: every link's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Name of the link.
    pub name: String,
    /// The body that it is fixed to; `None` for the base.
    pub body: Option<usize>,
    /// Where it lies in that body's frame.
    pub placement: Pose,
}

/// An arm: its moving bodies, parents first, on a base that does not move.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Its name in the URDF.
    pub name: String,
    /// The bodies, parents before children, in the order of the file.
    pub bodies: Vec<Body>,
    /// The frames of all links.
    pub frames: Vec<Frame>,
    /// What the file says and this model leaves out.
    pub notes: Vec<Note>,
}

impl Model {
    /// How many coordinates move it: joints that mimic none.
    #[must_use]
    pub fn degrees(&self) -> usize {
        self.bodies.iter().map(|b| b.coordinate.index + 1).max().unwrap_or(0)
    }

    /// The joints that mimic none, in the order of the coordinates.
    #[must_use]
    pub fn joints(&self) -> Vec<&Joint> {
        let mut joints: Vec<(usize, &Joint)> =
            self.bodies.iter().filter(|b| b.coordinate.own).map(|b| (b.coordinate.index, &b.joint)).collect();
        joints.sort_by_key(|(index, _)| *index);
        joints.into_iter().map(|(_, joint)| joint).collect()
    }

    /// The frame of the link `name`.
    ///
    /// # Errors
    /// [`Error::Setting`] where there is none, with those that there are.
    pub fn frame(&self, name: &str) -> Result<&Frame> {
        self.frames.iter().find(|f| f.name == name).ok_or_else(|| {
            let known: Vec<_> = self.frames.iter().map(|f| format!("`{}`", f.name)).collect();
            let expected = format!("a link of the URDF ({})", known.join(", "));
            Error::Setting { origin: Origin::Caller, name: "arm.payload_link", expected, found: format!("`{name}`") }
        })
    }

    /// The chain from the base to the link `tip`, all other joints fixed at their position: at 0, or at the nearest
    /// position that its limits allow. What is held is noted.
    ///
    /// # Errors
    /// As [`frame`](Self::frame); [`Error::Setting`] where no joint moves the link.
    pub fn chain_to(&self, tip: &str) -> Result<Self> {
        let frame = self.frame(tip)?;
        let mut on_path = vec![false; self.bodies.len()];
        let mut at = frame.body;
        while let Some(body) = at {
            on_path[body] = true;
            at = self.bodies[body].parent;
        }
        // A coordinate of the path moves only the path; joints outside it that mimic it would move too.
        let kept: Vec<usize> =
            (0..self.bodies.len()).filter(|&i| on_path[i]).map(|i| self.bodies[i].coordinate.index).collect();
        if kept.is_empty() {
            return Err(Error::Setting {
                origin: Origin::Caller,
                name: "arm.payload_link",
                expected: "a link that a joint moves".into(),
                found: format!("`{tip}`, which is fixed to the base"),
            });
        }
        Ok(self.keep(&kept))
    }

    /// The same with every coordinate but those of `kept` held, and what it moves fixed to its parent.
    pub(crate) fn keep(&self, kept: &[usize]) -> Self {
        let mut order: Vec<usize> = kept.to_vec();
        order.sort_unstable();
        order.dedup();
        let held = self.joints().into_iter().enumerate().map(|(i, j)| (i, 0f64.clamp(j.limits.lower, j.limits.upper)));
        let held: Vec<f64> = held.map(|(_, position)| position).collect();
        let mut new =
            Self { name: self.name.clone(), bodies: Vec::new(), frames: Vec::new(), notes: self.notes.clone() };
        // Where each old body went: the new body that carries it, and its place in that body's frame.
        let mut homes: Vec<(Option<usize>, Pose)> = Vec::new();
        for body in &self.bodies {
            let (parent, base) = body.parent.map_or((None, Pose::identity()), |p| homes[p]);
            if let Ok(index) = order.binary_search(&body.coordinate.index) {
                let coordinate = Coordinate { index, ..body.coordinate };
                let moved = Body { parent, placement: base * body.placement, coordinate, ..body.clone() };
                new.bodies.push(moved);
                homes.push((Some(new.bodies.len() - 1), Pose::identity()));
                continue;
            }
            let position = body.coordinate.position(&held);
            let place = base * body.moved(position);
            if let Some(parent) = parent {
                let carrier = &mut new.bodies[parent];
                carrier.inertia = carrier.inertia.with(&body.inertia.seen_from(&place));
            }
            if body.coordinate.own {
                let text = format!("joint `{}` is held at {position}", body.joint.name);
                new.notes.push(Note::new(findings::URDF_HELD, text, ""));
            }
            homes.push((parent, place));
        }
        new.frames.extend(self.frames.iter().map(|frame| {
            let (body, base) = frame.body.map_or((None, Pose::identity()), |b| homes[b]);
            Frame { name: frame.name.clone(), body, placement: base * frame.placement }
        }));
        new
    }

    /// The same, after the check that torques can be computed: everything that moves has an inertia.
    ///
    /// # Errors
    /// [`Error::Setting`] where a body has none.
    pub fn weighed(self) -> Result<Self> {
        let light = |index: &usize| self.bodies[*index].inertia.mass_kg == 0.0 && !self.passes_on(*index);
        let Some(body) = (0..self.bodies.len()).find(light).map(|index| &self.bodies[index]) else { return Ok(self) };
        let expected = format!("a URDF with an <inertial> of link `{}`, which moves", body.name);
        let found = "none: the maker's own URDF or SDF often has it".into();
        Err(Error::Setting { origin: Origin::Caller, name: "arm.urdf", expected, found })
    }

    /// Whether a body is a joint between two others of the same link, which has several: the last one has its mass.
    fn passes_on(&self, index: usize) -> bool {
        let mut later = self.bodies.iter().skip(index + 1);
        later.any(|other| other.parent == Some(index) && other.name == self.bodies[index].name)
    }

    /// The same with a load fixed to `frame`, in whose axes `load` is given. A load on the base changes nothing.
    #[must_use]
    pub fn loaded(&self, frame: &Frame, load: &Inertia) -> Self {
        let mut model = self.clone();
        if let Some(body) = frame.body {
            model.bodies[body].inertia = model.bodies[body].inertia.with(&load.seen_from(&frame.placement));
        }
        model
    }
}

impl Coordinate {
    /// The coordinate of a joint that mimics none.
    #[must_use]
    pub const fn own(index: usize) -> Self {
        Self { index, multiplier: 1.0, offset: 0.0, own: true }
    }

    /// The joint's position where the coordinates are `q`.
    #[must_use]
    pub fn position(&self, q: &[f64]) -> f64 {
        self.multiplier * q[self.index] + self.offset
    }
}

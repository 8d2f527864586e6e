//! What moves in one setup: the chain with its loads under gravity.

use std::borrow::Cow;

use nalgebra::Vector3;

use super::imperfect::Imperfect;
use super::numbers::JointNumbers;
use super::one_joint::Load;
use crate::arm::{Frame, Inertia, JointKind, Model, Recursion};

/// A link with less than this share of the mass of its loads is a frame for them.
const LEAST_SHARE: f64 = 1e-3;

/// A mass on a link.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::struct_field_names, reason = "a mass has a mass")]
pub(crate) struct Mass {
    pub link: Frame,
    pub mass_kg: f64,
    /// In the axes of the link, m.
    pub position_m: Vector3<f64>,
}

/// A robot as its recordings in one setup have it.
#[derive(Debug, Clone)]
pub(crate) struct Rig {
    /// The chain without loads.
    bare: Model,
    masses: Vec<Mass>,
    gravity_m_s2: f64,
    /// Turn of the base about x, then about y of the world, rad.
    tilt_rad: [f64; 2],
    /// The joints as the file has them, in the order of the model.
    pub joints: Vec<JointNumbers>,
    pub step_s: f64,
    /// The chain with its loads as they are stated.
    loaded: Model,
    /// Of one joint that moves one body: its load.
    one: Option<Load>,
}

impl Rig {
    pub fn new(
        bare: Model,
        masses: Vec<Mass>,
        (gravity_m_s2, tilt_rad): (f64, [f64; 2]),
        joints: Vec<JointNumbers>,
        step_s: f64,
    ) -> Self {
        let loaded = with_masses(&bare, &masses, 0.0, Vector3::zeros());
        let mut rig = Self { bare, masses, gravity_m_s2, tilt_rad, joints, step_s, loaded, one: None };
        rig.one = single(&rig.loaded, rig.gravity(&Imperfect::none(rig.joints.len())));
        rig
    }

    /// The chain with its loads, and gravity in the axes of its base.
    pub fn world(&self, imperfect: &Imperfect) -> (Cow<'_, Model>, Vector3<f64>) {
        let gravity = self.gravity(imperfect);
        let moved = imperfect.load_offset_m != 0.0 || imperfect.arm.com_offset_m != [0.0; 3];
        let mut world = Cow::Borrowed(&self.loaded);
        if moved {
            let offset = Vector3::from(imperfect.arm.com_offset_m);
            world = Cow::Owned(with_masses(&self.bare, &self.masses, imperfect.load_offset_m, offset));
        }
        if imperfect.extra_load_kg != 0.0 {
            world = Cow::Owned(self.with_extra(world.into_owned(), imperfect.extra_load_kg));
        }
        (world, gravity)
    }

    /// The load of its only joint, where it has one that moves one body.
    pub fn load(&self, imperfect: &Imperfect) -> Option<Load> {
        let one = self.one?;
        let (world, gravity) = self.world(imperfect);
        let same = matches!(world, Cow::Borrowed(_)) && imperfect.arm.tilt_rad == [0.0; 2];
        if same { Some(one) } else { single(&world, gravity) }
    }

    /// The chain with a mass at the centre of mass of its last link: of the link alone, since loads are stated and differ between setups,
    /// unless it has next to none.
    fn with_extra(&self, mut model: Model, mass_kg: f64) -> Model {
        if let (Some(last), Some(bare)) = (model.bodies.last_mut(), self.bare.bodies.last()) {
            let heavy = bare.inertia.mass_kg > LEAST_SHARE * last.inertia.mass_kg;
            let com_m = if heavy { bare.inertia.com_m } else { last.inertia.com_m };
            last.inertia = last.inertia.with(&Inertia::cube(mass_kg, com_m, 0.0));
        }
        model
    }

    fn gravity(&self, imperfect: &Imperfect) -> Vector3<f64> {
        let mut arm = imperfect.arm.clone();
        arm.tilt_rad.iter_mut().zip(self.tilt_rad).for_each(|(tilt, base)| *tilt += base);
        arm.gravity(self.gravity_m_s2)
    }
}

/// The chain with its loads, each `farther_m` from the origin of its link than stated and moved by `offset_m`.
fn with_masses(bare: &Model, masses: &[Mass], farther_m: f64, offset_m: Vector3<f64>) -> Model {
    let mut model = bare.clone();
    for mass in masses {
        let out = mass.position_m.try_normalize(0.0).unwrap_or_else(Vector3::zeros) * farther_m;
        let load = Inertia::cube(mass.mass_kg, mass.position_m + out + offset_m, 0.0);
        model = model.loaded(&mass.link, &load);
    }
    model
}

/// The load of a chain with one joint and one body.
fn single(model: &Model, gravity: Vector3<f64>) -> Option<Load> {
    let [body] = model.bodies.as_slice() else { return None };
    let mut torque = [0.0];
    let mut weightless = Recursion::new(model, Vector3::zeros());
    weightless.inverse_dynamics(&[0.0], &[0.0], &[1.0], &mut torque);
    let inertia = torque[0];
    let mut weighing = Recursion::new(model, gravity);
    let mut at = |q: f64| {
        weighing.inverse_dynamics(&[q], &[0.0], &[0.0], &mut torque);
        -torque[0]
    };
    if body.joint.kind == JointKind::Prismatic {
        return Some(Load { inertia, constant: at(0.0), amplitude: 0.0, phase: 0.0 });
    }
    // constant + a cos q + b sin q = constant − amplitude · sin(q + phase)
    let constant = 0.5 * (at(0.0) + at(std::f64::consts::PI));
    let (a, b) = (at(0.0) - constant, at(std::f64::consts::FRAC_PI_2) - constant);
    Some(Load { inertia, constant, amplitude: a.hypot(b), phase: (-a).atan2(-b) })
}

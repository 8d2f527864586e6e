//! `<link>` and `<joint>` of a URDF.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

use crate::given::Given;
use crate::robot::{Joint, Motion, Weight};
use crate::xml::{Document, Element, shown};
use crate::{Inertia, Pose, Result};

/// The first child with this tag.
pub(super) fn child<'a>(document: &'a Document, element: &'a Element, tag: &str) -> Option<Given<'a>> {
    element.named(tag).next().map(|own| Given::own(document, own))
}

/// What `<origin>` says; nothing where there is none.
pub(super) fn origin(document: &Document, element: &Element) -> Result<Pose> {
    let Some(given) = child(document, element, "origin") else { return Ok(Pose::identity()) };
    let place = Vector3::from(given.numbers::<3>("xyz")?.unwrap_or_default());
    let [roll, pitch, yaw] = given.numbers::<3>("rpy")?.unwrap_or_default();
    Ok(Pose::from_parts(place.into(), Rotation3::from_euler_angles(roll, pitch, yaw)))
}

/// The inertia of a link, in its own frame.
pub(super) fn inertia(document: &Document, link: &Element) -> Result<(Inertia, Weight)> {
    let Some(inertial) = link.named("inertial").next() else { return Ok((Inertia::zero(), Weight::Missing)) };
    let number = |tag: &str, key: &str| -> Result<f64> {
        let Some(given) = child(document, inertial, tag) else { return Ok(0.0) };
        Ok(given.number(key)?.unwrap_or(0.0))
    };
    let moment = |key: &str| number("inertia", key);
    let (xx, yy, zz) = (moment("ixx")?, moment("iyy")?, moment("izz")?);
    let (xy, xz, yz) = (moment("ixy")?, moment("ixz")?, moment("iyz")?);
    let own = Inertia {
        mass_kg: number("mass", "value")?,
        com_m: Vector3::zeros(),
        about_com_kg_m2: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
    };
    if let Some((expected, found)) = own.impossible() {
        let message = format!("link `{}`: expected {expected}, found {found}", name(link));
        return Err(document.error_at(link, message, "no body has such an inertia: correct <inertial>"));
    }
    let weight = if own.mass_kg == 0.0 { Weight::Missing } else { Weight::Stated };
    Ok((own.seen_from(&origin(document, inertial)?), weight))
}

/// A name as messages show it.
pub(super) fn name(element: &Element) -> String {
    shown(element.value("name").unwrap_or_default())
}

/// How a joint moves; `None` where it is fixed.
pub(super) fn motion(document: &Document, joint: &Element) -> Result<Option<Motion>> {
    let given = Given::own(document, joint);
    Ok(match given.text("type") {
        Some("fixed") => None,
        Some("revolute" | "continuous") => Some(Motion::Revolute),
        Some("prismatic") => Some(Motion::Prismatic),
        Some("floating") => Some(Motion::Free),
        Some("spherical") => Some(Motion::Ball),
        other => {
            let found = other.map_or_else(|| "no `type`".to_owned(), |kind| format!("`{}`", shown(kind)));
            let message = format!(
                "joint `{}`: expected fixed, revolute, continuous, prismatic or floating, found {found}",
                name(joint)
            );
            return Err(given.error("type", message, "describe it by joints with one axis each"));
        }
    })
}

/// The joint of an element.
pub(super) fn joint(document: &Document, element: &Element, motion: Motion) -> Result<Joint> {
    let mut new = Joint {
        name: element.value("name").unwrap_or_default().to_owned(),
        motion,
        anchor_m: Vector3::zeros(),
        axis: Vector3::x_axis(),
        reference: 0.0,
        range: None,
        velocity_limit: None,
        effort_range: None,
        armature: 0.0,
        damping: 0.0,
        friction: 0.0,
        stiffness: 0.0,
        spring_reference: 0.0,
    };
    if let Some(given) = child(document, element, "axis") {
        let axis = Vector3::from(given.numbers::<3>("xyz")?.unwrap_or([1.0, 0.0, 0.0]));
        new.axis = Unit::try_new(axis, 1e-9).filter(|axis| axis.iter().all(|n| n.is_finite())).ok_or_else(|| {
            let message = format!("joint `{}`: expected an axis with a direction, found none", name(element));
            given.error("xyz", message, "write <axis xyz=\"0 0 1\"/>, say")
        })?;
    }
    if let Some(given) = child(document, element, "dynamics") {
        new.damping = given.not_negative("damping", 0.0)?;
        new.friction = given.not_negative("friction", 0.0)?;
    }
    if let Some(given) = child(document, element, "limit") {
        let (lower, upper) = (given.number("lower")?.unwrap_or(0.0), given.number("upper")?.unwrap_or(0.0));
        if lower > upper {
            let message = format!("joint `{}`: expected lower below upper, found {lower} and {upper}", name(element));
            return Err(given.error("lower", message, "correct <limit>"));
        }
        let ends = element.value("type") != Some("continuous") && lower < upper;
        new.range = ends.then_some([lower, upper]);
        new.velocity_limit = Some(given.not_negative("velocity", 0.0)?).filter(|limit| *limit > 0.0);
        let effort = Some(given.not_negative("effort", 0.0)?).filter(|limit| *limit > 0.0);
        new.effort_range = effort.map(|effort| [-effort, effort]);
    }
    Ok(new)
}

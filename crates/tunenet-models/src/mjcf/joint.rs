//! `<joint>` and `<freejoint>`.

use nalgebra::{Unit, Vector3};

use super::actuator::{checked, limits};
use super::compiler::Compiler;
use crate::Result;
use crate::given::Given;
use crate::robot::{Joint, Motion};
use crate::unused::{Changes, Collector};

/// The joint of an element; `name` is its own or one that was made up.
pub(super) fn joint(given: &Given, compiler: &Compiler, name: String, unused: &mut Collector) -> Result<Joint> {
    let motions =
        [("hinge", Motion::Revolute), ("slide", Motion::Prismatic), ("ball", Motion::Ball), ("free", Motion::Free)];
    let motion = if given.own.tag == "freejoint" {
        Motion::Free
    } else {
        given.word("type", &motions)?.unwrap_or(Motion::Revolute)
    };
    let turn = |value: f64| if motion == Motion::Revolute { compiler.angle(value) } else { value };
    let axis = Vector3::from(given.numbers::<3>("axis")?.unwrap_or([0.0, 0.0, 1.0]));
    let axis = Unit::try_new(axis, 1e-14).filter(|axis| axis.iter().all(|n| n.is_finite()));
    let axis =
        axis.ok_or_else(|| given.error("axis", "`axis`: expected a direction, found none", "write 0 0 1, say"))?;
    let range = given.numbers::<2>("range")?.unwrap_or_default().map(turn);
    let limited = given.flag_or_auto("limited")?;
    let range = checked(limits(range, limited, compiler.auto_limits), "range", given)?;
    let effort = given.numbers::<2>("actuatorfrcrange")?.unwrap_or_default();
    let effort = limits(effort, given.flag_or_auto("actuatorfrclimited")?, compiler.auto_limits);
    let effort_range = checked(effort, "actuatorfrcrange", given)?;
    let scalar = matches!(motion, Motion::Revolute | Motion::Prismatic);
    Ok(Joint {
        name,
        motion,
        anchor_m: if motion == Motion::Free {
            Vector3::zeros()
        } else {
            given.numbers::<3>("pos")?.unwrap_or_default().into()
        },
        axis,
        reference: turn(given.number("ref")?.unwrap_or(0.0)),
        range: range.filter(|_| scalar),
        velocity_limit: None,
        effort_range: effort_range.filter(|_| scalar),
        armature: given.not_negative("armature", 0.0)?,
        damping: first(given, "damping", unused)?,
        friction: given.not_negative("frictionloss", 0.0)?,
        stiffness: first(given, "stiffness", unused)?,
        spring_reference: turn(given.number("springref")?.unwrap_or(0.0)),
    })
}

/// The linear coefficient of a polynomial; that there are others is noted.
fn first(given: &Given, name: &str, unused: &mut Collector) -> Result<f64> {
    let mut terms = [0.0; 3];
    given.fill(name, &mut terms)?;
    if let Some(attribute) = given.get(name)
        && terms[1..].iter().any(|term| *term != 0.0)
    {
        let what = "terms of higher order; the first number alone is taken on";
        unused.add(attribute.file, attribute.whole.start, (&given.own.tag, Some(name)), Changes::Dynamics, what);
    }
    if terms[0] >= 0.0 {
        return Ok(terms[0]);
    }
    Err(given.error(name, format!("`{name}`: expected 0 or more, found {}", terms[0]), "correct the attribute"))
}

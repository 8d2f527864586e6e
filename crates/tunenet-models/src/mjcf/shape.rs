//! The inertia of a shape with a density or a mass: solid sphere, capsule, cylinder, box, ellipsoid.

use std::f64::consts::PI;

use nalgebra::{Rotation3, Unit, Vector3};

use super::compiler::Compiler;
use super::pose::{rotation, to_z};
use crate::given::Given;
use crate::{Inertia, Pose, Result};

/// Density of a shape that states none, kg/m³.
const WATER_KG_M3: f64 = 1000.0;

/// What a shape gives its body.
pub(super) enum ShapeInertia {
    /// Nothing: it has no mass or does not count.
    None,
    /// This, in the frame in which the shape is placed.
    Known(Inertia),
    /// It would have mass, but only another file says how much; the sentence says which.
    Mesh(String),
}

/// The inertia of a `<geom>`.
pub(super) fn inertia(given: &Given, compiler: &Compiler) -> Result<ShapeInertia> {
    let group = given.number("group")?.unwrap_or(0.0);
    if group < compiler.groups[0] || group > compiler.groups[1] {
        return Ok(ShapeInertia::None);
    }
    let mass = given.number("mass")?;
    let density = given.number("density")?.unwrap_or(WATER_KG_M3);
    for (name, value) in [("mass", mass.unwrap_or(0.0)), ("density", density)] {
        if value < 0.0 {
            return Err(given.error(
                name,
                format!("`{name}`: expected 0 or more, found {value}"),
                "correct the attribute",
            ));
        }
    }
    if mass == Some(0.0) || mass.is_none() && density == 0.0 {
        return Ok(ShapeInertia::None);
    }
    let kind = given.text("type").unwrap_or("sphere");
    let line = given.document.files[given.own.file].line(given.own.open.start);
    if given.get("mesh").is_some() || matches!(kind, "mesh" | "sdf") {
        let mesh = given.text("mesh").unwrap_or("without a name");
        return Ok(ShapeInertia::Mesh(format!("mesh `{mesh}` (line {line})")));
    }
    if given.text("shellinertia") == Some("true") {
        return Ok(ShapeInertia::Mesh(format!("a hollow {kind} (line {line})")));
    }
    if matches!(kind, "plane" | "hfield") {
        return Ok(ShapeInertia::None);
    }
    let (size, pose) = placed(given, compiler, kind)?;
    let (volume, moments) = solid(kind, size).ok_or_else(|| {
        given.error("type", format!("`type`: expected a shape of MJCF, found `{kind}`"), "correct the type")
    })?;
    if !(volume > 0.0 && volume.is_finite()) {
        return Err(given.error(
            "size",
            format!("`size`: expected a {kind} with a volume, found none"),
            "correct the size",
        ));
    }
    let mass_kg = mass.unwrap_or(density * volume);
    Ok(ShapeInertia::Known(Inertia::principal(mass_kg, pose.translation.vector, pose.rotation, moments * mass_kg)))
}

/// Size and place; `fromto` gives both.
fn placed(given: &Given, compiler: &Compiler, kind: &str) -> Result<([f64; 3], Pose)> {
    let mut size = [0.0; 3];
    given.fill("size", &mut size)?;
    let Some([a, b, c, d, e, f]) = given.numbers("fromto")? else {
        let position = Vector3::from(given.numbers::<3>("pos")?.unwrap_or_default());
        return Ok((size, Pose::from_parts(position.into(), rotation(given, compiler)?)));
    };
    let (from, to) = (Vector3::new(a, b, c), Vector3::new(d, e, f));
    let along = Unit::try_new(from - to, 1e-14).ok_or_else(|| {
        given.error("fromto", "`fromto`: expected two points, found the same one twice", "correct it")
    })?;
    let half = (from - to).norm() / 2.0;
    size = if matches!(kind, "box" | "ellipsoid") { [size[0], size[0], half] } else { [size[0], half, 0.0] };
    let turn: Rotation3<f64> = to_z(&along);
    Ok((size, Pose::from_parts(((from + to) / 2.0).into(), turn)))
}

/// Volume in m³ and principal moments of inertia per mass in m², of half sizes in m.
fn solid(kind: &str, [a, b, c]: [f64; 3]) -> Option<(f64, Vector3<f64>)> {
    Some(match kind {
        "sphere" => (4.0 / 3.0 * PI * a.powi(3), Vector3::repeat(0.4 * a * a)),
        "box" => (8.0 * a * b * c, Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) / 3.0),
        "ellipsoid" => (4.0 / 3.0 * PI * a * b * c, Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) / 5.0),
        "cylinder" => {
            let across = (3.0 * a * a + 4.0 * b * b) / 12.0;
            (2.0 * PI * a * a * b, Vector3::new(across, across, a * a / 2.0))
        }
        "capsule" => {
            let height = 2.0 * b;
            let (ends, middle) = (4.0 / 3.0 * PI * a.powi(3), PI * a * a * height);
            let (share_ends, share_middle) = (ends / (ends + middle), middle / (ends + middle));
            let ball = 0.4 * a * a;
            // Two half balls, moved apart by the height: Steiner's theorem about their own centres of mass.
            let across = share_middle * (3.0 * a * a + height * height) / 12.0
                + share_ends * (ball + height * (3.0 * a + 2.0 * height) / 8.0);
            (ends + middle, Vector3::new(across, across, share_middle * a * a / 2.0 + share_ends * ball))
        }
        _ => return None,
    })
}

//! Places and orientations: `pos` with one of `quat`, `axisangle`, `euler`, `xyaxes`, `zaxis`.

use nalgebra::{Matrix3, Quaternion, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use super::compiler::Compiler;
use crate::given::Given;
use crate::{Pose, Result};

/// Shortest vector that has a direction.
const SHORTEST: f64 = 1e-14;

/// Where the element lies.
pub(super) fn pose(given: &Given, compiler: &Compiler) -> Result<Pose> {
    let position = Vector3::from(given.numbers::<3>("pos")?.unwrap_or_default());
    Ok(Pose::from_parts(Translation3::from(position), rotation(given, compiler)?))
}

/// How it is turned. The other notations come before `quat`, as a class may give one and the element another.
pub(super) fn rotation(given: &Given, compiler: &Compiler) -> Result<Rotation3<f64>> {
    let direction = |name: &str, v: Vector3<f64>| {
        let unit = Unit::try_new(v, SHORTEST).filter(|unit| unit.iter().all(|n| n.is_finite()));
        unit.ok_or_else(|| {
            given.error(name, format!("`{name}`: expected a direction, found none"), "correct the attribute")
        })
    };
    if let Some([x, y, z, angle]) = given.numbers("axisangle")? {
        let axis = direction("axisangle", Vector3::new(x, y, z))?;
        return Ok(Rotation3::from_axis_angle(&axis, compiler.angle(angle)));
    }
    if let Some(angles) = given.numbers::<3>("euler")? {
        return Ok(euler(compiler, angles));
    }
    if let Some([a, b, c, d, e, f]) = given.numbers("xyaxes")? {
        let x = direction("xyaxes", Vector3::new(a, b, c))?.into_inner();
        let y = Vector3::new(d, e, f);
        let y = direction("xyaxes", y - x * x.dot(&y))?.into_inner();
        return Ok(Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, x.cross(&y)])));
    }
    if let Some(z) = given.numbers::<3>("zaxis")? {
        let z = direction("zaxis", Vector3::from(z))?;
        return Ok(to_z(&z));
    }
    let Some([w, x, y, z]) = given.numbers("quat")? else { return Ok(Rotation3::identity()) };
    let unit = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), SHORTEST);
    let unit = unit.filter(|q| q.coords.iter().all(|n| n.is_finite()));
    unit.map(UnitQuaternion::to_rotation_matrix)
        .ok_or_else(|| given.error("quat", "`quat`: expected a quaternion with a length, found none", "write 1 0 0 0"))
}

/// Small letters turn about axes that turn along, capitals about those that stay.
fn euler(compiler: &Compiler, angles: [f64; 3]) -> Rotation3<f64> {
    let mut all = Rotation3::identity();
    for (axis, angle) in compiler.euler.iter().zip(angles) {
        let about = match axis.to_ascii_lowercase() {
            b'x' => Vector3::x_axis(),
            b'y' => Vector3::y_axis(),
            _ => Vector3::z_axis(),
        };
        let one = Rotation3::from_axis_angle(&about, compiler.angle(angle));
        all = if axis.is_ascii_lowercase() { all * one } else { one * all };
    }
    all
}

/// The smallest turn that brings z to this direction.
pub(super) fn to_z(direction: &Unit<Vector3<f64>>) -> Rotation3<f64> {
    let axis = Vector3::z().cross(direction);
    let (sine, cosine) = (axis.norm(), direction.z);
    let about = Unit::try_new(axis, SHORTEST).unwrap_or_else(Vector3::x_axis);
    Rotation3::from_axis_angle(&about, sine.atan2(cosine))
}

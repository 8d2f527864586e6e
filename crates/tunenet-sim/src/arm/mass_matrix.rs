//! The mass matrix by composite rigid bodies (Walker and Orin 1982, their third method).

use nalgebra::{DMatrix, Matrix3, Vector3};

use super::{JointKind, Model, Recursion};

/// A body with everything that it carries, as one rigid body in world axes.
#[derive(Debug, Clone, Copy)]
struct Composite {
    mass_kg: f64,
    /// Centre of mass, m.
    com: Vector3<f64>,
    /// About the centre of mass, kg·m².
    inertia: Matrix3<f64>,
}

impl Composite {
    /// Both together.
    fn with(&self, other: &Self) -> Self {
        let mass_kg = self.mass_kg + other.mass_kg;
        if mass_kg == 0.0 {
            return *self;
        }
        let apart = other.com - self.com;
        let reduced = self.mass_kg * other.mass_kg / mass_kg;
        let moved = (Matrix3::from_diagonal_element(apart.norm_squared()) - apart * apart.transpose()) * reduced;
        Self {
            mass_kg,
            com: self.com + apart * (other.mass_kg / mass_kg),
            inertia: self.inertia + other.inertia + moved,
        }
    }
}

/// Working memory for one model, which is allocated once.
#[derive(Debug, Clone)]
pub(crate) struct CompositeBodies<'a> {
    model: &'a Model,
    bodies: Vec<Composite>,
}

impl<'a> CompositeBodies<'a> {
    pub fn new(model: &'a Model) -> Self {
        let none = Composite { mass_kg: 0.0, com: Vector3::zeros(), inertia: Matrix3::zeros() };
        Self { model, bodies: vec![none; model.bodies.len()] }
    }

    /// The mass matrix of the rigid bodies where `placed` has them, kg·m² (kg·m and kg of prismatic joints), into `mass`, a square of
    /// [`Model::degrees`].
    ///
    /// # Panics
    /// Where `mass` is smaller, or `placed` is of a smaller model.
    pub fn mass_matrix(&mut self, placed: &Recursion, mass: &mut DMatrix<f64>) {
        for (i, body) in self.model.bodies.iter().enumerate() {
            let (rotation, position) = placed.place_of(i);
            let turned = rotation.matrix();
            self.bodies[i] = Composite {
                mass_kg: body.inertia.mass_kg,
                com: position + rotation * body.inertia.com_m,
                inertia: turned * body.inertia.about_com_kg_m2 * turned.transpose(),
            };
        }
        mass.fill(0.0);
        for i in (0..self.bodies.len()).rev() {
            let (body, moved) = (&self.model.bodies[i], self.bodies[i]);
            if let Some(parent) = body.parent {
                self.bodies[parent] = self.bodies[parent].with(&moved);
            }
            // What a unit of its joint's acceleration asks for: a force at the centre of mass, and a moment about it.
            let axis = placed.axis_of(i);
            let (force, moment) = if body.joint.kind == JointKind::Prismatic {
                (axis * moved.mass_kg, Vector3::zeros())
            } else {
                (axis.cross(&(moved.com - placed.place_of(i).1)) * moved.mass_kg, moved.inertia * axis)
            };
            let (own, mut carrier) = (body.coordinate, Some(i));
            while let Some(k) = carrier {
                let (other, axis) = (&self.model.bodies[k], placed.axis_of(k));
                let along = if other.joint.kind == JointKind::Prismatic {
                    force
                } else {
                    moment + (moved.com - placed.place_of(k).1).cross(&force)
                };
                let value = own.multiplier * other.coordinate.multiplier * axis.dot(&along);
                mass[(own.index, other.coordinate.index)] += value;
                if k != i {
                    mass[(other.coordinate.index, own.index)] += value;
                }
                carrier = other.parent;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::arm::urdf;

    const ARM: &str = r#"<robot name="r"><link name="base"/>
<link name="a"><inertial><origin xyz="0.1 0.02 0.3"/><mass value="2"/><inertia ixx="0.03" iyy="0.02" izz="0.04" ixy="0.001" ixz="0.002" iyz="0.003"/></inertial></link>
<link name="b"><inertial><origin xyz="0 0.2 0.1"/><mass value="1.5"/><inertia ixx="0.02" iyy="0.03" izz="0.015" ixy="0" ixz="0.001" iyz="0"/></inertial></link>
<link name="c"><inertial><origin xyz="0.05 0 0"/><mass value="0.5"/><inertia ixx="0.002" iyy="0.003" izz="0.0025" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="d"><inertial><origin xyz="0 0 0.04"/><mass value="0.3"/><inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="one" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0 0 0.2" rpy="0.1 0.2 0.3"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="two" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.3 0 0.1" rpy="0.4 0 0"/><axis xyz="0 0.6 0.8"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="slide" type="prismatic"><parent link="b"/><child link="c"/><origin xyz="0 0.4 0" rpy="0 0.5 0"/><axis xyz="1 0 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="follower" type="revolute"><parent link="b"/><child link="d"/><origin xyz="0.1 0 0.2"/><axis xyz="1 0 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/><mimic joint="two" multiplier="-0.7" offset="0.1"/></joint>
</robot>"#;

    /// Column by column the torques of unit accelerations by the recursion of Newton and Euler, which is another algorithm; of a branched
    /// chain with a slide and with a joint that follows another.
    #[test]
    fn columns_are_the_torques_of_unit_accelerations() {
        let model = urdf::parse(Path::new("arm.urdf"), ARM).unwrap();
        let n = model.degrees();
        let mut recursion = Recursion::new(&model, Vector3::zeros());
        let mut composites = CompositeBodies::new(&model);
        let mut mass = DMatrix::from_element(n, n, 7.0);
        for q in [[0.0, 0.0, 0.0], [0.4, -1.1, 0.2], [-2.0, 2.5, -0.3]] {
            recursion.place(&q);
            composites.mass_matrix(&recursion, &mut mass);
            for j in 0..n {
                let (mut unit, mut column) = (vec![0.0; n], vec![0.0; n]);
                unit[j] = 1.0;
                recursion.torques(&vec![0.0; n], &unit, &mut column);
                for (i, expected) in column.into_iter().enumerate() {
                    let found = mass[(i, j)];
                    assert!((found - expected).abs() < 1e-12 * mass.amax(), "{i} {j}: {found} {expected}");
                }
            }
        }
    }
}

//! Mass, centre of mass and inertia tensor of a rigid body.

use nalgebra::{Matrix3, Point3, Rotation3, SymmetricEigen, Vector3};

use crate::Pose;

/// How far the triangle inequality may be missed, relative to the trace: figures of files are rounded.
const ROUNDED: f64 = 1e-4;

/// What a rigid body weighs and how it resists turning, in the axes of one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass, m.
    pub com_m: Vector3<f64>,
    /// Rotational inertia about the centre of mass, kg·m².
    pub about_com_kg_m2: Matrix3<f64>,
}

impl Inertia {
    /// Nothing.
    #[must_use]
    pub fn zero() -> Self {
        Self { mass_kg: 0.0, com_m: Vector3::zeros(), about_com_kg_m2: Matrix3::zeros() }
    }

    /// A homogeneous cube with edges of `edge_m` (0: a point), its centre at `com_m`: `m·edge²/6` about every axis.
    #[must_use]
    pub fn cube(mass_kg: f64, com_m: Vector3<f64>, edge_m: f64) -> Self {
        let about_com_kg_m2 = Matrix3::identity() * (mass_kg * edge_m * edge_m / 6.0);
        Self { mass_kg, com_m, about_com_kg_m2 }
    }

    /// The same body in the axes of the frame in which `pose` places the present one.
    #[must_use]
    pub fn seen_from(&self, pose: &Pose) -> Self {
        let rotation = pose.rotation.matrix();
        Self {
            mass_kg: self.mass_kg,
            com_m: (pose * Point3::from(self.com_m)).coords,
            about_com_kg_m2: rotation * self.about_com_kg_m2 * rotation.transpose(),
        }
    }

    /// Both bodies as one, by Steiner's theorem; both in the same frame.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        let mass_kg = self.mass_kg + other.mass_kg;
        if mass_kg == 0.0 {
            return *self;
        }
        let com_m = (self.com_m * self.mass_kg + other.com_m * other.mass_kg) / mass_kg;
        let about = |body: &Self| body.about_kg_m2(&com_m);
        Self { mass_kg, com_m, about_com_kg_m2: about(self) + about(other) }
    }

    /// Rotational inertia about another point, kg·m².
    #[must_use]
    pub fn about_kg_m2(&self, point_m: &Vector3<f64>) -> Matrix3<f64> {
        let arm = self.com_m - point_m;
        self.about_com_kg_m2 + (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * self.mass_kg
    }

    /// Whether every number is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.mass_kg.is_finite() && self.com_m.iter().chain(self.about_com_kg_m2.iter()).all(|n| n.is_finite())
    }

    /// What no body can have, as (expected, found); `None` where all is well. A point, whose moments are 0, is allowed.
    #[must_use]
    pub fn impossible(&self) -> Option<(String, String)> {
        let mut numbers = self.com_m.iter().chain(self.about_com_kg_m2.iter()).chain([&self.mass_kg]);
        if let Some(number) = numbers.find(|number| !number.is_finite()) {
            return Some(("finite numbers".into(), number.to_string()));
        }
        if self.mass_kg < 0.0 {
            return Some(("a mass of 0 kg or more".into(), format!("{} kg", self.mass_kg)));
        }
        let moments = self.about_com_kg_m2.symmetric_eigenvalues();
        let (least, greatest, trace) = (moments.min(), moments.max(), moments.sum());
        if moments.amax() == 0.0 {
            return None;
        }
        if least < -ROUNDED * greatest.abs() {
            return Some(("moments of inertia of 0 or more".into(), format!("{least:.3e} kg·m²")));
        }
        (2.0 * greatest > trace * (1.0 + ROUNDED)).then(|| {
            let (expected, others) =
                ("the greatest moment of inertia to be at most the sum of the others", trace - greatest);
            (expected.into(), format!("{greatest:.3e} kg·m² and {others:.3e} kg·m²"))
        })
    }

    /// The same with its principal moments changed by `change`.
    pub(crate) fn with_moments(&self, change: impl FnOnce(Vector3<f64>) -> Vector3<f64>) -> Self {
        let eigen = SymmetricEigen::new(self.about_com_kg_m2);
        let moments = Matrix3::from_diagonal(&change(eigen.eigenvalues));
        Self { about_com_kg_m2: eigen.eigenvectors * moments * eigen.eigenvectors.transpose(), ..*self }
    }

    /// A body with these principal moments along the axes of `rotation`.
    pub(crate) fn principal(
        mass_kg: f64,
        com_m: Vector3<f64>,
        rotation: Rotation3<f64>,
        moments: Vector3<f64>,
    ) -> Self {
        let r = rotation.matrix();
        Self { mass_kg, com_m, about_com_kg_m2: r * Matrix3::from_diagonal(&moments) * r.transpose() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_points_make_a_dumb_bell() {
        let point = |x: f64| Inertia { mass_kg: 1.0, com_m: Vector3::new(x, 0.0, 0.0), ..Inertia::zero() };
        let both = point(-1.0).with(&point(3.0));
        assert_eq!((both.mass_kg, both.com_m.x), (2.0, 1.0));
        assert_eq!(both.about_com_kg_m2, Matrix3::from_diagonal(&Vector3::new(0.0, 8.0, 8.0)));
        assert_eq!(both.about_kg_m2(&Vector3::zeros())[(2, 2)], 10.0);
    }

    #[test]
    fn what_no_body_can_have_is_named() {
        let body = |m: f64, i: [f64; 3]| Inertia {
            mass_kg: m,
            about_com_kg_m2: Matrix3::from_diagonal(&i.into()),
            ..Inertia::zero()
        };
        assert_eq!(body(1.0, [1.0, 2.0, 3.0]).impossible(), None);
        assert_eq!(body(1.0, [0.0; 3]).impossible(), None);
        for (mass, moments) in [(-1.0, [1.0; 3]), (1.0, [1.0, 1.0, 2.1]), (1.0, [-1.0, 1.0, 1.0]), (1.0, [f64::NAN; 3])]
        {
            assert!(body(mass, moments).impossible().is_some(), "{mass} {moments:?}");
        }
    }
}

//! Mass, centre of mass and inertia of a rigid body, and what of them is physical.

use nalgebra::{Matrix3, Vector3};

use super::Pose;

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

impl Default for Inertia {
    fn default() -> Self {
        Self { mass_kg: 0.0, com_m: Vector3::zeros(), about_com_kg_m2: Matrix3::zeros() }
    }
}

impl Inertia {
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
            com_m: pose * nalgebra::Point3::from(self.com_m) - nalgebra::Point3::origin(),
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
        let moved = |body: &Self| body.about_com_kg_m2 + steiner(body.mass_kg, &(body.com_m - com_m));
        Self { mass_kg, com_m, about_com_kg_m2: moved(self) + moved(other) }
    }

    /// Inertia about the frame's own origin, kg·m².
    #[must_use]
    pub fn about_origin_kg_m2(&self) -> Matrix3<f64> {
        self.about_com_kg_m2 + steiner(self.mass_kg, &self.com_m)
    }

    /// What no body can have, as (expected, found); `None` where all is well.
    ///
    /// Mass and principal moments are positive, and of the three moments each is at most the sum of the others: they are
    /// sums of squares of distances. A point (all moments 0) is allowed.
    #[must_use]
    pub fn impossible(&self) -> Option<(String, String)> {
        let numbers = || self.com_m.iter().chain(self.about_com_kg_m2.iter()).chain([&self.mass_kg]);
        if let Some(number) = numbers().find(|n| !n.is_finite()) {
            return Some(("finite numbers".into(), number.to_string()));
        }
        if self.mass_kg < 0.0 {
            return Some(("a mass above 0 kg".into(), format!("{} kg", self.mass_kg)));
        }
        let moments = self.about_com_kg_m2.symmetric_eigenvalues();
        let trace = moments.sum();
        if moments.amax() == 0.0 {
            return None;
        }
        let (least, greatest) = (moments.min(), moments.max());
        if least <= 0.0 {
            let found = format!("{least:.3e} kg·m² about one of them");
            return Some(("inertia above 0 about every axis".into(), found));
        }
        if self.mass_kg == 0.0 {
            return Some(("a mass above 0 kg where there is inertia".into(), "0 kg".into()));
        }
        (2.0 * greatest > trace * (1.0 + ROUNDED)).then(|| {
            let expected = "principal inertias of which none exceeds the sum of the others".into();
            (expected, format!("{greatest:.3e} against {:.3e} kg·m²", trace - greatest))
        })
    }
}

/// Inertia of a point mass about a place `arm` away.
fn steiner(mass_kg: f64, arm: &Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * mass_kg
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_points_make_a_dumb_bell() {
        let point = |x: f64| Inertia::cube(1.0, Vector3::new(x, 0.0, 0.0), 0.0);
        let both = point(-1.0).with(&point(1.0));
        assert_eq!((both.mass_kg, both.com_m), (2.0, Vector3::zeros()));
        assert_eq!(both.about_com_kg_m2, Matrix3::from_diagonal(&Vector3::new(0.0, 2.0, 2.0)));
        assert_eq!(point(2.0).about_origin_kg_m2()[(1, 1)], 4.0);
    }

    #[test]
    fn what_no_body_can_have_is_said() {
        let body = |m: f64, i: [f64; 3]| Inertia {
            mass_kg: m,
            com_m: Vector3::zeros(),
            about_com_kg_m2: Matrix3::from_diagonal(&i.into()),
        };
        assert_eq!(body(1.0, [1.0, 2.0, 2.9]).impossible(), None);
        assert_eq!(body(1.0, [0.0; 3]).impossible(), None);
        let cases =
            [(-1.0, [1.0, 1.0, 1.0]), (1.0, [1.0, 1.0, 2.1]), (1.0, [-1.0, 1.0, 1.0]), (1.0, [f64::NAN, 1.0, 1.0])];
        for (mass, moments) in cases {
            assert!(body(mass, moments).impossible().is_some(), "{mass} {moments:?}");
        }
    }
}

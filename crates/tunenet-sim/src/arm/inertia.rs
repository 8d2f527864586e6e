//! What of an inertia is physical for torques to be computed with it.

use tunenet_models::Inertia;

/// What no moving body can have, as (expected, found); `None` where all is well.
///
/// As [`Inertia::impossible`], and stricter, since a URDF states its numbers directly: moments are above 0, or all of them are 0 (a
/// point), and what has moments has a mass.
pub(super) fn impossible(inertia: &Inertia) -> Option<(String, String)> {
    let moments = inertia.about_com_kg_m2.symmetric_eigenvalues();
    if inertia.is_finite() && moments.amax() != 0.0 {
        if moments.min() <= 0.0 {
            let found = format!("{:.3e} kg·m² about one of them", moments.min());
            return Some(("inertia above 0 about every axis".into(), found));
        }
        if inertia.mass_kg == 0.0 {
            return Some(("a mass above 0 kg where there is inertia".into(), "0 kg".into()));
        }
    }
    inertia.impossible()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;

    #[test]
    fn what_no_moving_body_can_have_is_named() {
        let body = |mass_kg: f64, moments: [f64; 3]| Inertia {
            mass_kg,
            com_m: Vector3::zeros(),
            about_com_kg_m2: Matrix3::from_diagonal(&moments.into()),
        };
        assert_eq!(impossible(&body(1.0, [1.0, 2.0, 2.9])), None);
        assert_eq!(impossible(&body(1.0, [0.0; 3])), None);
        for (mass, moments) in [
            (-1.0, [1.0; 3]),
            (1.0, [1.0, 1.0, 2.1]),
            (1.0, [-1.0, 1.0, 1.0]),
            (1.0, [0.0, 1.0, 1.0]),
            (0.0, [1.0; 3]),
            (1.0, [f64::NAN, 1.0, 1.0]),
        ] {
            assert!(impossible(&body(mass, moments)).is_some(), "{mass} {moments:?}");
        }
    }
}

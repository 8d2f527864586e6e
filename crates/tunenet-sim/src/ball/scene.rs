//! The constants of a ball's scene.

use rapier3d::math::Vector;

use super::contact::{Contact, Law};
use super::flight::{Field, Forces};
use super::range::{GREATEST, within};
use crate::formula_effect::contact::AppliedContact;
use crate::formula_effect::flight::AppliedForce;

/// A ball above a plane surface, in SI units; z points up.
///
/// The surface passes through `(0, 0, surface_height_m)`. Its normal is `Rx(about_x) · Ry(about_y) · z`, that is
/// `(sin b, −sin a cos b, cos a cos b)` with `a` the tilt about x and `b` the tilt about y.
///
/// The ball is a solid sphere: its moment of inertia is 2/5·m·r². It neither deforms nor, by itself, feels the air;
/// see [`Forces`].
///
/// ```
/// use tunenet_sim::ball::Scene;
/// let scene = Scene { restitution: 0.8, ..Scene::default() };
/// assert_eq!(scene.normal(), [0.0, 0.0, 1.0]);
/// assert!(scene.check().is_ok());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Downward acceleration of gravity, m/s².
    pub gravity_m_s2: f64,
    /// Radius of the ball, m; positive.
    pub radius_m: f64,
    /// Mass of the ball, kg; positive. The motion does not depend on it: every force here is given per mass.
    pub mass_kg: f64,
    /// Height of the surface itself where x = y = 0, m.
    pub surface_height_m: f64,
    /// Tilt of the surface about the x axis, rad; between −π/2 and π/2.
    pub surface_tilt_about_x_rad: f64,
    /// Tilt of the surface about the y axis, rad; between −π/2 and π/2.
    pub surface_tilt_about_y_rad: f64,
    /// Coulomb's coefficient of friction between ball and surface; 0 or more.
    pub friction: f64,
    /// Coefficient of restitution: normal speed after an impact over that before; 0 to 1.
    pub restitution: f64,
    /// What acts on the ball in flight besides gravity.
    pub flight: Forces,
    /// What a contact has besides restitution and friction.
    pub contact: Contact,
    /// Effects that a user wrote as formulas.
    pub formulas: Formulas,
}

/// Formulas with their numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Formulas {
    /// Accelerations in flight.
    pub flight: Vec<AppliedForce>,
    /// What they add to the restitution at contacts.
    pub contact: Vec<AppliedContact>,
}

impl Default for Scene {
    /// A rubber ball of 4 cm across above a level floor, without air.
    fn default() -> Self {
        Self {
            gravity_m_s2: 9.81,
            radius_m: 0.02,
            mass_kg: 0.037,
            surface_height_m: 0.0,
            surface_tilt_about_x_rad: 0.0,
            surface_tilt_about_y_rad: 0.0,
            friction: 0.3,
            restitution: 0.7,
            flight: Forces::default(),
            contact: Contact::default(),
            formulas: Formulas::default(),
        }
    }
}

impl Scene {
    /// The unit normal of the surface, pointing out of it.
    #[must_use]
    pub fn normal(&self) -> [f64; 3] {
        self.normal_vector().to_array()
    }

    pub(crate) fn normal_vector(&self) -> Vector {
        let (sin_a, cos_a) = self.surface_tilt_about_x_rad.sin_cos();
        let (sin_b, cos_b) = self.surface_tilt_about_y_rad.sin_cos();
        Vector::new(sin_b, -sin_a * cos_b, cos_a * cos_b)
    }

    pub(crate) fn law(&self) -> Law {
        Law::new(self.restitution, self.friction, &self.contact)
    }

    pub(crate) fn field(&self) -> Field {
        Field::new(self.gravity_m_s2, &self.flight, &self.formulas.flight)
    }

    /// Whether this scene can be simulated.
    ///
    /// # Errors
    /// A sentence that names the first number that is not finite, larger than [`GREATEST`] or outside its range.
    pub fn check(&self) -> Result<(), String> {
        let quarter = std::f64::consts::FRAC_PI_2;
        let tiny = f64::MIN_POSITIVE;
        let own = [
            ("gravity_m_s2", self.gravity_m_s2, -GREATEST, GREATEST),
            ("radius_m", self.radius_m, tiny, GREATEST),
            ("mass_kg", self.mass_kg, tiny, GREATEST),
            ("surface_height_m", self.surface_height_m, -GREATEST, GREATEST),
            ("surface_tilt_about_x_rad", self.surface_tilt_about_x_rad, -quarter, quarter),
            ("surface_tilt_about_y_rad", self.surface_tilt_about_y_rad, -quarter, quarter),
            ("friction", self.friction, 0.0, GREATEST),
            ("restitution", self.restitution, 0.0, 1.0),
        ];
        own.into_iter().try_for_each(|(name, value, min, max)| within(name, value, min, max))?;
        self.flight.check()?;
        self.contact.check()
    }
}

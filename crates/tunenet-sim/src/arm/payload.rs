//! What a load adds to the torques: they are linear in its ten inertial numbers.
//!
//! Source: Atkeson, An and Hollerbach (1986), with the load's frame as the last link.

use nalgebra::{Matrix3, Vector3};

use super::{Frame, Inertia, Recursion};

/// How many numbers describe a rigid load.
pub const PAYLOAD_NUMBERS: usize = 10;

/// The numbers in which torques are linear: mass (kg), mass times centre of mass (kg·m, 3), and the inertia about the frame's
/// origin (kg·m²: xx, xy, xz, yy, yz, zz).
#[must_use]
pub fn payload_numbers(load: &Inertia) -> [f64; PAYLOAD_NUMBERS] {
    let (m, c, i) = (load.mass_kg, load.com_m * load.mass_kg, load.about_kg_m2(&Vector3::zeros()));
    [m, c.x, c.y, c.z, i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]]
}

impl Recursion<'_> {
    /// How the torques of the last [`inverse_dynamics`](Self::inverse_dynamics) grow with each of the
    /// [`payload_numbers`] of a load fixed to `frame`, into `regressor`, row-major `[coordinate, number]`.
    ///
    /// # Panics
    /// Where `regressor` is shorter than [`degrees`](super::Model::degrees) · [`PAYLOAD_NUMBERS`].
    pub fn payload_regressor(&self, frame: &Frame, regressor: &mut [f64]) {
        regressor.fill(0.0);
        let at = self.motion_of(frame);
        let (a, w, r) = (at.acceleration, at.omega, at.alpha);
        for number in 0..PAYLOAD_NUMBERS {
            let (force, moment) = match number {
                0 => (a, Vector3::zeros()),
                1..=3 => {
                    let c = Vector3::ith(number - 1, 1.0);
                    (r.cross(&c) + w.cross(&w.cross(&c)), c.cross(&a))
                }
                _ => {
                    let inertia = unit_inertia(number - 4);
                    (Vector3::zeros(), inertia * r + w.cross(&(inertia * w)))
                }
            };
            let (force, moment) = (at.rotation * force, at.rotation * moment);
            self.carried(frame.body, &at.position, &force, &moment, |coordinate, torque| {
                regressor[coordinate * PAYLOAD_NUMBERS + number] += torque;
            });
        }
    }
}

/// The symmetric matrix with 1 at the `k`-th of xx, xy, xz, yy, yz, zz.
fn unit_inertia(k: usize) -> Matrix3<f64> {
    let (i, j) = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)][k];
    let mut unit = Matrix3::zeros();
    (unit[(i, j)], unit[(j, i)]) = (1.0, 1.0);
    unit
}

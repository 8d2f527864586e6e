//! Gravity that an MJCF states, as its size and the turn of the base under it.

use tunenet_models::Robot;

/// Gravity as a simulation file has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedGravity {
    /// Its size, m/s².
    pub size_m_s2: f64,
    /// Turn of the base about x, then about y of the world, rad.
    pub base_tilt_rad: [f64; 2],
}

/// What the file states, where it does: the turn is the one that takes gravity straight down in the world to the vector of the file in
/// the axes of the base.
#[must_use]
pub fn stated_gravity(robot: &Robot) -> Option<StatedGravity> {
    let [x, y, z] = robot.gravity_m_s2?;
    let size_m_s2 = x.hypot(y).hypot(z);
    // Straight down in the axes of the turned base: (sin b, -cos b·sin a, -cos b·cos a).
    let tilt = [(-y).atan2(-z), x.atan2(y.hypot(z))];
    let straight = x == 0.0 && y == 0.0 && z <= 0.0;
    Some(StatedGravity { size_m_s2, base_tilt_rad: if straight { [0.0; 2] } else { tilt } })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::effects::Imperfections;

    #[test]
    fn the_turned_base_has_the_gravity_of_the_file() {
        let of = |vector: [f64; 3]| {
            let [x, y, z] = vector;
            let text = format!(
                "<mujoco><option gravity='{x} {y} {z}'/><worldbody><body><joint/><geom size='0.1'/></body></worldbody></mujoco>"
            );
            stated_gravity(tunenet_models::Model::parse_alone(std::path::Path::new("m.xml"), &text).unwrap().robot())
        };
        for vector in [[0.0, 0.0, -1.62], [3.0, -2.0, -8.0], [0.0, 9.81, 0.0], [0.0, 0.0, 9.81], [-9.81, 0.0, 0.0]] {
            let found = of(vector).unwrap();
            let mut base = Imperfections::none(1);
            base.tilt_rad = found.base_tilt_rad;
            let back = base.gravity(found.size_m_s2);
            assert!((back - nalgebra::Vector3::from(vector)).norm() < 1e-12, "{vector:?}: {back}");
        }
        let none = StatedGravity { size_m_s2: 0.0, base_tilt_rad: [0.0; 2] };
        assert_eq!(of([0.0; 3]), Some(none));
    }
}

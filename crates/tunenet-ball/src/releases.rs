//! Releases that a next recording of a ball could have: a grid of heights and velocities.

use tunenet_core::simulator::{Prepared, ProposedStart};

/// Heights of release (m) and velocities (m/s along x, along y, upwards) that are compared.
const HEIGHTS_M: [f64; 3] = [0.5, 1.0, 2.0];
const VELOCITIES_M_S: [[f64; 3]; 9] = [
    [0.0, 0.0, 0.0],
    [2.0, 0.0, 0.0],
    [0.0, 2.0, 0.0],
    [4.0, 0.0, 0.0],
    [0.0, 4.0, 0.0],
    [3.0, 3.0, 2.0],
    [2.0, -2.0, 4.0],
    [2.0, 0.0, 4.0],
    [0.0, 2.0, 4.0],
];
/// What the names of the nuisance parameters of a release begin with.
pub const PREFIX: &str = "release.";

/// Releases over the grid, where the nuisance parameters of `prepared` hold all three components of a velocity. An axis of
/// `unmeasured` is not thrown along: it will not be measured next time either.
#[must_use]
pub fn proposed(prepared: &Prepared, nuisances: &[f64], unmeasured: &[usize]) -> Vec<ProposedStart> {
    let names: Vec<&str> = prepared.nuisances.iter().map(|p| p.name.as_str()).collect();
    let place = |key: &str| names.iter().position(|name| name.strip_prefix(PREFIX) == Some(key));
    if ["velocity_x", "velocity_y", "velocity_z"].map(place).contains(&None) {
        return Vec::new();
    }
    let seen = |velocity: &[f64; 3]| unmeasured.iter().all(|&axis| velocity[axis] == 0.0);
    let one = |height_m: f64, [x, y, z]: [f64; 3]| {
        let mut values = nuisances.to_vec();
        let wanted = [("x", 0.0), ("y", 0.0), ("z", height_m), ("velocity_x", x), ("velocity_y", y), ("velocity_z", z)];
        for (key, value) in wanted {
            if let Some(i) = place(key) {
                values[i] = value;
            }
        }
        let of_release = names.iter().zip(&values).filter(|(name, _)| name.starts_with(PREFIX));
        let settings: Vec<(String, f64)> = of_release.map(|(name, value)| ((*name).to_owned(), *value)).collect();
        let height_m = if place("z").is_some() { height_m } else { 0.0 };
        ProposedStart { text: text(height_m, [x, y, z]), settings, nuisances: values, tangential_m_s: x.hypot(y) }
    };
    HEIGHTS_M
        .into_iter()
        .flat_map(|height_m| VELOCITIES_M_S.into_iter().filter(seen).map(move |v| (height_m, v)))
        .map(|(height_m, velocity_m_s)| one(height_m, velocity_m_s))
        .collect()
}

/// How to make a release.
fn text(height_m: f64, velocity_m_s: [f64; 3]) -> String {
    let [x, y, z] = velocity_m_s;
    if (x, y, z) == (0.0, 0.0, 0.0) {
        return format!("drop it from {height_m:.2} m");
    }
    let along = [("x", x), ("y", y)].into_iter().filter(|(_, speed)| *speed != 0.0);
    let along: Vec<String> = along.map(|(axis, speed)| format!("{speed:.1} m/s along {axis}")).collect();
    format!("throw it from {height_m:.2} m with {} and {z:.1} m/s upwards", along.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tunenet_core::observation::{Channel, Kind, Observation};
    use tunenet_core::simulator::Parameter;

    #[test]
    fn a_design_without_velocity_is_a_drop() {
        assert_eq!(text(1.0, [0.0; 3]), "drop it from 1.00 m");
        assert_eq!(
            text(0.5, [2.0, -2.0, 4.0]),
            "throw it from 0.50 m with 2.0 m/s along x, -2.0 m/s along y and 4.0 m/s upwards"
        );
    }

    fn thrown(names: &[&str]) -> Prepared {
        let channels = ["x", "y", "z"].map(|axis| Channel::new(axis, "m")).to_vec();
        let seen = Observation::new(Kind::Positions, channels, vec![0.0, 0.1, 0.2], vec![0.0; 9]).unwrap();
        let mut prepared = Prepared::whole(seen, 0);
        prepared.nuisances = names.iter().map(|name| Parameter::new(*name, "m", 0.5, -9.0, 9.0).unwrap()).collect();
        prepared
    }

    #[test]
    fn no_release_goes_along_an_axis_that_is_not_measured() {
        let names = ["release.z", "release.velocity_x", "release.velocity_y", "release.velocity_z", "surface.height_m"];
        let all = proposed(&thrown(&names), &[0.5; 5], &[1]);
        assert_eq!(all.len(), 12, "{all:?}");
        assert!(all.iter().all(|one| one.nuisances[2] == 0.0 && one.nuisances[4] == 0.5 && one.settings.len() == 4));
        let fastest = all.iter().max_by(|a, b| a.tangential_m_s.total_cmp(&b.tangential_m_s)).unwrap();
        assert_eq!((fastest.tangential_m_s, fastest.settings[0].clone()), (4.0, ("release.z".to_owned(), 2.0)));
    }

    #[test]
    fn a_velocity_that_is_known_proposes_nothing() {
        assert!(proposed(&thrown(&["release.z", "release.velocity_x"]), &[0.5; 2], &[]).is_empty());
    }
}

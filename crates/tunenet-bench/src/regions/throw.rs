//! A thrown ball from formulas alone: parabolas between impacts whose instants are roots, and the impulse of a solid sphere
//! on a level floor with Coulomb's friction.
//!
//! An impulse j (per mass) along the floor changes the slip u of the lowest point by −7/2 j û, since the ball's own inertia
//! is 2/5 r². So 2/7 |u| ends the slip (grip), and Coulomb allows at most μ (1 + e) times the approach speed.

use crate::scene::GRAVITY_M_S2;

/// A ball thrown over a floor at height 0, without spin.
#[derive(Debug, Clone, Copy)]
pub struct ClosedFormThrow {
    pub restitution: f64,
    pub friction: f64,
    pub radius_m: f64,
    /// Centre at 0 s, m; its lowest point is above the floor.
    pub position_m: [f64; 3],
    pub velocity_m_s: [f64; 3],
}

/// A flight: where it begins, and how the ball moves and spins then.
#[derive(Debug, Clone, Copy)]
struct Flight {
    began_s: f64,
    position_m: [f64; 3],
    velocity_m_s: [f64; 3],
    spin_rad_s: [f64; 3],
}

impl Flight {
    fn at(&self, time_s: f64) -> [f64; 3] {
        let t = time_s - self.began_s;
        let fall = [0.0, 0.0, 0.5 * GRAVITY_M_S2 * t * t];
        [0, 1, 2].map(|i| self.position_m[i] + self.velocity_m_s[i] * t - fall[i])
    }

    /// When the lowest point meets the floor: the later root of z + v t − g t²/2 = r.
    fn impact_s(&self, radius_m: f64) -> f64 {
        let (rise, above) = (self.velocity_m_s[2], (self.position_m[2] - radius_m).max(0.0));
        self.began_s + (rise + (rise * rise + 2.0 * GRAVITY_M_S2 * above).sqrt()) / GRAVITY_M_S2
    }
}

impl ClosedFormThrow {
    /// The flights up to the one after impact number `impacts`.
    fn flights(&self, impacts: usize) -> Vec<Flight> {
        let Self { position_m, velocity_m_s, radius_m, .. } = *self;
        let mut flights = vec![Flight { began_s: 0.0, position_m, velocity_m_s, spin_rad_s: [0.0; 3] }];
        for _ in 0..impacts {
            let last = flights[flights.len() - 1];
            let began_s = last.impact_s(radius_m);
            let [x, y, _] = last.at(began_s);
            let mut next = Flight { began_s, position_m: [x, y, radius_m], ..last };
            let approach = GRAVITY_M_S2 * (began_s - last.began_s) - last.velocity_m_s[2];
            next.velocity_m_s[2] = self.restitution * approach;
            let [wx, wy, _] = last.spin_rad_s;
            let slip = [last.velocity_m_s[0] - radius_m * wy, last.velocity_m_s[1] + radius_m * wx];
            let size = slip[0].hypot(slip[1]);
            let impulse = (2.0 / 7.0 * size).min(self.friction * (1.0 + self.restitution) * approach);
            if size > 0.0 {
                let along = slip.map(|u| u / size);
                next.velocity_m_s[0] -= impulse * along[0];
                next.velocity_m_s[1] -= impulse * along[1];
                let turn = 2.5 * impulse / radius_m;
                next.spin_rad_s[0] -= turn * along[1];
                next.spin_rad_s[1] += turn * along[0];
            }
            flights.push(next);
        }
        flights
    }

    /// The least friction at which the first impact ends the slip; any greater one does the same.
    pub fn grip(&self) -> f64 {
        let first =
            Flight { began_s: 0.0, position_m: self.position_m, velocity_m_s: self.velocity_m_s, spin_rad_s: [0.0; 3] };
        let approach = GRAVITY_M_S2 * first.impact_s(self.radius_m) - self.velocity_m_s[2];
        2.0 / 7.0 * self.velocity_m_s[0].hypot(self.velocity_m_s[1]) / ((1.0 + self.restitution) * approach)
    }

    /// The middle of the flight after impact number `impacts`, s.
    pub fn middle_after_s(&self, impacts: usize) -> f64 {
        let flights = self.flights(impacts);
        let last = flights[impacts];
        last.began_s.midpoint(last.impact_s(self.radius_m))
    }

    /// The centre at each instant of a rising clock, m, for as long as the flight after impact number `impacts` lasts.
    pub fn positions(&self, clock: &[f64], impacts: usize) -> Vec<[f64; 3]> {
        let flights = self.flights(impacts);
        clock.iter().map(|&t| flights[flights.partition_point(|f| f.began_s <= t).max(1) - 1].at(t)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_impact_by_hand() {
        // Falls 4.905 m in 1 s, arrives at 9.81 m/s, leaves at half of it.
        let base = ClosedFormThrow {
            restitution: 0.5,
            friction: 0.1,
            radius_m: 0.1,
            position_m: [0.0, 0.0, 5.005],
            velocity_m_s: [7.0, 0.0, 0.0],
        };
        // Slips: the floor takes 0.1 · 1.5 · 9.81 = 1.4715 m/s; grips: 2/7 of 7 m/s, which is rolling.
        let after = |friction| ClosedFormThrow { friction, ..base }.flights(1)[1];
        let (slips, grips) = (after(0.1), after(1.0));
        assert!((slips.velocity_m_s[0] - 5.5285).abs() < 1e-12 && (slips.velocity_m_s[2] - 4.905).abs() < 1e-12);
        assert!((grips.velocity_m_s[0] - 5.0).abs() < 1e-12);
        assert!((grips.spin_rad_s[1] * 0.1 - 5.0).abs() < 1e-12);
        assert!((base.grip() - 2.0 / (1.5 * 9.81)).abs() < 1e-12);
        // The hop lasts 1 s: half of it is its apex, 1.22625 m above the floor.
        assert!((base.middle_after_s(1) - 1.5).abs() < 1e-12);
        let apex = base.positions(&[0.0, 1.5], 1)[1];
        assert!((apex[2] - 1.32625).abs() < 1e-12 && (apex[0] - 9.76425).abs() < 1e-12, "{apex:?}");
    }
}

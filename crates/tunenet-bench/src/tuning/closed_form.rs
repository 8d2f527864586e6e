//! A dropped ball from formulas alone: what the targets are made with, and what they are fitted with independently of
//! everything that tunenet tunes.
//!
//! Impact n leaves with `v_n = eⁿ v`, where `v = √(2 g h)`; the arc behind it lasts `2 v_n / g`. So impact n happens at
//! `t_n = v/g + Σ_{j<n} 2 eʲ v / g`, and in the arc behind it `z = v_n s − g s²/2` with `s = t − t_n`.

use crate::scene::GRAVITY_M_S2;

/// A rebound slower than this is no longer seen: its hop is 5e-20 m high.
const SLOWEST_M_S: f64 = 1e-9;

/// A ball released at 0 s, its lowest point `fall_m` above the floor.
#[derive(Debug, Clone, Copy)]
pub struct ClosedFormDrop {
    /// Height of fall, m; above 0.
    pub fall_m: f64,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: f64,
}

impl ClosedFormDrop {
    /// Height of the lowest point at each instant of a rising clock, m, and its derivative by the restitution.
    pub fn samples(self, clock: impl IntoIterator<Item = f64>) -> impl Iterator<Item = (f64, f64)> {
        let (g, e) = (GRAVITY_M_S2, self.restitution);
        let first = (2.0 * self.fall_m / g).sqrt();
        // The arc in flight: when it began, how fast, how long it lasts, and how the first two change with e.
        let (mut began, mut speed, mut lasts) = (first, e * g * first, 2.0 * e * first);
        let (mut began_by_e, mut speed_by_e) = (0.0, g * first);
        clock.into_iter().map(move |t| {
            if t <= first {
                return (self.fall_m - 0.5 * g * t * t, 0.0);
            }
            while t > began + lasts && speed > SLOWEST_M_S {
                began += lasts;
                began_by_e += 2.0 * speed_by_e / g;
                // v_{n+1} = e v_n.
                speed_by_e = speed + e * speed_by_e;
                speed *= e;
                lasts = 2.0 * speed / g;
            }
            let s = t - began;
            if s > lasts {
                return (0.0, 0.0);
            }
            (s * (speed - 0.5 * g * s), s * speed_by_e - (speed - g * s) * began_by_e)
        })
    }

    /// Heights alone.
    pub fn heights(self, clock: &[f64]) -> Vec<f64> {
        self.samples(clock.iter().copied()).map(|(z, _)| z).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_heights() {
        // 4.905 m of fall take 1 s; at e = ½ the first rebound lasts 1 s and rises to a quarter, the second ½ s.
        let drop = ClosedFormDrop { fall_m: 4.905, restitution: 0.5 };
        let seen = drop.heights(&[0.0, 0.5, 1.5, 2.25, 2.5 + 1e-12, 3.1]);
        for (seen, expected) in seen.iter().zip([4.905, 4.905 * 0.75, 4.905 / 4.0, 4.905 / 16.0, 0.0, 0.0]) {
            assert!((seen - expected).abs() < 1e-9, "{seen} is not {expected}");
        }
        assert_eq!(ClosedFormDrop { restitution: 0.0, ..drop }.heights(&[1.1])[0], 0.0);
        assert!((ClosedFormDrop { restitution: 1.0, ..drop }.heights(&[4.0])[0] - 4.905).abs() < 1e-9);
    }

    #[test]
    fn the_slope_is_the_difference() {
        let clock: Vec<f64> = (0..400).map(|i| f64::from(i) / 60.0 + 1e-3).collect();
        for e in [0.2, 0.55, 0.9] {
            let drop = |e| ClosedFormDrop { fall_m: 4.0, restitution: e };
            let (low, high) = (drop(e - 1e-7).heights(&clock), drop(e + 1e-7).heights(&clock));
            let slopes = drop(e).samples(clock.iter().copied()).map(|(_, s)| s);
            let worst = slopes.zip(low.iter().zip(&high)).map(|(s, (l, h))| (s - (h - l) / 2e-7).abs());
            assert!(worst.fold(0.0, f64::max) < 1e-4);
        }
    }
}

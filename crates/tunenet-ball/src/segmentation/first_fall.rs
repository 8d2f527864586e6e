//! The start of a drop with few samples, in which kinks cannot be distinguished from flight.

use super::polynomial::Polynomial;
use tunenet_core::observation::{Kind, Observation};

/// Falls in more samples than this have kinks that [`Arcs`](super::Arcs) finds.
const MOST_SAMPLES: usize = 30;
/// Fewer say nothing of whether they fall under gravity.
const FEWEST: usize = 4;
/// A rebound rises by this share of the range of heights at the least ...
const LEAST_RISE: f64 = 0.04;
/// ... and the fall before it strays from a parabola under gravity by no more than this share of it.
const WORST_MISFIT: f64 = 0.015;

/// The first fall of a record, up to its first low.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstFall {
    /// The first sample in free fall.
    pub begin: usize,
    /// Position there, m.
    pub start_m: [f64; 3],
    /// Velocity there, m/s.
    pub start_m_s: [f64; 3],
    /// The lowest height before the rebound, m.
    pub low_m: f64,
}

impl FirstFall {
    /// Finds it in `seen`, positions of a ball under gravity `gravity_m_s2`; `None` where the record does not begin with a
    /// fall of few samples and a rebound that rises no higher.
    #[must_use]
    pub fn find(seen: &Observation, gravity_m_s2: f64) -> Option<Self> {
        if seen.kind() != Kind::Positions {
            return None;
        }
        let clock = seen.clock();
        let axes: [Vec<f64>; 3] = [0, 1, 2].map(|axis| seen.column(axis).collect());
        let heights = &axes[2];
        let range = super::span(heights);
        let mut low = 0;
        while heights.get(low + 1..)?.first()? <= &heights[low] || low + 1 < FEWEST {
            low += 1;
        }
        let rise = heights[low..].iter().fold(f64::MIN, |high, z| high.max(*z)) - heights[low];
        let fallen = heights[..low].iter().fold(f64::MIN, |high, z| high.max(*z)) - heights[low];
        if low > MOST_SAMPLES || rise < LEAST_RISE * range || rise > fallen + LEAST_RISE * range {
            return None;
        }
        // What is held before it falls is left out. The lowest sample may lie behind the impact already.
        (0..=low.checked_sub(FEWEST)?).find_map(|begin| {
            let line = |axis: usize, curvature: f64| {
                Polynomial::fit(&clock[begin..low], &axes[axis][begin..low], clock[begin], Some(curvature))
            };
            let fall = line(2, -gravity_m_s2 / 2.0)?;
            let lines = [line(0, 0.0)?, line(1, 0.0)?, fall];
            let top = fall.at(clock[begin]);
            let held = heights[..begin].iter().all(|z| (z - top).abs() < 3.0 * WORST_MISFIT * range);
            (held && fall.residual_sd < WORST_MISFIT * range).then(|| Self {
                begin,
                start_m: [0, 1, 2].map(|axis| lines[axis].at(clock[begin])),
                start_m_s: [0, 1, 2].map(|axis| lines[axis].slope(clock[begin])),
                low_m: heights[low],
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drop(rate_hz: f64, frames: u32, gravity: f64) -> Observation {
        // 1 m of fall, a rebound at half the speed; from 2 m up.
        let fall = (2.0 / gravity).sqrt();
        let height = |t: f64| {
            let s = t - fall;
            if s < 0.0 { 3.0 - gravity / 2.0 * t * t } else { 2.0 + 0.5 * gravity * fall * s - gravity / 2.0 * s * s }
        };
        let clock: Vec<f64> = (0..frames).map(|i| f64::from(i) / rate_hz).collect();
        let rows: Vec<[f64; 3]> = clock.iter().map(|t| [0.2 * t, 0.0, height(*t)]).collect();
        Observation::positions(clock, &rows).unwrap()
    }

    #[test]
    fn a_coarse_drop_has_its_start() {
        let found = FirstFall::find(&drop(24.0, 20, 9.81), 9.81).unwrap();
        assert!((found.start_m[2] - 3.0).abs() < 1e-12 && found.start_m_s[2].abs() < 1e-12, "{found:?}");
        assert!((found.start_m_s[0] - 0.2).abs() < 1e-12 && found.low_m >= 2.0 && found.low_m < 2.2, "{found:?}");
    }

    #[test]
    fn other_motions_have_none() {
        assert_eq!(FirstFall::find(&drop(24.0, 10, 9.81), 9.81), None, "no rebound");
        assert_eq!(FirstFall::find(&drop(24.0, 40, 3.0), 9.81), None, "another gravity");
        let sine: Vec<f64> = (0..40).map(|i| f64::from(i) / 20.0).collect();
        let rows: Vec<[f64; 3]> = sine.iter().map(|t| [0.0, 0.0, 0.1 * (6.0 * t).cos()]).collect();
        assert_eq!(FirstFall::find(&Observation::positions(sine, &rows).unwrap(), 9.81), None, "a swing");
    }
}

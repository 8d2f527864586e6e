//! Error of an integration of first order (semi-implicit Euler: Hairer, Lubich and Wanner 2006, section I.1): half of what a joint moves in a
//! step. Recordings that another simulator made differ by as much from this one.

use tunenet_core::observation::Observation;
use tunenet_core::statistics::root_mean_square;

/// The rate of a channel is that over this time, s, in which noise counts little.
const RATE_S: f64 = 0.1;
/// Where another simulator made a recording, its step is unknown, s: this is the default of MuJoCo.
const USUAL_STEP_S: f64 = 0.002;
/// What an integration of first order is off by in a channel, root mean square: what the channel moves in half a step.
pub(super) fn step_error(seen: &Observation, channel: usize, step_s: f64) -> f64 {
    let (clock, values): (&[f64], Vec<f64>) = (seen.clock(), seen.column(channel).collect());
    let mut later = 0;
    let rates = (0..clock.len()).filter_map(|i| {
        while later < clock.len() && clock[later] - clock[i] < RATE_S {
            later += 1;
        }
        Some((values.get(later)? - values[i]) / (clock[later] - clock[i]))
    });
    0.5 * step_s.max(USUAL_STEP_S) * root_mean_square(rates)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tunenet_core::observation::{Channel, Kind};

    #[test]
    fn half_a_step_of_a_steady_motion_is_half_its_way() {
        let clock: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
        let values = clock.iter().map(|t| 1.5 - 0.8 * t).collect();
        let seen = Observation::new(Kind::Other, vec![Channel::new("a_rad", "rad")], clock, values).unwrap();
        assert!((step_error(&seen, 0, 0.004) - 0.8 * 0.002).abs() < 1e-12);
        // No finer than the default step of MuJoCo.
        assert!((step_error(&seen, 0, 1e-4) - 0.8 * 0.001).abs() < 1e-12);
    }
}

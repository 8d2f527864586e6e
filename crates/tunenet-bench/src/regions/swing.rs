//! A simulator of a user's own, and the truth that it is held against: small swings of a damped pendulum, stepped by
//! Runge and Kutta's method in the simulator and in closed form in the recordings.

use tunenet_core::Result;
use tunenet_core::observation::Channel;
use tunenet_core::simulator::{Parameter, RolloutResult, Simulator};

use crate::scene::GRAVITY_M_S2;

/// Longest step of the simulator, s: its error stays far below a microradian.
const LONGEST_STEP_S: f64 = 5e-3;

/// A pendulum with length, damping and the angle at which it was released.
pub struct Swing {
    parameters: Vec<Parameter>,
    channels: Vec<Channel>,
}

impl Swing {
    pub fn new() -> Result<Self> {
        let parameters = vec![
            Parameter::new("length", "m", 1.0, 0.2, 2.0)?,
            Parameter::new("damping", "1/s", 0.3, 0.0, 1.0)?,
            Parameter::new("start_angle", "rad", 0.1, -0.5, 0.5)?,
        ];
        Ok(Self { parameters, channels: vec![Channel::new("angle", "rad")] })
    }
}

impl Simulator for Swing {
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn rollout(&self, parameters: &[f64], _: &[f64], clock: &[f64], angles: &mut [f64]) -> RolloutResult {
        let slope = |s: [f64; 2]| [s[1], -GRAVITY_M_S2 / parameters[0] * s[0] - parameters[1] * s[1]];
        let (mut state, mut now) = ([parameters[2], 0.0], 0.0);
        for (&time, angle) in clock.iter().zip(angles) {
            let steps = ((time - now) / LONGEST_STEP_S).ceil().max(1.0);
            let h = (time - now) / steps;
            let mut left = steps;
            while left > 0.0 {
                let ahead = |k: [f64; 2], h: f64| [state[0] + h * k[0], state[1] + h * k[1]];
                let a = slope(state);
                let b = slope(ahead(a, h / 2.0));
                let c = slope(ahead(b, h / 2.0));
                let d = slope(ahead(c, h));
                state = ahead([0, 1].map(|i| (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]) / 6.0), h);
                left -= 1.0;
            }
            now = time;
            *angle = state[0];
        }
        Ok(())
    }
}

/// The angle at `time_s` of an underdamped pendulum released at rest: a decaying cosine.
pub fn angle([length, damping, start_angle]: [f64; 3], time_s: f64) -> f64 {
    let decay = damping / 2.0;
    let frequency = (GRAVITY_M_S2 / length - decay * decay).sqrt();
    let (sin, cos) = (frequency * time_s).sin_cos();
    start_angle * (-decay * time_s).exp() * (cos + decay / frequency * sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tunenet_core::simulator::rollout;

    #[test]
    fn steps_and_formula_agree() {
        let (swing, truth) = (Swing::new().unwrap(), [0.7, 0.4, -0.3]);
        let clock: Vec<f64> = (0..100).map(|i| 0.05 * f64::from(i)).collect();
        let stepped = rollout(&swing, &truth, &[], &clock).unwrap();
        let worst = stepped.iter().zip(&clock).map(|(a, &t)| (a - angle(truth, t)).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-8, "{worst}");
    }
}

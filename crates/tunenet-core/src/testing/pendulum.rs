//! A pendulum of small angles: θ'' = −(g/L) (θ − θ₀) − 2 γ θ'.

use super::oscillation::damped;
use super::{ClosedForm, Values, effect, start};
use crate::Result;
use crate::observation::{Channel, Observation};
use crate::simulator::{Effect, Parameter};

/// Standard gravity, m/s².
const GRAVITY_M_S2: f64 = 9.806_65;

/// A pendulum that the simulator takes for free of friction and hanging at 0.
#[derive(Debug, Clone, Copy)]
pub struct Pendulum;

impl ClosedForm for Pendulum {
    fn channel(&self) -> Channel {
        Channel::new("angle", "rad")
    }

    fn parameters(&self) -> Vec<Parameter> {
        Parameter::new("length", "m", 1.0, 0.2, 3.0).into_iter().collect()
    }

    fn effects(&self) -> Vec<Effect> {
        vec![
            effect("viscous_friction", "rate_1_s", "1/s", (0.0, 1.5), 0.01),
            effect("rest_angle", "angle_rad", "rad", (-0.5, 0.5), 0.01),
        ]
    }

    fn nuisances(&self, seen: &Observation) -> Result<Vec<Parameter>> {
        start(seen, [("start.angle", "rad"), ("start.speed", "rad/s")], [0.5, 2.0])
    }

    fn solution(&self, values: &Values, start: &[f64], t: f64) -> f64 {
        let omega = (GRAVITY_M_S2 / values("length")).sqrt();
        let (gamma, rest) = (values("viscous_friction.rate_1_s"), values("rest_angle.angle_rad"));
        rest + damped(omega, gamma, (start[0] - rest, start[1]), t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::tests::second_derivative;

    #[test]
    fn the_solution_obeys_its_equation() {
        let values = |name: &str| match name {
            "length" => 0.7,
            "viscous_friction.rate_1_s" => 0.3,
            _ => 0.05,
        };
        for t in [0.1, 0.7, 1.9] {
            let (angle, speed, bend) = second_derivative(&Pendulum, &values, &[0.2, -0.4], t);
            let right = -GRAVITY_M_S2 / 0.7 * (angle - 0.05) - 0.6 * speed;
            assert!((bend - right).abs() < 1e-4, "{t}: {bend} {right}");
        }
    }
}

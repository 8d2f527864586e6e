//! A driven oscillator: x'' = −ω² x − 2 γ x' + a cos Ωt.

use super::oscillation::damped;
use super::{ClosedForm, Values, effect, start};
use crate::Result;
use crate::observation::{Channel, Observation};
use crate::simulator::{Effect, Parameter};

/// What drives it: an acceleration in m/s², and its angular frequency in rad/s.
const DRIVE: (f64, f64) = (2.0, 9.0);

/// An oscillator that the simulator takes for undamped, and driven at exactly 9 rad/s.
///
/// The particular solution is A cos Ωt + B sin Ωt with A = a (ω² − Ω²)/N, B = 2 a γ Ω/N, N = (ω² − Ω²)² + (2γΩ)².
#[derive(Debug, Clone, Copy)]
pub struct DrivenOscillator;

impl ClosedForm for DrivenOscillator {
    fn channel(&self) -> Channel {
        Channel::new("x", "m")
    }

    fn parameters(&self) -> Vec<Parameter> {
        Parameter::new("natural_frequency", "rad/s", 5.0, 2.0, 8.0).into_iter().collect()
    }

    fn effects(&self) -> Vec<Effect> {
        vec![
            effect("damping", "gamma_1_s", "1/s", (0.0, 1.5), 0.01),
            effect("drive_detuning", "shift_rad_s", "rad/s", (-0.9, 0.9), 0.01),
        ]
    }

    fn nuisances(&self, seen: &Observation) -> Result<Vec<Parameter>> {
        start(seen, [("start.x", "m"), ("start.speed", "m/s")], [0.5, 3.0])
    }

    fn solution(&self, values: &Values, start: &[f64], t: f64) -> f64 {
        let (omega, gamma) = (values("natural_frequency"), values("damping.gamma_1_s"));
        let (size, drive) = (DRIVE.0, DRIVE.1 + values("drive_detuning.shift_rad_s"));
        let apart = omega * omega - drive * drive;
        let below = apart * apart + (2.0 * gamma * drive).powi(2);
        let (along, across) = (size * apart / below, 2.0 * size * gamma * drive / below);
        let (sin, cos) = (drive * t).sin_cos();
        let free = damped(omega, gamma, (start[0] - along, start[1] - drive * across), t);
        along * cos + across * sin + free
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::tests::second_derivative;

    #[test]
    fn the_solution_obeys_its_equation_and_its_start() {
        let values = |name: &str| match name {
            "natural_frequency" => 5.5,
            "damping.gamma_1_s" => 0.2,
            _ => 0.3,
        };
        for t in [0.0, 0.1, 0.7, 1.9] {
            let (x, speed, bend) = second_derivative(&DrivenOscillator, &values, &[0.1, -0.4], t);
            let right = -5.5 * 5.5 * x - 0.4 * speed + DRIVE.0 * ((DRIVE.1 + 0.3) * t).cos();
            assert!((bend - right).abs() < 1e-4, "{t}: {bend} {right}");
            assert!(t > 0.0 || (x - 0.1).abs() < 1e-12 && (speed + 0.4).abs() < 1e-4);
        }
    }
}

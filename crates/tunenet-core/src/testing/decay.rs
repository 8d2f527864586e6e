//! Exponential decay: y' = −k y − q y², towards an offset.

use super::{ClosedForm, Values, effect};
use crate::Result;
use crate::observation::{Channel, Observation};
use crate::simulator::{Effect, Parameter};

/// Decay at a rate `k`, of which the simulator knows neither the offset of the sensor nor that it quenches itself.
///
/// The logistic equation y' = −k y − q y² has the solution y = k y₀ e^(−kt) / (k + q y₀ (1 − e^(−kt))).
#[derive(Debug, Clone, Copy)]
pub struct Decay;

impl ClosedForm for Decay {
    fn channel(&self) -> Channel {
        Channel::new("y", "V")
    }

    fn parameters(&self) -> Vec<Parameter> {
        Parameter::new("rate", "1/s", 1.0, 0.1, 10.0).into_iter().collect()
    }

    fn effects(&self) -> Vec<Effect> {
        vec![
            effect("offset", "level_v", "V", (-1.0, 1.0), 0.01),
            effect("self_quenching", "q_1_vs", "1/(V s)", (0.0, 5.0), 0.01),
        ]
    }

    fn nuisances(&self, seen: &Observation) -> Result<Vec<Parameter>> {
        let first = seen.row(0)[0];
        Ok(vec![Parameter::new("start.value", "V", first, first - 1.0, first + 1.0)?])
    }

    fn solution(&self, values: &Values, start: &[f64], t: f64) -> f64 {
        let (rate, offset, quenching) = (values("rate"), values("offset.level_v"), values("self_quenching.q_1_vs"));
        let left = (-rate * t).exp();
        offset + rate * start[0] * left / (rate + quenching * start[0] * (1.0 - left))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::tests::second_derivative;

    #[test]
    fn the_solution_obeys_its_equation() {
        let values = |name: &str| match name {
            "rate" => 1.3,
            "self_quenching.q_1_vs" => 0.4,
            _ => 0.0,
        };
        for t in [0.1, 0.7, 1.9] {
            let (y, slope, _) = second_derivative(&Decay, &values, &[0.8], t);
            assert!((slope + 1.3 * y + 0.4 * y * y).abs() < 1e-6, "{t}: {slope}");
        }
    }
}
